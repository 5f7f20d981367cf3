//! Reference values of the stage, computed in float64 straight from the equations.

use approx::assert_relative_eq;
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use serde_json::Value;

use crate::ranking::rank_cliques;
use crate::{BitGraph, CliqueParams, PointPairs, inlier_ratio, kabsch};

fn cases() -> Vec<Value> {
    let golden: Value =
        serde_json::from_str(include_str!("../tests/golden/pairwise.json")).unwrap();
    golden["cases"].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|v| v.as_f64().unwrap()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn indices(value: &Value) -> Vec<usize> {
    numbers(value).iter().map(|&k| k as usize).collect()
}

fn matrix(value: &Value) -> Matrix3<f64> {
    let entries: Vec<f64> = value.as_array().unwrap().iter().flat_map(numbers).collect();
    Matrix3::from_row_slice(&entries)
}

/// The correspondences that the reference retained.
fn retained_pairs(case: &Value) -> PointPairs {
    let points = |key: &str| {
        let rows = case[key].as_array().unwrap().iter();
        rows.map(|row| Point3::from_slice(&numbers(row))).collect()
    };
    let all = PointPairs::new(points("points_i"), points("points_j")).unwrap();
    all.select(&indices(&case["retained"]))
}

/// `B̃ = Ã² ∘ Ã` by its definition.
fn second_order(pairs: &PointPairs, tolerance: f64) -> DMatrix<f64> {
    let fcg = DMatrix::from_fn(pairs.len(), pairs.len(), |m, n| {
        let target = (pairs.target()[m] - pairs.target()[n]).norm();
        let source = (pairs.source()[m] - pairs.source()[n]).norm();
        let affinity = 1.0 - ((target - source) / tolerance).powi(2);
        if m == n { 0.0 } else { affinity.max(0.0) }
    });
    (&fcg * &fcg).component_mul(&fcg)
}

#[test]
fn cliques_transformations_and_support_are_the_reference_ones() {
    for case in cases() {
        let pairs = retained_pairs(&case);
        let scg = second_order(&pairs, number(&case["tau_c"]));
        let graph = BitGraph::from_edges(pairs.len(), |m, n| scg[(m, n)] > 0.0);
        let max_cliques = number(&case["k_c"]) as usize;
        let params = CliqueParams {
            max_cliques,
            ..Default::default()
        };
        let ranked = rank_cliques(&graph, &scg, &params);
        let num_cliques = number(&case["n_maximal_cliques_ge3"]) as usize;
        assert_eq!(ranked.enumeration.cliques, num_cliques);

        let response = numbers(&case["refined_eigenvector_abs"]);
        let hypotheses = case["hypotheses"].as_array().unwrap();
        assert_eq!(ranked.best.len(), hypotheses.len());
        for (clique, expected) in ranked.best.iter().zip(hypotheses) {
            assert_eq!(clique.nodes, indices(&expected["clique"]));
            let affinity = number(&expected["mean_affinity"]);
            assert_relative_eq!(clique.mean_affinity, affinity, max_relative = 1e-9);

            let weights: Vec<f64> = clique.nodes.iter().map(|&m| response[m]).collect();
            let transformation = kabsch(&pairs.select(&clique.nodes), Some(&weights)).unwrap();
            let rotation = transformation.rotation.to_rotation_matrix();
            assert_relative_eq!(
                rotation.matrix(),
                &matrix(&expected["rotation"]),
                epsilon = 1e-9
            );
            let translation = Vector3::from_vec(numbers(&expected["translation"]));
            assert_relative_eq!(
                transformation.translation.vector,
                translation,
                epsilon = 1e-9
            );
            let support = inlier_ratio(&pairs, &transformation, number(&case["tau_in"]));
            assert_relative_eq!(support, number(&expected["inlier_ratio"]), epsilon = 1e-12);
        }
    }
}
