//! Scans from files or from the simulator, with the truth where it is known.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use gmpcr::features::FeatureParams;
use gmpcr::nalgebra::{Isometry3, Point3};
use gmpcr::{Descriptors, Scan, describe_clouds};
use gmpcr_eval::GroundTruthPair;
use gmpcr_io::{
    descriptor_files, read_descriptors, read_gt_info, read_gt_log, read_keypoints, read_points,
    scan_files,
};
use gmpcr_sim::{RoomParams, SimParams, SimulatedScans, overlapping_points, simulate};

/// What is to be registered.
pub struct Input {
    pub clouds: Vec<Vec<Point3<f64>>>,
    pub scans: Vec<Scan>,
    pub truth: Truth,
}

/// What is known of the true poses.
#[derive(Default)]
pub struct Truth {
    /// Pairs of more than 30 % overlap, and pairs of 10–30 %.
    pub matches: Option<[Vec<GroundTruthPair>; 2]>,
    pub world_from_scan: Option<Vec<Isometry3<f64>>>,
}

/// Points count as shared within 1.5 voxels of 2.5 cm, as in the 3DMatch benchmark.
const OVERLAP_RADIUS: f64 = 0.0375;

impl Input {
    pub fn simulate(
        num_scans: usize,
        num_rooms: usize,
        seed: u64,
        voxel: f64,
    ) -> Result<Self, Box<dyn Error>> {
        let start = Instant::now();
        let SimulatedScans {
            clouds,
            world_from_scan,
        } = simulate(&SimParams {
            num_scans,
            seed,
            room: RoomParams {
                num_rooms,
                ..RoomParams::default()
            },
            ..SimParams::default()
        })?;
        println!(
            "simulated {} scans in {:.2} s",
            clouds.len(),
            start.elapsed().as_secs_f64()
        );
        Ok(Self {
            scans: fpfh_scans(&clouds, voxel)?,
            truth: Truth {
                matches: Some(true_pairs(&clouds, &world_from_scan)),
                world_from_scan: Some(world_from_scan),
            },
            clouds,
        })
    }

    pub fn read(
        folder: &Path,
        descriptors: Option<&Path>,
        voxel: f64,
    ) -> Result<Self, Box<dyn Error>> {
        let start = Instant::now();
        let mut clouds = Vec::new();
        let files = scan_files(folder)?;
        for file in &files {
            let read = read_points(file)?;
            if read.invalid > 0 {
                println!(
                    "{}: {} points that are not finite left out",
                    file.display(),
                    read.invalid
                );
            }
            clouds.push(read.points);
        }
        println!(
            "read {} scans in {:.2} s",
            clouds.len(),
            start.elapsed().as_secs_f64()
        );
        let scans = match descriptors {
            Some(folder) => learned_scans(folder, &files)?,
            None => fpfh_scans(&clouds, voxel)?,
        };
        Ok(Self {
            clouds,
            scans,
            truth: read_truth(folder)?,
        })
    }
}

fn fpfh_scans(clouds: &[Vec<Point3<f64>>], voxel: f64) -> Result<Vec<Scan>, Box<dyn Error>> {
    let start = Instant::now();
    let scans = describe_clouds(clouds, &FeatureParams::from_voxel_size(voxel))?;
    println!(
        "computed normals and FPFH in {:.2} s",
        start.elapsed().as_secs_f64()
    );
    Ok(scans)
}

fn learned_scans(folder: &Path, clouds: &[PathBuf]) -> Result<Vec<Scan>, Box<dyn Error>> {
    let files = descriptor_files(folder)?;
    let folder = folder.display();
    if files.len() != clouds.len() {
        let (sets, scans) = (files.len(), clouds.len());
        return Err(format!("{folder}: {sets} descriptor sets for {scans} scans").into());
    }
    for (files, cloud) in files.iter().zip(clouds) {
        let stem = cloud
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
        if stem.as_deref().map(trailing_number) != Some(trailing_number(&files.name)) {
            let cloud = cloud.display();
            return Err(format!(
                "{folder}: descriptors {} stand where {cloud} has its turn",
                files.name
            )
            .into());
        }
    }
    let scan = |files: &gmpcr_io::DescriptorFiles| -> Result<Scan, Box<dyn Error>> {
        let read = read_descriptors(&files.descriptors)?;
        let named = |error: &dyn Error| format!("{}: {error}", files.descriptors.display());
        let descriptors = Descriptors::new(read.values, read.dimension).map_err(|e| named(&e))?;
        Ok(Scan::new(read_keypoints(&files.keypoints)?, descriptors).map_err(|e| named(&e))?)
    };
    files.iter().map(scan).collect()
}

/// The digits at the end of a name, by which clouds and descriptors belong together.
fn trailing_number(name: &str) -> Option<usize> {
    let start = name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    name[start..].parse().ok()
}

/// The benchmark's pairs where they lie beside the scans.
fn read_truth(folder: &Path) -> Result<Truth, Box<dyn Error>> {
    let names = ["official_3dmatch", "official_3dlomatch"].map(|name| folder.join(name));
    let is_present = |extension| {
        names
            .iter()
            .all(|name| name.with_extension(extension).is_file())
    };
    if !is_present("log") || !is_present("info") {
        return Ok(Truth::default());
    }
    let [matches, lo_matches] = names.map(|name| benchmark_pairs(&name));
    Ok(Truth {
        matches: Some([matches?, lo_matches?]),
        world_from_scan: None,
    })
}

fn benchmark_pairs(name: &Path) -> Result<Vec<GroundTruthPair>, Box<dyn Error>> {
    let log = read_gt_log(name.with_extension("log"))?;
    let info = read_gt_info(name.with_extension("info"))?;
    let is_same = log.len() == info.len()
        && log
            .iter()
            .zip(&info)
            .all(|(log, info)| (log.i, log.j) == (info.i, info.j));
    if !is_same {
        return Err(format!("{}: .log and .info list different pairs", name.display()).into());
    }
    let pair = |(log, info): (&gmpcr_io::LogEntry, &gmpcr_io::InfoEntry)| GroundTruthPair {
        i: log.i,
        j: log.j,
        i_from_j: log.i_from_j,
        information: info.information,
    };
    Ok(log.iter().zip(&info).map(pair).collect())
}

/// All pairs of simulated scans that overlap, in the classes of 3DMatch and 3DLoMatch.
fn true_pairs(
    clouds: &[Vec<Point3<f64>>],
    world_from_scan: &[Isometry3<f64>],
) -> [Vec<GroundTruthPair>; 2] {
    let mut matches = [Vec::new(), Vec::new()];
    for (i, j) in (0..clouds.len()).flat_map(|i| (i + 1..clouds.len()).map(move |j| (i, j))) {
        let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
        let shared_i = overlapping_points(&clouds[i], &clouds[j], &i_from_j, OVERLAP_RADIUS);
        let shared_j =
            overlapping_points(&clouds[j], &clouds[i], &i_from_j.inverse(), OVERLAP_RADIUS);
        let share = |shared: usize, all: usize| shared as f64 / all.max(1) as f64;
        let overlap =
            0.5 * (share(shared_i.len(), clouds[i].len()) + share(shared_j.len(), clouds[j].len()));
        let class = if overlap > 0.3 { 0 } else { 1 };
        if overlap >= 0.1 {
            matches[class].push(GroundTruthPair {
                i,
                j,
                i_from_j,
                information: gmpcr_eval::information_matrix(&shared_i),
            });
        }
    }
    matches
}
