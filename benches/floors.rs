//! How near the machine the stages are: the time of each on one thread beside its floor, the least
//! time that its work takes at the speeds this machine reaches.
//!
//! ```text
//! cargo bench --bench floors      # about a minute
//! ```
//!
//! The speeds come first: multiply-adds of faer's matrix product, and bytes read or copied. A floor is the
//! longer of the times for multiply-adds and bytes, as if done side by side. An addition or a root
//! takes the place of a multiply-add; inputs and results count once, what is between them never.
//!
//! | stage | multiply-adds |
//! |---|---|
//! | sampling `s` of `n` | `n s d` in f64, those of the plain algorithm; the lazy one does with fewer |
//! | matching | `n_i n_j d` in f32; comparisons are not counted |
//! | graph | 9 for each of `M (M − 1)` distances and half of `M³` by symmetry, zeros included |
//! | eigenvector | `p²` for each product and `2 p k²` for a basis of `k` steps, of a connected part of `p` nodes |
//! | filter | graph and eigenvector; on the retained, the half product and the eigenvector again |
//! | Kabsch | 15 for each pair: centroids and covariance; its decomposition is not counted |
//! | top-K | none: comparisons are not counted, so that only the bytes are left |
//!
//! Cliques, features and synchronization have no row: their work depends on what they find, on the
//! neighbors of points or on the fill of a factor, and no simple count of it would be a floor.

#![allow(clippy::unwrap_used, missing_docs)]

mod data;

use std::hint::black_box;
use std::time::Instant;

use data::{descriptors, half_inlier_pairs, scattered};
use faer::linalg::matmul::matmul;
use faer::traits::{ComplexField, math_utils::one};
use faer::{Accum, Mat, Par};
use gmpcr::cliques::{PointPairs, kabsch};
use gmpcr::compatibility::{CompatibilityGraph, DominantEigenpair, Route, SpectralFilter};
use gmpcr::correspondence::{
    Keypoints, correspondences, farthest_point_sampling, match_descriptors,
};
use gmpcr::nalgebra::Vector3;
use gmpcr::posegraph::{PairConfidences, PoseGraphParams, ScoredPair};
use gmpcr::{Descriptors, Params};
use gmpcr_io::read_overlaps;

fn main() {
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processor.lines().find(|line| line.contains("model name"));
    let cores = std::thread::available_parallelism().unwrap();
    println!("{}, {cores} cores\n", model.unwrap_or("unknown model"));
    println!("| speed | 10⁹ a second |\n|---|---|");
    let machine = Machine::measured();
    println!("\n| stage | size | 1000 multiply-adds | kB | floor (µs) | measured (µs) | ratio |");
    println!("|---|---|---|---|---|---|---|");
    synthetic(&machine);
    if let Err(error) = real(&machine, "redkitchen") {
        println!("| scoring of real pairs | skipped: {error} |");
    }
}

/// Multiply-adds in f32, the same in f64, bytes: of a stage, or of the machine in a second.
type Work = Vector3<f64>;

/// Its speeds where the bytes are in the cache and where they are in memory.
struct Machine([Work; 2]);

/// Half of a second-level cache.
const CACHED: usize = 1 << 20;

impl Machine {
    /// Measures the speeds and prints them.
    fn measured() -> Self {
        let printed = |name: &str, speed: f64| {
            println!("| {name} | {:.1} |", speed * 1e-9);
            speed
        };
        let large = [[384; 3], [768; 3], [1_536; 3]];
        printed("f32, 200 × 200 × 33", products::<f32>(&[[200, 200, 33]]));
        printed("f64, 100 × 100 × 100", products::<f64>(&[[100; 3]]));
        let single = printed("f32, large products", products::<f32>(&large));
        let double = printed("f64, large products", products::<f64>(&large));
        let cached = printed("bytes within 1 MiB", transfers(CACHED));
        let uncached = printed("bytes within 1 GiB", transfers(1 << 30));
        Self([cached, uncached].map(|bytes| Work::new(single, double, bytes)))
    }

