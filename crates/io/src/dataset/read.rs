//! A scene from its folder.

use std::path::Path;

use super::clouds;
use super::descriptors::DescriptorSets;
use super::ground_truth::GroundTruth;
use super::layout::Layout;
use super::numbered::Numbered;
use super::problems::Problems;
use super::scene::{Scene, SceneScan, folder_name};
use crate::Error;

/// Lists the files of a scene and reads its ground truth. Clouds and descriptors are not opened.
///
/// The names of the clouds number the scans 0, 1, 2, ... In a scene of [`Layout::Yoho`] without clouds, the
/// names of the keypoints do. [`Layout`] tells which files are looked for,
/// and where.
///
/// # Errors
/// * [`Error::NothingFound`] if there are no clouds, or for [`Layout::Yoho`] no descriptors.
/// * [`Error::Io`] and [`Error::Malformed`] if a file of the ground truth cannot be read.
/// * [`Error::Incomplete`], one error that names all problems of these kinds:
///   * gaps in the numbers of the scans, or two files of one number;
///   * a list of pairs without the `.info` file that the layout requires, or an `.info` file without its
///     list;
///   * a `.log` and an `.info` file of different pairs;
///   * a list with another number of scans, with an absent scan, or with a pair of a scan and itself;
///   * overlaps or poses of absent scans;
///   * scans with no pose file or row of `poses.txt`, or with two;
///   * scans without keypoints or descriptors, or keypoints or descriptors without a scan.
///
/// # Example
/// ```
/// use gmpcr_io::{Layout, read_scene};
///
/// let folder = tempfile::tempdir()?;
/// let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text);
/// write("cloud_bin_0.ply", "")?;
/// write("cloud_bin_2.ply", "")?;
/// write("gt.log", "0 2 3\n1 0 0 0.5\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")?;
/// let error = read_scene(folder.path(), Layout::ThreeDMatch).unwrap_err().to_string();
/// assert!(error.contains("missing clouds: cloud_bin_1.ply"));
/// assert!(error.contains("missing beside gt.log: gt.info"));
///
/// write("cloud_bin_1.ply", "")?;
/// let scene = read_scene(folder.path(), Layout::Eth)?;
/// assert_eq!(scene.scans.len(), 3);
/// let pair = &scene.ground_truth.pair_list("gt").unwrap().pairs[0];
/// assert_eq!((pair.i, pair.j, pair.i_from_j.translation.x), (0, 2, 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_scene(folder: impl AsRef<Path>, layout: Layout) -> Result<Scene, Error> {
    let folder = folder.as_ref();
    let clouds = clouds::find(folder)?;
    let sets = match layout {
        Layout::Yoho => DescriptorSets::find(folder)?,
        _ => None,
    };
    let scans = numbered_scans(layout, clouds.as_ref(), sets.as_ref());
    let scans = scans.ok_or_else(|| Error::NothingFound {
        folder: folder.to_owned(),
        wanted: layout.wanted(),
    })?;

    let mut problems = Problems::of(folder);
    scans.check_sequence(&mut problems);
    if let Some(sets) = &sets {
        sets.check(&scans.numbers(), &mut problems);
    }
    let ground_truth = GroundTruth::read(folder, layout, scans, &mut problems)?;
    problems.into_result()?;

    let files = |scan| SceneScan {
        cloud: clouds.as_ref().map(|clouds| clouds.path(scan)),
        descriptors: sets.as_ref().map(|sets| sets.of_scan(scan)),
    };
    Ok(Scene {
        name: folder_name(folder),
        folder: folder.to_owned(),
        scans: scans.numbers().into_iter().map(files).collect(),
        ground_truth,
    })
}

/// The files whose numbers are those of the scans.
fn numbered_scans<'a>(
    layout: Layout,
    clouds: Option<&'a Numbered>,
    sets: Option<&'a DescriptorSets>,
) -> Option<&'a Numbered> {
    match layout {
        Layout::Yoho => sets.map(|sets| clouds.unwrap_or(&sets.keypoints)),
        _ => clouds,
    }
}
