//! A bar for each stage, what the user should know meanwhile, and whether Ctrl-C was pressed.

use std::fmt;
use std::io::{self, Write};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use gmpcr::{Observer, Stage};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::outcome::Failure;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// Held while a file is written.
static WRITING: Mutex<()> = Mutex::new(());

/// Lets Ctrl-C, or a request to terminate, end the work between two items; where one takes longer, it ends
/// the program a second later, but in the middle of no file.
pub fn heed_interrupts() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        INTERRUPTED.store(true, Ordering::Relaxed);
        thread::sleep(Duration::from_secs(1));
        let _none_is_written = lock(&WRITING);
        // Nobody can be told that standard error is gone.
        let _ = writeln!(io::stderr(), "{}", Failure::Interrupted);
        process::exit(130);
    })?;
    Ok(())
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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
        if self.is_cancelled() {
            return Err(Failure::Interrupted);
        }
        let result = work();
        self.item_done();
        Ok(result)
    }

    /// An item that writes a file, which interrupts do not cut off.
    pub fn file<T>(&self, write: impl FnOnce() -> T) -> Result<T, Failure> {
        let _guard = lock(&WRITING);
        self.item(write)
    }

    /// Says something that is to stay.
    pub fn say(&self, message: &str) {
        if !self.is_quiet {
            let say = || writeln!(io::stderr(), "{message}");
            let _ = lock(&self.bar).suspend(say);
        }
    }

    /// Ends the bar of the last stage, which stays to be read.
    pub fn finish(&self) {
        lock(&self.bar).finish();
    }

    fn start(&self, name: &'static str, num_items: usize) {
        let mut bar = lock(&self.bar);
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
        lock(&self.bar).inc(1);
    }

    fn is_cancelled(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}
