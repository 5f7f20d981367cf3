//! Reference values of the stage, computed in float64 straight from the equations.

#![allow(clippy::unwrap_used, clippy::panic)]

use approx::assert_relative_eq;
use gmpcr_geometry::isometry;
use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sync::{AdaptiveHistory, Method, SyncParams, synchronize};
use nalgebra::{DVector, Isometry3, Matrix3x4, Rotation3, Vector3};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    let entries = value.as_array().unwrap().iter();
    entries.map(|v| v.as_f64().unwrap()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn pose(rows: &Value) -> Isometry3<f64> {
    let entries: Vec<f64> = rows.as_array().unwrap().iter().flat_map(numbers).collect();
    let matrix = Matrix3x4::from_row_slice(&entries);
    let rotation = Rotation3::from_matrix_unchecked(matrix.fixed_view::<3, 3>(0, 0).into());
    isometry(&rotation, &matrix.column(3).into())
}

fn graph(case: &Value) -> PoseGraph {
    let edges = case["edges"].as_array().unwrap().iter();
    let relative_poses = case["relative"].as_array().unwrap().iter().map(pose);
    let weights = numbers(&case["initial_weights"]);
    let edge = |((ends, i_from_j), weight): ((&Value, _), f64)| PoseEdge {
        i: number(&ends[0]) as usize,
        j: number(&ends[1]) as usize,
        i_from_j,
        weight,
    };
    let edges = edges.zip(relative_poses).zip(weights).map(edge).collect();
    PoseGraph::new(number(&case["n"]) as usize, edges).unwrap()
}

fn params(case: &Value) -> SyncParams {
    let params = &case["params"];
    let history = AdaptiveHistory {
        min_memory: number(&params["lambda_min"]),
        max_memory: number(&params["lambda_max"]),
        sensitivity: number(&params["kappa"]),
        recovery: number(&params["rho"]),
    };
    SyncParams {
        iterations: number(&params["iterations"]) as usize,
        residual_scale: number(&params["residual_scale_deg"]).to_radians(),
        method: match params["history"].as_str().unwrap() {
            "adaptive" => Method::Adaptive,
            "sghr" => Method::Sghr,
            other => panic!("unknown history {other}"),
        },
        history,
    }
}

#[test]
fn weights_errors_and_poses_are_the_reference_ones() {
    let golden: Value = serde_json::from_str(include_str!("golden/sync.json")).unwrap();
    for case in golden["cases"].as_array().unwrap() {
        let result = synchronize(&graph(case), &params(case)).unwrap();
        assert!(result.reports[0].rotations_converged());
        let trace = case["trace"].as_array().unwrap();
        assert_eq!(result.reports[0].iterations.len(), trace.len());
        for (iteration, expected) in result.reports[0].iterations.iter().zip(trace) {
            let error = number(&expected["weighted_error"]);
            assert_relative_eq!(
                iteration.weighted_error,
                error,
                epsilon = 1e-9,
                max_relative = 1e-9
            );
        }
        let of_trace = trace.iter().map(|step| numbers(&step["weights_after"]));
        let courses: Vec<_> = [numbers(&case["initial_weights"])]
            .into_iter()
            .chain(of_trace)
            .chain([numbers(&case["final_weights"])])
            .collect();
        for (k, edge) in result.edges.iter().enumerate() {
            let found = edge.weights.iter().chain([&edge.final_weight]);
            let expected: Vec<f64> = courses.iter().map(|weights| weights[k]).collect();
            assert_relative_eq!(
                DVector::from_iterator(expected.len(), found.copied()),
                DVector::from_column_slice(&expected),
                epsilon = 1e-9,
                max_relative = 1e-9
            );
        }
        let poses = case["poses"].as_array().unwrap().iter().map(pose);
        for (pose, expected) in result.world_from_scan.iter().zip(poses) {
            assert_relative_eq!(pose.to_matrix(), expected.to_matrix(), epsilon = 1e-9);
        }
        assert_eq!(
            result.world_from_scan[0].translation.vector,
            Vector3::zeros()
        );
    }
}
