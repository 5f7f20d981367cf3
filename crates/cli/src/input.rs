//! From what the user names to scans: reading, voxel size, features.

use std::path::{Path, PathBuf};
use std::time::Duration;

use gmpcr::{Cloud, Scan, ScanSet, VoxelSize, compute_features_with};
use gmpcr_io::{DescriptorFiles, descriptor_files, descriptor_files_of_clouds};
use rayon::prelude::*;

use crate::config::Config;
use crate::outcome::Failure;
use crate::progress::Progress;
use crate::scan_files::{NamedCloud, ScanFile, left_out, read_clouds};
use crate::table::counted;

/// Scans ready to be registered.
pub struct Input {
    pub files: Vec<ScanFile>,
    /// In the order of the files.
    pub set: ScanSet,
    /// Whether the voxel size follows from the scans.
    pub voxel_is_estimated: bool,
    /// What features the points have, in words.
    pub features: &'static str,
    /// Wall time of what the library did not do.
    pub times: Vec<(&'static str, Duration)>,
}

impl Input {
    /// Scans of files, with FPFH.
    pub fn with_fpfh(
        files: &[PathBuf],
        config: &Config,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let (clouds, reading) =
            progress.stage("reading", files.len(), || read_clouds(files, progress))?;
        let (mut files, clouds): (Vec<_>, Vec<_>) = clouds.into_iter().unzip();
        let (params, voxel_size) = match config.voxel_size {
            Some(voxel_size) => (config.params(voxel_size), VoxelSize::Given),
            None => (config.params(1.0), VoxelSize::Estimated),
        };
        let set = compute_features_with(clouds, &params.features, voxel_size, progress)
            .map_err(Failure::of_registration)?;
        progress.finish();
        for (file, num_strays) in files.iter().zip(&set.num_strays) {
            if *num_strays > 0 {
                let strays = counted(*num_strays, "point");
                progress.say(&format!("{}: {strays} far off left out", file.name));
            }
        }
        for (file, problem) in files.iter_mut().zip(&set.problems) {
            if let Some(problem) = problem {
                let problem = format!("{}: {problem}", file.file.display());
                progress.say(&left_out(&problem));
                file.problem = Some(problem);
            }
        }
        Ok(Self {
            files,
            set,
            voxel_is_estimated: config.voxel_size.is_none(),
            features: "FPFH",
            times: vec![("reading", reading)],
        })
    }

    /// Scans of files, with descriptors of other files; without clouds, keypoints stand in for them.
    pub fn with_descriptors(
        files: &[PathBuf],
        folder: &Path,
        config: &Config,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let (mut clouds, mut reading) = (Vec::new(), Duration::ZERO);
        let sets = if files.is_empty() {
            descriptor_files(folder)?
        } else {
            (clouds, reading) =
                progress.stage("reading", files.len(), || read_clouds(files, progress))?;
            if clouds.len() != files.len() {
                return Err("--descriptors needs one scan in a file".into());
            }
            descriptor_files_of_clouds(files, folder)?
        };
        let (mut scans, descriptors) = progress.stage("descriptors", sets.len(), || {
            let read = |files: &DescriptorFiles| progress.item(|| files.read());
            let scans: Result<Vec<_>, Failure> = sets.par_iter().map(read).collect();
            Ok(scans?.into_iter().collect::<Result<Vec<Scan>, _>>()?)
        })?;
        check_dimensions(&sets, &scans)?;
        if clouds.is_empty() {
            let named = sets.iter().zip(&scans);
            clouds = named
                .map(|(files, scan)| ScanFile::of_keypoints(files, scan))
                .collect();
        }
        leave_out_unreadable(&clouds, &mut scans)?;
        let (files, clouds): (Vec<_>, Vec<Cloud>) = clouds.into_iter().unzip();
        let set = ScanSet::with_scans(clouds, scans, config.voxel_size, progress)
            .map_err(Failure::of_registration)?;
        Ok(Self {
            files,
            set,
            voxel_is_estimated: config.voxel_size.is_none(),
            features: "descriptors of files",
            times: vec![("reading", reading), ("descriptors", descriptors)],
        })
    }

    /// The name of a scan.
    pub fn name(&self, scan: usize) -> &str {
        &self.files[scan].name
    }
}

/// The keypoints of a cloud that could not be read are no scan.
fn leave_out_unreadable(clouds: &[NamedCloud], scans: &mut [Scan]) -> Result<(), Failure> {
    for ((file, _), scan) in clouds.iter().zip(scans) {
        if file.problem.is_some() {
            *scan = Scan::new(Vec::new(), scan.descriptors().select(&[]))?;
        }
    }
    Ok(())
}

fn check_dimensions(sets: &[DescriptorFiles], scans: &[Scan]) -> Result<(), Failure> {
    let filled = sets.iter().zip(scans).filter(|(_, scan)| !scan.is_empty());
    let mut dimensions = filled.map(|(files, scan)| (files, scan.descriptors().dimension()));
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
