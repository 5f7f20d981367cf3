//! The experiments, one per section of the paper, each of which runs on a scene and reports over all.

mod ablation;
mod connectivity;
mod recall;
mod retrieval;
pub mod synchronization;
mod time;
mod views;

use std::path::Path;

use clap::ValueEnum;

use crate::arguments::Arguments;
use crate::failure::Failure;
use crate::records::{Record, Store};
use crate::reference;
use crate::scene::Scene;

/// What can be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Experiment {
    /// Registration recall, pose errors and ratios under thresholds, with both presets.
    Recall,
    /// The method without its parts, and other synchronization methods on the same graphs.
    Ablation,
    /// Recall over the number of scans, the views of the paper.
    Views,
    /// Confidence against overlap: R@K, regret, deciles; spectral response against inliers: AUC.
    Retrieval,
    /// Connectivity of the pose graph over K.
    Connectivity,
    /// All synchronization methods on simulated pose graphs with outlier edges.
    Sync,
    /// Time of each stage.
    Time,
}

impl Experiment {
    pub const ALL: [Self; 7] = [
        Self::Recall,
        Self::Ablation,
        Self::Views,
        Self::Retrieval,
        Self::Connectivity,
        Self::Sync,
        Self::Time,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Recall => "recall",
            Self::Ablation => "ablation",
            Self::Views => "views",
            Self::Retrieval => "retrieval",
            Self::Connectivity => "connectivity",
            Self::Sync => "sync",
            Self::Time => "time",
        }
    }

    pub fn needs_scenes(self) -> bool {
        self != Self::Sync
    }

    /// Runs on one scene. What the scene lacks (lists of pairs, overlaps) yields no records.
    pub fn run(self, scene: &Scene, arguments: &Arguments) -> Result<Vec<Record>, Failure> {
        match self {
            Self::Recall => recall::run(scene, arguments),
            Self::Ablation => ablation::run(scene, arguments),
            Self::Views => views::run(scene, arguments),
            Self::Retrieval => retrieval::run(scene),
            Self::Connectivity => connectivity::run(scene),
            Self::Sync => Ok(Vec::new()),
            Self::Time => time::run(scene, arguments),
        }
    }

    /// Appends the tables over all scenes to a text and draws the figures into a folder.
    pub fn report(self, store: &Store, folder: &Path, text: &mut String) -> Result<(), Failure> {
        if self == Self::Sync {
            return synchronization::report(store, folder, text);
        }
        for descriptors in store.descriptors(self.name()) {
            let records = store.select(self.name(), descriptors);
            let figure = |name: &str| folder.join(format!("{name}_{descriptors}.svg"));
            match self {
                Self::Recall => recall::report(&records, descriptors, text),
                Self::Ablation => ablation::report(&records, descriptors, text),
                Self::Views => views::report(&records, descriptors, &figure("views"), text)?,
                Self::Retrieval => retrieval::report(&records, descriptors, &figure, text)?,
                Self::Connectivity => {
                    let path = figure("connectivity");
                    connectivity::report(&records, descriptors, &path, text)?;
                }
                Self::Sync => {}
                Self::Time => time::report(&records, descriptors, &figure("time"), text)?,
            }
        }
        if let Some(tables) = reference::paper(self) {
            text.push_str(&format!("\n{tables}"));
        }
        Ok(())
    }
}
