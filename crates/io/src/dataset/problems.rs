//! The problems of a scene, gathered into one error.

use std::path::{Path, PathBuf};

use crate::Error;

/// How many names of a long list are spelled out.
pub(super) const FEW: usize = 5;

/// The problems of a folder, a clause for each kind.
pub(super) struct Problems {
    folder: PathBuf,
    clauses: Vec<String>,
}

impl Problems {
    pub(super) fn of(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            clauses: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, clause: String) {
        self.clauses.push(clause);
    }

    /// Adds `what: a, b, c`; nothing for an empty list.
    pub(super) fn add_list(&mut self, what: &str, items: impl IntoIterator<Item = String>) {
        let items: Vec<String> = items.into_iter().collect();
        let total = items.len();
        self.add_start_of_list(what, items, total);
    }

    /// As [`add_list`](Self::add_list) for a list of `total` items. `items` need only hold those that are
    /// spelled out.
    pub(super) fn add_start_of_list(
        &mut self,
        what: &str,
        items: impl IntoIterator<Item = String>,
        total: usize,
    ) {
        if total == 0 {
            return;
        }
        let shown: Vec<String> = items.into_iter().take(FEW).collect();
        let names = shown.join(", ");
        self.add(match total - shown.len().min(total) {
            0 => format!("{what}: {names}"),
            rest => format!("{what}: {names} and {rest} more"),
        });
    }

    pub(super) fn add_files(&mut self, what: &str, files: impl IntoIterator<Item = PathBuf>) {
        let names: Vec<String> = files.into_iter().map(|file| self.shown(&file)).collect();
        self.add_list(what, names);
    }

    /// The path as seen from the folder.
    pub(super) fn shown(&self, path: &Path) -> String {
        let inside = path.strip_prefix(&self.folder).unwrap_or(path);
        inside.display().to_string()
    }

    pub(super) fn into_result(self) -> Result<(), Error> {
        if self.clauses.is_empty() {
            return Ok(());
        }
        Err(Error::Incomplete {
            folder: self.folder,
            problems: self.clauses,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_cut_with_a_count() {
        let mut problems = Problems::of(Path::new("kitchen"));
        problems.add_list("missing", (0..6).map(|k| k.to_string()));
        problems.add_list("more", (0..5).map(|k| k.to_string()));
        problems.add_list("none", []);
        let said = problems.into_result().unwrap_err().to_string();
        let expected =
            "kitchen is incomplete: missing: 0, 1, 2, 3, 4 and 1 more; more: 0, 1, 2, 3, 4";
        assert_eq!(said, expected);
    }

    #[test]
    fn no_problem_is_no_error() {
        assert!(Problems::of(Path::new("")).into_result().is_ok());
    }
}
