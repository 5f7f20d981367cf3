//! Measured relative poses of which a known ratio are outliers.

use std::collections::BTreeSet;
use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::error::{Error, InvalidParameter, check_count, check_range};
use crate::random::{Stream, count, gaussian, generator, point_in_cube, rotation, uniform};

/// Which pose graph to simulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseGraphSimParams {
    /// The same seed gives the same bits. Default 0.
    pub seed: u64,
    /// Number of scans, 1 to a million. Default 50.
    pub num_scans: usize,
    /// Mean number of edges at a scan, 0 to 1000; a spanning tree is always there. Default 10.
    pub degree: f64,
    /// Which scans are joined. Default [`Topology::Random`].
    pub topology: Topology,
    /// Standard deviation of the rotation vector's components, in radians, 0 to 1. Default 2°.
    pub rotation_noise: f64,
    /// Standard deviation of the translation's components, 0 to 1e6. Default 0.05.
    pub translation_noise: f64,
    /// Ratio of outliers among all edges, 0 to 1. Default 0.
    pub outlier_ratio: f64,
    /// What outlier edges measure. Default [`Outliers::Uniform`].
    pub outliers: Outliers,
    /// How edges are weighted. Default [`EdgeWeights::Equal`].
    pub weights: EdgeWeights,
    /// Side of the cube that holds the scans, 0 to 1e6. Default 10.
    pub extent: f64,
}

/// Which scans are joined by edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topology {
    /// A random tree and pairs drawn uniformly: an expander.
    Random,
    /// Neighbors in space, as scans that overlap: the Euclidean minimum spanning tree and the
    /// shortest edges of the graph of nearest neighbors.
    Geometric,
}

/// What the outlier edges of a simulated pose graph measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outliers {
    /// Each its own: a uniform rotation, and a translation uniform in a cube of twice the extent.
    Uniform,
    /// One false set of poses: relative poses of a second set, with the noise of the inliers
    /// (perceptual aliasing).
    Coherent,
}

/// Weights of the edges of a simulated pose graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeWeights {
    /// One everywhere.
    Equal,
    /// Uniform in 0.5..1 for inliers and in 0..0.7 for outliers.
    Informative,
}

impl Default for PoseGraphSimParams {
    fn default() -> Self {
        Self {
            seed: 0,
            num_scans: 50,
            degree: 10.0,
            topology: Topology::Random,
            rotation_noise: 2.0_f64.to_radians(),
            translation_noise: 0.05,
            outlier_ratio: 0.0,
            outliers: Outliers::Uniform,
            weights: EdgeWeights::Equal,
            extent: 10.0,
        }
    }
}

/// A pose graph with its ground truth.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedPoseGraph {
    /// Ground truth poses: uniform rotations, positions uniform in the cube.
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// The measurements, in random order.
    pub edges: Vec<SimulatedEdge>,
}

/// A measured relative pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedEdge {
    /// The scan into whose frame the relative pose maps.
    pub i: usize,
    /// The scan from whose frame the relative pose maps; `i < j`.
    pub j: usize,
    /// The measured relative pose.
    pub i_from_j: Isometry3<f64>,
    /// How much it is trusted.
    pub weight: f64,
    /// Whether it measures the ground truth.
    pub is_inlier: bool,
}

