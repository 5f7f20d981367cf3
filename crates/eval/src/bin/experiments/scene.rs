//! Scenes of a folder: described scans and what is known of their poses.

use std::error::Error;
use std::time::{Duration, Instant};

use gmpcr::features::FeatureParams;
use gmpcr::{Descriptors, Scan, describe_clouds};
use gmpcr_eval::{GroundTruthPair, Protocol};
use gmpcr_io::{DescriptorFiles, Layout, PairList, read_descriptors, read_keypoints, read_points};
use nalgebra::{DMatrix, Matrix6, Point3};

use crate::arguments::Arguments;
use crate::registering::Registrations;

/// Least extent of a typical scan in voxels that FPFH makes sense for.
const MIN_VOXELS_PER_SCAN: f64 = 20.0;

/// What describes the points of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DescriptorKind {
    /// Computed from the clouds.
    Fpfh,
    /// Read from files.
    Learned,
}

impl DescriptorKind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Fpfh => "fpfh",
            Self::Learned => "learned",
        }
    }
}

/// A scene with one kind of descriptors, not loaded yet.
pub struct SceneSource {
    files: gmpcr_io::Scene,
    pub descriptors: DescriptorKind,
}

/// A scene in memory.
pub struct Scene {
    pub scans: Vec<Scan>,
    /// Pairs whose relative pose is known, list by list.
    pub lists: Vec<MatchList>,
    /// Overlap of all pairs, in [0, 1]; empty if it is not known.
    pub overlap: Option<DMatrix<f64>>,
    /// Time it took to compute the descriptors; zero where they were read.
    pub description: Duration,
    /// Registrations that several experiments share.
    pub registrations: Registrations,
}

/// One of the benchmark's lists of pairs.
pub struct MatchList {
    pub name: String,
    pub protocol: Protocol,
    pub pairs: Vec<GroundTruthPair>,
    /// Whether the list comes with information matrices, by which recall judges.
    pub has_information: bool,
}

/// The scenes of a folder in all kinds of descriptors they have. A scene that cannot be read is
/// named among the failures.
pub fn scene_sources(
    folder: &std::path::Path,
    arguments: &Arguments,
    failures: &mut Vec<String>,
) -> Result<Vec<SceneSource>, Box<dyn Error>> {
    let mut sources = Vec::new();
    let mut missing = arguments.scenes.clone();
    for folder in gmpcr_io::scene_folders(folder)? {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        missing.retain(|wanted| *wanted != name);
        if arguments.scenes.is_empty() || arguments.scenes.iter().any(|wanted| *wanted == name) {
            match sources_of_scene(&folder, arguments) {
                Ok(found) => sources.extend(found),
                Err(error) => failures.push(format!("{name}: {error}")),
            }
        }
    }
    match missing.first() {
        Some(name) => Err(format!("{} holds no scene {name}", folder.display()).into()),
        None => Ok(sources),
    }
}

fn sources_of_scene(
    folder: &std::path::Path,
    arguments: &Arguments,
) -> Result<Vec<SceneSource>, Box<dyn Error>> {
    let files = match Layout::of(folder)? {
        Some(layout) => gmpcr_io::read_scene(folder, layout)?,
        None => gmpcr_io::Scene::of_clouds(folder)?,
    };
    let mut learned = files.clone();
    let separate = arguments
        .descriptors
        .as_ref()
        .map(|root| root.join(&files.name));
    if let Some(separate) = separate.filter(|separate| separate.is_dir()) {
        learned.attach_descriptors(separate)?;
    }
    let has_clouds = files.scans.iter().all(|scan| scan.cloud.is_some());
    let is_described = learned.scans.iter().all(|scan| scan.descriptors.is_some());
    let source = |files: gmpcr_io::Scene, descriptors| SceneSource { files, descriptors };
    let fpfh = has_clouds.then(|| source(files, DescriptorKind::Fpfh));
    let learned = is_described.then(|| source(learned, DescriptorKind::Learned));
    Ok(fpfh.into_iter().chain(learned).collect())
}

impl SceneSource {
    pub fn name(&self) -> &str {
        &self.files.name
    }

