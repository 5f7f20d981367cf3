//! Solved pose graphs for other programs, each with its own convention for information matrices.

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::{G2o, G2oEdge, G2oVertex, Open3dEdge, Open3dPoseGraph};

/// Scans with poses, and the relative poses that were measured between them.
///
/// Convert it by [`to_g2o`](Self::to_g2o) or [`to_open3d`](Self::to_open3d), and write the result.
///
/// # Example
/// ```
/// use gmpcr_io::{MeasuredEdge, PosedGraph};
/// use nalgebra::{Isometry3, Matrix6, Vector6};
///
/// let x = |x| Isometry3::translation(x, 0.0, 0.0);
/// // Standard deviations of 0.1 m and 0.05 rad.
/// let (t, r) = (100.0, 400.0);
/// let edge = MeasuredEdge {
///     i: 2,
///     j: 5,
///     i_from_j: x(3.0),
///     information: Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r)),
/// };
/// let graph = PosedGraph::new(vec![(2, x(0.0)), (5, x(3.0))], vec![edge])?;
///
/// let g2o = graph.to_g2o();
/// assert_eq!((g2o.edges[0].i, g2o.edges[0].j), (2, 5));
/// assert_eq!((g2o.edges[0].information[(0, 0)], g2o.edges[0].information[(3, 3)]), (t, 4.0 * r));
///
/// let open3d = graph.to_open3d();
/// assert_eq!((open3d.edges[0].target, open3d.edges[0].source), (0, 1));
/// assert_eq!((open3d.edges[0].information[(0, 0)], open3d.edges[0].information[(3, 3)]), (r, t));
/// # Ok::<(), gmpcr_io::PosedGraphError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PosedGraph {
    poses: Vec<(usize, Isometry3<f64>)>,
    /// Place of each scan among the poses.
    places: HashMap<usize, usize>,
    edges: Vec<MeasuredEdge>,
}

/// A measured relative pose and how certain it is.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredEdge {
    /// The scan into whose frame the relative pose maps.
    pub i: usize,
    /// The scan whose coordinates the relative pose maps.
    pub j: usize,
    /// The measured `world_from_i⁻¹ * world_from_j`.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub i_from_j: Isometry3<f64>,
    /// Inverse covariance of `ξ` in `true i_from_j = i_from_j * exp(ξ)`, in the order translation (in
    /// the unit of the scans), rotation (radians). Symmetric.
    pub information: Matrix6<f64>,
}

/// Why poses and edges do not form a [`PosedGraph`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PosedGraphError {
    /// A scan has more than one pose.
    #[error("scan {scan} has two poses")]
    TwoPoses {
        /// The scan.
        scan: usize,
    },
    /// An edge names a scan that has no pose.
    #[error("edge ({i}, {j}) names scan {scan}, which has no pose")]
    NoPose {
        /// First scan of the edge.
        i: usize,
        /// Second scan of the edge.
        j: usize,
        /// The scan without a pose.
        scan: usize,
    },
}

impl PosedGraph {
    /// Joins `(scan, world_from_scan)` and edges between these scans, in `O(poses + edges)`. Scans may
    /// have any numbers, in any order.
    ///
    /// # Errors
    /// [`PosedGraphError`] if a scan has two poses, or an edge names one without a pose.
    pub fn new(
        poses: Vec<(usize, Isometry3<f64>)>,
        edges: Vec<MeasuredEdge>,
    ) -> Result<Self, PosedGraphError> {
        let mut places = HashMap::with_capacity(poses.len());
        for (place, &(scan, _)) in poses.iter().enumerate() {
            if places.insert(scan, place).is_some() {
                return Err(PosedGraphError::TwoPoses { scan });
            }
        }
        for &MeasuredEdge { i, j, .. } in &edges {
            if let Some(scan) = [i, j].into_iter().find(|scan| !places.contains_key(scan)) {
                return Err(PosedGraphError::NoPose { i, j, scan });
            }
        }
        Ok(Self {
            poses,
            places,
            edges,
        })
    }

