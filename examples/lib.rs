//! What the example programs share. The README's code is a doctest of this package.

use std::error::Error;
use std::process::ExitCode;

/// The exit code of a program, after its error, if any, is printed in words.
pub fn report(outcome: Result<(), Box<dyn Error>>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Parses an argument that must be a finite number above zero.
///
/// # Errors
/// What is needed, in words.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a positive number is needed".into()),
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
