use nalgebra::Isometry3;

/// A measured relative pose of two scans and how much it is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEdge {
    /// The scan into whose frame the motion maps.
    pub i: usize,
    /// The scan from whose frame the motion maps.
    pub j: usize,
    /// The motion `T_ij ≈ T_i⁻¹ T_j`: `x_i = i_from_j * x_j`.
    pub i_from_j: Isometry3<f64>,
    /// Initial weight `w_ij⁽⁰⁾`, in [0, 1e100]; only ratios between edges matter.
    pub weight: f64,
}

/// Scans as nodes, measured relative poses as weighted edges.
///
/// Edges may point either way, and two scans may share several.
///
/// ```
/// use gmpcr_posegraph::{PoseEdge, PoseGraph};
/// use nalgebra::Isometry3;
///
/// let step = Isometry3::translation(1.0, 0.0, 0.0);
/// let edge = |i, j| PoseEdge { i, j, i_from_j: step, weight: 1.0 };
/// let graph = PoseGraph::new(3, vec![edge(0, 1), edge(1, 2)])?;
/// assert_eq!((graph.num_scans(), graph.edges().len()), (3, 2));
/// assert!(PoseGraph::new(2, vec![edge(1, 2)]).is_err());
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PoseGraph {
    num_scans: usize,
    edges: Vec<PoseEdge>,
}

/// Why edges do not form a [`PoseGraph`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseGraphError {
    /// An edge names a scan that does not exist.
    #[error("edge ({i}, {j}) names a scan outside 0..{num_scans}")]
    ScanOutOfRange {
        /// First scan of the edge.
        i: usize,
        /// Second scan of the edge.
        j: usize,
        /// Number of scans.
        num_scans: usize,
    },
    /// An edge joins a scan with itself.
    #[error("edge ({i}, {i}) joins a scan with itself")]
    Loop {
        /// The scan.
        i: usize,
    },
    /// A weight is not in [0, 1e100].
    #[error("edge ({i}, {j}) has weight {weight}: it must be in [0, 1e100]")]
    InvalidWeight {
        /// First scan of the edge.
        i: usize,
        /// Second scan of the edge.
        j: usize,
        /// Its weight.
        weight: f64,
    },
    /// A motion has no unit quaternion, or a translation that is not a number within ±1e100.
    #[error("edge ({i}, {j}) has no unit quaternion or a translation that is not within ±1e100")]
    InvalidMotion {
        /// First scan of the edge.
        i: usize,
        /// Second scan of the edge.
        j: usize,
    },
}

impl PoseGraph {
    /// Joins `num_scans` scans by `edges`.
    ///
    /// # Errors
    /// [`PoseGraphError`] if an edge names a scan outside `0..num_scans`, joins a scan with itself,
    /// or has a weight outside [0, 1e100] or a motion that is none.
    pub fn new(num_scans: usize, edges: Vec<PoseEdge>) -> Result<Self, PoseGraphError> {
        edges
            .iter()
            .try_for_each(|edge| validate(edge, num_scans))?;
        Ok(Self { num_scans, edges })
    }

    /// Number of scans.
    pub fn num_scans(&self) -> usize {
        self.num_scans
    }

    /// The edges, in the order they were given.
    pub fn edges(&self) -> &[PoseEdge] {
        &self.edges
    }
}

/// The largest weight or length: sums of squares of them are finite.
const LARGEST: f64 = 1e100;

fn validate(edge: &PoseEdge, num_scans: usize) -> Result<(), PoseGraphError> {
    let &PoseEdge {
        i,
        j,
        ref i_from_j,
        weight,
    } = edge;
    if i >= num_scans || j >= num_scans {
        return Err(PoseGraphError::ScanOutOfRange { i, j, num_scans });
    }
    if i == j {
        return Err(PoseGraphError::Loop { i });
    }
    if !(0.0..=LARGEST).contains(&weight) {
        return Err(PoseGraphError::InvalidWeight { i, j, weight });
    }
    let is_rotation = (i_from_j.rotation.norm() - 1.0).abs() < 1e-6;
    let is_usable = |t: &f64| t.abs() <= LARGEST;
    if !(is_rotation && i_from_j.translation.vector.iter().all(is_usable)) {
        return Err(PoseGraphError::InvalidMotion { i, j });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_is_wrong_with_an_edge() {
        let good = PoseEdge {
            i: 0,
            j: 1,
            i_from_j: Isometry3::identity(),
            weight: 1.0,
        };
        let error = |edge| PoseGraph::new(2, vec![good, edge]).unwrap_err().to_string();
        let cases = [
            (
                PoseEdge { j: 2, ..good },
                "edge (0, 2) names a scan outside 0..2",
            ),
            (
                PoseEdge { j: 0, ..good },
                "edge (0, 0) joins a scan with itself",
            ),
            (
                PoseEdge {
                    weight: -1.0,
                    ..good
                },
                "edge (0, 1) has weight -1",
            ),
            (
                PoseEdge {
                    weight: f64::NAN,
                    ..good
                },
                "edge (0, 1) has weight NaN",
            ),
            (
                PoseEdge {
                    i_from_j: Isometry3::translation(f64::NAN, 0.0, 0.0),
                    ..good
                },
                "edge (0, 1) has no unit quaternion or a translation",
            ),
        ];
        for (edge, message) in cases {
            assert!(error(edge).starts_with(message), "{}", error(edge));
        }
    }

    #[test]
    fn edges_may_point_either_way_and_repeat() {
        let edge = |i, j| PoseEdge {
            i,
            j,
            i_from_j: Isometry3::identity(),
            weight: 0.0,
        };
        assert!(PoseGraph::new(2, vec![edge(0, 1), edge(1, 0), edge(0, 1)]).is_ok());
        assert!(PoseGraph::new(0, vec![]).is_ok());
    }
}
