use gmpcr_correspondence::{Keypoints, Scan};

use crate::known_pairs::KnownPairs;
use crate::pair::register_correspondences_unchecked;
use crate::pipeline::{Pipeline, sample};
use crate::source::Source;
use crate::{Error, Observer, PairRegistration, Params, Registration, ScanId, StageTimes};

/// Registration of scans that come and go: keeps what is known of each scan and each pair, so that a change
/// costs only what it changes.
///
/// Adding a scan samples it and gives it a [`ScanId`], which it keeps whatever else is removed.
/// [`register`](Self::register) then scores the pairs that were not scored before (the `N − 1` of the N-th
/// scan, or fewer where they are retrieved), chooses edges among all scored pairs, estimates the relative
/// poses of those that were not chosen before, and synchronizes. The result has the same bits as
/// [`register`](crate::register) of the same scans in the same order. Memory holds the keypoints, one
/// confidence per scored pair and one relative pose per edge.
///
/// Scans that are made of clouds need one voxel size, or their descriptors do not compare: give all of them the same
/// parameters (`compute_scan`).
///
/// Pairs are retrieved where there are [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans)
/// scans or more: each scan proposes others by its descriptors, and then neighbors of the neighbors
/// that it has by the confidences. The index of the descriptors is then made anew for each registration, on
/// one thread.
///
/// ```
/// use gmpcr::{Descriptors, IncrementalRegistration, Params, Scan, register};
///
/// let scan = |offset: f64| {
///     let points = (0..40).map(|k| f64::from(k)).map(|k| [(k + offset).sin(), (2.0 * k).cos(), 0.1 * k]);
///     let rows = Descriptors::new((0..40).map(|k| k as f32).collect(), 1)?;
///     Ok::<_, gmpcr::Error>(Scan::new(points.map(Into::into).collect(), rows)?)
/// };
/// let mut map = IncrementalRegistration::new(Params::default())?;
/// let first = map.add(&[scan(0.0)?, scan(0.01)?])?;
/// let last = map.add(&[scan(0.02)?])?;
/// let three = map.register()?;
/// let batch = register(&[scan(0.0)?, scan(0.01)?, scan(0.02)?], &Params::default())?;
/// assert_eq!(three.world_from_scan, batch.world_from_scan);
///
/// assert!(map.remove(first[1]));
/// let two = map.register()?;
/// assert_eq!(two.ids, [first[0], last[0]]);
/// assert!(two.pose_of(last[0]).is_some() && two.pose_of(first[1]).is_none());
/// # Ok::<(), gmpcr::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct IncrementalRegistration {
    params: Params,
    /// Of the scans, ascending.
    ids: Vec<ScanId>,
    /// In the order of the ids.
    keypoints: Vec<Keypoints>,
    next_id: ScanId,
    known: KnownPairs,
    /// What was spent since the last registration.
    times: StageTimes,
}

impl IncrementalRegistration {
    /// A registration without scans.
    ///
    /// # Errors
    /// [`Error::Parameter`] if one is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            params,
            ids: Vec::new(),
            keypoints: Vec::new(),
            next_id: ScanId::default(),
            known: KnownPairs::default(),
            times: StageTimes::default(),
        })
    }

    /// The scans, in the order in which they were added.
    pub fn ids(&self) -> &[ScanId] {
        &self.ids
    }

    /// Adds scans behind the others and samples them; returns their ids.
    ///
    /// # Errors
    /// [`Error::DimensionsDiffer`] if descriptors differ in dimension, also from those of earlier scans. Then
    /// nothing was added.
    pub fn add(&mut self, scans: &[Scan]) -> Result<Vec<ScanId>, Error> {
        self.add_observed(scans, &())
    }

    /// As [`add`](Self::add), with an observer that is told of the progress and may end the work.
    ///
    /// # Errors
    /// Those of [`add`](Self::add), and [`Error::Cancelled`] if the observer says so. Then nothing was added.
    pub fn add_observed(
        &mut self,
        scans: &[Scan],
        observer: &dyn Observer,
    ) -> Result<Vec<ScanId>, Error> {
        self.check_dimensions(scans)?;
        let Self { params, times, .. } = self;
        let sampled = times.timed(crate::Stage::Sampling, || sample(scans, params, observer))?;
        let mut ids = Vec::with_capacity(sampled.len());
        for _ in &sampled {
            ids.push(self.next_id);
            self.next_id = self.next_id.next();
        }
        self.ids.extend(&ids);
        self.keypoints.extend(sampled);
        Ok(ids)
    }

    /// Removes a scan and forgets its pairs, in time linear in all scored pairs. Returns whether it was there.
    pub fn remove(&mut self, scan: ScanId) -> bool {
        let Ok(position) = self.ids.binary_search(&scan) else {
            return false;
        };
        self.ids.remove(position);
        self.keypoints.remove(position);
        self.known.remove(scan);
        true
    }

    /// Registers the scans.
    ///
    /// # Errors
    /// [`Error::NoScans`] if there is none.
    pub fn register(&mut self) -> Result<Registration, Error> {
        self.register_observed(&())
    }

    /// As [`register`](Self::register), with an observer that is told of the progress and may end the work.
    ///
    /// # Errors
    /// Those of [`register`](Self::register), and [`Error::Cancelled`] if the observer says so. What was found out
    /// until then is kept, stage by stage.
    pub fn register_observed(&mut self, observer: &dyn Observer) -> Result<Registration, Error> {
        if self.ids.is_empty() {
            return Err(Error::NoScans);
        }
        let pipeline = Pipeline {
            ids: &self.ids,
            source: Source::Keypoints(&self.keypoints),
            params: &self.params,
            observer,
        };
        pipeline.run(&mut self.known, &mut self.times)
    }

    /// What two scans say about their relative pose, with all correspondences: for the edges of a
    /// registration that a person should check. Computed anew, with the same bits.
    ///
    /// # Errors
    /// [`Error::UnknownScan`] if there is no such scan.
    pub fn pair(&self, i: ScanId, j: ScanId) -> Result<PairRegistration, Error> {
        let position = |scan| {
            let found = self.ids.binary_search(&scan);
            found.map_err(|_| Error::UnknownScan { scan })
        };
        let (i, j) = (position(i)?, position(j)?);
        let source = Source::Keypoints(&self.keypoints);
        let correspondences = source.correspondences(i, j, &self.params)?;
        register_correspondences_unchecked(correspondences, &self.params)
    }

    /// Scans without points have no dimension.
    fn check_dimensions(&self, scans: &[Scan]) -> Result<(), Error> {
        let known = self
            .keypoints
            .iter()
            .map(|keypoints| keypoints.descriptors());
        let all = known.chain(scans.iter().map(Scan::descriptors)).enumerate();
        let mut with_features = all.filter(|(_, descriptors)| !descriptors.is_empty());
        let Some((first, expected)) = with_features.next() else {
            return Ok(());
        };
        match with_features.find(|(_, other)| other.dimension() != expected.dimension()) {
            Some((scan, other)) => Err(Error::DimensionsDiffer {
                first,
                expected: expected.dimension(),
                scan,
                dimension: other.dimension(),
            }),
            None => Ok(()),
        }
    }
}