    /// Reads, and where need be computes, points and descriptors.
    pub fn load(&self, arguments: &Arguments) -> Result<Scene, Box<dyn Error>> {
        let start = Instant::now();
        let (scans, description) = match self.descriptors {
            DescriptorKind::Learned => (self.learned_scans()?, Duration::ZERO),
            DescriptorKind::Fpfh => {
                let clouds = self.clouds()?;
                check_extent(&clouds, arguments.voxel)?;
                let reading = start.elapsed();
                let params = FeatureParams::from_voxel_size(arguments.voxel);
                let scans = describe_clouds(&clouds, &params)?;
                (scans, start.elapsed() - reading)
            }
        };
        Ok(Scene {
            lists: self
                .files
                .truth
                .match_lists
                .iter()
                .map(match_list)
                .collect(),
            overlap: self.overlap(),
            scans,
            description,
            registrations: Registrations::default(),
        })
    }

    fn clouds(&self) -> Result<Vec<Vec<Point3<f64>>>, Box<dyn Error>> {
        let files = self
            .files
            .scans
            .iter()
            .filter_map(|scan| scan.cloud.as_ref());
        let read = files.map(|file| Ok(read_points(file)?.points));
        read.collect()
    }

    fn learned_scans(&self) -> Result<Vec<Scan>, Box<dyn Error>> {
        let files = self.files.scans.iter();
        let files = files.filter_map(|scan| scan.descriptors.as_ref());
        files.map(learned_scan).collect()
    }

    fn overlap(&self) -> Option<DMatrix<f64>> {
        let num_scans = self.files.scans.len();
        let mut matrix = DMatrix::identity(num_scans, num_scans);
        for pair in self.files.truth.overlaps.as_ref()? {
            matrix[(pair.i, pair.j)] = pair.overlap;
            matrix[(pair.j, pair.i)] = pair.overlap;
        }
        Some(matrix)
    }
}

fn learned_scan(files: &DescriptorFiles) -> Result<Scan, Box<dyn Error>> {
    let named = |error: &dyn Error| format!("{}: {error}", files.descriptors.display());
    let read = read_descriptors(&files.descriptors)?;
    let descriptors =
        Descriptors::new(read.values, read.dimension).map_err(|error| named(&error))?;
    let points = read_keypoints(&files.keypoints)?;
    Ok(Scan::new(points, descriptors).map_err(|error| named(&error))?)
}

/// 3DMatch leaves consecutive pairs out; all other lists count every pair.
fn match_list(list: &PairList) -> MatchList {
    let information = |k: usize| match &list.information {
        Some(matrices) => matrices[k],
        None => Matrix6::zeros(),
    };
    let pairs = list
        .pairs
        .iter()
        .enumerate()
        .map(|(k, pair)| GroundTruthPair {
            i: pair.i,
            j: pair.j,
            i_from_j: pair.i_from_j,
            information: information(k),
        });
    MatchList {
        name: list.name.clone(),
        protocol: match list.name.as_str() {
            "3dmatch" => Protocol::ThreeDMatch,
            _ => Protocol::ThreeDLoMatch,
        },
        pairs: pairs.collect(),
        has_information: list.information.is_some(),
    }
}

/// Refuses scans that a voxel grid of this size would reduce to a few points.
fn check_extent(clouds: &[Vec<Point3<f64>>], voxel: f64) -> Result<(), Box<dyn Error>> {
    let extent = |cloud: &Vec<Point3<f64>>| {
        let low = cloud
            .iter()
            .fold(Point3::from([f64::MAX; 3]), |low, p| low.inf(p));
        let high = cloud
            .iter()
            .fold(Point3::from([f64::MIN; 3]), |high, p| high.sup(p));
        (high - low).max()
    };
    let mut extents: Vec<f64> = clouds.iter().map(extent).collect();
    extents.sort_by(f64::total_cmp);
    match extents.get(extents.len() / 2) {
        Some(&median) if median < MIN_VOXELS_PER_SCAN * voxel => Err(format!(
            "its scans extend {median:.3} only, less than {MIN_VOXELS_PER_SCAN} voxels of {voxel}: \
             a smaller --voxel is needed"
        )
        .into()),
        _ => Ok(()),
    }
}
