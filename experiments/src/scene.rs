//! Scenes of a folder: scans with descriptors, and what is known of their poses.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, UNIX_EPOCH};

use gmpcr::features::FeatureParams;
use gmpcr::{Params, Scan, compute_scan};
use gmpcr_eval::{GroundTruthPair, Protocol};
use gmpcr_io::{Layout, PairList, read_points};
use nalgebra::{DMatrix, Point3};
use rayon::prelude::*;

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::registering::Registrations;

/// Least extent of a typical scan in voxels that FPFH makes sense for.
const MIN_VOXELS_PER_SCAN: f64 = 20.0;

/// Where the descriptors of a scene come from.
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
    layout: Option<Layout>,
    pub descriptors: DescriptorKind,
    /// What the files are recognized by.
    input: String,
}

/// A scene in memory.
pub struct Scene {
    pub scans: Vec<Scan>,
    /// The paper's parameters for data of this layout, the main ones first.
    pub presets: Vec<(&'static str, Params)>,
    /// Pairs whose relative pose is known, list by list.
    pub lists: Vec<GroundTruthList>,
    /// Overlap of all pairs, in [0, 1]; empty if it is not known.
    pub overlap: Option<DMatrix<f64>>,
    /// Time that the features took; zero where descriptors were read.
    pub feature_time: Duration,
    /// Names the random numbers of this scene.
    pub seed: u64,
    /// Registrations that several experiments use.
    pub registrations: Registrations,
}

impl Scene {
    /// The parameters of the main preset.
    pub fn main_params(&self) -> &Params {
        &self.presets[0].1
    }
}

/// One list of pairs to judge.
pub struct GroundTruthList {
    pub name: String,
    /// What judges recall; none where pairs within 15° and 0.3 m count as registered.
    pub protocol: Option<Protocol>,
    pub pairs: Vec<GroundTruthPair>,
}

/// What a folder offers.
#[derive(Default)]
pub struct Sources {
    /// The scenes, in all kinds of descriptors they have.
    pub scenes: Vec<SceneSource>,
    /// Scenes that cannot be read, and why.
    pub failures: Vec<String>,
    /// What the reader of the tables should know of the others.
    pub notes: Vec<String>,
}

impl Sources {
    /// The scenes of the folder that was asked for.
    pub fn find(arguments: &Arguments) -> Result<Self, Failure> {
        let mut sources = Self::default();
        let Some(root) = &arguments.folder else {
            return Ok(sources);
        };
        let mut missing = arguments.scenes.clone();
        for folder in gmpcr_io::scene_folders(root)? {
            let resolved = folder.canonicalize()?;
            let name = resolved.file_name().unwrap_or_default().to_string_lossy();
            missing.retain(|wanted| *wanted != name);
            if arguments.scenes.is_empty() || arguments.scenes.iter().any(|wanted| *wanted == name)
            {
                sources.add_scene(&resolved, &name, arguments);
            }
        }
        match missing.first() {
            Some(name) => Err(format!("{} holds no scene {name}", root.display()).into()),
            None => Ok(sources),
        }
    }

    fn add_scene(&mut self, folder: &Path, name: &str, arguments: &Arguments) {
        let (files, layout) = match read_scene(folder) {
            Ok(read) => read,
            Err(error) => return self.failures.push(format!("{name}: {error}")),
        };
        let known = &files.ground_truth;
        if known.pair_lists.is_empty() && known.world_from_scan.is_none() {
            self.notes.push(format!(
                "{name}: neither pairs nor poses are known, so nothing is judged"
            ));
        }
        let num_pairs = files.scans.len() * files.scans.len().saturating_sub(1) / 2;
        if let Some(listed) = known.overlaps.as_ref().map(Vec::len)
            && listed < num_pairs
        {
            let unlisted = num_pairs - listed;
            self.notes.push(format!(
                "{name}: {unlisted} pairs without a listed overlap count as not overlapping"
            ));
        }
        self.add_fpfh(folder, &files, layout);
        if let Err(error) = self.add_learned(folder, files, layout, arguments) {
            self.failures.push(format!("{name}, learned: {error}"));
        }
    }

    fn add_fpfh(&mut self, folder: &Path, files: &gmpcr_io::Scene, layout: Option<Layout>) {
        if files.scans.iter().all(|scan| scan.cloud.is_some()) {
            self.scenes.push(SceneSource {
                files: files.clone(),
                layout,
                descriptors: DescriptorKind::Fpfh,
                input: fingerprint(&[folder]),
            });
        }
    }

