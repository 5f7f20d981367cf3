//! What users of the types rely on beside the numbers.

use gmpcr_cliques::{
    BitGraph, CliqueParams, Compatibility, Degenerate, Enumeration, PointPairs, PoseEstimate,
    RankedClique, RelativePose, estimate_pose,
};
use nalgebra::{DMatrix, DVector};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<BitGraph>();
    check::<CliqueParams>();
    check::<Compatibility<'static>>();
    check::<Degenerate>();
    check::<Enumeration>();
    check::<PoseEstimate>();
    check::<RankedClique>();
    check::<RelativePose>();
}

#[test]
fn every_parameter_out_of_range_is_named() {
    type Spoil = fn(&mut CliqueParams);
    let cases: [(&str, Spoil); 7] = [
        ("max_cliques", |p| p.max_cliques = 0),
        ("inlier_threshold", |p| p.inlier_threshold = f64::INFINITY),
        ("inlier_threshold", |p| p.inlier_threshold = 0.0),
        ("min_affinity", |p| p.min_affinity = 1.0),
        ("min_affinity", |p| p.min_affinity = -0.1),
        ("min_affinity", |p| p.min_affinity = f64::NAN),
        ("work_budget", |p| p.work_budget = 0),
    ];
    let (graph, response) = (DMatrix::zeros(0, 0), DVector::zeros(0));
    let compatibility = Compatibility {
        fcg: &graph,
        scg: &graph,
        response: &response,
    };
    for (name, spoil) in cases {
        let mut params = CliqueParams::default();
        assert_eq!(params.validate(), Ok(()));
        spoil(&mut params);
        assert_eq!(params.validate().unwrap_err().name, name);
        let error = estimate_pose(&PointPairs::default(), compatibility, &params).unwrap_err();
        assert_eq!(error.name, name);
    }
}

#[cfg(feature = "serde")]
mod files {
    use nalgebra::{Isometry3, Point3, Vector3};
    use serde_json::{from_value, json, to_value};

    use super::*;

    #[test]
    fn an_estimate_comes_back_as_it_was() {
        let pose = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.7, -0.3));
        let source: Vec<_> = (0..5)
            .map(f64::from)
            .map(|k| Point3::new(k, k * k, k.sin()))
            .collect();
        let target = source.iter().map(|point| pose * point).collect();
        let pairs = PointPairs::new(target, source).unwrap();
        let complete = DMatrix::from_fn(5, 5, |m, n| if m == n { 0.0 } else { 1.0 });
        let response = DVector::repeat(5, 0.5);
        let compatibility = Compatibility {
            fcg: &complete,
            scg: &complete,
            response: &response,
        };
        let params = CliqueParams {
            max_cliques: 3,
            ..Default::default()
        };
        let estimate = estimate_pose(&pairs, compatibility, &params).unwrap();

        let written = to_value((&estimate, &params)).unwrap();
        let (read, read_params): (PoseEstimate, CliqueParams) =
            from_value(written.clone()).unwrap();
        assert_eq!(read_params, params);
        // A rotation goes through a file as a matrix, so its quaternion may differ by rounding.
        let [found, read] = [&estimate, &read].map(|estimate| estimate.pose.clone().unwrap());
        let difference = found.target_from_source.to_matrix() - read.target_from_source.to_matrix();
        assert!(difference.norm() < 1e-14);
        assert_eq!(
            (found.inlier_ratio, found.clique),
            (read.inlier_ratio, read.clique)
        );
        assert_eq!(
            written[0]["pose"]["target_from_source"]
                .as_array()
                .unwrap()
                .len(),
            12
        );
        assert_eq!(written[0]["cliques_seen"], json!(1));
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial: CliqueParams = from_value(json!({ "max_cliques": 2 })).unwrap();
        assert_eq!(
            partial,
            CliqueParams {
                max_cliques: 2,
                ..Default::default()
            }
        );
        assert!(from_value::<CliqueParams>(json!({ "cliques": 2 })).is_err());
    }
}
