//! The scenes of a data set.

use std::path::{Path, PathBuf};

use super::layout::Layout;
use crate::Error;
use crate::folder::folder_names;

/// The scenes of a data set: the folder itself if [`Layout::of`] knows it, else those of its
/// subfolders that are scenes, in natural order.
///
/// # Errors
/// [`Error::Io`] if the folder or one in it cannot be listed, [`Error::NothingFound`] if there is no
/// scene.
///
/// # Example
/// ```
/// use gmpcr_io::scene_folders;
///
/// let root = tempfile::tempdir()?;
/// for scene in ["scene10", "scene9", "notes"] {
///     std::fs::create_dir(root.path().join(scene))?;
/// }
/// for file in ["cloud_bin_0.ply", "gt.log"] {
///     std::fs::write(root.path().join("scene9").join(file), "")?;
///     std::fs::write(root.path().join("scene10").join(file), "")?;
/// }
/// let scenes = scene_folders(root.path())?;
/// assert_eq!(scenes, ["scene9", "scene10"].map(|scene| root.path().join(scene)));
/// assert_eq!(scene_folders(&scenes[0])?, scenes[..1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scene_folders(root: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let root = root.as_ref();
    if Layout::of(root)?.is_some() {
        return Ok(vec![root.to_owned()]);
    }
    let mut scenes = Vec::new();
    for name in folder_names(root)? {
        let folder = root.join(name);
        if Layout::of(&folder)?.is_some() {
            scenes.push(folder);
        }
    }
    if scenes.is_empty() {
        return Err(Error::NothingFound {
            folder: root.to_owned(),
            wanted: "scene, nor does any folder in it",
        });
    }
    Ok(scenes)
}
