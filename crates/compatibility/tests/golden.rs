//! Reference values of the stage, computed in float64 straight from the equations.

#![allow(clippy::unwrap_used)]

use approx::assert_relative_eq;
use gmpcr_compatibility::{
    CompatibilityGraph, CompatibilityParams, DominantEigenpair, SpectralFilter,
};
use gmpcr_geometry::PointPairs;
use nalgebra::{DVector, Point3};
use serde_json::Value;

fn cases() -> Vec<Value> {
    let golden: Value = serde_json::from_str(include_str!("golden/pairwise.json")).unwrap();
    golden["cases"].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|v| v.as_f64().unwrap()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn pairs(case: &Value) -> PointPairs {
    let points = |key: &str| {
        let rows = case[key].as_array().unwrap().iter();
        rows.map(|row| Point3::from_slice(&numbers(row))).collect()
    };
    PointPairs::new(points("points_i"), points("points_j")).unwrap()
}

#[test]
fn graphs_and_their_eigenvector_are_the_reference_ones() {
    for case in cases() {
        let graph = CompatibilityGraph::new(&pairs(&case), number(&case["tau_c"]));
        let row = |matrix: &nalgebra::DMatrix<f64>| matrix.row(0).transpose();
        let expected = |key: &str| DVector::from_vec(numbers(&case[key]));
        assert_relative_eq!(row(graph.fcg()), expected("fcg_row0"), epsilon = 1e-9);
        assert_relative_eq!(row(graph.scg()), expected("scg_row0"), epsilon = 1e-9);
        assert_relative_eq!(
            graph.fcg().sum(),
            number(&case["fcg_sum"]),
            max_relative = 1e-9
        );
        assert_relative_eq!(
            graph.scg().sum(),
            number(&case["scg_sum"]),
            max_relative = 1e-9
        );

        let dominant = DominantEigenpair::new(graph.scg());
        let eigenvalue = number(&case["first_eigenvalue"]);
        assert_relative_eq!(dominant.value, eigenvalue, max_relative = 1e-9);
        assert_relative_eq!(
            dominant.vector,
            expected("first_eigenvector_abs"),
            epsilon = 1e-9
        );
    }
}

/// Correspondences without second-order support have exactly zero response. Which of them fill up
/// the retained set is a matter of the tie rule (lower index); the third case's reference leaves
/// it to the rounding noise (1e-23, 1e-26) of its eigensolver. They support nobody, so that all
/// other values agree.
#[test]
fn the_filter_retains_the_reference_set_up_to_correspondences_without_support() {
    for case in cases() {
        let params = CompatibilityParams {
            tolerance: number(&case["tau_c"]),
            retained_fraction: number(&case["r_s"]),
        };
        let filter = SpectralFilter::new(&pairs(&case), &params).unwrap();
        let response = numbers(&case["first_eigenvector_abs"]);
        let expected: Vec<usize> = numbers(&case["retained"])
            .iter()
            .map(|&k| k as usize)
            .collect();
        let supported = |set: &[usize]| -> Vec<usize> {
            set.iter()
                .copied()
                .filter(|&k| response[k] > 1e-12)
                .collect()
        };
        assert_eq!(filter.retained.len(), expected.len());
        assert_eq!(supported(&filter.retained), supported(&expected));

        let sum = filter.graph.scg().sum();
        assert_relative_eq!(sum, number(&case["refined_scg_sum"]), max_relative = 1e-9);
        let confidence = number(&case["raw_confidence"]);
        assert_relative_eq!(filter.raw_confidence(), confidence, max_relative = 1e-9);
        let refined = numbers(&case["refined_eigenvector_abs"]);
        for (index, entry) in expected.iter().zip(refined) {
            let position = filter.retained.iter().position(|k| k == index);
            let ours = position.map_or(0.0, |position| filter.dominant.vector[position]);
            assert_relative_eq!(ours, entry, epsilon = 1e-9);
        }
    }
}
