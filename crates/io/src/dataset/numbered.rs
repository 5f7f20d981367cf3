//! Files whose names end in the number of their scan.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::problems::{FEW, Problems};
use crate::Error;
use crate::folder::file_names;

/// How the files of one kind are named: `<start><number><ending>`.
#[derive(Clone, Copy)]
pub(super) struct Naming<'a> {
    /// What the files hold, in the plural.
    pub(super) what: &'static str,
    /// What stands before the number, where this is prescribed.
    pub(super) start: Option<&'a str>,
    /// The endings, of which the first that fits counts; case does not matter.
    pub(super) endings: &'a [&'a str],
}

impl Naming<'_> {
    /// Start, digits and ending of a name of this kind; the digits may be none.
    fn parts<'n>(&self, name: &'n str) -> Option<(&'n str, &'n str, &'n str)> {
        let (stem, ending) = self.endings.iter().find_map(|ending| {
            let (stem, end) = name.split_at_checked(name.len().checked_sub(ending.len())?)?;
            end.eq_ignore_ascii_case(ending).then_some((stem, end))
        })?;
        let (start, digits) = split_number(stem);
        match self.start {
            Some(prescribed) if start != prescribed || digits.is_empty() => None,
            _ => Some((start, digits, ending)),
        }
    }
}

/// The part of a name before the digits at its end, and these digits.
fn split_number(stem: &str) -> (&str, &str) {
    stem.split_at(stem.trim_end_matches(|c: char| c.is_ascii_digit()).len())
}

/// The digits at the end of a name as a number. One that is too large becomes the largest: no scan
/// has it, and the gap below it is noticed.
pub(super) fn trailing_number(stem: &str) -> Option<usize> {
    let (_, digits) = split_number(stem);
    (!digits.is_empty()).then(|| digits.parse().unwrap_or(usize::MAX))
}

/// The files of one kind in a folder, by number.
pub(super) struct Numbered {
    what: &'static str,
    folder: PathBuf,
    names: BTreeMap<usize, Vec<String>>,
    without_number: Vec<String>,
    template: Template,
}

/// How the file of another number would be called.
#[derive(Default)]
struct Template {
    start: String,
    width: usize,
    ending: String,
}

impl Numbered {
    /// An absent folder is an [`Error::Io`]. A folder without such files is an empty list.
    pub(super) fn list(folder: &Path, naming: Naming) -> Result<Self, Error> {
        let mut files = Self {
            what: naming.what,
            folder: folder.to_owned(),
            names: BTreeMap::new(),
            without_number: Vec::new(),
            template: Template::default(),
        };
        for name in file_names(folder)? {
            if let Some(parts) = naming.parts(&name) {
                files.insert(&name, parts);
            }
        }
        Ok(files)
    }

    fn insert(&mut self, name: &str, (start, digits, ending): (&str, &str, &str)) {
        let Some(number) = trailing_number(digits) else {
            self.without_number.push(name.to_owned());
            return;
        };
        if self.names.is_empty() {
            let is_padded = digits.starts_with('0');
            self.template = Template {
                start: start.to_owned(),
                width: if is_padded { digits.len() } else { 0 },
                ending: ending.to_owned(),
            };
        }
        self.names.entry(number).or_default().push(name.to_owned());
    }