/// Simulates a pose graph: `T̂_ij = T_i⁻¹ T_j` with `R̂_ij = R_ij exp(ε)`, `t̂_ij = t_ij + η` and
/// Gaussian `ε`, `η`; of all edges, those of the spanning tree among them, a ratio are outliers.
///
/// `O(N log N + E log E)`.
///
/// # Errors
/// [`Error`] if a parameter is out of range.
///
/// ```
/// use gmpcr_sim::{PoseGraphSimParams, simulate_pose_graph};
///
/// let params = PoseGraphSimParams { outlier_ratio: 0.2, ..PoseGraphSimParams::default() };
/// let graph = simulate_pose_graph(&params)?;
/// assert_eq!((graph.world_from_scan.len(), graph.edges.len()), (50, 250));
/// assert_eq!(graph.edges.iter().filter(|edge| !edge.is_inlier).count(), 50);
/// # Ok::<(), gmpcr_sim::Error>(())
/// ```
pub fn simulate_pose_graph(params: &PoseGraphSimParams) -> Result<SimulatedPoseGraph, Error> {
    params.validate()?;
    let mut rng = generator(params.seed, Stream::PoseGraph);
    let world_from_scan = random_poses(params, &mut rng);
    let alias = random_poses(params, &mut rng);
    let mut pairs = match params.topology {
        Topology::Random => random_pairs(params, &mut rng),
        Topology::Geometric => neighboring_pairs(params, &world_from_scan),
    };
    // The first of the shuffled pairs are the outliers; a second shuffle hides which.
    pairs.shuffle(&mut rng);
    let num_outliers = (params.outlier_ratio * pairs.len() as f64).round() as usize;
    let poses = Poses {
        ground_truth: &world_from_scan,
        alias: &alias,
    };
    let edge = |(position, pair)| poses.edge(pair, position >= num_outliers, params, &mut rng);
    let mut edges: Vec<_> = pairs.into_iter().enumerate().map(edge).collect();
    edges.shuffle(&mut rng);
    Ok(SimulatedPoseGraph {
        world_from_scan,
        edges,
    })
}

/// The poses that edges measure.
struct Poses<'a> {
    ground_truth: &'a [Isometry3<f64>],
    /// What coherent outliers measure.
    alias: &'a [Isometry3<f64>],
}

impl Poses<'_> {
    fn edge(
        &self,
        (i, j): (usize, usize),
        is_inlier: bool,
        params: &PoseGraphSimParams,
        rng: &mut ChaCha8Rng,
    ) -> SimulatedEdge {
        let i_from_j = match params.outliers {
            _ if is_inlier => measured(self.ground_truth, i, j, params, rng),
            Outliers::Coherent => measured(self.alias, i, j, params, rng),
            Outliers::Uniform => {
                let translation = point_in_cube(rng, 2.0 * params.extent);
                Isometry3::from_parts(translation.into(), rotation(rng))
            }
        };
        let weight = match (params.weights, is_inlier) {
            (EdgeWeights::Equal, _) => 1.0,
            (EdgeWeights::Informative, true) => uniform(rng, 0.5, 1.0),
            (EdgeWeights::Informative, false) => uniform(rng, 0.0, 0.7),
        };
        SimulatedEdge {
            i,
            j,
            i_from_j,
            weight,
            is_inlier,
        }
    }
}

impl PoseGraphSimParams {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_count("num_scans", self.num_scans)?;
        check_range("degree", self.degree, 0.0..=1000.0, "in [0, 1000]")?;
        check_range(
            "rotation_noise",
            self.rotation_noise,
            0.0..=1.0,
            "in [0, 1]",
        )?;
        check_range(
            "translation_noise",
            self.translation_noise,
            0.0..=1e6,
            "in [0, 1e6]",
        )?;
        check_range("outlier_ratio", self.outlier_ratio, 0.0..=1.0, "in [0, 1]")?;
        check_range("extent", self.extent, 0.0..=1e6, "in [0, 1e6]")
    }

    /// Edges wanted in all, as far as there are pairs.
    fn num_edges(&self) -> usize {
        let num_pairs = self.num_scans * (self.num_scans - 1) / 2;
        let wanted = (0.5 * self.num_scans as f64 * self.degree).round() as usize;
        wanted.max(self.num_scans - 1).min(num_pairs)
    }
}

fn random_poses(params: &PoseGraphSimParams, rng: &mut ChaCha8Rng) -> Vec<Isometry3<f64>> {
    let mut pose = || {
        let rotation = rotation(rng);
        Isometry3::from_parts(point_in_cube(rng, params.extent).into(), rotation)
    };
    (0..params.num_scans).map(|_| pose()).collect()
}

fn measured(
    world_from_scan: &[Isometry3<f64>],
    i: usize,
    j: usize,
    params: &PoseGraphSimParams,
    rng: &mut ChaCha8Rng,
) -> Isometry3<f64> {
    let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
    let rotation = UnitQuaternion::from_scaled_axis(gaussian(rng) * params.rotation_noise);
    let translation = Translation3::from(gaussian(rng) * params.translation_noise);
    Isometry3::from_parts(
        translation * i_from_j.translation,
        i_from_j.rotation * rotation,
    )
}

