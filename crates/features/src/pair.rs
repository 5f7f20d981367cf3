//! How the normals of two points lie to each other, in eleven steps per angle.

use nalgebra::{Point3, Vector3};

/// Steps into which each of the three features is divided.
pub(crate) const BINS: usize = 11;

/// Bins of a pair of which no frame can be built: the middle, where all three features are zero.
const NO_FRAME: [usize; 3] = [BINS / 2; 3];

/// A point with its unit normal.
#[derive(Clone, Copy)]
pub(crate) struct Oriented<'a> {
    pub(crate) point: &'a Point3<f64>,
    pub(crate) normal: &'a Vector3<f64>,
}

/// Bins of the three pair features of Rusu et al. (ICRA 2009, section III), as Open3D and PCL
/// measure them.
///
/// Of the two points the one whose normal lies closer to the connecting line is the source `s`,
/// the other the target `t`; with `d = (t - s) / |t - s|` and the frame `u = n_s`,
/// `v = d x u / |d x u|`, `w = u x v` the features are
///
/// - `f0 = atan2(w . n_t, u . n_t)`, divided evenly over -pi..pi,
/// - `f1 = v . n_t`, divided evenly over -1..1,
/// - `f2 = u . d`, divided evenly over -1..1.
///
/// Points in one place and a normal along the connecting line leave no frame; such pairs count as
/// `f0 = f1 = f2 = 0`.
pub(crate) fn pair_bins(a: Oriented, b: Oriented) -> [usize; 3] {
    let a_to_b = b.point - a.point;
    let distance = a_to_b.norm();
    let (along_a, along_b) = (a.normal.dot(&a_to_b), b.normal.dot(&a_to_b));
    let (source, target, line, along) = if along_a.abs() < along_b.abs() {
        (b.normal, a.normal, -a_to_b, -along_b)
    } else {
        (a.normal, b.normal, a_to_b, along_a)
    };
    let v = line.cross(source);
    let length = v.norm();
    if distance == 0.0 || length == 0.0 {
        return NO_FRAME;
    }
    let w = source.cross(&v) / length;
    [
        angle_bin(w.dot(target), source.dot(target)),
        cosine_bin(v.dot(target) / length),
        cosine_bin(along / distance),
    ]
}

/// `floor(11 (cosine + 1) / 2)`, kept inside 0..=10.
fn cosine_bin(cosine: f64) -> usize {
    // The conversion takes negative numbers and NaN to zero.
    ((0.5 * BINS as f64 * (cosine + 1.0)) as usize).min(BINS - 1)
}

/// Cosine and sine of the borders between the bins 5|6, 6|7, ... 9|10: odd multiples of pi / 11.
const BORDERS: [(f64, f64); BINS / 2] = [
    (0.959_492_973_614_497_4, 0.281_732_556_841_429_67),
    (0.654_860_733_945_285_1, 0.755_749_574_354_258_3),
    (0.142_314_838_273_285_14, 0.989_821_441_880_932_7),
    (-0.415_415_013_001_886_44, 0.909_631_995_354_518_4),
    (-0.841_253_532_831_181_2, 0.540_640_817_455_597_6),
];

/// `floor(11 (atan2(y, x) + pi) / (2 pi))`, kept inside 0..=10, without the arc tangent.
///
/// The bins lie symmetrically about the angle zero, so it is enough to count the borders that the
/// angle of `(x, |y|)` has passed: those to the left of which `(x, |y|)` lies.
fn angle_bin(y: f64, x: f64) -> usize {
    let passed = BORDERS
        .iter()
        .filter(|(cos, sin)| y.abs() * cos - x * sin > 0.0)
        .count();
    if y.is_sign_negative() {
        BINS / 2 - passed
    } else {
        BINS / 2 + passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn borders_are_odd_multiples_of_pi_over_eleven() {
        for (k, (cos, sin)) in BORDERS.into_iter().enumerate() {
            let angle = (2 * k + 1) as f64 * PI / 11.0;
            assert!((cos - angle.cos()).abs() < 1e-15 && (sin - angle.sin()).abs() < 1e-15);
        }
    }

    #[test]
    fn angle_bins_are_those_of_the_arc_tangent() {
        for k in 0..100_000 {
            let angle = (k as f64 + 0.5) / 100_000.0 * 2.0 * PI - PI;
            let (y, x) = (0.3 * angle.sin(), 0.3 * angle.cos());
            let bin = (11.0 * (y.atan2(x) + PI) / (2.0 * PI)).floor() as usize;
            assert_eq!(angle_bin(y, x), bin, "angle {angle}");
        }
    }

    #[test]
    fn angle_bins_on_the_axes_are_those_of_the_arc_tangent() {
        for (y, x) in [
            (0.0, 0.0),
            (0.0, 1.0),
            (0.0, -1.0),
            (-0.0, -1.0),
            (1.0, 0.0),
            (-1.0, 0.0),
        ] {
            let bin = (11.0 * (f64::atan2(y, x) + PI) / (2.0 * PI)).floor() as usize;
            assert_eq!(angle_bin(y, x), bin.min(10), "y {y}, x {x}");
        }
    }

    #[test]
    fn cosine_bins_keep_the_ends_and_rounding_beyond_them() {
        let bins = [-1.1, -1.0, 0.0, 1.0 - 1e-9, 1.0, 1.1, f64::NAN].map(cosine_bin);
        assert_eq!(bins, [0, 0, 5, 10, 10, 10, 0]);
    }

    #[test]
    fn a_pair_has_the_same_bins_from_either_end() {
        let (p, q) = (Point3::new(0.1, 0.2, 0.3), Point3::new(-0.4, 0.1, 0.2));
        let (m, n) = (Vector3::new(0.48, 0.6, 0.64), Vector3::new(0.8, -0.6, 0.0));
        let (a, b) = (
            Oriented {
                point: &p,
                normal: &m,
            },
            Oriented {
                point: &q,
                normal: &n,
            },
        );
        assert_eq!(pair_bins(a, b), pair_bins(b, a));
    }

    #[test]
    fn pairs_without_a_frame_fall_into_the_middle() {
        let (p, z) = (Point3::new(1.0, 2.0, 3.0), Vector3::z());
        let a = Oriented {
            point: &p,
            normal: &z,
        };
        let above = p + 0.5 * z;
        assert_eq!(pair_bins(a, a), NO_FRAME);
        assert_eq!(
            pair_bins(
                a,
                Oriented {
                    point: &above,
                    normal: &z
                }
            ),
            NO_FRAME
        );
    }
}
