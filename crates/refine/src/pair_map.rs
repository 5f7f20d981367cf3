/// How the work on many pairs is carried out.
///
/// This crate starts no threads. A caller who has some implements this for a type of its own, with rayon for
/// instance as `(0..count).into_par_iter().map(work).collect()`. Results are used in their order, so they are
/// the same bits with any number of threads.
///
/// ```
/// use gmpcr_refine::PairMap;
///
/// struct Halves;
///
/// impl PairMap for Halves {
///     fn map<T: Send>(&self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
///         let (work, middle) = (&work, count / 2);
///         std::thread::scope(|scope| {
///             let later = scope.spawn(move || (middle..count).map(work).collect::<Vec<_>>());
///             let mut results: Vec<T> = (0..middle).map(work).collect();
///             results.extend(later.join().unwrap_or_default());
///             results
///         })
///     }
/// }
/// assert_eq!(Halves.map(5, |k| k * k), [0, 1, 4, 9, 16]);
/// ```
pub trait PairMap {
    /// The results of `work` for `0, 1, …, count − 1`, in that order.
    fn map<T: Send>(&self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T>;
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequential;

impl PairMap for Sequential {
    fn map<T: Send>(&self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        (0..count).map(work).collect()
    }
}