/// A random tree, every scan joined to an earlier one of a random order, and uniform pairs.
fn random_pairs(params: &PoseGraphSimParams, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..params.num_scans).collect();
    order.shuffle(rng);
    let mut pairs = BTreeSet::new();
    for place in 1..params.num_scans {
        pairs.insert(ascending(order[place], order[count(rng, 0, place - 1)]));
    }
    while pairs.len() < params.num_edges() {
        let (a, b) = (
            count(rng, 0, params.num_scans - 1),
            count(rng, 0, params.num_scans - 1),
        );
        if a != b {
            pairs.insert(ascending(a, b));
        }
    }
    pairs.into_iter().collect()
}

/// The minimum spanning tree (Kruskal) and then the shortest pairs of the graph of nearest
/// neighbors. That graph is connected unless the scans lie in far clusters, which they do not.
fn neighboring_pairs(
    params: &PoseGraphSimParams,
    world_from_scan: &[Isometry3<f64>],
) -> Vec<(usize, usize)> {
    let mut candidates = nearest_neighbors(params, world_from_scan);
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    candidates.dedup();
    let mut parent: Vec<usize> = (0..params.num_scans).collect();
    let (tree, others): (Vec<_>, Vec<_>) = candidates.into_iter().partition(|&(_, (i, j))| {
        let (i, j) = (root(&mut parent, i), root(&mut parent, j));
        parent[j] = i;
        i != j
    });
    let pairs = tree.into_iter().chain(others).map(|(_, pair)| pair);
    pairs.take(params.num_edges()).collect()
}

/// Pairs of scans near each other with their squared distances, some of them twice.
fn nearest_neighbors(
    params: &PoseGraphSimParams,
    world_from_scan: &[Isometry3<f64>],
) -> Vec<(f64, (usize, usize))> {
    let position = |pose: &Isometry3<f64>| <[f64; 3]>::from(pose.translation.vector);
    let positions: Vec<[f64; 3]> = world_from_scan.iter().map(position).collect();
    // One more than the neighbors, since the scan itself is found too.
    let wanted = NonZero::<usize>::MIN.saturating_add((2.0 * params.degree) as usize + 4);
    let tree: ImmutableKdTree<f64, 3> = ImmutableKdTree::new_from_slice(&positions)
        .expect("a million positions, the most there may be, fit into a tree");
    let of_scan = |(scan, position): (usize, &[f64; 3])| {
        let nearest = tree
            .query(position)
            .nearest_n::<SquaredEuclidean<f64>>(wanted);
        let found = nearest.execute().into_iter();
        let others = found.map(|hit| (hit.distance, hit.item as usize));
        let others = others.filter(move |&(_, other)| other != scan);
        others.map(move |(distance, other)| (distance, ascending(scan, other)))
    };
    positions.iter().enumerate().flat_map(of_scan).collect()
}

/// The representative of a node's set; halves the path to it on the way.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

