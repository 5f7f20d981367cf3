//! Reference values of the stage, computed in float64 straight from the definitions.

#![allow(clippy::unwrap_used)]

use approx::assert_relative_eq;
use gmpcr_posegraph::{Components, Connectivity, PairConfidences, PoseGraphParams, ScoredPair};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn confidences_edges_and_components_are_the_reference_ones() {
    let golden: Value = serde_json::from_str(include_str!("golden/posegraph.json")).unwrap();
    let n = golden["raw"].as_array().unwrap().len();
    let positions: Vec<_> = (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .collect();
    let scored = |&(i, j): &(usize, usize)| ScoredPair {
        i,
        j,
        raw_confidence: number(&golden["raw"][i][j]),
    };
    let confidences = PairConfidences::new(n, positions.iter().map(scored).collect()).unwrap();
    for (&(i, j), &confidence) in positions.iter().zip(confidences.normalized()) {
        let expected = number(&golden["normalized"][i][j]);
        assert_relative_eq!(confidence, expected, max_relative = 1e-9);
    }
    for (k, expected) in golden["top_k"].as_object().unwrap() {
        let params = PoseGraphParams {
            neighbors: k.parse().unwrap(),
        };
        let selected = confidences.top_k_union(&params).unwrap();
        let edges: Vec<_> = selected.iter().map(|&p| positions[p]).collect();
        let expected_edges: Vec<(usize, usize)> =
            serde_json::from_value(expected["edges"].clone()).unwrap();
        assert_eq!(edges, expected_edges);

        let components = Components::new(n, edges.iter().copied());
        let mut sizes: Vec<usize> = components.members().iter().map(Vec::len).collect();
        sizes.sort_unstable_by(|a, b| b.cmp(a));
        let expected_sizes: Vec<usize> =
            serde_json::from_value(expected["components"].clone()).unwrap();
        assert_eq!(sizes, expected_sizes);
        let figures = Connectivity::new(n, &edges, 0);
        assert_eq!(figures.num_components, sizes.len());
        assert_eq!(figures.largest_component_ratio, sizes[0] as f64 / n as f64);
    }
}
