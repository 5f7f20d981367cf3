use gmpcr_geometry::SignedSvd3;
use gmpcr_posegraph::PoseGraph;
use nalgebra::{DMatrix, Matrix3, Rotation3};

use crate::eigenspace::{Eigenspace, smallest_eigenvectors};
use crate::laplacian::ConnectionLaplacian;
use crate::subgraph::{Subgraph, relative};

/// Rotations of all scans of a connected graph, and how well their eigenproblem was solved.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct AveragedRotations {
    /// `R_i`, from the scan's frame into that of scan 0, which has the identity.
    #[cfg_attr(feature = "serde", serde(with = "crate::rotation_rows"))]
    pub world_from_scan: Vec<Rotation3<f64>>,
    /// Largest residual of the three eigenvectors in units of the largest weighted degree: whether
    /// the eigenproblem was solved (below 1e-11), not whether its solution is a good one.
    pub eigen_residual: f64,
    /// Smallest over largest singular value of the scans' 3×3 blocks, in [0, 1]: 1 for consistent
    /// measurements, near 0 where the eigenvectors dwell on a part of the graph that only weak or
    /// contradictory edges connect with the rest. The rotations of the rest are then unreliable.
    pub weakest_block: f64,
}

/// Rotation averaging: the spectral relaxation of `argmin Σ w_ij ‖R̂_ij − R_iᵀ R_j‖_F²`.
///
/// The eigenvectors of the three smallest eigenvalues of the weighted connection Laplacian form an
/// `N × 3×3` block matrix whose blocks approximate `R_iᵀ` up to one common orthogonal factor. A
/// reflection is removed once for all scans (one eigenvector changes sign where most blocks have a
/// negative determinant), and each block is projected onto SO(3) (Arie-Nachimson et al. 2012).
/// Exact for noise-free measurements. `weights` holds one weight per edge of `graph`.
///
/// # Panics
/// If there is not one weight per edge.
///
/// ```
/// use gmpcr_posegraph::{PoseEdge, PoseGraph};
/// use gmpcr_sync::average_rotations;
/// use nalgebra::{Isometry3, Vector3};
///
/// let quarter = Isometry3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2);
/// let edge = |i, j| PoseEdge { i, j, i_from_j: quarter, weight: 1.0 };
/// let ring = PoseGraph::new(4, vec![edge(0, 1), edge(1, 2), edge(2, 3), edge(3, 0)])?;
/// let rotations = average_rotations(&ring, &[1.0; 4]).world_from_scan;
/// assert!((rotations[2].angle() - std::f64::consts::PI).abs() < 1e-7);
/// # Ok::<(), gmpcr_posegraph::PoseGraphError>(())
/// ```
pub fn average_rotations(graph: &PoseGraph, weights: &[f64]) -> AveragedRotations {
    assert_eq!(weights.len(), graph.edges().len(), "one weight per edge");
    let graph = Subgraph::whole(graph);
    RotationAverager::new(&graph, weights).solve(weights)
}

/// Averages the rotations of one graph again and again under changing weights: the pattern is
/// analyzed once, and each search starts from the eigenvectors of the last.
pub(crate) struct RotationAverager<'a> {
    laplacian: ConnectionLaplacian<'a>,
    /// Of the last weights.
    eigenspace: Eigenspace,
}

impl<'a> RotationAverager<'a> {
    /// Starts from the rotations along a spanning tree of maximal weight.
    pub fn new(graph: &'a Subgraph, weights: &[f64]) -> Self {
        let rotations = graph.rotations_along(&graph.spanning_tree(weights));
        let entry = |row: usize, column: usize| rotations[row / 3].matrix()[(column, row % 3)];
        Self {
            laplacian: ConnectionLaplacian::new(graph),
            eigenspace: Eigenspace::guess(DMatrix::from_fn(3 * graph.num_nodes, 3, entry)),
        }
    }

    pub fn solve(&mut self, weights: &[f64]) -> AveragedRotations {
        self.laplacian.set_weights(&relative(weights));
        self.eigenspace = smallest_eigenvectors(&mut self.laplacian, 3, &self.eigenspace);
        let (world_from_scan, weakest_block) = project_blocks(&self.eigenspace.vectors);
        AveragedRotations {
            world_from_scan,
            eigen_residual: self.eigenspace.residual,
            weakest_block,
        }
    }
}

/// Rotations from the first three eigenvectors, in the gauge of the first block, and the ratio of
/// the smallest to the largest singular value of all blocks.
fn project_blocks(vectors: &DMatrix<f64>) -> (Vec<Rotation3<f64>>, f64) {
    let block = |node: usize| vectors.fixed_view::<3, 3>(3 * node, 0).into_owned();
    let (scan_from_world, weakest_block) =
        nearest_rotations((0..vectors.nrows() / 3).map(block).collect());
    let Some((reference, others)) = scan_from_world.split_first() else {
        return (Vec::new(), 1.0);
    };
    let in_its_frame = others.iter().map(|rotation| reference * rotation.inverse());
    let rotations = std::iter::once(Rotation3::identity()).chain(in_its_frame);
    (rotations.collect(), weakest_block)
}

/// Projects blocks that are rotations up to scale, noise, and a common orthogonal factor onto SO(3),
/// after the reflection of most blocks is removed from all. Also returns the ratio of the smallest to
/// the largest singular value of all blocks.
pub(crate) fn nearest_rotations(mut blocks: Vec<Matrix3<f64>>) -> (Vec<Rotation3<f64>>, f64) {
    let num_reflected = blocks
        .iter()
        .filter(|block| block.determinant() < 0.0)
        .count();
    if 2 * num_reflected > blocks.len() {
        blocks
            .iter_mut()
            .for_each(|block| block.column_mut(2).neg_mut());
    }
    let decomposed: Vec<_> = blocks.iter().map(SignedSvd3::new).collect();
    let smallest = decomposed
        .iter()
        .map(|svd| svd.singular_values[2].abs())
        .fold(1.0, f64::min);
    let largest = decomposed
        .iter()
        .map(|svd| svd.singular_values[0])
        .fold(0.0, f64::max);
    let rotations = decomposed
        .iter()
        .map(SignedSvd3::nearest_rotation)
        .collect();
    (rotations, smallest / largest)
}
