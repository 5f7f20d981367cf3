use std::fmt;

/// A stage of [`register`](crate::register).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Farthest-point sampling; its items are scans.
    Sampling,
    /// Matching and scoring; its items are pairs of scans. It begins again for each round of pairs where they
    /// are retrieved; the retrieval itself has no items.
    Scoring,
    /// Choice of the edges, one item.
    Selection,
    /// Relative poses; its items are the selected pairs.
    PoseEstimation,
    /// Synchronisation, one item.
    Synchronization,
}

impl Stage {
    /// All stages in their order.
    pub const ALL: [Self; 5] = [
        Self::Sampling,
        Self::Scoring,
        Self::Selection,
        Self::PoseEstimation,
        Self::Synchronization,
    ];

    /// The name in words, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sampling => "sampling",
            Self::Scoring => "pair scoring",
            Self::Selection => "pair selection",
            Self::PoseEstimation => "pose estimation",
            Self::Synchronization => "synchronisation",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.pad(self.name())
    }
}

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
    fn begin(&self, _stage: Stage, _num_items: usize) {}

    /// An item of the stage that began last is done. Called from any thread.
    fn item_done(&self) {}

    /// Whether the registration is to end with [`Error::Cancelled`](crate::Error::Cancelled): asked
    /// before every item, from any thread. Items under way are finished; selection and
    /// synchronisation are one item each.
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Observer for () {}
