//! A bar for each stage, what the user should know meanwhile, and whether Ctrl-C was pressed.

use std::fmt;
use std::io::Write;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use gmpcr::{Observer, Stage};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::outcome::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Lets Ctrl-C end the work between two items; pressed again, it ends the program at once.
pub fn heed_interrupts() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            process::exit(130);
        }
    })?;
    Ok(())
}

/// Progress on standard error: nothing when quiet, no bars where it is no terminal.
pub struct Progress {
    is_quiet: bool,
    bar: Mutex<ProgressBar>,
}

impl Progress {
    pub fn new(is_quiet: bool) -> Self {
        Self {
            is_quiet,
            bar: Mutex::new(ProgressBar::hidden()),
        }
    }

    /// Does a stage of a number of items; returns its time, too.
    pub fn stage<T>(
        &self,
        name: &'static str,
        num_items: usize,
        work: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<(T, Duration), Failure> {
        let start = Instant::now();
        self.start(name, num_items);
        let result = work()?;
        self.finish();
        Ok((result, start.elapsed()))
    }

    /// Does an item of the stage, unless the user wants no more.
    pub fn item<T>(&self, work: impl FnOnce() -> T) -> Result<T, Failure> {
        self.check()?;
        let result = work();
        self.item_done();
        Ok(result)
    }

    pub fn check(&self) -> Result<(), Failure> {
        if self.is_cancelled() {
            return Err(Failure::Interrupted);
        }
        Ok(())
    }

    /// Says something that is to stay.
    pub fn say(&self, message: &str) {
        if !self.is_quiet {
            self.lock().suspend(|| {
                // Nobody can be told that standard error is gone.
                let _ = writeln!(std::io::stderr(), "{message}");
            });
        }
    }

    /// Ends the bar of the last stage, which stays to be read.
    pub fn finish(&self) {
        self.lock().finish();
    }

    fn start(&self, name: &'static str, num_items: usize) {
        let mut bar = self.lock();
        bar.finish();
        if self.is_quiet {
            return;
        }
        *bar = ProgressBar::new(num_items as u64).with_message(name);
        let template = "{msg:16} {bar:20} {pos:>6}/{len:<6} {rate:>9} {elapsed:>4}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key("rate", write_rate));
        }
    }

    fn lock(&self) -> MutexGuard<'_, ProgressBar> {
        self.bar.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn write_rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    // A bar without its rate is still a bar.
    let _ = write!(text, "{:.0}/s", state.per_sec());
}

impl Observer for Progress {
    fn begin(&self, stage: Stage, num_items: usize) {
        self.start(stage.name(), num_items);
    }

    fn item_done(&self) {
        self.lock().inc(1);
    }

    fn is_cancelled(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}
