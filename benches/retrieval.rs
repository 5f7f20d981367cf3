//! What retrieval misses and what it saves: per number of candidates, the ratio of pairs that are
//! scored, the ratios of the exhaustive run's edges and of the overlapping pairs among them, and the
//! time of one thread, on simulated scans and on the real ones that `GMPCR_DATA` names.
//!
//! ```text
//! cargo bench --bench retrieval            # all of it: about five minutes
//! cargo bench --bench retrieval -- 100     # only what has "100" in its name
//! ```

#![allow(clippy::unwrap_used, missing_docs)]

mod data;

use std::collections::BTreeMap;
use std::time::Instant;

use gmpcr::compatibility::SpectralFilter;
use gmpcr::correspondence::{Keypoints, correspondences};
use gmpcr::posegraph::{PairConfidences, PoseGraphParams, ScoredPair};
use gmpcr::{Params, Scan};
use gmpcr_eval::overlap_matrix;
use gmpcr_io::{read_overlaps, read_points, scan_files};
use gmpcr_retrieval::{RetrievalParams, candidate_pairs, further_pairs};
use gmpcr_sim::{SimParams, SimulatedScans, simulate};

type Pair = (usize, usize);

/// Scans whose overlaps are known.
struct Scene {
    name: String,
    scans: Vec<Scan>,
    overlaps: BTreeMap<Pair, f64>,
}

/// Candidates per scan, most rounds of neighbors, candidates per round.
type Setting = [usize; 3];
const MANY_SCANS: [Setting; 8] = [
    [15, 0, 1],
    [40, 0, 1],
    [15, 3, 8],
    [10, 20, 8],
    [15, 20, 6],
    [15, 20, 8],
    [15, 20, 10],
    [30, 20, 8],
];
const FEW_SCANS: [Setting; 5] = [[5, 0, 1], [10, 0, 1], [5, 20, 3], [5, 20, 5], [15, 20, 8]];

fn main() {
    // Cargo adds the argument "--bench".
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|part| name.contains(part));
    for (num_scans, seed) in [(100, 0), (200, 0), (400, 0), (400, 1), (400, 2)] {
        let name = format!("simulated {num_scans}, seed {seed}, FPFH");
        if is_wanted(&name) {
            report(&simulated(name, num_scans, seed));
        }
    }
    for scene in ["redkitchen", "hotel_umd3", "mit_lab"] {
        for (kind, read) in [("learned", data::learned as fn(&_) -> _), ("FPFH", fpfh)] {
            let name = format!("{scene}, {kind}");
            if is_wanted(&name) {
                match real(name.clone(), scene, read) {
                    Ok(scene) => report(&scene),
                    Err(error) => println!("\n{name}: skipped: {error}"),
                }
            }
        }
    }
}

/// The scans of the benchmark `sizes`, and others with other seeds.
fn simulated(name: String, num_scans: usize, seed: u64) -> Scene {
    let params = SimParams {
        seed,
        ..data::flat(num_scans)
    };
    let simulated = simulate(&params).unwrap();
    let SimulatedScans {
        clouds,
        world_from_scan,
    } = &simulated;
    let matrix = overlap_matrix(clouds, world_from_scan, 1.5 * params.voxel).unwrap();
    Scene {
        name,
        scans: data::fpfh_scans(clouds),
        overlaps: all_pairs(num_scans)
            .map(|pair| (pair, matrix[pair]))
            .collect(),
    }
}

fn real(
    name: String,
    scene: &str,
    read: fn(&str) -> Result<Vec<Scan>, gmpcr_io::Error>,
) -> Result<Scene, gmpcr_io::Error> {
    let overlaps = read_overlaps(data::folder().join(scene).join("overlap.csv"))?;
    Ok(Scene {
        name,
        scans: read(scene)?,
        overlaps: overlaps.iter().map(|o| ((o.i, o.j), o.overlap)).collect(),
    })
}

fn fpfh(scene: &str) -> Result<Vec<Scan>, gmpcr_io::Error> {
    let files = scan_files(data::folder().join(scene))?;
    let clouds = files.iter().map(|file| Ok(read_points(file)?.points));
    let clouds: Result<Vec<_>, gmpcr_io::Error> = clouds.collect();
    Ok(data::fpfh_scans(&clouds?))
}

fn all_pairs(num_scans: usize) -> impl Iterator<Item = Pair> {
    (0..num_scans).flat_map(move |i| (i + 1..num_scans).map(move |j| (i, j)))
}

