//! A scan as its file has it.

use nalgebra::Point3;

/// The points of a file, in its order and unit, and how many more it listed without a position.
///
/// Depth sensors mark pixels without a return by coordinates that are not numbers, and organized clouds
/// keep these rows. They are left out and counted, so all coordinates in `points` are finite. If
/// `invalid` is not zero, the place of a point in `points` is not its row in the file.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PointFile {
    /// The points with three finite coordinates.
    pub points: Vec<Point3<f64>>,
    /// How many points were left out since a coordinate is NaN or infinite, or since the file marks
    /// them as invalid.
    pub invalid: usize,
    /// Whether the file lists a normal for every point: `nx ny nz` of PLY, `normal_x normal_y
    /// normal_z` of PCD. The normals themselves are not read.
    pub has_normals: bool,
    /// Where the sensor stood, in the frame of the points, if the file has it: the translation of
    /// `VIEWPOINT` of PCD. Many programs write the origin there whatever they know.
    pub viewpoint: Option<Point3<f64>>,
}

impl PointFile {
    pub(crate) fn push(&mut self, coordinates: [f64; 3]) {
        if coordinates.iter().all(|coordinate| coordinate.is_finite()) {
            self.points.push(Point3::from(coordinates));
        } else {
            self.invalid += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_counts_as_invalid_if_any_coordinate_is_not_finite() {
        let mut file = PointFile::default();
        file.push([1.0, 2.0, 3.0]);
        file.push([f64::NAN, 2.0, 3.0]);
        file.push([1.0, f64::INFINITY, 3.0]);
        file.push([f64::NAN; 3]);
        assert_eq!((file.points.len(), file.invalid), (1, 3));
    }
}