    fn add_learned(
        &mut self,
        folder: &Path,
        mut files: gmpcr_io::Scene,
        layout: Option<Layout>,
        arguments: &Arguments,
    ) -> Result<(), Failure> {
        let mut folders = vec![folder.to_owned()];
        if let Some(root) = &arguments.descriptors {
            let separate = root.join(&files.name);
            if separate.is_dir() {
                files.attach_descriptors(&separate)?;
                folders.push(separate.canonicalize()?);
            } else {
                let (name, root) = (&files.name, root.display());
                self.notes
                    .push(format!("{name}: {root} has no descriptors for it"));
            }
        }
        if files.scans.iter().all(|scan| scan.descriptors.is_some()) {
            let folders: Vec<&Path> = folders.iter().map(PathBuf::as_path).collect();
            self.scenes.push(SceneSource {
                input: fingerprint(&folders),
                files,
                layout,
                descriptors: DescriptorKind::Learned,
            });
        }
        Ok(())
    }
}

fn read_scene(folder: &Path) -> Result<(gmpcr_io::Scene, Option<Layout>), gmpcr_io::Error> {
    let layout = Layout::of(folder)?;
    let scene = match layout {
        Some(layout) => gmpcr_io::read_scene(folder, layout)?,
        None => gmpcr_io::Scene::of_clouds(folder)?,
    };
    Ok((scene, layout))
}

/// Where the files of some folders are, how many, how large, and when the last one changed.
pub fn fingerprint(paths: &[&Path]) -> String {
    let (mut count, mut bytes, mut latest) = (0, 0, 0);
    let mut open: Vec<PathBuf> = paths.iter().map(|path| path.to_path_buf()).collect();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).into_iter().flatten().flatten();
            open.extend(entries.map(|entry| entry.path()));
        } else if let Ok(metadata) = path.metadata() {
            let changed = metadata.modified().ok();
            let changed = changed.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
            count += 1;
            bytes += metadata.len();
            latest = latest.max(changed.unwrap_or_default().as_secs());
        }
    }
    let places: Vec<String> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let places = places.join(", ");
    format!("{places}: {count} files, {bytes} bytes, changed {latest}")
}

impl SceneSource {
    pub fn name(&self) -> &str {
        &self.files.name
    }

    pub fn input(&self) -> &str {
        &self.input
    }

    /// Reads, and where need be computes, points and descriptors.
    pub fn load(&self, arguments: &Arguments) -> Result<Scene, Failure> {
        let start = Instant::now();
        let (scans, feature_time) = match self.descriptors {
            DescriptorKind::Learned => (self.learned_scans()?, Duration::ZERO),
            DescriptorKind::Fpfh => {
                let clouds = self.clouds()?;
                check_extent(&clouds, arguments.voxel)?;
                let reading = start.elapsed();
                let params = FeatureParams::from_voxel_size(arguments.voxel);
                let scans = clouds.par_iter().map(|cloud| compute_scan(cloud, &params));
                let scans = scans.collect::<Result<_, _>>()?;
                (scans, start.elapsed() - reading)
            }
        };
        Ok(Scene {
            lists: self.lists()?,
            presets: self.presets(arguments),
            seed: hash(self.name()) ^ arguments.seed,
            overlap: self.overlap(),
            scans,
            feature_time,
            registrations: Registrations::default(),
        })
    }

    /// The paper's parameters for data of this layout, at the voxel size.
    fn presets(&self, arguments: &Arguments) -> Vec<(&'static str, Params)> {
        let presets = match self.layout {
            Some(Layout::ScanNet) => vec![("ScanNet preset", Params::scannet())],
            Some(Layout::Eth) => vec![("ETH preset", Params::eth())],
            _ => vec![
                ("3DMatch preset", Params::threedmatch()),
                ("3DLoMatch preset", Params::threedlomatch()),
            ],
        };
        let at_voxel =
            |(name, params): (_, Params)| (name, params.with_voxel_size(arguments.voxel));
        presets.into_iter().map(at_voxel).collect()
    }

    /// The lists of pairs; where there is none, all pairs of known poses.
    fn lists(&self) -> Result<Vec<GroundTruthList>, gmpcr_eval::Error> {
        let known = &self.files.ground_truth;
        match &known.world_from_scan {
            Some(poses) if known.pair_lists.is_empty() => Ok(vec![GroundTruthList {
                name: "poses".to_owned(),
                protocol: None,
                pairs: GroundTruthPair::all_pairs(poses),
            }]),
            _ => known.pair_lists.iter().map(ground_truth_list).collect(),
        }
    }

    fn clouds(&self) -> Result<Vec<Vec<Point3<f64>>>, Failure> {
        let files = self
            .files
            .scans
            .iter()
            .filter_map(|scan| scan.cloud.as_ref());
        let read = files.map(|file| Ok(read_points(file)?.points));
        read.collect()
    }

    fn learned_scans(&self) -> Result<Vec<Scan>, Failure> {
        let files = self.files.scans.iter();
        let files = files.filter_map(|scan| scan.descriptors.as_ref());
        files.map(|files| Ok(files.read()?)).collect()
    }

    fn overlap(&self) -> Option<DMatrix<f64>> {
        let num_scans = self.files.scans.len();
        let mut matrix = DMatrix::identity(num_scans, num_scans);
        for pair in self.files.ground_truth.overlaps.as_ref()? {
            matrix[(pair.i, pair.j)] = pair.overlap;
            matrix[(pair.j, pair.i)] = pair.overlap;
        }
        Some(matrix)
    }
}

fn ground_truth_list(list: &PairList) -> Result<GroundTruthList, gmpcr_eval::Error> {
    let pairs = list
        .pairs
        .iter()
        .map(|pair| (pair.i, pair.j, pair.i_from_j));
    Ok(GroundTruthList {
        name: list.name.clone(),
        protocol: Protocol::of_list(&list.name, list.information.is_some()),
        pairs: GroundTruthPair::of_list(pairs, list.information.as_deref())?,
    })
}

/// FNV-1a.
fn hash(text: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    text.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

/// Refuses scans that a voxel grid of this size would reduce to a few points.
fn check_extent(clouds: &[Vec<Point3<f64>>], voxel: f64) -> Result<(), Failure> {
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
            "its scans are {median:.3} m wide, less than {MIN_VOXELS_PER_SCAN} voxels of {voxel} m: \
             leave it out with --scenes or run it alone with a smaller --voxel"
        )
        .into()),
        _ => Ok(()),
    }
}