    fn report(&self, stage: &str, size: &str, work: Work, seconds: f64) {
        let is_uncached = work.z > CACHED as f64;
        let least = work.component_div(&self.0[usize::from(is_uncached)]);
        let floor = (least.x + least.y).max(least.z);
        let (products, kilobytes) = ((work.x + work.y) / 1e3, work.z / 1e3);
        let (least, measured, ratio) = (1e6 * floor, 1e6 * seconds, seconds / floor);
        print!("| {stage} | {size} | {products:.1} | {kilobytes:.1} | ");
        println!("{least:.3} | {measured:.2} | {ratio:.1} |");
    }
}

/// Multiply-adds per second of the fastest product among those of the given rows, columns and terms.
fn products<T: ComplexField>(sizes: &[[usize; 3]]) -> f64 {
    let speed = |&[rows, columns, terms]: &[usize; 3]| {
        let (a, b) = (Mat::<T>::ones(rows, terms), Mat::<T>::ones(terms, columns));
        let mut c = Mat::<T>::zeros(rows, columns);
        let multiply = || matmul(&mut c, Accum::Replace, &a, &b, one::<T>(), Par::Seq);
        (rows * columns * terms) as f64 / best(multiply)
    };
    sizes.iter().map(speed).fold(0.0, f64::max)
}

/// Bytes per second, summed or copied, whichever is faster.
fn transfers(bytes: usize) -> f64 {
    let mut values = vec![1.0; bytes / size_of::<f64>()];
    let summed = best(|| {
        let mut sums = [0.0; 32];
        for chunk in black_box(&values).chunks_exact(32) {
            (0..32).for_each(|lane| sums[lane] += chunk[lane]);
        }
        sums
    });
    let (source, target) = values.split_at_mut(bytes / size_of::<f64>() / 2);
    let copied = best(|| black_box(&mut *target).copy_from_slice(black_box(source)));
    bytes as f64 / summed.min(copied)
}

/// All stages on synthetic data.
fn synthetic(machine: &Machine) {
    let params = Params::threedmatch().compatibility;
    let rows = descriptors(2_000, 32, 0);
    let work = Work::new(0.0, 2_000.0 * 200.0 * 32.0, 4.0 * 2_000.0 * 32.0);
    let seconds = best(|| farthest_point_sampling(black_box(&rows), 200));
    machine.report("sampling", "200 of 2 000 × 32", work, seconds);

    let [a, b] = [0, 104_729].map(|salt| descriptors(200, 33, salt));
    let seconds = best(|| match_descriptors(black_box(&a), black_box(&b)));
    machine.report("matching", "200 × 200 × 33", matching_work(&a, &b), seconds);

    for num_pairs in [100, 250] {
        let (size, pairs) = (format!("M = {num_pairs}"), half_inlier_pairs(num_pairs));
        let build = || CompatibilityGraph::new(black_box(&pairs), params.tolerance);
        let (graph, seconds) = (build(), best(build));
        machine.report("compatibility graph", &size, graph_work(&graph), seconds);
        let solve = || DominantEigenpair::new(black_box(graph.scg()));
        let (work, seconds) = (eigenvector_work(&solve()), best(solve));
        machine.report("dominant eigenvector", &size, work, seconds);
        let filter = || SpectralFilter::new(black_box(&pairs), &params).unwrap();
        let (work, seconds) = (filter_work(&graph, &filter()), best(filter));
        machine.report("graph to filter", &size, work, seconds);
    }

    let (pairs, weights) = (half_inlier_pairs(10), [0.5; 10]);
    let work = Work::new(0.0, 15.0 * 10.0, 56.0 * 10.0);
    let seconds = best(|| kabsch(black_box(&pairs), Some(&weights)));
    machine.report("weighted Kabsch", "10 pairs", work, seconds);

    for num_scans in [60, 1_000] {
        let pairs = (0..num_scans).flat_map(|i| (i + 1..num_scans).map(move |j| (i, j)));
        let scored = pairs.map(|(i, j)| ScoredPair {
            i,
            j,
            raw_confidence: scattered(i * num_scans + j).abs(),
        });
        let confidences = PairConfidences::new(num_scans, scored.collect()).unwrap();
        let params = PoseGraphParams::default();
        let select = || black_box(&confidences).top_k_union(&params).unwrap();
        let bytes = size_of_val(confidences.pairs()) + size_of_val(&*select());
        let (work, size) = (Work::z() * bytes as f64, format!("6 of {num_scans} scans"));
        machine.report("top-K union", &size, work, best(select));
    }
}

