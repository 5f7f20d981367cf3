//! Every stage at the paper's sizes and at growing ones, on synthetic data, with its throughput.
//!
//! ```text
//! cargo bench --bench sizes -- --quick       # all of it: about eight minutes
//! cargo bench --bench sizes -- matching      # one stage
//! cargo bench --bench sizes                  # with more samples: most of an hour, for 50 000 poses
//! ```

#![allow(clippy::unwrap_used, missing_docs)]

mod data;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use data::{descriptors, half_inlier_pairs, scattered};
use gmpcr::cliques::{BitGraph, for_each_maximal_clique, kabsch};
use gmpcr::compatibility::{CompatibilityParams, SpectralFilter};
use gmpcr::correspondence::{farthest_point_sampling, match_descriptors};
use gmpcr::features::{FeatureParams, compute_features};
use gmpcr::posegraph::{PairConfidences, PoseEdge, PoseGraph, PoseGraphParams, ScoredPair};
use gmpcr::sync::{SyncParams, synchronize};
use gmpcr::{IncrementalRegistration, Params, register};
use gmpcr_sim::{PoseGraphSimParams, SimParams, simulate, simulate_pose_graph};

fn sampling(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sampling");
    group.sample_size(10);
    for (num_rows, dimension, num_samples) in [
        (2_000, 32, 200),
        (5_000, 33, 200),
        (20_000, 33, 400),
        (50_000, 33, 1_000),
    ] {
        let descriptors = descriptors(num_rows, dimension, 0);
        group.throughput(Throughput::Elements(num_rows as u64));
        let id = BenchmarkId::new(format!("{num_samples} of d = {dimension}"), num_rows);
        group.bench_function(id, |bencher| {
            bencher.iter(|| farthest_point_sampling(black_box(&descriptors), num_samples));
        });
    }
}

fn matching(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("matching");
    for num_rows in [200, 240, 400, 1_000] {
        let [a, b] = [0, 104_729].map(|salt| descriptors(num_rows, 33, salt));
        group.throughput(Throughput::Elements((num_rows * num_rows) as u64));
        group.bench_function(BenchmarkId::new("d = 33", num_rows), |bencher| {
            bencher.iter(|| match_descriptors(black_box(&a), black_box(&b)));
        });
    }
}

fn compatibility(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("compatibility, eigenvector, filter");
    for num_pairs in [50, 100, 250, 500] {
        let pairs = half_inlier_pairs(num_pairs);
        group.throughput(Throughput::Elements((num_pairs * num_pairs) as u64));
        group.bench_function(BenchmarkId::new("M", num_pairs), |bencher| {
            bencher
                .iter(|| SpectralFilter::new(black_box(&pairs), &CompatibilityParams::default()));
        });
    }
}

/// Sparse, dense and adversarial graphs: the last, whose complement is triangles, has `3^(n/3)` maximal
/// cliques (Moon and Moser 1965) and ends at the budget.
fn cliques(criterion: &mut Criterion) {
    const BUDGET: usize = 200_000;
    let size = 60;
    let random = |ratio: f64| {
        BitGraph::from_edges(size, |i, j| {
            scattered(61 * i.min(j) + i.max(j)) < 2.0 * ratio - 1.0
        })
    };
    let graphs = [
        ("a tenth of the edges", random(0.1)),
        ("half of the edges", random(0.5)),
        ("nine tenths of the edges", random(0.9)),
        (
            "Moon–Moser",
            BitGraph::from_edges(size, |i, j| i / 3 != j / 3),
        ),
    ];
    let mut group = criterion.benchmark_group("maximal cliques, 60 nodes");
    group.sample_size(20);
    for (name, graph) in graphs {
        let count = || for_each_maximal_clique(black_box(&graph), 3, BUDGET, |_| ()).cliques as u64;
        group.throughput(Throughput::Elements(count()));
        group.bench_function(name, |bencher| bencher.iter(count));
    }
}

