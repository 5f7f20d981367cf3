//! Time of every stage at the paper's sizes, on simulated scans and, where `GMPCR_DATA` names
//! them, on real ones.
//!
//! ```text
//! cargo bench --bench stages
//! ```

#![allow(clippy::unwrap_used, missing_docs)]

mod data;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use gmpcr::cliques::{Compatibility, estimate_pose};
use gmpcr::compatibility::{DominantEigenpair, SpectralFilter};
use gmpcr::correspondence::{
    Keypoints, correspondences, farthest_point_sampling, match_descriptors,
};
use gmpcr::features::{FeatureParams, compute_features};
use gmpcr::sync::synchronize;
use gmpcr::{Params, Scan, register};
use gmpcr_sim::{SimParams, simulate};

/// Learned descriptors of a real scene, or FPFH of simulated scans.
fn scans() -> (String, Vec<Scan>) {
    match data::learned("redkitchen") {
        Ok(scans) => ("redkitchen".into(), scans),
        Err(error) => {
            eprintln!("no real scans, simulated ones are used: {error}");
            let simulated = simulate(&SimParams::default()).unwrap();
            ("simulated".into(), data::fpfh_scans(&simulated.clouds))
        }
    }
}

fn pair_stages(criterion: &mut Criterion) {
    let (name, scans) = scans();
    let params = Params::threedmatch();
    let mut group = criterion.benchmark_group(format!("pair/{name}"));
    group.bench_function("farthest-point sampling of a scan", |bencher| {
        bencher.iter(|| farthest_point_sampling(black_box(scans[0].descriptors()), 200));
    });
    let sample = |scan| Keypoints::sample(scan, &params.correspondence).unwrap();
    let keypoints = [&scans[0], &scans[1]].map(sample);
    group.bench_function("matching 200 × 200", |bencher| {
        bencher.iter(|| match_descriptors(keypoints[0].descriptors(), keypoints[1].descriptors()));
    });
    let pairs = correspondences(&keypoints[0], &keypoints[1], &params.correspondence).unwrap();
    group.bench_function("compatibility, filter, confidence", |bencher| {
        bencher.iter(|| SpectralFilter::new(black_box(&pairs), &params.compatibility));
    });
    let filter = SpectralFilter::new(&pairs, &params.compatibility).unwrap();
    group.bench_function("dominant eigenvector, 50 × 50", |bencher| {
        bencher.iter(|| DominantEigenpair::new(black_box(filter.graph.scg())));
    });
    let retained = pairs.select(&filter.retained);
    group.bench_function("cliques and relative pose", |bencher| {
        bencher.iter(|| {
            let compatibility = Compatibility {
                fcg: filter.graph.fcg(),
                scg: filter.graph.scg(),
                response: &filter.dominant.vector,
            };
            estimate_pose(black_box(&retained), compatibility, &params.cliques)
        });
    });
    group.finish();
}

fn whole(criterion: &mut Criterion) {
    let (name, scans) = scans();
    let params = Params::threedmatch();
    let mut group = criterion.benchmark_group(format!("whole/{name}"));
    group.sample_size(10);
    group.bench_function("sampling to poses", |bencher| {
        bencher.iter(|| register(black_box(&scans), &params));
    });
    let graph = register(&scans, &params).unwrap().pose_graph();
    for (name, params) in [
        ("10", Params::threedmatch()),
        ("90", Params::threedlomatch()),
    ] {
        group.bench_function(format!("synchronization, {name} iterations"), |bencher| {
            bencher.iter(|| synchronize(black_box(&graph), &params.sync));
        });
    }
    group.finish();
}

fn features(criterion: &mut Criterion) {
    let params = SimParams {
        num_scans: 1,
        ..SimParams::default()
    };
    let cloud = simulate(&params).unwrap().clouds.remove(0);
    criterion.bench_function(
        "voxel grid, normals and FPFH of a simulated scan",
        |bencher| {
            bencher.iter(|| compute_features(black_box(&cloud), &FeatureParams::default()));
        },
    );
}

criterion_group!(benches, pair_stages, whole, features);
criterion_main!(benches);
