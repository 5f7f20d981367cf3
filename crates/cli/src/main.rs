//! The program `gmpcr`: registers a folder of overlapping point clouds and reports how sure it is.

mod arguments;
mod commands;
mod config;
mod input;
mod outcome;
mod output;
mod progress;
mod report;
mod result;
mod scan_files;
mod table;
mod warnings;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Verbosity};
use outcome::{Answer, Failure};

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version come this way, too.
            let _ = error.print();
            return ExitCode::from(u8::from(error.use_stderr()));
        }
    };
    let outcome = progress::heed_interrupts()
        .and_then(|()| commands::run(&arguments))
        .and_then(|answer| print(&answer, arguments.verbosity).map(|()| answer.exit_code()));
    outcome.unwrap_or_else(|failure| {
        let _ = writeln!(io::stderr(), "{failure}");
        failure.exit_code()
    })
}

/// Writes the answer to standard output; a reader who has seen enough is no error.
fn print(answer: &Answer, verbosity: Verbosity) -> Result<(), Failure> {
    let text = match &answer.json {
        Some(json) if verbosity.json => format!("{json:#}\n"),
        Some(_) if verbosity.quiet => return Ok(()),
        _ => answer.text.clone(),
    };
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}").into())
        }
        _ => Ok(()),
    }
}