fn matching_work(a: &Descriptors, b: &Descriptors) -> Work {
    let bytes = size_of_val(a.values()) + size_of_val(b.values());
    Work::new((a.len() * b.values().len()) as f64, 0.0, bytes as f64)
}

fn graph_work(graph: &CompatibilityGraph) -> Work {
    let size = graph.len() as f64;
    let multiply_adds = 9.0 * size * (size - 1.0) + size.powi(3) / 2.0;
    Work::new(0.0, multiply_adds, 48.0 * size + 16.0 * size * size)
}

fn eigenvector_work(eigenpair: &DominantEigenpair) -> Work {
    let size = eigenpair.vector.len() as f64;
    let part = eigenpair.vector.iter().filter(|&&v| v > 0.0).count() as f64;
    let (products, basis) = match eigenpair.route {
        Route::Power { iterations } => (iterations as f64, 0.0),
        Route::Lanczos { iterations, steps } => (iterations as f64, 2.0 * (steps * steps) as f64),
        // As a tridiagonalization takes.
        _ => (part, 0.0),
    };
    Work::new(
        0.0,
        products * part.powi(2) + basis * part,
        8.0 * size * size,
    )
}

fn filter_work(graph: &CompatibilityGraph, filter: &SpectralFilter) -> Work {
    let [size, retained] = [graph.len(), filter.retained.len()].map(|count| count as f64);
    let initial = graph_work(graph) + eigenvector_work(&DominantEigenpair::new(graph.scg()));
    let refined = retained.powi(3) / 2.0 + eigenvector_work(&filter.dominant).y;
    let bytes = 48.0 * size + 16.0 * retained * retained;
    Work::new(0.0, initial.y + refined, bytes)
}

/// Matching and filter of pairs of a real scene, each timed in ten rounds over all.
fn real(machine: &Machine, scene: &str) -> Result<(), gmpcr_io::Error> {
    let overlaps = read_overlaps(data::folder().join(scene).join("overlap.csv"))?;
    let params = Params::threedmatch();
    let sample = |scan| Keypoints::sample(scan, &params.correspondence).unwrap();
    let keypoints: Vec<_> = data::learned(scene)?.iter().map(sample).collect();
    for (name, least) in [("all", -1.0), ("overlap > 30 %", 0.3)] {
        let chosen = overlaps.iter().filter(|pair| pair.overlap > least);
        let pairs: Vec<_> = chosen.map(|p| [&keypoints[p.i], &keypoints[p.j]]).collect();
        let mut seconds = vec![f64::INFINITY; pairs.len()];
        for (k, &pair) in pairs.iter().enumerate().cycle().take(10 * pairs.len()) {
            seconds[k] = seconds[k].min(elapsed(|| scored(pair, &params)));
        }
        let works = pairs.iter().map(|&[a, b]| {
            let (pairs, filter) = scored([a, b], &params);
            let graph = CompatibilityGraph::new(&pairs, params.compatibility.tolerance);
            matching_work(a.descriptors(), b.descriptors()) + filter_work(&graph, &filter)
        });
        let (work, seconds) = (works.sum::<Work>(), seconds.iter().sum::<f64>());
        let (count, size) = (pairs.len() as f64, format!("{} pairs, {name}", pairs.len()));
        machine.report("matching to filter", &size, work / count, seconds / count);
    }
    Ok(())
}

fn scored([a, b]: [&Keypoints; 2], params: &Params) -> (PointPairs, SpectralFilter) {
    let pairs = correspondences(a, b, &params.correspondence).unwrap();
    let filter = SpectralFilter::new(&pairs, &params.compatibility).unwrap();
    (pairs, filter)
}

/// Seconds of a run: the best of many, which other programs disturb least.
fn best<T>(mut run: impl FnMut() -> T) -> f64 {
    let once = elapsed(&mut run).min(elapsed(&mut run));
    let runs = (20e-6 / once).ceil(); // so many that the clock's own time does not count
    let samples = (1.0 / (runs * once)).clamp(5.0, 10_000.0) as usize;
    let sample = |_| elapsed(|| (0..runs as usize).for_each(|_| drop(black_box(run())))) / runs;
    (0..samples).map(sample).fold(f64::INFINITY, f64::min)
}

fn elapsed<T>(run: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(run());
    start.elapsed().as_secs_f64()
}
