use nalgebra::{Isometry3, Point3, Vector3};

/// The largest coordinate that is accepted: its square, summed over many points, is finite.
pub const MAX_COORDINATE: f64 = 1e100;

/// Whether all coordinates are numbers within ±[`MAX_COORDINATE`].
pub fn is_usable(coordinates: &Vector3<f64>) -> bool {
    coordinates.iter().all(|c| c.abs() <= MAX_COORDINATE)
}

/// Corresponding points of two scans: `target()[m]` and `source()[m]` may be one place.
///
/// For a pair of scans (i, j) the target is scan i and the source scan j, each in its own frame:
/// the correspondences `C_ij = {(x_m^i, x_m^j)}` of the paper. Any fraction of them may be outliers.
///
/// ```
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::Point3;
///
/// let target = vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0)];
/// let source = vec![Point3::new(0.0, 0.0, 5.0), Point3::new(0.0, 1.0, 5.0)];
/// let pairs = PointPairs::new(target, source)?;
/// assert_eq!(pairs.len(), 2);
/// assert_eq!(pairs.swapped().target(), pairs.source());
/// # Ok::<(), gmpcr_geometry::PairsError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct PointPairs {
    target: Vec<Point3<f64>>,
    source: Vec<Point3<f64>>,
}

/// Pairs as a file has them.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "PointPairs", deny_unknown_fields)]
struct Unchecked {
    target: Vec<Point3<f64>>,
    source: Vec<Point3<f64>>,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for PointPairs {
    type Error = PairsError;

    fn try_from(pairs: Unchecked) -> Result<Self, PairsError> {
        Self::new(pairs.target, pairs.source)
    }
}

/// Why two lists of points are no [`PointPairs`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PairsError {
    /// The lists differ in length.
    #[error("{target} target points do not pair with {source_points} source points")]
    LengthsDiffer {
        /// Number of target points.
        target: usize,
        /// Number of source points.
        source_points: usize,
    },
    /// A coordinate is NaN, infinite, or beyond ±[`MAX_COORDINATE`].
    #[error("point pair {index} has a coordinate that is not a number within ±1e100")]
    BadCoordinate {
        /// The first such pair.
        index: usize,
    },
}

impl PointPairs {
    /// Pairs `target[m]` with `source[m]`.
    ///
    /// # Errors
    /// [`PairsError`] if the lengths differ or a coordinate is not a number within
    /// ±[`MAX_COORDINATE`].
    pub fn new(target: Vec<Point3<f64>>, source: Vec<Point3<f64>>) -> Result<Self, PairsError> {
        if target.len() != source.len() {
            return Err(PairsError::LengthsDiffer {
                target: target.len(),
                source_points: source.len(),
            });
        }
        let is_good = |&m: &usize| is_usable(&target[m].coords) && is_usable(&source[m].coords);
        match (0..target.len()).find(|m| !is_good(m)) {
            Some(index) => Err(PairsError::BadCoordinate { index }),
            None => Ok(Self { target, source }),
        }
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.target.len()
    }

    /// Whether there is no pair.
    pub fn is_empty(&self) -> bool {
        self.target.is_empty()
    }

    /// The points in the target's frame (scan i).
    pub fn target(&self) -> &[Point3<f64>] {
        &self.target
    }

    /// The points in the source's frame (scan j).
    pub fn source(&self) -> &[Point3<f64>] {
        &self.source
    }

    /// The pairs at `indices`, in that order.
    ///
    /// # Panics
    /// If an index is `len()` or more.
    pub fn select(&self, indices: &[usize]) -> Self {
        Self {
            target: indices.iter().map(|&m| self.target[m]).collect(),
            source: indices.iter().map(|&m| self.source[m]).collect(),
        }
    }

    /// The same pairs with the roles of target and source exchanged.
    pub fn swapped(&self) -> Self {
        Self {
            target: self.source.clone(),
            source: self.target.clone(),
        }
    }

    /// Distance `‖target_m − target_from_source · source_m‖` of every pair, in the unit of the input.
    pub fn residuals<'a>(
        &'a self,
        target_from_source: &'a Isometry3<f64>,
    ) -> impl Iterator<Item = f64> + 'a {
        self.target
            .iter()
            .zip(&self.source)
            .map(move |(target, source)| (target - target_from_source * source).norm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_makes_lists_no_pairs() {
        let p = Point3::origin();
        let nan = Point3::new(0.0, f64::NAN, 0.0);
        let infinite = Point3::new(f64::INFINITY, 0.0, 0.0);
        let huge = Point3::new(0.0, 0.0, -1.1e100);
        let lengths = PointPairs::new(vec![p; 3], vec![p; 2]).unwrap_err();
        assert_eq!(
            lengths.to_string(),
            "3 target points do not pair with 2 source points"
        );
        let not_finite = Err(PairsError::BadCoordinate { index: 1 });
        assert_eq!(PointPairs::new(vec![p, nan], vec![p; 2]), not_finite);
        assert_eq!(PointPairs::new(vec![p; 2], vec![p, infinite]), not_finite);
        assert_eq!(PointPairs::new(vec![p; 2], vec![p, huge]), not_finite);
    }

    #[test]
    fn residuals_vanish_under_the_transformation_of_the_points_only() {
        let source = vec![Point3::new(1.0, 2.0, 3.0), Point3::new(-1.0, 0.5, 0.0)];
        let transformation = Isometry3::translation(0.0, 3.0, 4.0);
        let target = source.iter().map(|p| transformation * p).collect();
        let pairs = PointPairs::new(target, source).unwrap();
        assert!(pairs.residuals(&transformation).all(|r| r < 1e-15));
        assert!(
            pairs
                .residuals(&Isometry3::identity())
                .all(|r| (r - 5.0).abs() < 1e-15)
        );
    }
}
