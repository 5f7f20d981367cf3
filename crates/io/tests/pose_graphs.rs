//! Laws of the conversions between pose graphs and their files.
#![allow(clippy::unwrap_used)]

use gmpcr_io::*;
use gmpcr_posegraph::Components;
use nalgebra::{Isometry3, Matrix6, Quaternion, Translation3, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    let translation = prop::array::uniform3(-10.0..10.0f64);
    let quaternion = prop::array::uniform4(-1.0..1.0f64);
    (translation, quaternion)
        .prop_filter("a direction", |(_, q)| q.iter().any(|c| c.abs() > 0.1))
        .prop_map(|([x, y, z], [a, b, c, d])| {
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(a, b, c, d));
            Isometry3::from_parts(Translation3::new(x, y, z), rotation)
        })
}

/// Symmetric positive definite.
fn information() -> impl Strategy<Value = Matrix6<f64>> {
    prop::collection::vec(-3.0..3.0f64, 36).prop_map(|entries| {
        let root = Matrix6::from_iterator(entries);
        let square = root * root.transpose() + Matrix6::identity();
        (square + square.transpose()) / 2.0
    })
}

/// Scans 1, 4, 7, … with poses, and edges between some of them.
fn posed_graph() -> impl Strategy<Value = PosedGraph> {
    let ends = (0usize..5, 1usize..5);
    let edges = prop::collection::vec((ends, pose(), information()), 1..8);
    (prop::collection::vec(pose(), 5), edges).prop_map(|(poses, edges)| {
        let poses = poses.into_iter().enumerate();
        let edge = |((i, step), i_from_j, information): ((usize, usize), _, _)| MeasuredEdge {
            i: 3 * i + 1,
            j: 3 * ((i + step) % 5) + 1,
            i_from_j,
            information,
        };
        let edges = edges.into_iter().map(edge).collect();
        PosedGraph::new(poses.map(|(k, pose)| (3 * k + 1, pose)).collect(), edges).unwrap()
    })
}

fn error(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let difference = a.inv_mul(b);
    difference.translation.vector.norm() + difference.rotation.angle()
}

