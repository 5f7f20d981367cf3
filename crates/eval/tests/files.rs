//! Results and pairs are written to files and read again.

#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use std::fmt::Debug;

use gmpcr_eval::{
    ConnectivitySummary, DecileSummary, Gauge, GroundTruthPair, PairErrors, Protocol, Spread,
    WorldPoses, absolute_errors, overlap_deciles, registration_recall, retrieval,
};
use gmpcr_posegraph::Connectivity;
use nalgebra::{Isometry3, Matrix6, Vector3};
use serde::{Serialize, de::DeserializeOwned};

fn assert_round_trip<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn results_survive_a_file() {
    let i_from_j = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 0.2, -2.0));
    let pair = |j| GroundTruthPair {
        i: 0,
        j,
        i_from_j,
        information: Matrix6::identity(),
    };
    let pairs = [pair(1), pair(2), pair(3)];
    let world_from_scan = [Isometry3::identity(), i_from_j, Isometry3::identity()];
    let poses = WorldPoses::new(
        world_from_scan
            .iter()
            .copied()
            .map(Some)
            .chain([None])
            .collect(),
        vec![0; 4],
    );
    let poses = poses.unwrap();
    assert_round_trip(&poses);
    let mut other = serde_json::to_value(&poses).unwrap();
    other["component"].as_array_mut().unwrap().pop();
    assert!(serde_json::from_value::<WorldPoses>(other).is_err());
    assert_round_trip(&registration_recall(&pairs, &poses, Protocol::ThreeDLoMatch).unwrap());
    let errors = PairErrors::of_pairs(&pairs, &poses).unwrap();
    assert_round_trip(&errors);
    assert_round_trip(&errors.scannet_ratios().unwrap());
    assert_round_trip(&Spread::of(&[0.1, 0.3]).unwrap());
    assert_round_trip(&retrieval(3, 1, |_, j| j as f64, |i, _| i as f64).unwrap());
    let deciles = overlap_deciles(&[0.1, 0.7], &[0.2, 0.3]).unwrap();
    assert_round_trip(&deciles);
    assert_round_trip(&DecileSummary::of(&[deciles]).unwrap());
    let scenes = [Connectivity::new(3, &[(0, 1)], 0)];
    assert_round_trip(&ConnectivitySummary::of(&scenes).unwrap());
    let errors = absolute_errors(&world_from_scan, &world_from_scan, Gauge::LeastAbsolute);
    assert_round_trip(&errors.unwrap());
    assert_round_trip(&Gauge::LeastSquares);
    assert_round_trip(&Protocol::ThreeDMatch);
}

#[test]
fn a_pair_is_written_as_the_rows_of_its_matrices() {
    let pair = GroundTruthPair {
        i: 4,
        j: 7,
        i_from_j: Isometry3::translation(1.0, 2.0, 3.0),
        information: Matrix6::identity(),
    };
    let value = serde_json::to_value(pair).unwrap();
    let rows = [1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3].map(f64::from);
    assert_eq!(value["i_from_j"], serde_json::json!(rows));
    assert_round_trip(&pair);
    let mut sheared = value;
    sheared["i_from_j"][1] = 0.5.into();
    assert!(serde_json::from_value::<GroundTruthPair>(sheared).is_err());
}
