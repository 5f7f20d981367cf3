//! Recalls and errors where the truth is known.

use std::error::Error;

use gmpcr::Registration;
use gmpcr_eval::{GroundTruthPair, PairErrors, Protocol, WorldPoses, registration_recall};

use crate::input::Truth;

pub fn print_evaluation(truth: &Truth, registration: &Registration) -> Result<(), Box<dyn Error>> {
    let poses = registration
        .world_from_scan
        .iter()
        .copied()
        .map(Some)
        .collect();
    let poses = WorldPoses::new(poses, registration.components.labels().to_vec())?;
    if let Some(matches) = &truth.matches {
        print_recalls(matches, &poses)?;
    }
    if let Some(world_from_scan) = &truth.world_from_scan {
        print_errors(&PairErrors::of_all(world_from_scan, &poses)?);
    }
    Ok(())
}

fn print_recalls(
    matches: &[Vec<GroundTruthPair>; 2],
    poses: &WorldPoses,
) -> Result<(), Box<dyn Error>> {
    let protocols = [Protocol::ThreeDMatch, Protocol::ThreeDLoMatch];
    println!("\nregistration recall          3DMatch  3DLoMatch");
    print!("{:<28}", "RMSE below 0.2 m");
    for (pairs, protocol) in matches.iter().zip(protocols) {
        let recall = registration_recall(pairs, poses, protocol)?;
        match recall.ratio() {
            Some(ratio) => print!(" {:>6.1} % ", 100.0 * ratio),
            None => print!(" {:>8} ", "no pairs"),
        }
        for (i, j) in &recall.unjudgeable {
            eprintln!(
                "pair ({i}, {j}) has an empty information matrix: it counts as not registered"
            );
        }
    }
    println!();
    print!("{:<28}", "within 15° and 0.3 m");
    for pairs in matches {
        match PairErrors::of_pairs(pairs, poses)?.recall() {
            Some(share) => print!(" {:>6.1} % ", 100.0 * share),
            None => print!(" {:>8} ", "no pairs"),
        }
    }
    println!();
    Ok(())
}

fn print_errors(errors: &PairErrors) {
    println!("\nerror over all pairs    mean      median");
    if let (Some(mean), Some(median)) = (errors.mean(), errors.median()) {
        println!(
            "rotation          {:>8.3}°  {:>9.3}°",
            mean.rotation_degrees(),
            median.rotation_degrees()
        );
        println!(
            "translation       {:>8.4} m {:>9.4} m",
            mean.translation, median.translation
        );
    }
    println!("pairs without a common frame  {}", errors.num_missing());
}
