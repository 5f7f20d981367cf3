use crate::{Error, Stage};

/// Watches a registration, and may end it: for progress bars and for programs that are told to stop.
///
/// Every method has a default that does nothing; `()` is an observer that only lets the work go on.
/// What is observed does not influence the result.
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use gmpcr::{Descriptors, Error, Observer, Params, Scan, Stage, register_observed};
///
/// /// Stops before pairs are scored.
/// #[derive(Default)]
/// struct SamplingOnly {
///     is_over: AtomicBool,
/// }
///
/// impl Observer for SamplingOnly {
///     fn begin(&self, stage: Stage, _num_items: usize) {
///         self.is_over.store(stage == Stage::Scoring, Ordering::Relaxed);
///     }
///     fn is_cancelled(&self) -> bool {
///         self.is_over.load(Ordering::Relaxed)
///     }
/// }
///
/// let scan = Scan::new(vec![[0.0; 3].into()], Descriptors::new(vec![0.0], 1)?)?;
/// let observer = SamplingOnly::default();
/// let outcome = register_observed(&[scan.clone(), scan], &Params::default(), &observer);
/// assert!(matches!(outcome, Err(Error::Cancelled { stage: Stage::Scoring })));
/// # Ok::<(), Error>(())
/// ```
pub trait Observer: Sync {
    /// A stage begins, which has `num_items` items. Called by the thread of the caller, before any of
    /// them.
    fn begin(&self, stage: Stage, num_items: usize) {
        let _ = (stage, num_items);
    }

    /// An item of the stage that began last is done. Called from any thread.
    fn item_done(&self) {}

    /// Whether the work is to end with [`Error::Cancelled`]: asked
    /// before every item, from any thread. Items under way are finished; selection and
    /// synchronization are one item each.
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Observer for () {}

/// A stage under way: tells the observer of its items, and heeds it.
pub(crate) struct StageProgress<'a> {
    stage: Stage,
    observer: &'a dyn Observer,
}

impl<'a> StageProgress<'a> {
    pub fn begin(stage: Stage, num_items: usize, observer: &'a dyn Observer) -> Self {
        observer.begin(stage, num_items);
        Self { stage, observer }
    }

    /// Does one item, unless the observer has had enough.
    pub fn item<T>(&self, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        if self.observer.is_cancelled() {
            return Err(Error::Cancelled { stage: self.stage });
        }
        let result = work();
        self.observer.item_done();
        result
    }
}
