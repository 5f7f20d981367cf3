//! Scans from files or from the simulator, with the truth where it is known.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use gmpcr::features::FeatureParams;
use gmpcr::nalgebra::{Isometry3, Point3};
use gmpcr::{Descriptors, Scan, describe_clouds};
use gmpcr_eval::{GroundTruthPair, OverlapIndex, information_matrix};
use gmpcr_io::{
    DescriptorFiles, Layout, PairList, Scene, SceneScan, SceneTruth, read_points, read_scene,
};
use gmpcr_sim::{RoomParams, SimParams, SimulatedScans, simulate};

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
        let mut scene = match Layout::of(folder)? {
            Some(layout) => read_scene(folder, layout)?,
            None => Scene::of_clouds(folder)?,
        };
        if let Some(folder) = descriptors {
            scene.attach_descriptors(folder)?;
        }
        let clouds = read_clouds(&scene)?;
        let scans = match learned_scans(&scene.scans)? {
            Some(scans) => scans,
            None => fpfh_scans(&clouds, voxel)?,
        };
        Ok(Self {
            clouds,
            scans,
            truth: Truth::of(scene.truth),
        })
    }
}

impl Truth {
    fn of(truth: SceneTruth) -> Self {
        let [matches, lo_matches] =
            ["3dmatch", "3dlomatch"].map(|name| truth.match_list(name).and_then(benchmark_pairs));
        Self {
            matches: matches.zip(lo_matches).map(<[_; 2]>::from),
            world_from_scan: truth
                .world_from_scan
                .and_then(|poses| poses.into_iter().collect()),
        }
    }
}

fn benchmark_pairs(list: &PairList) -> Option<Vec<GroundTruthPair>> {
    let information = list.information.as_ref()?;
    let pairs = list.pairs.iter().zip(information);
    let pairs = pairs.map(|(pair, &information)| GroundTruthPair {
        i: pair.i,
        j: pair.j,
        i_from_j: pair.i_from_j,
        information,
    });
    Some(pairs.collect())
}

fn read_clouds(scene: &Scene) -> Result<Vec<Vec<Point3<f64>>>, Box<dyn Error>> {
    let start = Instant::now();
    let mut clouds = Vec::new();
    for scan in &scene.scans {
        let Some(file) = &scan.cloud else {
            return Err(format!("{} has descriptors but no clouds", scene.folder.display()).into());
        };
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
    Ok(clouds)
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

/// Scans of learned descriptors, if all have some.
fn learned_scans(scans: &[SceneScan]) -> Result<Option<Vec<Scan>>, Box<dyn Error>> {
    let files: Option<Vec<_>> = scans.iter().map(|scan| scan.descriptors.as_ref()).collect();
    let read = files.map(|files| files.into_iter().map(learned_scan).collect());
    read.transpose()
}

fn learned_scan(files: &DescriptorFiles) -> Result<Scan, Box<dyn Error>> {
    let (points, read) = files.read()?;
    Ok(Scan::new(
        points,
        Descriptors::new(read.values, read.dimension)?,
    )?)
}

/// All pairs of simulated scans that overlap, in the classes of 3DMatch and 3DLoMatch.
fn true_pairs(
    clouds: &[Vec<Point3<f64>>],
    world_from_scan: &[Isometry3<f64>],
) -> [Vec<GroundTruthPair>; 2] {
    let indices: Vec<_> = clouds
        .iter()
        .map(|cloud| OverlapIndex::new(cloud, OVERLAP_RADIUS))
        .collect();
    let mut matches = [Vec::new(), Vec::new()];
    for (i, j) in (0..clouds.len()).flat_map(|i| (i + 1..clouds.len()).map(move |j| (i, j))) {
        let i_from_j = world_from_scan[i].inv_mul(&world_from_scan[j]);
        let overlap = indices[i].overlap(&indices[j], &i_from_j);
        let class = if overlap > 0.3 { 0 } else { 1 };
        if overlap >= 0.1 {
            let overlapping = indices[i].overlapping_points(&indices[j], &i_from_j);
            matches[class].push(GroundTruthPair {
                i,
                j,
                i_from_j,
                information: information_matrix(&overlapping),
            });
        }
    }
    matches
}