fn report(scene: &Scene) {
    let params = Params::threedmatch();
    let sample = |scan| Keypoints::sample(scan, &params.correspondence).unwrap();
    let keypoints: Vec<_> = scene.scans.iter().map(sample).collect();
    let num_scans = keypoints.len();
    let (exhaustive, exhaustive_time) = timed(|| score(&keypoints, all_pairs(num_scans), &params));
    println!("\n{}: {num_scans} scans\n", scene.name);
    println!(
        "| candidates + rounds × candidates | scored per scan | ratio of pairs | K = 6 edges kept (overlapping) \
         | K = 10 edges kept (overlapping) | overlaps ≥ 30 % | ≥ 10 % | retrieval | all scoring | exhaustive | faster |\n\
         |---|---|---|---|---|---|---|---|---|---|---|"
    );
    let settings = if num_scans < 100 {
        FEW_SCANS.as_slice()
    } else {
        MANY_SCANS.as_slice()
    };
    for &setting in settings {
        let run = retrieve(&keypoints, setting, &params);
        let scored: Vec<Pair> = ends(run.confidences.pairs());
        let kept = |pairs: Vec<Pair>| percentage(&pairs, |pair| scored.binary_search(pair).is_ok());
        let edges = |neighbors| -> Vec<Pair> {
            let positions = exhaustive
                .top_k_union(&PoseGraphParams { neighbors })
                .unwrap();
            let pairs = positions
                .iter()
                .map(|&position| exhaustive.pairs()[position]);
            ends(&pairs.collect::<Vec<_>>())
        };
        let overlaps = |pair: &Pair, least: f64| scene.overlaps[pair] >= least;
        let overlapping_edges = |k| {
            edges(k)
                .into_iter()
                .filter(|pair| overlaps(pair, 0.1))
                .collect()
        };
        let overlapping = |least| {
            all_pairs(num_scans)
                .filter(|pair| overlaps(pair, least))
                .collect()
        };
        let [per_scan, rounds, per_round] = setting;
        println!(
            "| {per_scan} + {rounds} × {per_round} | {:.1} | {} | {} ({}) | {} ({}) | {} | {} | {:.2} s | {:.2} s | {:.2} s | {:.1} × |",
            2.0 * scored.len() as f64 / num_scans as f64,
            kept(all_pairs(num_scans).collect()),
            kept(edges(6)),
            kept(overlapping_edges(6)),
            kept(edges(10)),
            kept(overlapping_edges(10)),
            kept(overlapping(0.3)),
            kept(overlapping(0.1)),
            run.retrieval_time,
            run.time,
            exhaustive_time,
            exhaustive_time / run.time,
        );
    }
}

struct Run {
    confidences: PairConfidences,
    /// Seconds that went into the choice of candidates.
    retrieval_time: f64,
    /// Seconds in all.
    time: f64,
}

fn retrieve(keypoints: &[Keypoints], setting: Setting, params: &Params) -> Run {
    let [candidates_per_scan, expansions, candidates_per_expansion] = setting;
    let retrieval = RetrievalParams {
        min_scans: 0,
        candidates_per_scan,
        expansions,
        candidates_per_expansion,
    };
    let descriptors: Vec<_> = keypoints.iter().map(Keypoints::descriptors).collect();
    let (pairs, mut retrieval_time) = timed(|| candidate_pairs(&descriptors, &retrieval).unwrap());
    let (mut confidences, mut time) = timed(|| score(keypoints, pairs.into_iter(), params));
    for _ in 0..expansions {
        let (further, found_time) = timed(|| further_pairs(&confidences, &retrieval).unwrap());
        retrieval_time += found_time;
        if further.is_empty() {
            break;
        }
        let (more, scored_time) = timed(|| score(keypoints, further.into_iter(), params));
        confidences = joined(&confidences, &more);
        time += scored_time;
    }
    Run {
        confidences,
        retrieval_time,
        time: time + retrieval_time,
    }
}

fn score(
    keypoints: &[Keypoints],
    pairs: impl Iterator<Item = Pair>,
    params: &Params,
) -> PairConfidences {
    let scored = pairs.map(|(i, j)| {
        let [a, b] = [&keypoints[i], &keypoints[j]];
        let pairs = correspondences(a, b, &params.correspondence).unwrap();
        let filter = SpectralFilter::new(&pairs, &params.compatibility).unwrap();
        ScoredPair {
            i,
            j,
            raw_confidence: filter.raw_confidence(),
        }
    });
    PairConfidences::new(keypoints.len(), scored.collect()).unwrap()
}

fn joined(a: &PairConfidences, b: &PairConfidences) -> PairConfidences {
    let mut pairs = [a.pairs(), b.pairs()].concat();
    pairs.sort_by_key(|pair| (pair.i, pair.j));
    PairConfidences::new(a.num_scans(), pairs).unwrap()
}

fn ends(pairs: &[ScoredPair]) -> Vec<Pair> {
    pairs.iter().map(|pair| (pair.i, pair.j)).collect()
}

fn percentage(pairs: &[Pair], holds: impl Fn(&Pair) -> bool) -> String {
    let number = pairs.iter().filter(|pair| holds(pair)).count();
    format!("{:.1} %", 100.0 * number as f64 / pairs.len() as f64)
}

/// The result and the seconds that it took this thread.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (wall, processor) = (Instant::now(), processor_time());
    let result = work();
    let seconds = match (processor, processor_time()) {
        (Some(start), Some(end)) => end - start,
        _ => wall.elapsed().as_secs_f64(),
    };
    (result, seconds)
}

/// Seconds that this thread has run, where the system tells (Linux): unlike the clock on the wall they
/// do not count what other programs take.
fn processor_time() -> Option<f64> {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = statistics.split(' ').next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}
