use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use gmpcr_posegraph::Components;

use super::loops::LoopSupport;
use super::poses::{Noise, Poses, Transformation};
use super::refinement::LeastSquares;
use crate::subgraph::{Measurement, Subgraph};

/// Proposals that are tried where two parts are joined by more measurements.
const MAX_PROPOSALS: usize = 32;

/// First poses: parts that triangles connect are solved by least squares, then joined one by
/// one, each time the two that most of the measurements between them agree on.
pub(super) fn assemble(
    graph: &Subgraph,
    weights: &[f64],
    loops: &LoopSupport,
    noise: &Noise,
) -> Poses {
    let confirmed: Vec<usize> = (0..weights.len())
        .filter(|&k| loops.num_loops[k] > 0)
        .collect();
    let ends = |&k: &usize| (graph.measurements[k].i, graph.measurements[k].j);
    let parts = Components::new(graph.num_nodes, confirmed.iter().map(ends));
    let mut poses = Poses::identities(graph.num_nodes);
    for (nodes, measurements) in parts
        .members()
        .iter()
        .zip(by_part(graph, &parts, &confirmed))
    {
        if nodes.len() > 1 {
            solve_part(graph, weights, loops, nodes, &measurements, &mut poses);
        }
    }
    let mut clusters = Clusters::new(graph, weights, noise, &parts, poses);
    clusters.join_all();
    clusters.poses
}

fn by_part(graph: &Subgraph, parts: &Components, measurements: &[usize]) -> Vec<Vec<usize>> {
    let mut of_part = vec![Vec::new(); parts.members().len()];
    for &k in measurements {
        of_part[parts.label(graph.measurements[k].i)].push(k);
    }
    of_part
}

/// Poses of some nodes in a frame of their own, from the measurements that connect them.
fn solve_part(
    graph: &Subgraph,
    weights: &[f64],
    loops: &LoopSupport,
    nodes: &[usize],
    measurements: &[usize],
    poses: &mut Poses,
) {
    // The nodes of a component ascend.
    let local = |node: usize| nodes.partition_point(|&other| other < node);
    let renumbered = |&k: &usize| {
        let m = graph.measurements[k].clone();
        let (i, j) = (local(m.i), local(m.j));
        Measurement { i, j, ..m }
    };
    let part = Subgraph {
        num_nodes: nodes.len(),
        measurements: measurements.iter().map(renumbered).collect(),
    };
    let weights: Vec<f64> = measurements.iter().map(|&k| weights[k]).collect();
    let num_loops = measurements.iter().map(|&k| loops.num_loops[k] as f64);
    let support: Vec<f64> = num_loops.zip(&weights).map(|(n, w)| n * w).collect();
    let rotations = part.rotations_along(&part.spanning_tree(&support));
    let (solution, _) = LeastSquares::new(&part, rotations).solve(&weights);
    for (index, &node) in nodes.iter().enumerate() {
        poses.set(node, &solution.get(index));
    }
}

/// Nodes that share a frame.
#[derive(Default)]
struct Cluster {
    nodes: Vec<usize>,
    /// Measurements to each other cluster.
    measurements_to: BTreeMap<usize, Vec<usize>>,
}

/// A pair of clusters that could be joined, ordered by how many measurements would agree.
type Candidate = (Votes, Reverse<(usize, usize)>, NumMeasurements);
/// Bits of a sum of weights: those of nonnegative numbers are ordered as the numbers are.
type Votes = u64;
/// Number of measurements that voted. It grows as clusters do, which shows that a candidate is
/// outdated.
type NumMeasurements = usize;

struct Clusters<'a> {
    graph: &'a Subgraph,
    weights: &'a [f64],
    noise: &'a Noise,
    clusters: Vec<Cluster>,
    /// The cluster of each node.
    labels: Vec<usize>,
    /// Poses in the frame of the node's cluster.
    poses: Poses,
    candidates: BinaryHeap<Candidate>,
}

