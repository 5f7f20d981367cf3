//! Figures of others, printed beside ours.
//!
//! The paper's tables stand in `reference/*.md` as they are printed. Other systems stand in
//! `reference/systems.csv`: measured on graphs of the same kind (another random generator, other
//! seeds), Open3D 0.20, GTSAM 4.3, COLMAP 4.2 (GLOMAP's rotation averaging), SE-Sync of 2022-07,
//! SGHR's synchronization; mean / median over the scans, three seeds; CPU times.

use std::collections::BTreeMap;

use crate::experiment::Experiment;

/// The paper's tables that belong to an experiment.
pub fn paper(experiment: Experiment) -> Option<&'static str> {
    match experiment {
        Experiment::Recall => Some(include_str!("reference/recall.md")),
        Experiment::Ablation => Some(include_str!("reference/ablation.md")),
        Experiment::Views => Some(include_str!("reference/views.md")),
        Experiment::Retrieval => Some(include_str!("reference/retrieval.md")),
        Experiment::Connectivity => Some(include_str!("reference/connectivity.md")),
        Experiment::Sync => None,
        Experiment::Time => Some(include_str!("reference/time.md")),
    }
}

/// Another system on a family of simulated pose graphs.
#[derive(Debug, Default, PartialEq)]
pub struct System {
    pub name: String,
    /// Figures by the column that they belong in.
    pub figures: BTreeMap<String, String>,
}

/// The systems that a family of pose graphs was given to.
pub fn systems(family: &str) -> Vec<System> {
    let mut reader = csv::Reader::from_reader(include_str!("reference/systems.csv").as_bytes());
    let mut systems: Vec<System> = Vec::new();
    for row in reader.records().flatten().filter(|row| &row[0] == family) {
        if systems.last().is_none_or(|system| system.name != row[1]) {
            systems.push(System {
                name: row[1].to_owned(),
                ..System::default()
            });
        }
        if let Some(system) = systems.last_mut() {
            system.figures.insert(row[2].to_owned(), row[3].to_owned());
        }
    }
    systems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_systems_is_read() {
        let families = [
            "uniform",
            "coherent",
            "informative",
            "geometric500",
            "geometric5000",
        ];
        let systems: Vec<System> = families.into_iter().flat_map(systems).collect();
        assert_eq!(systems.len(), 31);
        let num_figures: usize = systems.iter().map(|system| system.figures.len()).sum();
        let num_rows = include_str!("reference/systems.csv").lines().count() - 1;
        assert_eq!(num_figures, num_rows);
        assert_eq!(systems[0].figures["20 %"], "34 / 5.3");
    }
}
