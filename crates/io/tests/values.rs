//! Values that leave the crate can go to other threads, and with the feature `serde` into files.
#![allow(clippy::unwrap_used)]

use gmpcr_io::*;

#[test]
fn values_may_go_to_other_threads() {
    fn check<T: Send + Sync>() {}
    check::<Error>();
    check::<G2o>();
    check::<G2oGraphError>();
    check::<G2oPoseGraph>();
    check::<NpyMatrix>();
    check::<Open3dPoseGraph>();
    check::<PointFile>();
    check::<PosedGraph>();
    check::<PosedGraphError>();
    check::<Scene>();
}

#[cfg(feature = "serde")]
mod serde {
    use super::*;
    use ::serde::Serialize;
    use ::serde::de::DeserializeOwned;
    use nalgebra::{Isometry3, Matrix6, Vector3};

    fn back<T: Serialize + DeserializeOwned>(value: &T) -> T {
        serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
    }

    fn pose() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, -0.5, 0.9))
    }

    fn assert_same(a: &Isometry3<f64>, b: &Isometry3<f64>) {
        assert_eq!(a.translation, b.translation);
        assert!(a.rotation.angle_to(&b.rotation) < 1e-14);
    }

    #[test]
    fn a_pose_graph_of_g2o_comes_back() {
        let information = Matrix6::from_fn(|row, column| (row * column) as f64 / 3.0);
        let graph = G2o {
            vertices: vec![G2oVertex {
                id: 3,
                world_from_vertex: pose(),
            }],
            edges: vec![G2oEdge {
                i: 3,
                j: 4,
                i_from_j: pose(),
                information,
            }],
        };
        let read = back(&graph);
        assert_same(&read.vertices[0].world_from_vertex, &pose());
        assert_same(&read.edges[0].i_from_j, &pose());
        assert_eq!(read.edges[0].information, information);
        assert_eq!(
            (read.vertices[0].id, read.edges[0].i, read.edges[0].j),
            (3, 3, 4)
        );
    }

    #[test]
    fn clouds_scenes_and_edges_come_back() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.xyz"), "0 0 1\n0 1 1\n").unwrap();
        let scans = read_scans(folder.path().join("a.xyz")).unwrap();
        assert_eq!(back(&scans), scans);
        assert_eq!(back(&scans[0].points), scans[0].points);
        let scene = Scene::of_clouds(folder.path()).unwrap();
        assert_eq!(back(&scene), scene);
        let edge = MeasuredEdge {
            i: 3,
            j: 4,
            i_from_j: pose(),
            information: Matrix6::identity() / 3.0,
        };
        let read = back(&edge);
        assert_same(&read.i_from_j, &pose());
        assert_eq!((read.i, read.j, read.information), (3, 4, edge.information));
    }

    #[test]
    fn a_pose_graph_of_open3d_comes_back() {
        let graph = Open3dPoseGraph {
            nodes: vec![Isometry3::identity(), pose()],
            edges: vec![Open3dEdge {
                source: 1,
                target: 0,
                target_from_source: pose(),
                information: Matrix6::identity() / 3.0,
                uncertain: true,
                confidence: 0.1,
            }],
        };
        let read = back(&graph);
        assert_same(&read.nodes[1], &pose());
        assert_same(&read.edges[0].target_from_source, &pose());
        assert_eq!(read.edges[0].information, graph.edges[0].information);
        assert_eq!((read.edges[0].source, read.edges[0].target), (1, 0));
        assert_eq!(
            (read.edges[0].uncertain, read.edges[0].confidence),
            (true, 0.1)
        );
    }

    #[test]
    fn what_is_read_of_a_benchmark_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let matrix = "1 0 0 0 0 0\n".repeat(6);
        let info = file("gt.info", &format!("0 1 2\n{matrix}"));
        let log = file("gt.log", "0 1 2\n1 0 0 7\n0 1 0 8\n0 0 1 9\n0 0 0 1\n");
        let list = PairList::read(&log).unwrap();
        assert_eq!(back(&list), list);
        let information = read_gt_info(&info).unwrap();
        assert_eq!(back(&information), information);
        let overlaps = read_overlaps(file("overlap.csv", "0,1,0.1\n")).unwrap();
        assert_eq!(back(&overlaps), overlaps);
        assert_eq!(back(&Layout::Eth), Layout::Eth);
        assert_eq!(back(&Coordinates::Double), Coordinates::Double);
    }
}
