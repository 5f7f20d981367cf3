//! From what the user names to described scans: reading, working voxel, features.

use std::path::{Path, PathBuf};
use std::time::Duration;

use gmpcr::features::{FPFH_DIMENSION, FeatureParams, describe, estimate_voxel_size};
use gmpcr::{Descriptors, Scan, describe_cloud};
use gmpcr_io::{DescriptorFiles, PointFile, Scene, SceneScan, SceneTruth, descriptor_files};
use rayon::prelude::*;

use crate::config::Config;
use crate::outcome::Failure;
use crate::progress::Progress;
use crate::scans::{Cloud, localize_georeferenced, read_clouds};
use crate::table::counted;

/// Scans ready to be registered.
pub struct DescribedScans {
    pub clouds: Vec<Cloud>,
    /// One per cloud, in its coordinates.
    pub scans: Vec<Scan>,
    pub voxel: WorkingVoxel,
    /// What describes the points, in words.
    pub features: &'static str,
    /// Wall time of reading and of describing.
    pub times: Vec<(&'static str, Duration)>,
}

/// The length from which all others follow, in the unit of the scans.
#[derive(Clone, Copy)]
pub struct WorkingVoxel {
    pub size: f64,
    pub is_estimated: bool,
}

impl DescribedScans {
    /// Scans of files, described by FPFH.
    pub fn by_fpfh(
        files: &[PathBuf],
        config: &Config,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let (mut clouds, reading) = read(files, progress)?;
        let (voxel, estimation) = WorkingVoxel::of(&clouds, config, progress)?;
        let params = config.features(voxel.size);
        // Parameters that cannot be are no fault of the scans.
        describe(&[], &params).map_err(|error| format!("parameters of the features: {error}"))?;
        let (scans, describing) = progress.stage("features", clouds.len(), || {
            let describe =
                |cloud: &mut Cloud| progress.item(|| fpfh_scan(cloud, &params, progress));
            clouds.par_iter_mut().map(describe).collect()
        })?;
        Ok(Self {
            clouds,
            scans,
            voxel,
            features: "FPFH",
            times: vec![
                ("reading", reading),
                ("voxel", estimation),
                ("features", describing),
            ],
        })
    }

