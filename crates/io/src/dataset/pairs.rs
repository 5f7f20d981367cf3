//! The lists of pairs that a benchmark judges.

use std::path::{Path, PathBuf};

use nalgebra::Matrix6;

use super::numbered::Numbered;
use super::problems::Problems;
use crate::{Error, InfoEntry, LogEntry, read_gt_info, read_gt_log};

/// Names of the lists, and of their files without extension, the preferred first.
const LISTS: [(&str, &[&str]); 3] = [
    ("3dmatch", &["official_3dmatch", "gt_3dmatch"]),
    ("3dlomatch", &["official_3dlomatch", "gt_3dlomatch", "gtLo"]),
    ("gt", &["gt"]),
];

/// Pairs of scans whose relative poses are known from elsewhere.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairList {
    /// `3dmatch`, `3dlomatch` or `gt` in a scene, otherwise the name of the file.
    pub name: String,
    /// The `.log` file of the list.
    pub file: PathBuf,
    /// The pairs in the order of the file.
    pub pairs: Vec<LogEntry>,
    /// The information matrices of the pairs, in the same order, as [`InfoEntry::information`] has
    /// them; `None` if there is no `.info` file.
    pub information: Option<Vec<Matrix6<f64>>>,
}

impl PairList {
    /// Reads a list from its `.log` file, with the `.info` file of the same name where there is one. The
    /// name of the list is that of the file.
    ///
    /// # Errors
    /// Those of [`read_gt_log`] and [`read_gt_info`], and [`Error::Malformed`] if the two files list
    /// different pairs.
    ///
    /// # Example
    /// ```
    /// use gmpcr_io::{LogEntry, PairList, write_gt_log};
    /// use nalgebra::Isometry3;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("kitchen.log");
    /// let pair = LogEntry { i: 0, j: 2, num_scans: 3, i_from_j: Isometry3::identity() };
    /// write_gt_log(&path, &[pair])?;
    /// let list = PairList::read(&path)?;
    /// assert_eq!((&*list.name, list.pairs.len(), &list.information), ("kitchen", 1, &None));
    ///
    /// std::fs::write(folder.path().join("kitchen.info"), "")?;
    /// let error = PairList::read(&path).unwrap_err().to_string();
    /// assert!(error.contains("kitchen.info: it and kitchen.log list different pairs: 1 and 0"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn read(log: impl AsRef<Path>) -> Result<Self, Error> {
        let log = log.as_ref();
        let pairs = read_gt_log(log)?;
        let info = log.with_extension("info");
        let information = info.is_file().then(|| read_gt_info(&info)).transpose()?;
        let difference = information
            .as_ref()
            .and_then(|info| difference(&pairs, info));
        if let Some(difference) = difference {
            let log = Path::new(log.file_name().unwrap_or_default()).display();
            let reason = format!("it and {log} list different pairs: {difference}");
            return Err(Error::malformed(&info, reason));
        }
        Ok(Self {
            name: list_name(log),
            file: log.to_owned(),
            pairs,
            information: information.map(matrices),
        })
    }
}

/// The two files of a list, of which at least one is there.
pub(super) struct ListFiles {
    name: &'static str,
    log: PathBuf,
    info: PathBuf,
}

impl ListFiles {
    /// One pair of files for each list that is there.
    pub(super) fn find(places: &[PathBuf]) -> Vec<Self> {
        LISTS
            .iter()
            .filter_map(|(name, stems)| Self::find_list(name, stems, places))
            .collect()
    }

    fn find_list(name: &'static str, stems: &[&str], places: &[PathBuf]) -> Option<Self> {
        let candidates = stems.iter().flat_map(|stem| {
            places.iter().map(move |place| Self {
                name,
                log: place.join(format!("{stem}.log")),
                info: place.join(format!("{stem}.info")),
            })
        });
        let mut present = candidates.filter(|files| files.log.is_file() || files.has_information());
        present.next()
    }

    pub(super) fn has_information(&self) -> bool {
        self.info.is_file()
    }

    /// The list, or none if its poses are missing, which is then among the problems.
    pub(super) fn read(
        self,
        scans: &Numbered,
        needs_information: bool,
        problems: &mut Problems,
    ) -> Result<Option<PairList>, Error> {
        if !self.log.is_file() {
            problems.add(beside(&self.info, &self.log, problems));
            return Ok(None);
        }
        if needs_information && !self.has_information() {
            problems.add(beside(&self.log, &self.info, problems));
        }
        let pairs = read_gt_log(&self.log)?;
        check_pairs(&self.log, &pairs, scans, problems);
        let information = self.has_information().then(|| read_gt_info(&self.info));
        let information = information.transpose()?.map(|information| {
            self.check_same_pairs(&pairs, &information, problems);
            matrices(information)
        });
        Ok(Some(PairList {
            name: self.name.to_owned(),
            file: self.log,
            pairs,
            information,
        }))
    }

    fn check_same_pairs(
        &self,
        pairs: &[LogEntry],
        information: &[InfoEntry],
        problems: &mut Problems,
    ) {
        let Some(difference) = difference(pairs, information) else {
            return;
        };
        let [log, info] = [&self.log, &self.info].map(|file| problems.shown(file));
        problems.add(format!(
            "{log} and {info} list different pairs: {difference}"
        ));
    }
}

/// How the pairs of a `.log` and of an `.info` file differ, if they do.
fn difference(pairs: &[LogEntry], information: &[InfoEntry]) -> Option<String> {
    if pairs.len() != information.len() {
        return Some(format!("{} and {} of them", pairs.len(), information.len()));
    }
    let log = pairs.iter().map(|pair| (pair.i, pair.j));
    let mut ends = log.zip(information.iter().map(|entry| (entry.i, entry.j)));
    let (log, info) = ends.find(|(log, info)| log != info)?;
    Some(format!("{log:?} where the other has {info:?}"))
}

fn matrices(information: Vec<InfoEntry>) -> Vec<Matrix6<f64>> {
    let entries = information.into_iter();
    entries.map(|entry| entry.information).collect()
}

fn beside(present: &Path, missing: &Path, problems: &Problems) -> String {
    let [present, missing] = [present, missing].map(|file| problems.shown(file));
    format!("missing beside {present}: {missing}")
}

fn check_pairs(log: &Path, pairs: &[LogEntry], scans: &Numbered, problems: &mut Problems) {
    let file = problems.shown(log);
    let num_scans = scans.len();
    if let Some(pair) = pairs.iter().find(|pair| pair.num_scans != num_scans) {
        let counted = pair.num_scans;
        problems.add(format!(
            "{file} counts {counted} scans, {num_scans} are there"
        ));
    }
    scans.check_named(
        log,
        pairs.iter().flat_map(|pair| [pair.i, pair.j]),
        problems,
    );
    let itself = pairs.iter().filter(|pair| pair.i == pair.j);
    problems.add_list(
        &format!("{file} pairs scans with themselves"),
        itself.map(|pair| pair.i.to_string()),
    );
}
/// The name of the file. A `gt.log` is named by its folder, too: `3DLoMatch/gt.log` is not the list of 3DMatch.
fn list_name(log: &Path) -> String {
    let stem = log.file_stem().unwrap_or_default().to_string_lossy();
    let folder = log.parent().and_then(Path::file_name).unwrap_or_default();
    let folder = folder.to_string_lossy();
    match stem == "gt" && folder.to_ascii_lowercase().contains("match") {
        true => format!("{folder}/gt"),
        false => stem.into_owned(),
    }
}