fn cost(information: &Matrix6<f64>, error: &Vector6<f64>) -> f64 {
    (error.transpose() * information * error)[(0, 0)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_graph_for_g2o_comes_back_as_the_pose_graph(graph in posed_graph()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.g2o");
        let file = graph.to_g2o();
        write_g2o(&path, &file).unwrap();
        let read = G2oPoseGraph::new(&read_g2o(&path).unwrap()).unwrap();

        prop_assert_eq!(&read.ids, &[1, 4, 7, 10, 13]);
        let certainty = |edge: &G2oEdge| edge.information.fixed_view::<3, 3>(3, 3).trace();
        let largest = file.edges.iter().map(certainty).fold(0.0, f64::max);
        for (written, edge) in file.edges.iter().zip(read.graph.edges()) {
            prop_assert_eq!((read.ids[edge.i], read.ids[edge.j]), (written.i, written.j));
            prop_assert_eq!(edge.i_from_j, written.i_from_j);
            prop_assert_eq!(edge.weight, certainty(written) / largest);
        }
        // The poses of the file lead back to the file.
        let poses: Vec<_> = read.initial_poses.iter().map(|pose| pose.unwrap()).collect();
        let ends = read.graph.edges().iter().map(|edge| (edge.i, edge.j));
        let components = Components::new(5, ends);
        let solved = read.solved(&poses, &components);
        prop_assert_eq!(&solved.edges, &file.edges);
        for (a, b) in solved.vertices.iter().zip(&file.vertices) {
            prop_assert_eq!(a.id, b.id);
            prop_assert!(error(&a.world_from_vertex, &b.world_from_vertex) < 1e-12);
        }
    }

    #[test]
    fn a_change_of_the_world_does_not_change_the_solved_file(graph in posed_graph(), gauge in pose()) {
        let read = G2oPoseGraph::new(&graph.to_g2o()).unwrap();
        let ends = read.graph.edges().iter().map(|edge| (edge.i, edge.j));
        let components = Components::new(5, ends);
        let poses: Vec<_> = (0..5).map(|k| Isometry3::translation(f64::from(k), 0.0, 1.0)).collect();
        let moved: Vec<_> = poses.iter().map(|pose| gauge * pose).collect();
        let (plain, moved) = (read.solved(&poses, &components), read.solved(&moved, &components));
        for (a, b) in plain.vertices.iter().zip(&moved.vertices) {
            prop_assert!(error(&a.world_from_vertex, &b.world_from_vertex) < 1e-12);
        }
        for nodes in components.members() {
            let first = nodes[0];
            let kept = plain.vertices[first].world_from_vertex;
            prop_assert!(error(&kept, &read.initial_poses[first].unwrap()) < 1e-12);
        }
    }

    /// The cost of a small error in each program is that of the edge.
    #[test]
    fn programs_give_an_error_the_cost_that_the_edge_gives_it(
        i_from_j in pose(), information in information(), direction in prop::array::uniform6(-1.0..1.0f64),
    ) {
        let x: Vector6<f64> = 1e-4 * Vector6::from(direction);
        let [translation, rotation]: [Vector3<f64>; 2] = [x.fixed_rows::<3>(0).into(), x.fixed_rows::<3>(3).into()];
        let edge = MeasuredEdge { i: 0, j: 1, i_from_j, information };
        let poses = vec![(0, Isometry3::identity()), (1, i_from_j * Isometry3::new(translation, rotation))];
        let graph = PosedGraph::new(poses, vec![edge]).unwrap();
        let expected = cost(&information, &x);

        // g2o: translation and quaternion of measured⁻¹ * estimated.
        let g2o = graph.to_g2o();
        let estimated = g2o.vertices[0].world_from_vertex.inv_mul(&g2o.vertices[1].world_from_vertex);
        let error = g2o.edges[0].i_from_j.inv_mul(&estimated);
        let (t, q) = (error.translation.vector, error.rotation.imag());
        let found = cost(&g2o.edges[0].information, &Vector6::new(t.x, t.y, t.z, q.x, q.y, q.z));
        prop_assert!((found - expected).abs() <= 1e-6 * expected + 1e-16, "{} {}", found, expected);

        // Open3D: angles and translation of X⁻¹ * target⁻¹ * source.
        let open3d = graph.to_open3d();
        let edge = &open3d.edges[0];
        let estimated = open3d.nodes[edge.target].inv_mul(&open3d.nodes[edge.source]);
        let error = edge.target_from_source.inv_mul(&estimated);
        let (t, r) = (error.translation.vector, error.rotation.scaled_axis());
        let found = cost(&edge.information, &Vector6::new(r.x, r.y, r.z, t.x, t.y, t.z));
        prop_assert!((found - expected).abs() <= 1e-6 * expected + 1e-16, "{} {}", found, expected);
    }

    #[test]
    fn diagonal_information_is_scaled_without_rounding(
        t in 1e-3..1e6f64, r in 1e-3..1e6f64, weight in 1e-6..1.0f64,
    ) {
        let diagonal = |a: f64, b: f64| Matrix6::from_diagonal(&Vector6::new(a, a, a, b, b, b));
        let edge = MeasuredEdge {
            i: 0,
            j: 1,
            i_from_j: Isometry3::identity(),
            information: diagonal(t, r) * weight,
        };
        let poses = vec![(0, Isometry3::identity()), (1, Isometry3::identity())];
        let graph = PosedGraph::new(poses, vec![edge]).unwrap();
        prop_assert_eq!(graph.to_g2o().edges[0].information, diagonal(t, 4.0 * r) * weight);
        prop_assert_eq!(graph.to_open3d().edges[0].information, diagonal(r, t) * weight);
    }
}

#[test]
fn a_graph_for_open3d_comes_back() {
    let edge = MeasuredEdge {
        i: 8,
        j: 3,
        i_from_j: Isometry3::translation(-1.0, 0.0, 0.5),
        information: Matrix6::identity(),
    };
    let poses = [3, 8].map(|scan| (scan, Isometry3::translation(scan as f64, 0.0, 0.0)));
    let graph = PosedGraph::new(poses.to_vec(), vec![edge])
        .unwrap()
        .to_open3d();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.json");
    write_open3d_pose_graph(&path, &graph).unwrap();
    assert_eq!(read_open3d_pose_graph(&path).unwrap(), graph);
}
