//! How a depth camera errs.

use crate::error::{InvalidParameter, check_range};

/// Noise of a structured-light or stereo depth camera, per pixel.
///
/// The depth z along the optical axis is measured as `z + σ(z) · N(0, 1)` with
/// `σ(z) = axial_floor + axial_growth · (z − axial_start)²`
/// (Nguyen, Izadi, Lovell: Modeling Kinect sensor noise, 3DIMPVT 2012).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthNoise {
    /// Standard deviation at `axial_start`, in meters. Default 0.0012.
    pub axial_floor: f64,
    /// Growth of the standard deviation with squared depth, in 1/m. Default 0.0019.
    pub axial_growth: f64,
    /// Depth of the least noise, in meters. Default 0.4.
    pub axial_start: f64,
    /// Depths are rounded to multiples of `depth_step · z²`, in 1/m; 0 keeps them continuous.
    /// A Kinect has about 0.0028 (Khoshelham and Elberink, Sensors 2012). Default 0.
    pub depth_step: f64,
    /// Standard deviation of the direction a pixel really looks into, in pixels.
    /// Default 0.2, which is 0.8 pixels of an image four times as wide.
    pub lateral_sigma: f64,
    /// Surfaces seen at more than this angle from their normal return nothing, in radians.
    /// Default 80°.
    pub grazing_limit: f64,
    /// Fraction of the pixels that return nothing for no reason. Default 0.01.
    pub dropout: f64,
}

impl Default for DepthNoise {
    fn default() -> Self {
        Self {
            axial_floor: 0.0012,
            axial_growth: 0.0019,
            axial_start: 0.4,
            depth_step: 0.0,
            lateral_sigma: 0.2,
            grazing_limit: 80.0_f64.to_radians(),
            dropout: 0.01,
        }
    }
}

impl DepthNoise {
    /// A perfect camera: exact depths, nothing dropped.
    #[cfg(test)]
    pub(crate) fn none() -> Self {
        Self {
            axial_floor: 0.0,
            axial_growth: 0.0,
            axial_start: 0.0,
            depth_step: 0.0,
            lateral_sigma: 0.0,
            grazing_limit: std::f64::consts::FRAC_PI_2,
            dropout: 0.0,
        }
    }

    /// Standard deviation of the depth at depth `z`, in meters.
    pub(crate) fn axial_sigma(&self, z: f64) -> f64 {
        self.axial_floor + self.axial_growth * (z - self.axial_start).powi(2)
    }

    /// `z` rounded to the camera's resolution at that depth.
    pub(crate) fn quantized(&self, z: f64) -> f64 {
        let step = self.depth_step * z * z;
        if step > 0.0 {
            (z / step).round() * step
        } else {
            z
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_range("axial_floor", self.axial_floor, 0.0..=1.0, "in [0, 1]")?;
        check_range("axial_growth", self.axial_growth, 0.0..=1.0, "in [0, 1]")?;
        check_range("axial_start", self.axial_start, 0.0..=100.0, "in [0, 100]")?;
        check_range("depth_step", self.depth_step, 0.0..=0.1, "in [0, 0.1]")?;
        check_range(
            "lateral_sigma",
            self.lateral_sigma,
            0.0..=100.0,
            "in [0, 100]",
        )?;
        let angles = 0.0..=std::f64::consts::FRAC_PI_2;
        check_range("grazing_limit", self.grazing_limit, angles, "in [0, π/2]")?;
        check_range("dropout", self.dropout, 0.0..=1.0, "in [0, 1]")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantized_depths_are_multiples_of_the_step() {
        let noise = DepthNoise {
            depth_step: 0.01,
            ..DepthNoise::none()
        };
        assert!((noise.quantized(1.004) - 1.008_016).abs() < 1e-3);
        assert_eq!(DepthNoise::none().quantized(1.2345), 1.2345);
    }

    #[test]
    fn quantization_changes_a_depth_by_half_a_step_at_most() {
        let noise = DepthNoise {
            depth_step: 0.0028,
            ..DepthNoise::none()
        };
        for k in 1..400 {
            let z = 0.01 * f64::from(k);
            assert!((noise.quantized(z) - z).abs() <= 0.5 * 0.0028 * z * z + 1e-12);
        }
    }
}
