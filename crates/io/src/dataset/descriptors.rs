//! The sets of keypoints and descriptors of a scene.

use std::collections::BTreeSet;
use std::path::Path;

use super::numbered::{Naming, Numbered};
use super::problems::Problems;
use crate::descriptors::{DESCRIPTORS, KEYPOINTS};
use crate::folder::folder_names;
use crate::{DescriptorFiles, Error};

/// What a folder without descriptors lacks.
pub(super) const WANTED: &str = "keypoints with descriptors: neither <i>.kpts.npy, <i>.desc.npy, nor \
     folders such as Keypoints_PC, yoho_desc of .npy files";

/// Names of the two folders in lower case, the preferred first.
const KEYPOINT_FOLDERS: &[&str] = &["keypoints_pc", "keypoints", "kpts"];
const DESCRIPTOR_FOLDERS: &[&str] = &["yoho_desc", "descriptors", "features", "yoho"];

const KEYPOINT_FILES: Naming = Naming {
    what: "keypoints",
    start: None,
    endings: &[KEYPOINTS],
};
const DESCRIPTOR_FILES: Naming = Naming {
    what: "descriptors",
    start: None,
    endings: &[DESCRIPTORS],
};

/// Keypoints and descriptors by the number of their scan.
pub(super) struct DescriptorSets {
    pub(super) keypoints: Numbered,
    descriptors: Numbered,
}

impl DescriptorSets {
    /// The sets of a folder, side by side or in two subfolders.
    pub(super) fn find(folder: &Path) -> Result<Option<Self>, Error> {
        let keypoints = Numbered::list(folder, KEYPOINT_FILES)?;
        let descriptors = Numbered::list(folder, DESCRIPTOR_FILES)?;
        if keypoints.is_empty() && descriptors.is_empty() {
            return Self::find_in_subfolders(folder);
        }
        Ok(Some(Self {
            keypoints,
            descriptors,
        }))
    }

    fn find_in_subfolders(folder: &Path) -> Result<Option<Self>, Error> {
        let keypoints = Naming {
            endings: &["Keypoints.npy", KEYPOINTS, ".npy"],
            ..KEYPOINT_FILES
        };
        let descriptors = Naming {
            endings: &[DESCRIPTORS, ".npy"],
            ..DESCRIPTOR_FILES
        };
        let keypoints = first_subfolder(folder, KEYPOINT_FOLDERS, keypoints)?;
        let descriptors = first_subfolder(folder, DESCRIPTOR_FOLDERS, descriptors)?;
        Ok(keypoints
            .zip(descriptors)
            .map(|(keypoints, descriptors)| Self {
                keypoints,
                descriptors,
            }))
    }

    pub(super) fn check(&self, scans: &BTreeSet<usize>, problems: &mut Problems) {
        self.keypoints.check_scans(scans, problems);
        self.descriptors.check_scans(scans, problems);
    }

    pub(super) fn of_scan(&self, scan: usize) -> DescriptorFiles {
        DescriptorFiles {
            name: scan.to_string(),
            keypoints: self.keypoints.path(scan),
            descriptors: self.descriptors.path(scan),
        }
    }
}

/// The files of the first subfolder of one of the names that has any.
fn first_subfolder(
    folder: &Path,
    names: &[&str],
    naming: Naming,
) -> Result<Option<Numbered>, Error> {
    let present = folder_names(folder)?;
    for name in names {
        for subfolder in present.iter().filter(|p| p.eq_ignore_ascii_case(name)) {
            let files = Numbered::find(&folder.join(subfolder), naming)?;
            if files.is_some() {
                return Ok(files);
            }
        }
    }
    Ok(None)
}