    /// The graph of Open3D: scans have the numbers of its nodes. What Open3D says of uncertainty and confidence
    /// does not count.
    ///
    /// A graph to be synchronized is
    /// [`G2oPoseGraph::new(&graph.to_g2o())`](crate::G2oPoseGraph::new), with the weights of that rule.
    ///
    /// # Errors
    /// [`PosedGraphError::NoPose`] if an edge names a node that is not there.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{G2oPoseGraph, Open3dEdge, Open3dPoseGraph, PosedGraph};
    /// use nalgebra::{Isometry3, Matrix6};
    ///
    /// let x = |x| Isometry3::translation(x, 0.0, 0.0);
    /// let edge = Open3dEdge {
    ///     source: 1,
    ///     target: 0,
    ///     target_from_source: x(3.0),
    ///     information: Matrix6::identity(),
    ///     uncertain: true,
    ///     confidence: 1.0,
    /// };
    /// let open3d = Open3dPoseGraph { nodes: vec![x(0.0), x(2.9)], edges: vec![edge] };
    /// let graph = PosedGraph::from_open3d(&open3d)?;
    /// assert_eq!(graph.to_open3d(), open3d);
    /// let graph = G2oPoseGraph::new(&graph.to_g2o())?.graph;
    /// assert_eq!(graph.edges()[0].i_from_j, x(3.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_open3d(open3d: &Open3dPoseGraph) -> Result<Self, PosedGraphError> {
        let edges = open3d.edges.iter().map(|edge| MeasuredEdge {
            i: edge.target,
            j: edge.source,
            i_from_j: edge.target_from_source,
            // The swap of the two halves is its own inverse.
            information: rotation_first(&edge.information),
        });
        let poses = open3d.nodes.iter().copied().enumerate();
        Self::new(poses.collect(), edges.collect())
    }

    /// The same graph where scans have coordinates of other frames: `new_from_old(k)` maps those of scan `k` to the
    /// new ones.
    ///
    /// With `N_k` this transformation and `r` the scan of the first pose, whose coordinates the world follows, a
    /// pose `T_k` becomes `N_r T_k N_k⁻¹`, a relative pose `T_ij` becomes `N_i T_ij N_j⁻¹`, and its information `Λ`
    /// becomes `Aᵀ Λ A` with the adjoint `A` of `N_j⁻¹`, so that every error costs the same as before.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{MeasuredEdge, PosedGraph};
    /// use nalgebra::{Isometry3, Matrix6};
    ///
    /// let x = |x| Isometry3::translation(x, 0.0, 0.0);
    /// let edge = MeasuredEdge { i: 0, j: 1, i_from_j: x(3.0), information: Matrix6::identity() };
    /// let graph = PosedGraph::new(vec![(0, x(0.0)), (1, x(3.0))], vec![edge])?;
    ///
    /// // Coordinates of both scans are counted from a place 100 m away.
    /// let far = graph.with_scan_frames(|_| Isometry3::translation(0.0, 100.0, 0.0)).to_g2o();
    /// assert_eq!(far.vertices, graph.to_g2o().vertices);
    /// // A rotation about the zero of scan 1 moves its points by a hundred times its angle.
    /// assert_eq!(far.edges[0].information[(5, 5)], 4.0 * (1.0 + 100.0 * 100.0));
    /// # Ok::<(), gmpcr_io::PosedGraphError>(())
    /// ```
    #[must_use]
    pub fn with_scan_frames(&self, new_from_old: impl Fn(usize) -> Isometry3<f64>) -> Self {
        let reference = self.poses.first().map_or(0, |&(scan, _)| scan);
        let changed = |i: usize, i_from_j: &Isometry3<f64>, j: usize| {
            new_from_old(i) * i_from_j * new_from_old(j).inverse()
        };
        let poses = self.poses.iter();
        let edges = self.edges.iter().map(|edge| {
            let adjoint = adjoint(&new_from_old(edge.j).inverse());
            MeasuredEdge {
                i: edge.i,
                j: edge.j,
                i_from_j: changed(edge.i, &edge.i_from_j, edge.j),
                information: adjoint.transpose() * edge.information * adjoint,
            }
        });
        Self {
            poses: poses
                .map(|(scan, pose)| (*scan, changed(reference, pose, *scan)))
                .collect(),
            edges: edges.collect(),
            places: self.places.clone(),
        }
    }

    /// The graph for g2o; ids are the numbers of the scans.
    ///
    /// g2o measures a rotation by the vector part of its unit quaternion, half of the angle. With
    /// `S = diag(1, 1, 1, 2, 2, 2)` its information is `S Λ S` for the information `Λ` of an edge: the
    /// rotation block is four times as large.
    #[must_use]
    pub fn to_g2o(&self) -> G2o {
        let vertices = self.poses.iter().map(|&(id, world_from_vertex)| G2oVertex {
            id,
            world_from_vertex,
        });
        let edges = self.edges.iter().map(|edge| G2oEdge {
            i: edge.i,
            j: edge.j,
            i_from_j: edge.i_from_j,
            information: of_half_angles(&edge.information),
        });
        G2o {
            vertices: vertices.collect(),
            edges: edges.collect(),
        }
    }

    /// The graph for Open3D; nodes are numbered from 0 in the order of the poses.
    ///
    /// Open3D has rotation first, in radians. An edge maps its source, `j`, into its target, `i`. All
    /// edges are uncertain and have confidence 1.
    #[must_use]
    pub fn to_open3d(&self) -> Open3dPoseGraph {
        let edges = self.edges.iter().map(|edge| Open3dEdge {
            source: self.places[&edge.j],
            target: self.places[&edge.i],
            target_from_source: edge.i_from_j,
            information: rotation_first(&edge.information),
            uncertain: true,
            confidence: 1.0,
        });
        Open3dPoseGraph {
            nodes: self.poses.iter().map(|&(_, pose)| pose).collect(),
            edges: edges.collect(),
        }
    }
}

