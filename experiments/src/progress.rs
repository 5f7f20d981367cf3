//! How far the program is: a bar on a terminal, lines elsewhere.

use std::io::{IsTerminal, stderr};

use indicatif::{ProgressBar, ProgressStyle};

pub struct Progress {
    bar: ProgressBar,
    is_terminal: bool,
}

impl Progress {
    /// Progress over a number of units of work, on standard error.
    pub fn new(num_units: usize) -> Self {
        let template = "{bar:30} {pos}/{len} {elapsed} (eta {eta}) {msg}";
        let bar = ProgressBar::new(num_units as u64);
        Self {
            bar: match ProgressStyle::with_template(template) {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            },
            is_terminal: stderr().is_terminal(),
        }
    }

    /// Says what is being done.
    pub fn begin(&self, what: String) {
        if !self.is_terminal {
            eprintln!("{what}");
        }
        self.bar.set_message(what);
    }

    /// Units that are done, or will not be done.
    pub fn advance(&self, num_units: usize) {
        self.bar.inc(num_units as u64);
    }

    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}
