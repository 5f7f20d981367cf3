//! Registration of scenes from chosen sampling starts, and how well it went.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use gmpcr::correspondence::{farthest_point_sampling, farthest_point_sampling_from};
use gmpcr::posegraph::Components;
use gmpcr::{Params, Registration, Scan, register};
use gmpcr_eval::{
    PairErrors, Protocol, SCANNET_DEGREES, SCANNET_METERS, WorldPoses, registration_recall,
};
use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::records::Record;
use crate::scene::{GroundTruthList, Scene};

/// Scans reduced to their samples, from which registration takes all. Run 0 starts the sampling as
/// the method does, at the descriptor farthest from the mean; other runs start anywhere.
pub fn sampled(scene: &Scene, params: &Params, run: usize) -> Vec<Scan> {
    let num_samples = params.correspondence.num_samples;
    let sample = |(index, scan): (usize, &Scan)| {
        let descriptors = scan.descriptors();
        let rows = if run == 0 || scan.is_empty() {
            farthest_point_sampling(descriptors, num_samples)
        } else {
            let mut rng = generator(scene.seed, run, index);
            let first = rng.random_range(0..scan.len());
            farthest_point_sampling_from(descriptors, first, num_samples)
        };
        let points = rows.iter().map(|&row| scan.points()[row]).collect();
        Scan::new(points, descriptors.select(&rows)).expect("rows of a scan form a scan")
    };
    scene.scans.par_iter().enumerate().map(sample).collect()
}

/// Registrations by parameters and run.
#[derive(Default)]
pub struct Registrations(Mutex<BTreeMap<(String, usize), Arc<Registration>>>);

/// Registers a scene from the sampling start of a run, or finds that it was done before.
pub fn registered(
    scene: &Scene,
    params: &Params,
    run: usize,
) -> Result<Arc<Registration>, gmpcr::Error> {
    let key = (format!("{params:?}"), run);
    let known = || {
        scene
            .registrations
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    };
    if let Some(found) = known().get(&key) {
        return Ok(found.clone());
    }
    let scans = sampled(scene, params, run);
    let found = Arc::new(register(&scans, params)?);
    known().insert(key, found.clone());
    Ok(found)
}

/// The random numbers of one purpose in one run.
pub fn generator(seed: u64, run: usize, purpose: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream((run as u64) << 32 | purpose as u64);
    rng
}

/// The result of a registration in the form that the protocols take.
pub fn world_poses(world_from_scan: &[Isometry3<f64>], components: &Components) -> WorldPoses {
    let poses = world_from_scan.iter().copied().map(Some).collect();
    WorldPoses::new(poses, components.labels().to_vec()).expect("one label per pose")
}

/// Figures of one result on all lists of a scene, as records of one configuration and run.
pub struct Judge<'a> {
    pub scene: &'a Scene,
    pub configuration: &'a str,
    pub run: usize,
}

impl Judge<'_> {
    /// Recalls (ratio, number registered, number of pairs), and pairs within 15° and 0.3 m with mean and
    /// median errors.
    pub fn judge(&self, poses: &WorldPoses) -> Result<Vec<Record>, gmpcr_eval::Error> {
        self.judge_pairs(poses, |_, _| true)
    }

    /// The same on the pairs that are wanted.
    pub fn judge_pairs(
        &self,
        poses: &WorldPoses,
        is_wanted: impl Fn(usize, usize) -> bool,
    ) -> Result<Vec<Record>, gmpcr_eval::Error> {
        let mut records = Vec::new();
        for list in &self.scene.lists {
            let wanted = list.pairs.iter().filter(|pair| is_wanted(pair.i, pair.j));
            let wanted = GroundTruthList {
                name: list.name.clone(),
                pairs: wanted.copied().collect(),
                ..*list
            };
            let errors = PairErrors::of_pairs(&wanted.pairs, poses)?;
            self.errors(&wanted.name, &errors, &mut records);
            match wanted.protocol {
                Some(protocol) => self.recall(&wanted, protocol, poses, &mut records)?,
                None => self.recall_by_errors(&wanted.name, &errors, &mut records),
            }
        }
        Ok(records)
    }

    fn record(&self, metric: String, value: f64) -> Record {
        Record::new(self.configuration, self.run, metric, value)
    }

    /// Where a list has no information matrices, pairs within 15° and 0.3 m are registered.
    fn recall_by_errors(&self, name: &str, errors: &PairErrors, records: &mut Vec<Record>) {
        if let Some(ratio) = errors.recall() {
            let total = errors.pairs.len() as f64;
            records.extend(self.recall_records(name, ratio, ratio * total, total));
        }
    }

    fn recall(
        &self,
        list: &GroundTruthList,
        protocol: Protocol,
        poses: &WorldPoses,
        records: &mut Vec<Record>,
    ) -> Result<(), gmpcr_eval::Error> {
        let name = &list.name;
        let recall = registration_recall(&list.pairs, poses, protocol)?;
        if let Some(ratio) = recall.ratio() {
            let (registered, total) = (recall.registered as f64, recall.total as f64);
            records.extend(self.recall_records(name, ratio, registered, total));
        }
        for (i, j) in recall.unjudgeable {
            records.push(self.record(format!("{name} unjudgeable pair {i} {j}"), 1.0));
        }
        Ok(())
    }

    fn recall_records(&self, name: &str, ratio: f64, registered: f64, total: f64) -> [Record; 3] {
        [
            self.record(name.to_owned(), ratio),
            self.record(format!("{name} registered"), registered),
            self.record(format!("{name} pairs"), total),
        ]
    }

    fn errors(&self, name: &str, errors: &PairErrors, records: &mut Vec<Record>) {
        if let Some(ratio) = errors.recall() {
            records.push(self.record(format!("{name} within 15° and 0.3 m"), ratio));
            let missing = errors.num_missing() as f64 / errors.pairs.len() as f64;
            records.push(self.record(format!("{name} without estimate"), missing));
        }
        for (statistic, error) in [("mean", errors.mean()), ("median", errors.median())] {
            if let Some(error) = error {
                let degrees = error.rotation_degrees();
                records.push(self.record(format!("{name} {statistic} degrees"), degrees));
                records.push(self.record(format!("{name} {statistic} meters"), error.translation));
            }
        }
        if let Some(ratios) = errors.scannet_ratios() {
            for (limit, ratio) in SCANNET_DEGREES.iter().zip(ratios.rotation) {
                records.push(self.record(format!("{name} under {limit}°"), ratio));
            }
            for (limit, ratio) in SCANNET_METERS.iter().zip(ratios.translation) {
                records.push(self.record(format!("{name} under {limit} m"), ratio));
            }
        }
    }
}
