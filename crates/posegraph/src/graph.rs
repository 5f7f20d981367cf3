use gmpcr_geometry::is_usable;
use nalgebra::Isometry3;

/// A measured relative pose of two scans and how much it is trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PoseEdge {
    /// The scan into whose frame the relative pose maps.
    pub i: usize,
    /// The scan from whose frame the relative pose maps.
    pub j: usize,
    /// The relative pose `T_ij ≈ T_i⁻¹ T_j`: `x_i = i_from_j * x_j`.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// Initial weight `w_ij⁽⁰⁾`, in [0, 1e100]; only ratios between edges matter.
    pub weight: f64,
}

/// Scans as nodes, measured relative poses as weighted edges.
///
/// Edges may point either way, and two scans may share several. To change a graph, take its edges out
/// and build it again, which checks them anew.
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
///
/// // Distrust the first edge, remove the second, and add another.
/// let num_scans = graph.num_scans();
/// let mut edges = graph.into_edges();
/// edges[0].weight = 0.1;
/// edges.remove(1);
/// edges.push(edge(0, 2));
/// let graph = PoseGraph::new(num_scans, edges)?;
/// assert_eq!((graph.edges()[0].weight, graph.edges()[1].j), (0.1, 2));
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "UncheckedGraph")
)]
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
    /// A relative pose has no unit quaternion, or a translation that is not a number within ±1e100.
    #[error("edge ({i}, {j}) has no unit quaternion or a translation that is not within ±1e100")]
    InvalidRelativePose {
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
    /// or has a weight outside [0, 1e100] or a relative pose that is not rigid.
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

    /// The edges, to be changed; see the example of [`PoseGraph`].
    pub fn into_edges(self) -> Vec<PoseEdge> {
        self.edges
    }
}

/// The graph as it stands in files.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct UncheckedGraph {
    num_scans: usize,
    edges: Vec<PoseEdge>,
}

#[cfg(feature = "serde")]
impl TryFrom<UncheckedGraph> for PoseGraph {
    type Error = PoseGraphError;

    fn try_from(
        UncheckedGraph { num_scans, edges }: UncheckedGraph,
    ) -> Result<Self, PoseGraphError> {
        Self::new(num_scans, edges)
    }
}

/// The largest weight: sums of squares of weights are finite.
const MAX_WEIGHT: f64 = 1e100;

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
    if !(0.0..=MAX_WEIGHT).contains(&weight) {
        return Err(PoseGraphError::InvalidWeight { i, j, weight });
    }
    let is_rotation = (i_from_j.rotation.norm() - 1.0).abs() < 1e-6;
    if !(is_rotation && is_usable(&i_from_j.translation.vector)) {
        return Err(PoseGraphError::InvalidRelativePose { i, j });
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

    #[cfg(feature = "serde")]
    #[test]
    fn graphs_of_files_are_checked() {
        let edge = PoseEdge {
            i: 1,
            j: 0,
            i_from_j: Isometry3::translation(1.0, -2.0, 0.5),
            weight: 0.5,
        };
        let graph = PoseGraph::new(2, vec![edge]).unwrap();
        let text = serde_json::to_string(&graph).unwrap();
        assert_eq!(serde_json::from_str::<PoseGraph>(&text).unwrap(), graph);
        let negative = text.replace(r#""weight":0.5"#, r#""weight":-0.5"#);
        let error = serde_json::from_str::<PoseGraph>(&negative).unwrap_err();
        assert!(
            error.to_string().contains("edge (1, 0) has weight -0.5"),
            "{error}"
        );
    }
}
