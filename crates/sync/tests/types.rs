//! What users may rely on of the public types.

use gmpcr_sync::{
    AdaptiveHistory, AveragedRotations, EdgeResidual, InvalidParameter, Method, SolvedTranslations,
    SyncParams, Synchronization, UnknownMethod,
};

#[test]
fn types_may_go_from_thread_to_thread() {
    fn check<T: Send + Sync>() {}
    check::<(SyncParams, AdaptiveHistory, Method)>();
    check::<(Synchronization, EdgeResidual)>();
    check::<(AveragedRotations, SolvedTranslations)>();
    check::<(InvalidParameter, UnknownMethod)>();
}

#[cfg(feature = "serde")]
mod files {
    #![allow(clippy::unwrap_used)]

    use gmpcr_posegraph::{PoseEdge, PoseGraph};
    use gmpcr_sync::{average_rotations, edge_residuals, solve_translations, synchronize};
    use nalgebra::{Isometry3, Rotation3};
    use serde::{Serialize, de::DeserializeOwned};

    use super::*;

    fn read_back<T: Serialize + DeserializeOwned>(value: &T) -> T {
        serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
    }

    #[test]
    fn a_part_of_the_parameters_is_enough_and_unknown_ones_are_refused() {
        let text = r#"{ "method": "no-recovery", "history": { "max_memory": 0.5 } }"#;
        let params: SyncParams = serde_json::from_str(text).unwrap();
        let history = AdaptiveHistory {
            max_memory: 0.5,
            ..AdaptiveHistory::default()
        };
        let expected = SyncParams {
            method: Method::NoRecovery,
            history,
            ..SyncParams::default()
        };
        assert_eq!(params, expected);
        for wrong in [
            r#"{ "method": "best" }"#,
            r#"{ "history": { "memory": 0.5 } }"#,
            r#"{ "iteration": 3 }"#,
        ] {
            assert!(
                serde_json::from_str::<SyncParams>(wrong).is_err(),
                "{wrong}"
            );
        }
        for method in Method::ALL {
            assert_eq!(read_back(method), *method);
        }
    }

    #[test]
    fn results_survive_a_file() {
        let edge = |i, j| PoseEdge {
            i,
            j,
            i_from_j: Isometry3::translation(0.5, 2.0, -1.0),
            weight: 1.0,
        };
        let graph = PoseGraph::new(4, vec![edge(0, 1), edge(1, 2)]).unwrap();
        let result = synchronize(&graph, &SyncParams::default()).unwrap();
        let read = read_back(&result);
        assert_eq!(read.components, result.components);
        assert_eq!(read.reports[0].iterations.len(), 10);
        for (a, b) in read.edges.iter().zip(&result.edges) {
            assert_eq!(a.weights.len(), b.weights.len());
            assert!((a.final_weight - b.final_weight).abs() < 1e-12);
        }
        for (a, b) in read.world_from_scan.iter().zip(&result.world_from_scan) {
            assert!((a.to_matrix() - b.to_matrix()).norm() < 1e-12);
        }
        let residuals = edge_residuals(&graph, &result.world_from_scan);
        assert_eq!(read_back(&residuals).len(), residuals.len());

        let graph = PoseGraph::new(3, graph.into_edges()).unwrap();
        let averaged = average_rotations(&graph, &[1.0; 2]);
        for (a, b) in read_back(&averaged)
            .world_from_scan
            .iter()
            .zip(&averaged.world_from_scan)
        {
            assert!((a.matrix() - b.matrix()).norm() < 1e-12);
        }
        let solved = solve_translations(&graph, &[Rotation3::identity(); 3], &[1.0; 2]);
        let read = read_back(&solved);
        assert!((read.positions[2] - solved.positions[2]).norm() < 1e-12);
    }
}
