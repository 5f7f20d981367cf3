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

/// Pairs of scans with their true relative poses.
#[derive(Clone, Debug, PartialEq)]
pub struct PairList {
    /// `3dmatch`, `3dlomatch` or `gt`.
    pub name: String,
    /// The `.log` file of the list.
    pub file: PathBuf,
    /// The pairs in the order of the file.
    pub pairs: Vec<LogEntry>,
    /// The information matrices of the pairs, in the same order, as [`InfoEntry::information`] has
    /// them; `None` if there is no `.info` file.
    pub information: Option<Vec<Matrix6<f64>>>,
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
            information.iter().map(|entry| entry.information).collect()
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
        let difference = match (pairs.len(), information.len()) {
            (log, info) if log != info => format!("{log} and {info} of them"),
            _ => {
                let mut entries = pairs.iter().zip(information);
                match entries.find(|(log, info)| (log.i, log.j) != (info.i, info.j)) {
                    None => return,
                    Some((log, info)) => {
                        let [log, info] = [(log.i, log.j), (info.i, info.j)];
                        format!("{log:?} where the other has {info:?}")
                    }
                }
            }
        };
        let [log, info] = [&self.log, &self.info].map(|file| problems.shown(file));
        problems.add(format!(
            "{log} and {info} list different pairs: {difference}"
        ));
    }
}

fn beside(present: &Path, missing: &Path, problems: &Problems) -> String {
    let [present, missing] = [present, missing].map(|file| problems.shown(file));
    format!("missing beside {present}: {missing}")
}

fn check_pairs(log: &Path, pairs: &[LogEntry], scans: &Numbered, problems: &mut Problems) {
    let file = problems.shown(log);
    let num_scans = scans.len();
    if let Some(pair) = pairs.iter().find(|pair| pair.num_fragments != num_scans) {
        let counted = pair.num_fragments;
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
