use std::error::Error as StdError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a file could not be read or written: which file, where in it, and the reason.
///
/// The message of each variant is complete in itself. [`source`](std::error::Error::source) is the error
/// of the operating system or of the format's parser where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to open, read, list, write or rename.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was attempted, as a verb: "open", "read", "write", ...
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },

    /// The content is not what the format prescribes: foreign, truncated, or out of range.
    #[error("{}: {reason}", place(path, *line))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line of the file, counted from 1, where the format has lines.
        line: Option<usize>,
        /// What the problem is, and what would be allowed.
        reason: String,
        /// The error of the parser underneath, if it was the one to notice.
        source: Option<Box<dyn StdError + Send + Sync>>,
    },

    /// The format cannot hold what should be written. The file is as it was before.
    #[error("cannot write {}: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the problem is.
        reason: String,
    },

    /// The extension is not that of a known kind of point file.
    #[error(
        "{}: unknown kind of point file, known extensions are .{}",
        path.display(),
        known.join(", .")
    )]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// The extensions that this build reads, in lower case and without the dot.
        known: Vec<&'static str>,
    },

    /// The format is known, but this build does not read it.
    #[error(
        "{} is a {format} file, but this build reads no {format}: rebuild with the feature `{feature}`",
        path.display()
    )]
    FeatureOff {
        /// The file.
        path: PathBuf,
        /// The name of the format.
        format: &'static str,
        /// The feature of this crate that reads it.
        feature: &'static str,
    },

    /// A folder holds no file of the wanted kind.
    #[error("{} holds no {wanted}", folder.display())]
    NothingFound {
        /// The folder.
        folder: PathBuf,
        /// What was looked for.
        wanted: &'static str,
    },

    /// Of two files that belong together, one is missing.
    #[error("{} stands alone: {} is missing", present.display(), missing.display())]
    Unpaired {
        /// The file that exists.
        present: PathBuf,
        /// The file that should stand beside it.
        missing: PathBuf,
    },

    /// Files of a scene are missing or contradict each other.
    #[error("{} is incomplete: {}", folder.display(), problems.join("; "))]
    Incomplete {
        /// The folder of the scene, or of its descriptors.
        folder: PathBuf,
        /// The problems, a clause for each kind. Each names its files, relative to the
        /// folder where they are inside, and cuts long lists after a few: "and 7 more".
        problems: Vec<String>,
    },
}

impl Error {
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io {
            action,
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn malformed(path: &Path, reason: impl AsRef<str>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            line: None,
            reason: in_one_line(reason.as_ref()),
            source: None,
        }
    }

    pub(crate) fn malformed_line(path: &Path, line: usize, reason: impl AsRef<str>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            line: Some(line),
            reason: in_one_line(reason.as_ref()),
            source: None,
        }
    }

    /// Wraps what a parser reports; its words, shortened, become part of the reason.
    pub(crate) fn parser(
        path: &Path,
        line: Option<usize>,
        context: &str,
        source: impl StdError + Send + Sync + 'static,
    ) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            line,
            reason: in_one_line(&format!("{context}: {source}")),
            source: Some(Box::new(source)),
        }
    }
}

fn place(path: &Path, line: Option<usize>) -> String {
    match line {
        Some(line) => format!("{}:{line}", path.display()),
        None => path.display().to_string(),
    }
}

/// Messages quote the offending words, which may be megabytes in a file of another format.
fn in_one_line(message: &str) -> String {
    const LONGEST: usize = 200;
    let words: Vec<&str> = message.split_whitespace().take(LONGEST).collect();
    words.join(" ").chars().take(LONGEST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_file_the_line_and_the_reason() {
        let error = Error::malformed_line(Path::new("a.g2o"), 7, "x is not a number");
        assert_eq!(error.to_string(), "a.g2o:7: x is not a number");
        let error = Error::malformed(Path::new("a.ply"), "the file is empty");
        assert_eq!(error.to_string(), "a.ply: the file is empty");
    }

    #[test]
    fn the_cause_stays_reachable_and_long_messages_are_cut() {
        let noise = io::Error::other("x\n\t".repeat(100_000));
        let error = Error::parser(Path::new("a.ply"), None, "header", noise);
        assert!(error.to_string().len() < 300);
        assert!(error.source().is_some());
    }
}