impl<'a> Clusters<'a> {
    fn new(
        graph: &'a Subgraph,
        weights: &'a [f64],
        noise: &'a Noise,
        parts: &Components,
        poses: Poses,
    ) -> Self {
        let cluster = |nodes: &Vec<usize>| Cluster {
            nodes: nodes.clone(),
            measurements_to: BTreeMap::new(),
        };
        let mut clusters: Vec<_> = parts.members().iter().map(cluster).collect();
        for (k, m) in graph.measurements.iter().enumerate() {
            let (a, b) = (parts.label(m.i), parts.label(m.j));
            if a != b && weights[k] > 0.0 {
                clusters[a].measurements_to.entry(b).or_default().push(k);
                clusters[b].measurements_to.entry(a).or_default().push(k);
            }
        }
        Self {
            graph,
            weights,
            noise,
            clusters,
            labels: parts.labels().to_vec(),
            poses,
            candidates: BinaryHeap::new(),
        }
    }

    fn join_all(&mut self) {
        for a in 0..self.clusters.len() {
            let above = self.clusters[a].measurements_to.range(a + 1..);
            let others: Vec<usize> = above.map(|(&b, _)| b).collect();
            others.into_iter().for_each(|b| self.consider(a, b));
        }
        while let Some((_, Reverse((a, b)), num_measurements)) = self.candidates.pop() {
            if self.clusters[a].measurements_to.get(&b).map(Vec::len) == Some(num_measurements) {
                let [size_a, size_b] = [a, b].map(|cluster| self.clusters[cluster].nodes.len());
                let (larger, smaller) = if size_a >= size_b { (a, b) } else { (b, a) };
                self.join(larger, smaller);
            }
        }
    }

    fn consider(&mut self, a: usize, b: usize) {
        let measurements = &self.clusters[a].measurements_to[&b];
        let (votes, _) = self.best_proposal(a, measurements);
        let pair = (a.min(b), a.max(b));
        let candidate = (votes.to_bits(), Reverse(pair), measurements.len());
        self.candidates.push(candidate);
    }

    /// Moves the nodes of cluster `b` into cluster `a`.
    fn join(&mut self, a: usize, b: usize) {
        let Cluster {
            nodes,
            mut measurements_to,
        } = std::mem::take(&mut self.clusters[b]);
        let between = measurements_to.remove(&a).unwrap_or_default();
        self.clusters[a].measurements_to.remove(&b);
        let (_, a_from_b) = self.best_proposal(a, &between);
        for &node in &nodes {
            let pose = a_from_b.then(&self.poses.get(node));
            self.poses.set(node, &pose);
            self.labels[node] = a;
        }
        self.clusters[a].nodes.extend(nodes);
        for (other, measurements) in measurements_to {
            self.clusters[other].measurements_to.remove(&b);
            for (from, to) in [(a, other), (other, a)] {
                let joined = self.clusters[from].measurements_to.entry(to).or_default();
                joined.extend(&measurements);
            }
            self.consider(a, other);
        }
    }

    /// The transformation between the frames of cluster `a` and another one that most of the measurements
    /// between the two agree on, and the sum of their votes. The heaviest measurements propose.
    fn best_proposal(&self, a: usize, measurements: &[usize]) -> (f64, Transformation) {
        let mut proposers = measurements.to_vec();
        proposers.sort_by(|&k, &l| self.weights[l].total_cmp(&self.weights[k]).then(k.cmp(&l)));
        proposers.truncate(MAX_PROPOSALS);
        let proposals = proposers.iter().map(|&k| {
            let a_from_b = self.proposal(a, k);
            let votes = measurements.iter().map(|&l| self.vote(a, l, &a_from_b));
            (votes.sum::<f64>(), a_from_b)
        });
        let better = |best: (f64, Transformation), next: (f64, Transformation)| {
            if next.0 > best.0 { next } else { best }
        };
        proposals
            .reduce(better)
            .expect("candidates are joined by measurements")
    }

    /// Where a measurement puts the frame of the other cluster.
    fn proposal(&self, a: usize, measurement: usize) -> Transformation {
        let m = &self.graph.measurements[measurement];
        let (i, j) = (self.poses.get(m.i), self.poses.get(m.j));
        if self.labels[m.i] == a {
            i.then(&Transformation::measured(m)).then(&j.inverse())
        } else {
            j.then(&Transformation::measured(m).inverse())
                .then(&i.inverse())
        }
    }

    fn vote(&self, a: usize, measurement: usize, a_from_b: &Transformation) -> f64 {
        let m = &self.graph.measurements[measurement];
        let in_a = |node: usize| {
            let pose = self.poses.get(node);
            if self.labels[node] == a {
                pose
            } else {
                a_from_b.then(&pose)
            }
        };
        self.weights[measurement] * self.noise.agreement(&in_a(m.i), m, &in_a(m.j))
    }
}
