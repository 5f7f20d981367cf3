//! How a command ends.

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

/// What a command has found out.
pub struct Answer {
    /// For people.
    pub text: String,
    /// For scripts; `None` where the text serves both.
    pub json: Option<serde_json::Value>,
    /// Whether all scans share one frame.
    pub is_complete: bool,
}

impl Answer {
    /// An answer that is neither complete nor partial, but text.
    pub fn of_text(text: String) -> Self {
        Self {
            text,
            json: None,
            is_complete: true,
        }
    }

    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(if self.is_complete { 0 } else { 2 })
    }
}

/// Why a command has no answer.
#[derive(Debug)]
pub enum Failure {
    /// Input, parameters or the machine are to blame.
    Error(Box<dyn Error + Send + Sync>),
    /// The user has stopped the program.
    Interrupted,
}

impl Failure {
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Error(_) => 1,
            Self::Interrupted => 130,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Error(error) => write!(formatter, "error: {error}"),
            Self::Interrupted => write!(formatter, "interrupted: no file is half-written"),
        }
    }
}

impl Failure {
    /// An error with the file that it concerns.
    pub fn of(file: &Path, reason: impl fmt::Display) -> Self {
        format!("{}: {reason}", file.display()).into()
    }

    /// Why scans could not be registered.
    pub fn of_registration(error: gmpcr::Error) -> Self {
        match error {
            gmpcr::Error::Cancelled { .. } => Self::Interrupted,
            other => Self::Error(other.into()),
        }
    }
}

impl<E: Into<Box<dyn Error + Send + Sync>>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Error(error.into())
    }
}
