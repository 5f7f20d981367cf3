//! What the program does.

mod eval;
mod info;
mod pair;
mod register;
mod sync;

use clap::CommandFactory;

use crate::arguments::{Arguments, Command, ParamsArguments};
use crate::config::Config;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;

/// Carries out a command.
pub fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let verbosity = arguments.verbosity;
    let progress = Progress::new(verbosity.quiet);
    match &arguments.command {
        Command::Register(arguments) => register::run(arguments, verbosity.verbose, &progress),
        Command::Pair(arguments) => pair::run(arguments, &progress),
        Command::Sync(arguments) => sync::run(arguments, verbosity.verbose, &progress),
        Command::Info(arguments) => info::run(arguments, &progress),
        Command::Eval(arguments) => eval::run(arguments, verbosity.verbose),
        Command::Params(arguments) => params(arguments, verbosity.json),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Arguments::command(), "gmpcr", &mut script);
            Ok(Answer::of_text(String::from_utf8(script)?))
        }
    }
}

fn params(arguments: &ParamsArguments, as_json: bool) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    Ok(Answer::of_text(match as_json {
        true => format!("{:#}\n", config.to_json()),
        false => config.to_toml(),
    }))
}
