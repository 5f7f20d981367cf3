use gmpcr_geometry::is_usable;
use nalgebra::Point3;

use crate::Descriptors;

/// Points in their own frame and one local descriptor per point.
///
/// Coordinates may have any unit; meters are usual. A scan may be empty: it then matches nothing.
///
/// ```
/// use gmpcr_correspondence::{Descriptors, Scan};
/// use nalgebra::Point3;
///
/// let points = vec![Point3::new(0.0, 0.0, 1.0), Point3::new(0.5, 0.0, 1.2)];
/// let scan = Scan::new(points, Descriptors::new(vec![0.1; 2 * 33], 33)?)?;
/// assert_eq!(scan.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct Scan {
    points: Vec<Point3<f64>>,
    descriptors: Descriptors,
}

/// A scan as a file has it.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Scan", deny_unknown_fields)]
struct Unchecked {
    points: Vec<Point3<f64>>,
    descriptors: Descriptors,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Scan {
    type Error = ScanError;

    fn try_from(scan: Unchecked) -> Result<Self, ScanError> {
        Self::new(scan.points, scan.descriptors)
    }
}

/// Why points and descriptors are no [`Scan`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// There is not one descriptor per point.
    #[error("{points} points, but {descriptors} descriptors: one per point is needed")]
    LengthsDiffer {
        /// Number of points.
        points: usize,
        /// Number of descriptors.
        descriptors: usize,
    },
    /// A coordinate is NaN, infinite, or beyond ±1e100, where squares overflow.
    #[error("point {index} has a coordinate that is not a number within ±1e100")]
    BadCoordinate {
        /// The first such point.
        index: usize,
    },
}

impl Scan {
    /// Joins points and their descriptors.
    ///
    /// # Errors
    /// [`ScanError`] if their numbers differ or a coordinate is not a number within ±1e100.
    pub fn new(points: Vec<Point3<f64>>, descriptors: Descriptors) -> Result<Self, ScanError> {
        if points.len() != descriptors.len() {
            return Err(ScanError::LengthsDiffer {
                points: points.len(),
                descriptors: descriptors.len(),
            });
        }
        match points.iter().position(|p| !is_usable(&p.coords)) {
            Some(index) => Err(ScanError::BadCoordinate { index }),
            None => Ok(Self {
                points,
                descriptors,
            }),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the scan has no point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The points, in the scan's frame.
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// The descriptors, one per point.
    pub fn descriptors(&self) -> &Descriptors {
        &self.descriptors
    }

    /// Points and descriptors.
    #[cfg(feature = "serde")]
    pub(crate) fn into_parts(self) -> (Vec<Point3<f64>>, Descriptors) {
        (self.points, self.descriptors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_makes_points_and_descriptors_no_scan() {
        let descriptors = Descriptors::new(vec![0.0; 4], 2).unwrap();
        let one = vec![Point3::origin()];
        let lengths = ScanError::LengthsDiffer {
            points: 1,
            descriptors: 2,
        };
        assert_eq!(Scan::new(one, descriptors.clone()), Err(lengths));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e100] {
            let points = vec![Point3::origin(), Point3::new(0.0, bad, 0.0)];
            let not_finite = Err(ScanError::BadCoordinate { index: 1 });
            assert_eq!(Scan::new(points, descriptors.clone()), not_finite);
        }
    }

    #[test]
    fn an_empty_scan_is_a_scan() {
        let scan = Scan::new(vec![], Descriptors::new(vec![], 33).unwrap()).unwrap();
        assert!(scan.is_empty());
    }
}