    /// Scans of files, described by other files; without clouds, keypoints stand in for them.
    pub fn by_descriptors(
        files: &[PathBuf],
        folder: &Path,
        config: &Config,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let (mut clouds, mut reading) = (Vec::new(), Duration::ZERO);
        let sets = if files.is_empty() {
            descriptor_files(folder)?
        } else {
            (clouds, reading) = read(files, progress)?;
            if clouds.len() != files.len() {
                return Err("--descriptors needs one scan in a file".into());
            }
            attached(files, folder)?
        };
        let (scans, describing) = progress.stage("descriptors", sets.len(), || {
            let read = |files| progress.item(|| learned_scan(files));
            let scans: Result<Vec<_>, Failure> = sets.par_iter().map(read).collect();
            scans?.into_iter().collect::<Result<Vec<_>, _>>()
        })?;
        check_dimensions(&sets, &scans)?;
        if clouds.is_empty() {
            let named = sets.iter().zip(&scans);
            clouds = named
                .map(|(files, scan)| Cloud::of_keypoints(files, scan))
                .collect();
            localize_georeferenced(&mut clouds);
        }
        let scans = clouds.iter().zip(scans);
        let scans = scans
            .map(|(cloud, scan)| cloud.localized(scan))
            .collect::<Result<_, _>>()?;
        let (voxel, estimation) = WorkingVoxel::of(&clouds, config, progress)?;
        Ok(Self {
            clouds,
            scans,
            voxel,
            features: "descriptors of files",
            times: vec![
                ("reading", reading),
                ("descriptors", describing),
                ("voxel", estimation),
            ],
        })
    }
}

fn read(files: &[PathBuf], progress: &Progress) -> Result<(Vec<Cloud>, Duration), Failure> {
    progress.stage("reading", files.len(), || {
        let mut clouds = read_clouds(files, progress)?;
        localize_georeferenced(&mut clouds);
        Ok(clouds)
    })
}

/// The sets of descriptors of the files, in their order.
fn attached(files: &[PathBuf], folder: &Path) -> Result<Vec<DescriptorFiles>, Failure> {
    let scans = files.iter().map(|cloud| SceneScan {
        cloud: Some(cloud.clone()),
        descriptors: None,
    });
    let mut scene = Scene {
        name: String::new(),
        folder: folder.to_owned(),
        scans: scans.collect(),
        truth: SceneTruth::default(),
    };
    scene.attach_descriptors(folder)?;
    Ok(scene
        .scans
        .into_iter()
        .filter_map(|scan| scan.descriptors)
        .collect())
}

/// A scan that cannot be described is left out: it becomes one without points.
fn fpfh_scan(cloud: &mut Cloud, params: &FeatureParams, progress: &Progress) -> Scan {
    let num_strays = cloud.drop_strays(params.voxel_size);
    if num_strays > 0 {
        let strays = counted(num_strays, "point");
        progress.say(&format!("{}: {strays} far off left out", cloud.name));
    }
    let mut params = *params;
    params.normals.viewpoint = cloud.viewpoint;
    describe_cloud(&cloud.points, &params).unwrap_or_else(|error| {
        let problem = format!("{}: {error}", cloud.file.display());
        progress.say(&format!("left out: {problem}; mend or remove the file"));
        cloud.problem = Some(problem);
        empty_scan()
    })
}

fn empty_scan() -> Scan {
    let none = Descriptors::new(Vec::new(), FPFH_DIMENSION);
    none.ok()
        .and_then(|descriptors| Scan::new(Vec::new(), descriptors).ok())
        .expect("no points and no descriptors are a scan")
}

fn learned_scan(files: &DescriptorFiles) -> Result<Scan, Failure> {
    let (points, read) = files.read()?;
    Ok(Scan::new(
        points,
        Descriptors::new(read.values, read.dimension)?,
    )?)
}

fn check_dimensions(sets: &[DescriptorFiles], scans: &[Scan]) -> Result<(), Failure> {
    let described = sets.iter().zip(scans).filter(|(_, scan)| !scan.is_empty());
    let mut dimensions = described.map(|(files, scan)| (files, scan.descriptors().dimension()));
    let Some((first, expected)) = dimensions.next() else {
        return Ok(());
    };
    match dimensions.find(|&(_, dimension)| dimension != expected) {
        Some((other, dimension)) => Err(format!(
            "{} has descriptors of {dimension} numbers, but {} of {expected}: all scans need the same \
             kind of descriptor",
            other.descriptors.display(),
            first.descriptors.display()
        )
        .into()),
        None => Ok(()),
    }
}

impl Cloud {
    fn of_keypoints(files: &DescriptorFiles, scan: &Scan) -> Self {
        let mut file = PointFile::default();
        file.points = scan.points().to_vec();
        Self::new(&files.name, &files.keypoints, file)
    }

    /// A scan of the file's coordinates, in those of the cloud.
    fn localized(&self, scan: Scan) -> Result<Scan, Failure> {
        if self.problem.is_some() {
            return Ok(Scan::new(Vec::new(), scan.descriptors().select(&[]))?);
        }
        let points = scan.points().iter().map(|point| point - self.origin);
        Ok(Scan::new(points.collect(), scan.descriptors().clone())?)
    }
}

impl WorkingVoxel {
    /// The one that the user has given, or the median of the estimates of all clouds (the lower of
    /// the two in the middle).
    fn of(
        clouds: &[Cloud],
        config: &Config,
        progress: &Progress,
    ) -> Result<(Self, Duration), Failure> {
        if let Some(size) = config.voxel {
            let given = Self {
                size,
                is_estimated: false,
            };
            return Ok((given, Duration::ZERO));
        }
        let (mut estimates, time) = progress.stage("voxel", clouds.len(), || {
            let estimate = |cloud: &Cloud| {
                let estimate = progress.item(|| estimate_voxel_size(&cloud.points))?;
                estimate.map_err(|error| Failure::of(&cloud.file, error))
            };
            let estimates: Result<Vec<_>, Failure> = clouds.par_iter().map(estimate).collect();
            Ok(estimates?.into_iter().flatten().collect::<Vec<f64>>())
        })?;
        if estimates.is_empty() {
            return Err("no scan has two different points: nothing can be said of them".into());
        }
        let middle = (estimates.len() - 1) / 2;
        let (_, &mut size, _) = estimates.select_nth_unstable_by(middle, f64::total_cmp);
        let estimate = Self {
            size,
            is_estimated: true,
        };
        Ok((estimate, time))
    }
}