/// Maps a tangent `(v, ω)` at the right of a transformation to the frame that `transformation` leads to:
/// `(R v + t × R ω, R ω)`.
fn adjoint(transformation: &Isometry3<f64>) -> Matrix6<f64> {
    let rotation = transformation.rotation.to_rotation_matrix().into_inner();
    let moment = transformation.translation.vector.cross_matrix() * rotation;
    let mut adjoint = Matrix6::zeros();
    adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    adjoint.fixed_view_mut::<3, 3>(0, 3).copy_from(&moment);
    adjoint
}

/// `S Λ S` with `S = diag(1, 1, 1, 2, 2, 2)`.
fn of_half_angles(information: &Matrix6<f64>) -> Matrix6<f64> {
    let scale = Vector6::new(1.0, 1.0, 1.0, 2.0, 2.0, 2.0);
    Matrix6::from_fn(|row, column| information[(row, column)] * (scale[row] * scale[column]))
}

/// Rows and columns with their halves swapped.
fn rotation_first(information: &Matrix6<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| information[((row + 3) % 6, (column + 3) % 6)])
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    fn edge(i: usize, j: usize) -> MeasuredEdge {
        MeasuredEdge {
            i,
            j,
            i_from_j: Isometry3::identity(),
            information: Matrix6::identity(),
        }
    }

    fn poses(scans: &[usize]) -> Vec<(usize, Isometry3<f64>)> {
        let pose = |&scan: &usize| (scan, Isometry3::translation(scan as f64, 0.0, 0.0));
        scans.iter().map(pose).collect()
    }

    #[test]
    fn scans_without_a_pose_or_with_two_are_named() {
        let complaint = |scans: &[usize], edges: Vec<MeasuredEdge>| {
            let error = PosedGraph::new(poses(scans), edges).unwrap_err();
            error.to_string()
        };
        assert_eq!(complaint(&[3, 7, 4, 7], vec![]), "scan 7 has two poses");
        assert_eq!(
            complaint(&[3, 7], vec![edge(3, 7), edge(7, 5)]),
            "edge (7, 5) names scan 5, which has no pose"
        );
        assert!(PosedGraph::new(vec![], vec![]).is_ok());
    }

    #[test]
    fn errors_cost_the_same_in_other_coordinates() {
        let frame = |scan: usize| {
            let k = scan as f64;
            Isometry3::new(
                Vector3::new(50.0, -k, 9.0),
                Vector3::new(0.2, 0.5 * k, -1.0),
            )
        };
        let small = Isometry3::new(
            Vector3::new(2e-4, -1e-4, 3e-4),
            Vector3::new(1e-4, 4e-4, -2e-4),
        );
        let root = Matrix6::from_fn(|row, column| ((3 * row + 5 * column) as f64).sin());
        let measured = MeasuredEdge {
            information: root * root.transpose() + Matrix6::identity(),
            ..edge(2, 5)
        };
        let graph = PosedGraph::new(poses(&[2, 5]), vec![measured]).unwrap();
        let moved = graph.with_scan_frames(frame);
        let cost = |edge: &MeasuredEdge, true_i_from_j: &Isometry3<f64>| {
            let error = edge.i_from_j.inv_mul(true_i_from_j);
            let (v, w) = (error.translation.vector, error.rotation.scaled_axis());
            let tangent = Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z);
            (tangent.transpose() * edge.information * tangent).x
        };
        let before = cost(&graph.edges[0], &small);
        let after = cost(&moved.edges[0], &(frame(2) * small * frame(5).inverse()));
        assert!((after / before - 1.0).abs() < 0.01, "{before} and {after}");
    }

    #[test]
    fn open3d_counts_nodes_without_gaps_in_the_order_of_the_poses() {
        let graph = PosedGraph::new(poses(&[9, 2, 5]), vec![edge(2, 9), edge(5, 2)]).unwrap();
        let open3d = graph.to_open3d();
        assert_eq!(open3d.nodes[0].translation.x, 9.0);
        let ends = open3d.edges.iter().map(|edge| (edge.target, edge.source));
        assert_eq!(ends.collect::<Vec<_>>(), [(1, 0), (2, 1)]);
        assert!(open3d.edges.iter().all(|edge| edge.uncertain));
    }

    #[test]
    fn blocks_of_the_information_go_where_the_formats_have_them() {
        let entry = |row: usize, column: usize| (10 * row.min(column) + row.max(column)) as f64;
        let information = Matrix6::from_fn(entry);
        let edges = vec![MeasuredEdge {
            information,
            ..edge(0, 1)
        }];
        let graph = PosedGraph::new(poses(&[0, 1]), edges).unwrap();
        let g2o = graph.to_g2o().edges[0].information;
        assert_eq!(g2o[(0, 2)], entry(0, 2));
        assert_eq!(g2o[(1, 4)], 2.0 * entry(1, 4));
        assert_eq!(g2o[(5, 3)], 4.0 * entry(5, 3));
        let open3d = graph.to_open3d().edges[0].information;
        assert_eq!(open3d[(0, 2)], entry(3, 5));
        assert_eq!(open3d[(1, 4)], entry(4, 1));
        assert_eq!(open3d[(5, 3)], entry(2, 0));
        assert_eq!(g2o, g2o.transpose());
        assert_eq!(open3d, open3d.transpose());
    }
}