fn kabsch_of(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("weighted Kabsch");
    for num_pairs in [3, 10, 100] {
        let pairs = half_inlier_pairs(num_pairs);
        let weights = vec![0.5; num_pairs];
        group.throughput(Throughput::Elements(num_pairs as u64));
        group.bench_function(BenchmarkId::new("pairs", num_pairs), |bencher| {
            bencher.iter(|| kabsch(black_box(&pairs), Some(&weights)));
        });
    }
}

fn selection(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("top-K union");
    for num_scans in [60, 400, 1_000] {
        let pairs = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
        let scored = pairs.map(|(i, j)| ScoredPair {
            i,
            j,
            raw_confidence: scattered(i * num_scans + j).abs(),
        });
        let confidences = PairConfidences::new(num_scans, scored.collect()).unwrap();
        group.throughput(Throughput::Elements(confidences.pairs().len() as u64));
        group.bench_function(BenchmarkId::new("scans", num_scans), |bencher| {
            bencher.iter(|| black_box(&confidences).top_k_union(&PoseGraphParams::default()));
        });
    }
}

/// Degree 8, a fifth of the edges outliers, 10 iterations.
fn synchronization(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("synchronization");
    group.sample_size(10);
    for num_scans in [60, 500, 5_000, 50_000] {
        let simulated = simulate_pose_graph(&PoseGraphSimParams {
            num_scans,
            degree: 8.0,
            outlier_ratio: 0.2,
            topology: gmpcr_sim::Topology::Geometric,
            ..PoseGraphSimParams::default()
        });
        let edges = simulated.unwrap().edges.into_iter().map(|edge| PoseEdge {
            i: edge.i,
            j: edge.j,
            i_from_j: edge.i_from_j,
            weight: edge.weight,
        });
        let graph = PoseGraph::new(num_scans, edges.collect()).unwrap();
        group.throughput(Throughput::Elements(graph.edges().len() as u64));
        group.bench_function(BenchmarkId::new("poses", num_scans), |bencher| {
            bencher.iter(|| synchronize(black_box(&graph), &SyncParams::default()));
        });
    }
}

fn features(criterion: &mut Criterion) {
    let params = SimParams {
        num_scans: 1,
        voxel: 0.0,
        ..SimParams::default()
    };
    let cloud = simulate(&params).unwrap().clouds.remove(0);
    let mut group = criterion.benchmark_group("voxel grid, normals, FPFH");
    group.sample_size(20);
    for stride in [4, 2, 1] {
        let cloud: Vec<_> = cloud.iter().step_by(stride).copied().collect();
        group.throughput(Throughput::Elements(cloud.len() as u64));
        group.bench_function(BenchmarkId::new("points", cloud.len()), |bencher| {
            bencher.iter(|| compute_features(black_box(&cloud), &FeatureParams::default()));
        });
    }
}

/// Scans with descriptors of a flat that grows with their number, registered at once, and one more added.
fn pipeline(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("sampling to poses");
    group.sample_size(10);
    let params = Params::threedmatch();
    for num_scans in [30usize, 60, 100, 200, 400] {
        let scans = data::scans(num_scans);
        group.throughput(Throughput::Elements(
            (num_scans * (num_scans - 1) / 2) as u64,
        ));
        group.bench_function(BenchmarkId::new("scans at once", num_scans), |bencher| {
            bencher.iter(|| register(black_box(&scans), &params));
        });
        let (last, others) = scans.split_last().unwrap();
        let mut known = IncrementalRegistration::new(params.clone()).unwrap();
        known.add(others).unwrap();
        known.register().unwrap();
        group.throughput(Throughput::Elements((num_scans - 1) as u64));
        group.bench_function(BenchmarkId::new("one more scan", num_scans), |bencher| {
            bencher.iter_batched(
                || known.clone(),
                |mut known| {
                    known.add(std::slice::from_ref(last)).unwrap();
                    known.register().unwrap()
                },
                criterion::BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(
    benches,
    sampling,
    matching,
    compatibility,
    cliques,
    kabsch_of,
    selection,
    synchronization,
    features,
    pipeline
);
criterion_main!(benches);
