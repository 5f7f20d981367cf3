//! Recalls and errors where the ground truth is known.

use std::error::Error;

use gmpcr::Registration;
use gmpcr_eval::{
    GroundTruthPair, PairErrors, Protocol, WorldPoses, overlap_matrix, registration_recall,
};
use gmpcr_sim::SimulatedScans;

/// A list of pairs whose relative pose is known.
pub struct GroundTruth {
    name: String,
    pairs: Vec<GroundTruthPair>,
    /// What judges lists with information matrices.
    protocol: Option<Protocol>,
}

/// Points overlap within 1.5 voxels of 2.5 cm, as in the 3DMatch benchmark.
const OVERLAP_RADIUS: f64 = 0.0375;

/// The lists of a scene, and all pairs of known poses.
pub fn of_scene(known: &gmpcr::io::GroundTruth) -> Result<Vec<GroundTruth>, Box<dyn Error>> {
    let mut lists = Vec::new();
    for list in &known.pair_lists {
        let pairs = list.pairs.iter();
        let pairs = pairs.map(|pair| (pair.i, pair.j, pair.i_from_j));
        lists.push(GroundTruth {
            name: list.name.clone(),
            pairs: GroundTruthPair::of_list(pairs, list.information.as_deref())?,
            protocol: Protocol::of_list(&list.name, list.information.is_some()),
        });
    }
    let poses = known.world_from_scan.iter();
    lists.extend(poses.map(|poses| of_pairs("all pairs", GroundTruthPair::all_pairs(poses))));
    Ok(lists)
}

/// Pairs that overlap as those of 3DMatch and of 3DLoMatch do, and all pairs.
pub fn of_simulation(scans: &SimulatedScans) -> Result<Vec<GroundTruth>, Box<dyn Error>> {
    let overlap = overlap_matrix(&scans.clouds, &scans.world_from_scan, OVERLAP_RADIUS)?;
    let overlap = |pair: &GroundTruthPair| overlap[(pair.i, pair.j)];
    let poses: Vec<_> = scans.world_from_scan.iter().copied().map(Some).collect();
    let all = GroundTruthPair::all_pairs(&poses);
    let (mut high, mut low) = (all.clone(), all.clone());
    high.retain(|pair| overlap(pair) > 0.3);
    low.retain(|pair| (0.1..=0.3).contains(&overlap(pair)));
    let lists = [
        ("overlap above 30 %", high),
        ("overlap of 10–30 %", low),
        ("all pairs", all),
    ];
    Ok(lists.map(|(name, pairs)| of_pairs(name, pairs)).into())
}

fn of_pairs(name: &str, pairs: Vec<GroundTruthPair>) -> GroundTruth {
    GroundTruth {
        name: name.to_owned(),
        pairs,
        protocol: None,
    }
}

pub fn print_recalls(lists: &[GroundTruth], found: &Registration) -> Result<(), Box<dyn Error>> {
    let poses = found.world_from_scan.iter().copied().map(Some);
    let poses = WorldPoses::new(poses.collect(), found.components.labels().to_vec())?;
    let percent =
        |ratio: Option<f64>| ratio.map_or("–".into(), |r| format!("{:.1} %", 100.0 * r));
    println!("\nground truth         pairs   < 15°, 0.3 m   RMSE < 0.2 m   median errors");
    for list in lists {
        let errors = PairErrors::of_pairs(&list.pairs, &poses)?;
        let official = match list.protocol {
            Some(protocol) => registration_recall(&list.pairs, &poses, protocol)?.ratio(),
            None => None,
        };
        let median = errors.median().map_or(String::new(), |error| {
            format!(
                "{:.2}°  {:.3} m",
                error.rotation_degrees(),
                error.translation
            )
        });
        println!(
            "{:<18} {:>7} {:>14} {:>14}   {median}",
            list.name,
            list.pairs.len(),
            percent(errors.recall()),
            percent(official)
        );
    }
    Ok(())
}
