//! What holds for every method of synchronization.

#![allow(clippy::unwrap_used)]

mod common;

use gmpcr_eval::{Gauge, PoseError, absolute_errors};
use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sim::{PoseGraphSimParams, SimulatedPoseGraph, simulate_pose_graph};
use gmpcr_sync::{AdaptiveHistory, Method, SyncParams, Synchronization};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use common::{WeightedEnds, difference, error, measured, renumbered, scaled, scene};

fn synchronize(graph: &PoseGraph, params: &SyncParams) -> Synchronization {
    gmpcr_sync::synchronize(graph, params).unwrap()
}

fn run(graph: &PoseGraph, method: Method) -> Synchronization {
    let params = SyncParams {
        method,
        ..SyncParams::default()
    };
    synchronize(graph, &params)
}

/// Finite poses, and weights in `[0, w⁰]` from the initial to the final one.
fn assert_sound(result: &Synchronization, what: &str) {
    let is_finite = |pose: &Isometry3<f64>| pose.to_matrix().iter().all(|x| x.is_finite());
    assert!(result.world_from_scan.iter().all(is_finite), "{what}");
    for edge in &result.edges {
        let range = 0.0..=edge.initial_weight;
        assert!(
            edge.weights.iter().all(|weight| range.contains(weight)),
            "{what}: {edge:?}"
        );
        assert_eq!(edge.weights.first(), Some(&edge.initial_weight), "{what}");
        assert_eq!(edge.weights.last(), Some(&edge.final_weight), "{what}");
    }
    if let [report] = &result.reports[..] {
        for edge in &result.edges {
            assert_eq!(edge.weights.len(), 1 + report.iterations.len(), "{what}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn noise_free_measurements_give_the_exact_poses((poses, ends) in scene()) {
        let graph = measured(&poses, &ends, 0.0);
        for &method in Method::ALL {
            let result = run(&graph, method);
            assert_sound(&result, method.name());
            let error = error(&result, &poses);
            prop_assert!(error < 1e-8, "{}: {error}", method.name());
            for edge in &result.edges {
                prop_assert!(edge.final_weight > 0.999 * edge.initial_weight, "{}", method.name());
            }
        }
    }

    #[test]
    fn permuting_the_scans_permutes_the_poses((poses, ends) in scene(), seed in any::<u32>()) {
        let graph = measured(&poses, &ends, 0.01);
        let (order, renamed) = renumbered(&graph, seed);
        for &method in Method::ALL {
            let [a, b] = [&graph, &renamed].map(|graph| run(graph, method).world_from_scan);
            let new_zero = a[order.iter().position(|&k| k == 0).unwrap()];
            for (k, &renamed) in order.iter().enumerate() {
                let difference = difference(&new_zero.inv_mul(&a[k]), &b[renamed]);
                prop_assert!(difference < 1e-4, "{}: {difference}", method.name());
            }
        }
    }

    #[test]
    fn the_scale_of_weights_and_lengths_does_not_matter((poses, ends) in scene(), scale in 1e-6..1e6f64) {
        let graph = measured(&poses, &ends, 0.02);
        let scaled = scaled(&graph, scale);
        for &method in Method::ALL {
            let [a, b] = [&graph, &scaled].map(|graph| run(graph, method).world_from_scan);
            for (a, b) in a.iter().zip(&b) {
                prop_assert!(a.rotation.angle_to(&b.rotation) < 1e-6, "{}", method.name());
                let offset = a.translation.vector - b.translation.vector / scale;
                prop_assert!(offset.norm() < 1e-5, "{}: {offset}", method.name());
            }
        }
    }
}

/// An edge with a rotation about z and a translation along x, both of this size.
fn edge_of_size(i: usize, j: usize, size: f64, weight: f64) -> PoseEdge {
    let i_from_j = Isometry3::new(Vector3::x() * size, Vector3::z() * size);
    PoseEdge {
        i,
        j,
        i_from_j,
        weight,
    }
}

#[test]
fn small_and_contradictory_graphs_give_finite_poses() {
    let pi = std::f64::consts::PI;
    let graphs = [
        ("one edge", 2, vec![edge_of_size(1, 0, 0.7, 2.0)]),
        ("an identity", 2, vec![edge_of_size(0, 1, 0.0, 1.0)]),
        (
            "edges without weight",
            4,
            vec![
                edge_of_size(0, 1, 0.3, 1.0),
                edge_of_size(0, 1, 3.0, 0.0),
                edge_of_size(1, 2, 1.0, 0.0),
                edge_of_size(3, 2, 1.0, 0.5),
            ],
        ),
        (
            "opposite edges",
            2,
            vec![edge_of_size(0, 1, 0.0, 1.0), edge_of_size(0, 1, pi, 1.0)],
        ),
        (
            "repeated and contradictory edges",
            3,
            vec![
                edge_of_size(0, 1, 0.0, 1.0),
                edge_of_size(0, 1, 3.1, 1.0),
                edge_of_size(1, 0, 1.5, 1.0),
                edge_of_size(1, 2, 0.2, 1.0),
                edge_of_size(1, 2, -3.0, 1.0),
            ],
        ),
        (
            "a triangle that does not close",
            3,
            vec![
                edge_of_size(0, 1, pi, 1.0),
                edge_of_size(1, 2, pi, 1.0),
                edge_of_size(2, 0, pi, 1.0),
            ],
        ),
        (
            "extreme weights",
            4,
            vec![
                edge_of_size(0, 1, 0.1, 1e-100),
                edge_of_size(1, 2, 0.2, 1e100),
                edge_of_size(0, 2, -2.0, 1e-100),
                edge_of_size(2, 3, 0.2, 1e-30),
                edge_of_size(3, 1, 1.2, 1.0),
            ],
        ),
    ];
    for (name, num_scans, edges) in graphs {
        let graph = PoseGraph::new(num_scans, edges).unwrap();
        for &method in Method::ALL {
            for iterations in [0, 1, 10, 100] {
                let params = SyncParams {
                    iterations,
                    method,
                    ..SyncParams::default()
                };
                let result = synchronize(&graph, &params);
                assert_sound(&result, &format!("{name}, {}", method.name()));
            }
        }
    }
}

#[test]
fn extreme_lengths_and_weights_change_nothing() {
    let (poses, ends) = ring(9);
    let graph = measured(&poses, &ends, 0.02);
    for &method in Method::ALL {
        let plain = run(&graph, method);
        for (weight, length) in [(1e-150, 1.0), (1e100, 1.0), (1.0, 1e90), (1.0, 1e-90)] {
            let scaled = graph.edges().iter().map(|edge| {
                let mut edge = PoseEdge { weight, ..*edge };
                edge.i_from_j.translation.vector *= length;
                edge
            });
            let scaled = PoseGraph::new(9, scaled.collect()).unwrap();
            let result = run(&scaled, method);
            for (pose, expected) in result.world_from_scan.iter().zip(&plain.world_from_scan) {
                let angle = pose.rotation.angle_to(&expected.rotation);
                let offset = pose.translation.vector / length - expected.translation.vector;
                let what = format!("{}, weight {weight}, length {length}", method.name());
                assert!(
                    angle < 1e-7 && offset.norm() < 1e-6,
                    "{what}: {angle}, {offset}"
                );
            }
        }
    }
}

#[test]
fn chains_and_separate_parts_are_exact() {
    let (poses, _) = ring(30);
    let chain = (1..20).map(|k| (k - 1, k, 1.0));
    let other = (21..30).map(|k| (k, k - 1, 0.3));
    let graph = measured(&poses, &chain.chain(other).collect::<Vec<_>>(), 0.0);
    for &method in Method::ALL {
        let result = run(&graph, method);
        assert_sound(&result, method.name());
        assert_eq!(result.reports.len(), 2);
        for (k, pose) in result.world_from_scan.iter().enumerate() {
            let root = if k < 20 { 0 } else { 20 };
            let error = difference(pose, &poses[root].inv_mul(&poses[k]));
            assert!(error < 1e-10, "{}: {error}", method.name());
        }
    }
}

/// A ring with chords: `n` scans a step of about 2 apart, three edges each.
fn ring(n: usize) -> (Vec<Isometry3<f64>>, Vec<WeightedEnds>) {
    let pose = |k: usize| {
        let angle = k as f64 / n as f64 * std::f64::consts::TAU;
        let position = Vector3::new(angle.cos(), angle.sin(), 0.1 * angle) * (n as f64 / 3.0);
        Isometry3::new(position, Vector3::new(0.3, 0.1, 1.0) * angle)
    };
    let ends = (0..n).flat_map(|i| [1, 2, 5].map(|step| (i, (i + step) % n, 1.0)));
    ((0..n).map(pose).collect(), ends.collect())
}

#[test]
fn two_thousand_poses_are_exact() {
    let (poses, ends) = ring(2000);
    let graph = measured(&poses, &ends, 0.0);
    for &method in Method::ALL {
        let params = SyncParams {
            iterations: 2,
            method,
            ..SyncParams::default()
        };
        let error = error(&synchronize(&graph, &params), &poses);
        assert!(error < 1e-6, "{}: {error}", method.name());
    }
}

/// The factors of such a graph would fill up, so that it is solved without.
#[test]
fn a_large_graph_joined_at_random_is_exact() {
    let (poses, graph) = simulated(&PoseGraphSimParams {
        num_scans: 4000,
        degree: 8.0,
        rotation_noise: 0.0,
        translation_noise: 0.0,
        ..PoseGraphSimParams::default()
    });
    for name in ["adaptive", "l1", "consensus"] {
        let params = SyncParams {
            iterations: 1,
            method: name.parse().unwrap(),
            ..SyncParams::default()
        };
        let result = synchronize(&graph, &params);
        assert!(result.reports[0].eigen_residual < 1e-11, "{name}");
        assert!(result.reports[0].position_residual < 1e-9, "{name}");
        let error = error(&result, &poses);
        assert!(error < 1e-6, "{name}: {error}");
    }
}

#[test]
fn no_recovery_is_the_adaptive_history_with_a_recovery_of_zero() {
    let (_, graph) = random_graph(0.2, 3);
    let with = |method, recovery| {
        let params = SyncParams {
            method,
            history: AdaptiveHistory {
                recovery,
                ..AdaptiveHistory::default()
            },
            ..SyncParams::default()
        };
        synchronize(&graph, &params).edges
    };
    let expected = with(Method::Adaptive, 0.0);
    assert_eq!(with(Method::NoRecovery, 0.5), expected);
    assert_ne!(with(Method::Adaptive, 0.5), expected);
}

/// 50 scans, ten edges at each, noise of 2° and 5 cm, and a ratio of uniformly random edges.
fn random_graph(outlier_ratio: f64, seed: u64) -> (Vec<Isometry3<f64>>, PoseGraph) {
    simulated(&PoseGraphSimParams {
        seed,
        outlier_ratio,
        ..PoseGraphSimParams::default()
    })
}

fn simulated(params: &PoseGraphSimParams) -> (Vec<Isometry3<f64>>, PoseGraph) {
    let SimulatedPoseGraph {
        world_from_scan,
        edges,
    } = simulate_pose_graph(params).unwrap();
    let edges = edges.iter().map(|edge| PoseEdge {
        i: edge.i,
        j: edge.j,
        i_from_j: edge.i_from_j,
        weight: edge.weight,
    });
    let graph = PoseGraph::new(world_from_scan.len(), edges.collect()).unwrap();
    (world_from_scan, graph)
}

/// Mean rotation error in degrees after the ℓ₁ alignment of all scans.
fn mean_rotation_error(result: &Synchronization, poses: &[Isometry3<f64>]) -> f64 {
    let errors = absolute_errors(&result.world_from_scan, poses, Gauge::LeastAbsolute).unwrap();
    let degrees = errors.iter().map(PoseError::rotation_degrees);
    degrees.sum::<f64>() / poses.len() as f64
}

/// The mean over eight graphs.
fn error_at(outliers: f64, method: Method) -> f64 {
    let errors = (0..8).map(|seed| {
        let (poses, graph) = random_graph(outliers, seed);
        let result = run(&graph, method);
        assert_sound(&result, method.name());
        mean_rotation_error(&result, &poses)
    });
    errors.sum::<f64>() / 8.0
}

#[test]
fn robust_methods_withstand_random_edges() {
    for &method in Method::ALL
        .iter()
        .filter(|&&method| method != Method::EigSe3)
    {
        let is_consensus = method == Method::Consensus;
        let limits = if is_consensus {
            [0.8, 1.2, 4.9]
        } else {
            [1.7, 2.2, 13.0]
        };
        for (outliers, limit) in [0.0, 0.2, 0.4].into_iter().zip(limits) {
            let error = error_at(outliers, method);
            println!("{} at {outliers}: {error:.2}°", method.name());
            assert!(
                error < limit,
                "{} at {outliers}: {error:.2}°",
                method.name()
            );
        }
    }
}

/// Averages of rotations alone are 1.2° off where maximum likelihood is 0.6° off.
#[test]
fn consensus_draws_on_the_translations_for_its_rotations() {
    for (outliers, limit) in [(0.0, 0.7), (0.2, 0.85)] {
        let error = error_at(outliers, Method::Consensus);
        assert!(error < limit, "{outliers}: {error:.2}°");
    }
}

#[test]
fn trusting_all_edges_degrades_with_random_ones() {
    let [clean, few, many] = [0.0, 0.2, 0.4].map(|outliers| error_at(outliers, Method::EigSe3));
    println!("eigse3: {clean:.2}°, {few:.2}°, {many:.2}°");
    assert!(clean < 1.5 && few > 3.0 * clean && many > few);
    assert!(few < 15.0 && many < 45.0);
}