fn ascending(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(params: PoseGraphSimParams) -> SimulatedPoseGraph {
        simulate_pose_graph(&params).unwrap()
    }

    fn num_components(num_scans: usize, edges: &[SimulatedEdge]) -> usize {
        let mut parent: Vec<usize> = (0..num_scans).collect();
        let joins = |edge: &&SimulatedEdge| {
            let (i, j) = (root(&mut parent, edge.i), root(&mut parent, edge.j));
            parent[j] = i;
            i != j
        };
        num_scans - edges.iter().filter(joins).count()
    }

    #[test]
    fn both_topologies_are_connected_and_have_the_edges_asked_for() {
        for topology in [Topology::Random, Topology::Geometric] {
            for (num_scans, degree, edges) in
                [(1, 10.0, 0), (2, 10.0, 1), (30, 0.0, 29), (500, 10.0, 2500)]
            {
                let params = PoseGraphSimParams {
                    topology,
                    num_scans,
                    degree,
                    ..Default::default()
                };
                let graph = graph(params);
                assert_eq!(graph.edges.len(), edges);
                assert_eq!(num_components(num_scans, &graph.edges), 1);
                assert!(graph.edges.iter().all(|edge| edge.i < edge.j));
            }
        }
    }

    #[test]
    fn geometric_edges_are_shorter_than_random_ones() {
        let mean_length = |topology| {
            let params = PoseGraphSimParams {
                topology,
                num_scans: 300,
                ..Default::default()
            };
            let graph = graph(params);
            let length = |edge: &SimulatedEdge| edge.i_from_j.translation.vector.norm();
            graph.edges.iter().map(length).sum::<f64>() / graph.edges.len() as f64
        };
        assert!(mean_length(Topology::Geometric) < 0.4 * mean_length(Topology::Random));
    }

    #[test]
    fn inliers_are_off_by_the_noise_and_outliers_by_much_more() {
        for kind in [Outliers::Uniform, Outliers::Coherent] {
            let params = PoseGraphSimParams {
                outlier_ratio: 0.3,
                outliers: kind,
                ..Default::default()
            };
            let SimulatedPoseGraph {
                world_from_scan,
                edges,
            } = graph(params);
            let error = |edge: &SimulatedEdge| {
                let true_i_from_j = world_from_scan[edge.i].inv_mul(&world_from_scan[edge.j]);
                let angle = true_i_from_j
                    .rotation
                    .angle_to(&edge.i_from_j.rotation)
                    .to_degrees();
                (
                    angle,
                    (true_i_from_j.translation.vector - edge.i_from_j.translation.vector).norm(),
                )
            };
            let (inliers, outliers): (Vec<_>, Vec<_>) =
                edges.iter().partition(|edge| edge.is_inlier);
            assert_eq!(outliers.len(), 75);
            assert!(
                inliers
                    .iter()
                    .all(|edge| error(edge).0 < 12.0 && error(edge).1 < 0.3)
            );
            // The mean angle of uniform rotations is 126.5°.
            let mean = outliers.iter().map(|edge| error(edge).0).sum::<f64>() / 75.0;
            assert!((mean - 126.5).abs() < 15.0, "{mean}");
        }
    }

    #[test]
    fn coherent_outliers_agree_with_each_other() {
        let params = PoseGraphSimParams {
            num_scans: 3,
            outlier_ratio: 1.0,
            outliers: Outliers::Coherent,
            rotation_noise: 0.0,
            translation_noise: 0.0,
            ..Default::default()
        };
        let edges = graph(params).edges;
        let i_from_j = |i, j| {
            edges
                .iter()
                .find(|e| (e.i, e.j) == (i, j))
                .unwrap()
                .i_from_j
        };
        let gap = (i_from_j(0, 1) * i_from_j(1, 2)).inv_mul(&i_from_j(0, 2));
        assert!(gap.translation.vector.norm() + gap.rotation.angle() < 1e-9);
    }

    #[test]
    fn informative_weights_tell_inliers_from_outliers_on_average() {
        let params = PoseGraphSimParams {
            outlier_ratio: 0.5,
            weights: EdgeWeights::Informative,
            ..Default::default()
        };
        for edge in graph(params).edges {
            assert!(if edge.is_inlier {
                edge.weight >= 0.5
            } else {
                edge.weight <= 0.7
            });
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let default = PoseGraphSimParams::default();
        #[rustfmt::skip]
        let cases = [
            (PoseGraphSimParams { num_scans: 0, ..default }, "num_scans"),
            (PoseGraphSimParams { degree: f64::NAN, ..default }, "degree"),
            (PoseGraphSimParams { rotation_noise: -0.1, ..default }, "rotation_noise"),
            (PoseGraphSimParams { translation_noise: 1e7, ..default }, "translation_noise"),
            (PoseGraphSimParams { outlier_ratio: 1.1, ..default }, "outlier_ratio"),
            (PoseGraphSimParams { extent: f64::INFINITY, ..default }, "extent"),
        ];
        for (params, name) in cases {
            assert_eq!(params.validate().unwrap_err().name, name);
            assert!(matches!(
                simulate_pose_graph(&params),
                Err(Error::Parameter(_))
            ));
        }
    }
}
