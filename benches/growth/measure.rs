//! Measurements in child processes: a peak of memory cannot be taken back.

use std::io::{BufReader, BufWriter, Read, Write};
use std::process::{Command, Stdio};
use std::time::Instant;

use gmpcr::nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use gmpcr::posegraph::{PoseEdge, PoseGraph};
use gmpcr::sync::{SyncParams, synchronize};
use gmpcr::{Descriptors, Params, Scan, Stage, register};
use gmpcr_sim::SimulatedPoseGraph;

/// Makes this program the child that measures.
pub const FLAG: &str = "--measure";
pub const REGISTRATION: &str = "registration";
pub const SYNCHRONIZATION: &str = "synchronization";

/// The cells that a process of its own measures, with one thread, given the `data`.
pub fn ask(part: &str, what: &str, data: impl Iterator<Item = f64>) -> String {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([FLAG, part, what])
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = BufWriter::new(child.stdin.take().unwrap());
    data.for_each(|number| pipe.write_all(&number.to_le_bytes()).unwrap());
    pipe.flush().unwrap();
    drop(pipe);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{part}, {what}: {}", output.status);
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

/// The child: data in, cells out.
pub fn answer(part: &str, what: &str) {
    let data = Numbers(BufReader::new(std::io::stdin().lock()));
    match part {
        REGISTRATION => registration(&read_scans(data), what),
        _ => synchronization(&read_graph(data), what),
    }
}

/// From sampling to poses.
fn registration(scans: &[Scan], what: &str) {
    let mut params = Params::threedmatch();
    params.retrieval.min_scans = if what == "retrieval" { 0 } else { usize::MAX };
    let (registration, cost) = measured(|| register(scans, &params).unwrap());
    let times = &registration.times;
    let scoring_ratio = times.of(Stage::Scoring).as_secs_f64() / times.total().as_secs_f64();
    let num_pairs = registration.confidences.pairs().len();
    print(num_pairs, &cost, Some(cost.seconds * scoring_ratio));
}

/// By the method that the first word names.
fn synchronization(graph: &PoseGraph, what: &str) {
    let params = SyncParams {
        method: what.split(' ').next().unwrap().parse().unwrap(),
        ..SyncParams::default()
    };
    let (_, cost) = measured(|| synchronize(graph, &params).unwrap());
    print(graph.edges().len(), &cost, None);
}

struct Cost {
    seconds: f64,
    before_mib: Option<f64>,
    peak_mib: Option<f64>,
}

/// Without a value the cell is empty.
fn print(num_edges: usize, cost: &Cost, scoring_seconds: Option<f64>) {
    let cell = |value: Option<f64>, digits| {
        value.map_or_else(String::new, |value| format!("{value:.digits$}"))
    };
    let [before, peak] = [cost.before_mib, cost.peak_mib].map(|mib| cell(mib, 1));
    let [seconds, scoring] = [Some(cost.seconds), scoring_seconds].map(|time| cell(time, 5));
    println!("{num_edges},{seconds},{scoring},{before},{peak}");
}

/// The first result and its memory; the mean time of the runs that begin within a second, as the system
/// counts the time of threads in steps of milliseconds.
fn measured<T>(work: impl Fn() -> T) -> (T, Cost) {
    let before_mib = memory("VmRSS:");
    let (start, wall) = (processor_seconds(), Instant::now());
    let result = work();
    let peak_mib = memory("VmHWM:");
    if peak_mib.is_none() {
        eprintln!("memory is not measured: there is no /proc/self/status");
    }
    let mut num_runs = 1.0;
    while wall.elapsed().as_secs_f64() < 1.0 {
        work();
        num_runs += 1.0;
    }
    let wall_seconds = wall.elapsed().as_secs_f64();
    let spent = processor_seconds()
        .zip(start)
        .map(|(end, start)| end - start);
    let cost = Cost {
        seconds: spent.unwrap_or(wall_seconds) / num_runs,
        before_mib,
        peak_mib,
    };
    (result, cost)
}

/// Seconds that the threads of this process have run (Linux).
fn processor_seconds() -> Option<f64> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let nanoseconds = threads.map(|thread| {
        let statistics = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        statistics.split(' ').next()?.parse::<f64>().ok()
    });
    Some(nanoseconds.sum::<Option<f64>>()? * 1e-9)
}

/// A line of `/proc/self/status` in MiB (Linux).
fn memory(name: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes / 1024.0)
}

/// Numbers that arrive one by one, so that reading them needs no memory of its own.
struct Numbers<R>(R);

impl<R: Read> Numbers<R> {
    fn next(&mut self) -> f64 {
        let mut bytes = [0; 8];
        self.0.read_exact(&mut bytes).unwrap();
        f64::from_le_bytes(bytes)
    }

    fn count(&mut self) -> usize {
        self.next() as usize
    }

    fn items<T>(&mut self, number: usize, read: impl Fn(&mut Self) -> T) -> Vec<T> {
        (0..number).map(|_| read(self)).collect()
    }
}

pub fn scan_numbers(scans: &[Scan]) -> impl Iterator<Item = f64> {
    let numbers = scans.iter().flat_map(|scan| {
        let descriptors = scan.descriptors();
        let counts = [scan.len() as f64, descriptors.dimension() as f64];
        let points = scan.points().iter().flat_map(|p| [p.x, p.y, p.z]);
        let values = descriptors.values().iter().map(|value| f64::from(*value));
        counts.into_iter().chain(points).chain(values)
    });
    std::iter::once(scans.len() as f64).chain(numbers)
}

fn read_scans(mut data: Numbers<impl Read>) -> Vec<Scan> {
    let num_scans = data.count();
    data.items(num_scans, |data| {
        let (num_points, dimension) = (data.count(), data.count());
        let point = |data: &mut Numbers<_>| Point3::from([(); 3].map(|()| data.next()));
        let points = data.items(num_points, point);
        let values = data.items(num_points * dimension, |data| data.next() as f32);
        Scan::new(points, Descriptors::new(values, dimension).unwrap()).unwrap()
    })
}

pub fn graph_numbers(graph: &SimulatedPoseGraph) -> impl Iterator<Item = f64> {
    let numbers = graph.edges.iter().flat_map(|edge| {
        let ends = [edge.i as f64, edge.j as f64, edge.weight];
        let t = edge.i_from_j.translation.vector;
        let q = edge.i_from_j.rotation.coords;
        ends.into_iter().chain([t.x, t.y, t.z, q.w, q.x, q.y, q.z])
    });
    let counts = [graph.world_from_scan.len(), graph.edges.len()];
    counts.map(|count| count as f64).into_iter().chain(numbers)
}

fn read_graph(mut data: Numbers<impl Read>) -> PoseGraph {
    let (num_scans, num_edges) = (data.count(), data.count());
    let edges = data.items(num_edges, |data| {
        let (i, j, weight) = (data.count(), data.count(), data.next());
        let [x, y, z, qw, qx, qy, qz] = [(); 7].map(|()| data.next());
        let rotation = UnitQuaternion::new_unchecked(Quaternion::new(qw, qx, qy, qz));
        PoseEdge {
            i,
            j,
            i_from_j: Isometry3::from_parts(Translation3::new(x, y, z), rotation),
            weight,
        }
    });
    PoseGraph::new(num_scans, edges).unwrap()
}
