//! Scans from files: what of them can be read.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use gmpcr::Cloud;
use gmpcr_io::{DescriptorFiles, PointFile, read_scans, scan_files};
use rayon::prelude::*;

use crate::outcome::Failure;
use crate::progress::Progress;
use crate::table::counted;

/// A scan as it was read, but for its points.
#[derive(Clone)]
pub struct ScanFile {
    /// Name of its file, and its own within one that holds several.
    pub name: String,
    pub file: PathBuf,
    /// Points without a position.
    pub invalid: usize,
    pub has_normals: bool,
    /// Why it cannot be used.
    pub problem: Option<String>,
}

/// The scan, and its points.
pub type NamedCloud = (ScanFile, Cloud);

impl ScanFile {
    fn with_points(name: &str, file: &Path, content: PointFile) -> NamedCloud {
        let scan = Self {
            name: name.replace(char::is_control, "\u{fffd}"),
            file: file.to_owned(),
            invalid: content.invalid,
            has_normals: content.has_normals,
            problem: None,
        };
        (scan, content.into())
    }

    fn unreadable(name: &str, file: &Path, problem: String) -> NamedCloud {
        let (scan, cloud) = Self::with_points(name, file, PointFile::default());
        let problem = Some(problem);
        (Self { problem, ..scan }, cloud)
    }

    /// Keypoints that stand in for the points of a scan.
    pub fn of_keypoints(files: &DescriptorFiles, keypoints: &gmpcr::Scan) -> NamedCloud {
        let mut content = PointFile::default();
        content.points = keypoints.points().to_vec();
        Self::with_points(&files.name, &files.keypoints, content)
    }
}

/// The files of folders and files, in order. What `gmpcr register` has written into a folder of scans is no
/// scan.
pub fn files_of(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for input in inputs {
        if input.is_dir() {
            let mut scans = scan_files(input)?;
            if input.join("result.json").exists() {
                scans.retain(|file| !file.ends_with("merged.ply"));
            }
            files.extend(scans);
        } else if input.exists() {
            files.push(input.clone());
        } else {
            let reason = "there is no such folder or file of scans";
            return Err(Failure::of(input, reason));
        }
    }
    Ok(files)
}

/// Reads all scans. One that cannot be read is a cloud without points and with the reason.
pub fn read_clouds(files: &[PathBuf], progress: &Progress) -> Result<Vec<NamedCloud>, Failure> {
    let read = |file: &PathBuf| progress.item(|| read_file(file));
    let clouds: Result<Vec<_>, Failure> = files.par_iter().map(read).collect();
    let mut clouds: Vec<NamedCloud> = clouds?.into_iter().flatten().collect();
    make_names_differ(&mut clouds);
    for (scan, _) in &clouds {
        if let Some(problem) = &scan.problem {
            progress.say(&left_out(problem));
        }
        if scan.invalid > 0 {
            let invalid = counted(scan.invalid, "point");
            progress.say(&format!(
                "{}: {invalid} without a position left out",
                scan.name
            ));
        }
    }
    Ok(clouds)
}

/// What the user is told of a scan that cannot be used.
pub fn left_out(problem: &str) -> String {
    format!("left out: {problem}; mend or remove the file")
}

/// The scans of a file: one, but for E57.
fn read_file(file: &Path) -> Vec<NamedCloud> {
    let name = file.file_name().unwrap_or(file.as_os_str());
    let name = name.to_string_lossy();
    let scans = match read_scans(file) {
        Ok(scans) => scans,
        Err(error) => return vec![ScanFile::unreadable(&name, file, error.to_string())],
    };
    let is_one = scans.len() == 1;
    let named = scans.into_iter().enumerate().map(|(k, scan)| {
        let part = scan.name.unwrap_or_else(|| k.to_string());
        match is_one {
            true => ScanFile::with_points(&name, file, scan.points),
            false => ScanFile::with_points(&format!("{name}:{part}"), file, scan.points),
        }
    });
    named.collect()
}

/// Where names are not unique, as those of files of several folders, the number of the scan is added.
fn make_names_differ(clouds: &mut [NamedCloud]) {
    let names: HashSet<_> = clouds.iter().map(|(scan, _)| &scan.name).collect();
    if names.len() < clouds.len() {
        for (k, (scan, _)) in clouds.iter_mut().enumerate() {
            scan.name = format!("{}#{k}", scan.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_on_their_line() {
        let (scan, _) = ScanFile::with_points("a\nb", Path::new("a\nb"), PointFile::default());
        assert_eq!(scan.name, "a\u{fffd}b");
    }
}