    /// As [`list`](Self::list); none if no file has a number.
    pub(super) fn find(folder: &Path, naming: Naming) -> Result<Option<Self>, Error> {
        let files = Self::list(folder, naming)?;
        Ok((!files.is_empty()).then_some(files))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// What stands before the number.
    pub(super) fn start(&self) -> &str {
        &self.template.start
    }

    pub(super) fn numbers(&self) -> BTreeSet<usize> {
        self.names.keys().copied().collect()
    }

    /// Path of the file of a number, whether it is there or not.
    pub(super) fn path(&self, number: usize) -> PathBuf {
        let present = self.names.get(&number).and_then(|names| names.first());
        match present {
            Some(name) => self.folder.join(name),
            None => {
                let Template {
                    start,
                    width,
                    ending,
                } = &self.template;
                self.folder.join(format!("{start}{number:0width$}{ending}"))
            }
        }
    }

    /// Checks files whose numbers define the scans of the scene: they must be 0, 1, 2, ...
    pub(super) fn check_sequence(&self, problems: &mut Problems) {
        let what = self.what;
        problems.add_list(
            &format!("{what} without a number"),
            self.without_number.iter().cloned(),
        );
        self.check_single(problems);
        let last = self.last();
        // The highest number may be any: only a few of the missing ones are looked up.
        let absent = (0..last).filter(|number| !self.names.contains_key(number));
        let total = last.saturating_add(1).saturating_sub(self.len());
        let missing: Vec<String> = absent
            .take(FEW.min(total))
            .map(|number| problems.shown(&self.path(number)))
            .collect();
        problems.add_start_of_list(&format!("missing {what}"), missing, total);
    }

    fn last(&self) -> usize {
        self.names.keys().next_back().copied().unwrap_or(0)
    }

    /// Checks that each of the given scans has one file, and that no other scan has any.
    pub(super) fn check_scans(&self, scans: &BTreeSet<usize>, problems: &mut Problems) {
        let what = self.what;
        self.check_single(problems);
        let present = self.numbers();
        let missing = scans.difference(&present).map(|&scan| self.path(scan));
        problems.add_files(&format!("missing {what}"), missing);
        let surplus = present.difference(scans).map(|&scan| self.path(scan));
        problems.add_files(&format!("{what} of no scan"), surplus);
    }

    fn check_single(&self, problems: &mut Problems) {
        let doubles = self.names.values().filter(|names| names.len() > 1);
        problems.add_list(
            &format!("{} of the same number", self.what),
            doubles.map(|names| names.join(" = ")),
        );
    }

    /// Checks that the scans exist that a file of the ground truth names. Gaps in the sequence are reported
    /// elsewhere.
    pub(super) fn check_named(
        &self,
        file: &Path,
        scans: impl IntoIterator<Item = usize>,
        problems: &mut Problems,
    ) {
        let last = self.last();
        let beyond: BTreeSet<usize> = scans.into_iter().filter(|&scan| scan > last).collect();
        let what = format!("{} names scans that are missing", problems.shown(file));
        problems.add_files(&what, beyond.into_iter().map(|scan| self.path(scan)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const CLOUDS: Naming = Naming {
        what: "clouds",
        start: None,
        endings: &[".ply", ".pcd"],
    };

    fn complaint(names: &[&str]) -> String {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let mut problems = Problems::of(folder.path());
        let files = Numbered::list(folder.path(), CLOUDS).unwrap();
        files.check_sequence(&mut problems);
        let result = problems.into_result();
        result.map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn numbers_are_read_with_and_without_leading_zeros() {
        assert_eq!(complaint(&["a_0.ply", "a_1.PCD", "readme.txt"]), "");
        assert_eq!(complaint(&["scan000.ply", "scan001.ply"]), "");
        let said = complaint(&["scan000.ply", "scan002.ply"]);
        assert!(said.ends_with("missing clouds: scan001.ply"), "{said}");
        let said = complaint(&["scan_10.ply", "scan_11.ply"]);
        assert!(
            said.ends_with("scan_0.ply, scan_1.ply, scan_2.ply, scan_3.ply, scan_4.ply and 5 more")
        );
    }

    #[test]
    fn doubles_and_names_without_a_number_are_told() {
        let said = complaint(&["a_0.pcd", "a_0.ply", "a.ply", "b.pcd"]);
        assert!(
            said.contains("clouds without a number: a.ply, b.pcd"),
            "{said}"
        );
        assert!(
            said.contains("clouds of the same number: a_0.pcd = a_0.ply"),
            "{said}"
        );
    }

    #[test]
    fn numbers_beyond_all_bounds_are_gaps() {
        for huge in ["18446744073709551615", "999999999999999999999999999999"] {
            let said = complaint(&["a_0.ply", &format!("a_{huge}.ply")]);
            assert!(said.contains("missing clouds: a_1.ply, "), "{said}");
            assert!(said.ends_with(" more"), "{said}");
        }
    }

    #[test]
    fn the_prescribed_start_and_the_first_ending_count() {
        let naming = Naming {
            what: "keypoints",
            start: Some("cloud_bin_"),
            endings: &["Keypoints.npy", ".npy"],
        };
        let name = "cloud_bin_12Keypoints.npy";
        assert_eq!(
            naming.parts(name),
            Some(("cloud_bin_", "12", "Keypoints.npy"))
        );
        for other in [
            "cloud_bin_.npy",
            "cloud_bin_0_1.npy",
            "cloud_1.npy",
            "é.npy",
            "y",
            "",
        ] {
            assert_eq!(naming.parts(other), None, "{other}");
        }
    }
}
