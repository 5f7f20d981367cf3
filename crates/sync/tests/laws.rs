//! What holds for every pose graph.

#![allow(clippy::unwrap_used)]

mod common;

use gmpcr_posegraph::{PoseEdge, PoseGraph};
use gmpcr_sync::{
    EdgeResidual, Method, SyncParams, Synchronization, average_rotations, edge_residuals,
    solve_translations,
};
use nalgebra::{DMatrix, Isometry3, Rotation3, Vector3};
use proptest::prelude::*;

use common::{WeightedEnds, difference, error, measured, renumbered, scaled, scene};

const HISTORIES: [Method; 3] = [Method::Adaptive, Method::Sghr, Method::Memoryless];

fn params(method: Method) -> SyncParams {
    SyncParams {
        method,
        ..SyncParams::default()
    }
}

fn synchronize(graph: &PoseGraph, params: &SyncParams) -> Synchronization {
    gmpcr_sync::synchronize(graph, params).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn noise_free_measurements_give_the_exact_poses((poses, edges) in scene()) {
        for method in HISTORIES {
            let result = synchronize(&measured(&poses, &edges, 0.0), &params(method));
            prop_assert!(error(&result, &poses) < 1e-8, "{}", error(&result, &poses));
            for edge in &result.edges {
                prop_assert!(edge.rotation_residual.unwrap() < 1e-8);
                prop_assert!((edge.final_weight / edge.initial_weight - 1.0).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn reversing_edges_keeps_the_rotations((poses, edges) in scene(), reversed in any::<u32>()) {
        let graph = measured(&poses, &edges, 0.05);
        let flip = |(k, edge): (usize, &PoseEdge)| match reversed >> (k % 32) & 1 {
            1 => PoseEdge { i: edge.j, j: edge.i, i_from_j: edge.i_from_j.inverse(), weight: edge.weight },
            _ => *edge,
        };
        let flipped = graph.edges().iter().enumerate().map(flip).collect();
        let flipped = PoseGraph::new(graph.num_scans(), flipped).unwrap();
        let [a, b] = [&graph, &flipped].map(|graph| synchronize(graph, &SyncParams::default()));
        for (a, b) in a.world_from_scan.iter().zip(&b.world_from_scan) {
            prop_assert!(a.rotation.angle_to(&b.rotation) < 1e-6);
        }
    }

    #[test]
    fn permuting_the_scans_permutes_the_poses((poses, edges) in scene(), seed in any::<u32>()) {
        let graph = measured(&poses, &edges, 0.05);
        let (order, renamed) = renumbered(&graph, seed);
        let [a, b] = [&graph, &renamed].map(|graph| synchronize(graph, &SyncParams::default()).world_from_scan);
        let new_zero = a[order.iter().position(|&k| k == 0).unwrap()];
        for (k, &renamed) in order.iter().enumerate() {
            prop_assert!(difference(&new_zero.inv_mul(&a[k]), &b[renamed]) < 1e-6);
        }
    }

    #[test]
    fn the_scale_of_weights_and_lengths_does_not_matter((poses, edges) in scene(), scale in 1e-6..1e6f64) {
        let graph = measured(&poses, &edges, 0.05);
        let scaled = scaled(&graph, scale);
        let [a, b] = [&graph, &scaled].map(|graph| synchronize(graph, &SyncParams::default()));
        for (a, b) in a.world_from_scan.iter().zip(&b.world_from_scan) {
            prop_assert!(a.rotation.angle_to(&b.rotation) < 1e-6);
            let offset = a.translation.vector - b.translation.vector / scale;
            prop_assert!(offset.norm() < 1e-5, "{offset}");
        }
    }

    #[test]
    fn translations_are_those_of_the_dense_normal_equations((poses, edges) in scene()) {
        let graph = measured(&poses, &edges, 0.3);
        let rotations: Vec<_> = poses.iter().map(|pose| pose.rotation.to_rotation_matrix()).collect();
        let weights: Vec<f64> = graph.edges().iter().map(|edge| edge.weight).collect();
        let found = solve_translations(&graph, &rotations, &weights);
        prop_assert!(found.residual < 1e-9, "{}", found.residual);
        let found = found.positions;
        let mut design = DMatrix::zeros(edges.len(), poses.len() - 1);
        let mut right = DMatrix::zeros(edges.len(), 3);
        for (k, edge) in graph.edges().iter().enumerate() {
            let root = edge.weight.sqrt();
            let offset = rotations[edge.i] * edge.i_from_j.translation.vector * root;
            right.set_row(k, &offset.transpose());
            for (node, sign) in [(edge.i, -1.0), (edge.j, 1.0)] {
                if node > 0 {
                    design[(k, node - 1)] += sign * root;
                }
            }
        }
        let expected = design.svd(true, true).solve(&right, 1e-12).unwrap();
        for (node, expected) in expected.row_iter().enumerate() {
            prop_assert!((found[node + 1].transpose() - expected).norm() < 1e-8);
        }
    }

    #[test]
    fn the_spectral_rotations_minimize_the_relaxed_objective((poses, edges) in scene()) {
        // With small noise the relaxation is close to tight: no rotations nearby are much better.
        let graph = measured(&poses, &edges, 1e-3);
        let weights: Vec<f64> = graph.edges().iter().map(|edge| edge.weight).collect();
        let cost = |rotations: &[Rotation3<f64>]| -> f64 {
            graph.edges().iter().map(|edge| {
                let measured = edge.i_from_j.rotation.to_rotation_matrix();
                let estimated = rotations[edge.i].inverse() * rotations[edge.j];
                edge.weight * (measured.matrix() - estimated.matrix()).norm_squared()
            }).sum()
        };
        let averaged = average_rotations(&graph, &weights);
        let ground_truth: Vec<_> = poses.iter().map(|pose| pose.rotation.to_rotation_matrix()).collect();
        prop_assert!(cost(&averaged.world_from_scan) <= cost(&ground_truth) * 1.01 + 1e-12);
    }
}

/// A ring with chords: `n` scans, three edges each.
fn ring(n: usize) -> (Vec<Isometry3<f64>>, Vec<WeightedEnds>) {
    let pose = |k: usize| {
        let angle = k as f64 / n as f64 * std::f64::consts::TAU;
        Isometry3::new(
            Vector3::new(angle.cos(), angle.sin(), 0.1 * angle) * 10.0,
            Vector3::z() * angle,
        )
    };
    let edges = (0..n).flat_map(|i| [1, 2, 5].map(|step| (i, (i + step) % n, 1.0)));
    ((0..n).map(pose).collect(), edges.collect())
}

#[test]
fn outliers_lose_their_weight_and_the_rest_keeps_it() {
    let (poses, edges) = ring(40);
    for method in HISTORIES {
        let mut spoiled = measured(&poses, &edges, 0.0).edges().to_vec();
        for k in [3, 30, 57, 88, 101] {
            spoiled[k].i_from_j *= Isometry3::new(
                Vector3::new(3.0, -2.0, 1.0),
                Vector3::new(1.0, 0.3 * (k % 7) as f64, 0.5),
            );
        }
        let params = SyncParams {
            iterations: 40,
            ..params(method)
        };
        let result = synchronize(&PoseGraph::new(40, spoiled).unwrap(), &params);
        assert!(
            error(&result, &poses) < 0.05,
            "{method}: {}",
            error(&result, &poses)
        );
        for (k, edge) in result.edges.iter().enumerate() {
            let is_outlier = [3, 30, 57, 88, 101].contains(&k);
            assert_eq!(
                edge.final_weight < 0.1,
                is_outlier,
                "edge {k}: {}",
                edge.final_weight
            );
        }
    }
}

#[test]
fn components_are_synchronized_each_in_its_own_frame() {
    let (poses, edges) = ring(12);
    let mut all = measured(&poses, &edges, 0.0).edges().to_vec();
    let copied = all.clone().into_iter().map(|edge| PoseEdge {
        i: edge.i + 12,
        j: edge.j + 12,
        ..edge
    });
    all.extend(copied.collect::<Vec<_>>());
    // An edge without weight joins nothing.
    all.push(PoseEdge {
        i: 0,
        j: 12,
        i_from_j: Isometry3::identity(),
        weight: 0.0,
    });
    let result = synchronize(&PoseGraph::new(25, all).unwrap(), &SyncParams::default());
    let members = result.components.members();
    assert_eq!(members, [(0..12).collect(), (12..24).collect(), vec![24]]);
    for k in 0..12 {
        assert!(difference(&result.world_from_scan[k], &poses[0].inv_mul(&poses[k])) < 1e-10);
        assert!(difference(&result.world_from_scan[k + 12], &result.world_from_scan[k]) < 1e-10);
    }
    let joining = result.edges.last().unwrap();
    assert_eq!(
        (joining.final_weight, joining.rotation_residual),
        (0.0, None)
    );
    assert_eq!(result.reports.len(), 3);
}

#[test]
fn reports_hold_the_residuals_under_the_final_poses() {
    let (poses, edges) = ring(12);
    let graph = measured(&poses, &edges, 0.1);
    let result = synchronize(&graph, &SyncParams::default());
    let residuals = edge_residuals(&graph, &result.world_from_scan);
    assert!(residuals[0].rotation > 1e-3 && residuals[0].translation > 1e-3);
    for (edge, residual) in result.edges.iter().zip(&residuals) {
        assert_eq!(edge.rotation_residual, Some(residual.rotation));
        assert_eq!(edge.translation_residual, Some(residual.translation));
    }
    let exact = edge_residuals(&measured(&poses, &edges, 0.0), &poses);
    let largest = |residual: &EdgeResidual| residual.rotation.max(residual.translation);
    assert!(exact.iter().map(largest).all(|residual| residual < 1e-12));
}

#[test]
fn parameters_out_of_range_are_refused() {
    let params = SyncParams {
        residual_scale: 0.0,
        ..SyncParams::default()
    };
    let graph = PoseGraph::new(0, vec![]).unwrap();
    let error = gmpcr_sync::synchronize(&graph, &params).unwrap_err();
    assert_eq!(error.name, "residual_scale");
}

#[test]
fn graphs_without_edges_give_identities() {
    for n in 0..3 {
        let result = synchronize(&PoseGraph::new(n, vec![]).unwrap(), &SyncParams::default());
        assert_eq!(result.world_from_scan, vec![Isometry3::identity(); n]);
        assert_eq!(result.components.members().len(), n);
    }
}

#[test]
fn contradictory_and_repeated_edges_give_finite_poses() {
    let edge = |i, j, size: f64| PoseEdge {
        i,
        j,
        i_from_j: Isometry3::new(Vector3::x() * size, Vector3::z() * size),
        weight: 1.0,
    };
    let graph = PoseGraph::new(
        3,
        vec![
            edge(0, 1, 0.0),
            edge(0, 1, 3.1),
            edge(1, 0, 1.5),
            edge(1, 2, 0.2),
            edge(1, 2, -3.0),
        ],
    );
    let graph = graph.unwrap();
    for method in HISTORIES {
        for iterations in [0, 1, 10, 200] {
            let params = SyncParams {
                iterations,
                ..params(method)
            };
            let result = synchronize(&graph, &params);
            let is_finite = |pose: &Isometry3<f64>| pose.to_matrix().iter().all(|x| x.is_finite());
            assert!(result.world_from_scan.iter().all(is_finite));
        }
    }
}

#[test]
fn extreme_weights_and_lengths_change_nothing() {
    let (poses, edges) = ring(9);
    let graph = measured(&poses, &edges, 0.05);
    let plain = synchronize(&graph, &SyncParams::default());
    for (weight, length) in [
        (1e-300, 1.0),
        (1e-162, 1.0),
        (1e100, 1.0),
        (1.0, 1e95),
        (1.0, 1e-150),
    ] {
        let scaled = graph.edges().iter().map(|edge| {
            let mut edge = PoseEdge { weight, ..*edge };
            edge.i_from_j.translation.vector *= length;
            edge
        });
        let scaled = PoseGraph::new(9, scaled.collect()).unwrap();
        let result = synchronize(&scaled, &SyncParams::default());
        for (pose, expected) in result.world_from_scan.iter().zip(&plain.world_from_scan) {
            let angle = pose.rotation.angle_to(&expected.rotation);
            assert!(angle < 1e-8, "weight {weight}, length {length}: {angle}");
            let offset = pose.translation.vector / length - expected.translation.vector;
            assert!(
                offset.norm() < 1e-6,
                "weight {weight}, length {length}: {offset}"
            );
        }
    }
}

#[test]
fn a_weak_bridge_places_both_sides_exactly() {
    let (poses, edges) = ring(8);
    let ring_edges = measured(&poses, &edges, 0.0).edges().to_vec();
    for weight in [1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-16, 1e-100, 1e-300] {
        let mut all = ring_edges.clone();
        all.extend(ring_edges.iter().map(|edge| PoseEdge {
            i: edge.i + 8,
            j: edge.j + 8,
            ..*edge
        }));
        let bridge = Isometry3::translation(0.0, 0.0, 7.0);
        all.push(PoseEdge {
            i: 0,
            j: 8,
            i_from_j: bridge,
            weight,
        });
        let graph = PoseGraph::new(16, all).unwrap();
        let rotations: Vec<_> = [&poses[..], &poses[..]].concat();
        let rotations = rotations.iter().map(|pose| poses[0].inv_mul(pose));
        let rotations: Vec<_> = rotations
            .map(|pose| pose.rotation.to_rotation_matrix())
            .collect();
        let weights: Vec<f64> = graph.edges().iter().map(|edge| edge.weight).collect();
        let positions = solve_translations(&graph, &rotations, &weights).positions;
        for k in 0..8 {
            let expected = bridge * poses[0].inv_mul(&poses[k]);
            let error = (positions[k + 8] - expected.translation.vector).norm();
            assert!(error < 1e-10, "weight {weight}, node {k}: {error}");
        }
    }
}

#[test]
fn rotations_under_weights_of_many_decades_are_those_of_the_full_decomposition() {
    for seed in 0..20usize {
        let wave = |k: usize, f: f64| ((k + 7 * seed) as f64 * f).sin();
        let n = 11 + seed;
        let pose =
            |k: usize| Isometry3::rotation(Vector3::new(wave(k, 1.1), wave(k, 2.3), 0.5) * 2.0);
        let poses: Vec<_> = (0..n).map(pose).collect();
        let chords = (0..2 * n).map(|k| (k % n, (k * 7 + 3 + seed) % n));
        let ends = (1..n)
            .map(|k| (k - 1, k))
            .chain(chords)
            .filter(|(i, j)| i != j);
        let weight = |k: usize| 10f64.powf(4.0 * wave(k, 5.7) - 4.0);
        let ends: Vec<WeightedEnds> = ends
            .enumerate()
            .map(|(k, (i, j))| (i, j, weight(k)))
            .collect();
        let graph = measured(&poses, &ends, 0.3);
        let weights: Vec<f64> = graph.edges().iter().map(|edge| edge.weight).collect();
        let averaged = average_rotations(&graph, &weights);
        let expected = dense_average(&graph);
        for (a, b) in averaged.world_from_scan.iter().zip(&expected) {
            let angle = gmpcr_geometry::angular_distance(a, b);
            // What small gaps and blocks leave of the plain decomposition's own digits.
            let digits = 1e-6 + 1e-12 / averaged.weakest_block;
            assert!(angle < digits, "seed {seed}: {angle}");
        }
    }
}

/// Rotation averaging by a full eigendecomposition of the connection Laplacian.
fn dense_average(graph: &PoseGraph) -> Vec<Rotation3<f64>> {
    let n = graph.num_scans();
    let mut laplacian = DMatrix::<f64>::zeros(3 * n, 3 * n);
    for edge in graph.edges() {
        let rotation = edge.i_from_j.rotation.to_rotation_matrix();
        for axis in 0..3 {
            laplacian[(3 * edge.i + axis, 3 * edge.i + axis)] += edge.weight;
            laplacian[(3 * edge.j + axis, 3 * edge.j + axis)] += edge.weight;
            for other in 0..3 {
                let entry = edge.weight * rotation[(axis, other)];
                laplacian[(3 * edge.i + axis, 3 * edge.j + other)] -= entry;
                laplacian[(3 * edge.j + other, 3 * edge.i + axis)] -= entry;
            }
        }
    }
    let eigen = laplacian.symmetric_eigen();
    let mut order: Vec<usize> = (0..3 * n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let block = |node: usize| {
        let entry = |row, column| eigen.eigenvectors[(3 * node + row, order[column])];
        nalgebra::Matrix3::from_fn(entry)
    };
    let num_reflected = (0..n)
        .filter(|&node| block(node).determinant() < 0.0)
        .count();
    let sign = if 2 * num_reflected > n { -1.0 } else { 1.0 };
    let fix = nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign));
    let scan_from_world = |node| gmpcr_geometry::nearest_rotation(&(block(node) * fix));
    let reference = scan_from_world(0);
    (0..n)
        .map(|node| reference * scan_from_world(node).inverse())
        .collect()
}

#[test]
fn a_thousand_poses_are_exact() {
    let (poses, edges) = ring(1000);
    let result = synchronize(
        &measured(&poses, &edges, 0.0),
        &SyncParams {
            iterations: 2,
            ..SyncParams::default()
        },
    );
    assert!(error(&result, &poses) < 1e-6, "{}", error(&result, &poses));
    assert!(result.reports[0].eigen_residual < 1e-11);
    assert!(result.reports[0].position_residual < 1e-9);
}
