//! What users of the types rely on beside the numbers.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{room, sample, surface};
use gmpcr_refine::{
    CrossPair, DirectedCounts, EquationParams, Error, IcpParams, InvalidParameter, JointPair,
    JointParams, JointRefinement, PairCounts, PairEquations, PairRefinement, PosedSurface,
    Sequential, SetIcpParams, SetRefinement, SetSupport, Surface, SurfaceParams, VerifyParams,
    pair_equations, refine_jointly, refine_pair, refine_sets, verify_pair, verify_sets,
};
use nalgebra::{Isometry3, Point3, Vector3};

#[test]
fn the_types_go_between_threads() {
    fn check<T: Send + Sync>() {}
    check::<CrossPair>();
    check::<DirectedCounts>();
    check::<EquationParams>();
    check::<Error>();
    check::<IcpParams>();
    check::<JointPair>();
    check::<JointParams>();
    check::<JointRefinement>();
    check::<PairCounts>();
    check::<PairEquations>();
    check::<PairRefinement>();
    check::<PosedSurface<'static>>();
    check::<Sequential>();
    check::<SetIcpParams>();
    check::<SetRefinement>();
    check::<SetSupport>();
    check::<Surface>();
    check::<SurfaceParams>();
    check::<VerifyParams>();
}

fn plain() -> Surface {
    let (points, normals) = sample(&room(), &Isometry3::identity(), 0.05, 1);
    surface(&points, &normals)
}

/// Puts one parameter out of range.
type Spoil<P> = fn(&mut P);

/// Spoils each parameter, and checks that its name is in the error of `validate` and of the function.
fn refuses<P: Default>(
    cases: &[(&str, Spoil<P>)],
    validate: impl Fn(&P) -> Result<(), InvalidParameter>,
    call: impl Fn(&P) -> Option<Error>,
) {
    assert_eq!(validate(&P::default()), Ok(()));
    assert_eq!(call(&P::default()), None);
    for (name, spoil) in cases {
        let mut params = P::default();
        spoil(&mut params);
        assert_eq!(validate(&params).unwrap_err().name, *name);
        let Some(Error::Parameter(error)) = call(&params) else {
            panic!("{name} was accepted");
        };
        assert_eq!(error.name, *name);
    }
}

#[test]
fn every_parameter_of_a_surface_out_of_range_is_named() {
    refuses(
        &[
            ("voxel_size", |p: &mut SurfaceParams| p.voxel_size = 0.0),
            ("voxel_size", |p| p.voxel_size = f64::NAN),
            ("max_queries", |p| p.max_queries = 0),
            ("smoothing_radius", |p| p.smoothing_radius = 0.5),
            ("smoothing_radius", |p| p.smoothing_radius = f64::NAN),
            ("pixel", |p| p.pixel = 0.001),
            ("pixel", |p| p.pixel = 0.6),
        ],
        SurfaceParams::validate,
        |params| Surface::new(&[], &[], params).err(),
    );
}

#[test]
fn every_parameter_of_verification_out_of_range_is_named() {
    let i = plain();
    let pose = Isometry3::identity();
    refuses(
        &[
            ("radius", |p: &mut VerifyParams| p.radius = 0.0),
            ("radius", |p| p.radius = 3.1),
            ("min_normal_cosine", |p| p.min_normal_cosine = 1.0),
            ("min_normal_cosine", |p| p.min_normal_cosine = f64::NAN),
            ("depth_tolerance", |p| p.depth_tolerance = -1.0),
            ("relative_depth_tolerance", |p| {
                p.relative_depth_tolerance = 1.0
            }),
            ("min_depth", |p| p.min_depth = f64::INFINITY),
        ],
        VerifyParams::validate,
        |params| verify_pair(&i, &i, &pose, params).err(),
    );
    let params = VerifyParams {
        radius: 9.0,
        ..VerifyParams::default()
    };
    assert!(verify_sets(&[], &[], &pose, &params, &Sequential).is_err());
    refuses(
        &[
            ("radius", |p: &mut EquationParams| p.radius = 4.0),
            ("min_normal_cosine", |p| p.min_normal_cosine = -0.5),
            ("robust_scale", |p| p.robust_scale = Some(0.0)),
        ],
        EquationParams::validate,
        |params| pair_equations(&i, &i, &pose, params).err(),
    );
}

#[test]
fn every_parameter_of_refinement_out_of_range_is_named() {
    let i = plain();
    let pose = Isometry3::identity();
    refuses(
        &[
            ("first_radius", |p: &mut IcpParams| p.first_radius = 3.5),
            ("last_radius", |p| p.last_radius = -1.0),
            ("steps", |p| p.steps = 0),
            ("min_normal_cosine", |p| p.min_normal_cosine = -0.1),
            ("min_correspondences", |p| p.min_correspondences = 5),
            ("min_stability", |p| p.min_stability = 1.0),
            ("tolerance", |p| p.tolerance = f64::NAN),
        ],
        IcpParams::validate,
        |params| refine_pair(&i, &i, &pose, params).err(),
    );
    refuses(
        &[
            ("steps", |p: &mut SetIcpParams| p.steps = 0),
            ("min_correspondences", |p| p.min_correspondences = 1),
            ("search_radius", |p| p.search_radius = 0.0),
            ("search_min_normal_cosine", |p| {
                p.search_min_normal_cosine = 1.0
            }),
            ("max_pairs", |p| p.max_pairs = 0),
        ],
        SetIcpParams::validate,
        |params| refine_sets(&[], &[], &pose, params, &Sequential).err(),
    );
    refuses(
        &[
            ("first_radius", |p: &mut JointParams| p.first_radius = 0.0),
            ("last_radius", |p| p.last_radius = 4.0),
            ("steps", |p| p.steps = 0),
            ("min_normal_cosine", |p| p.min_normal_cosine = 1.0),
            ("search_radius", |p| p.search_radius = 5.0),
            ("search_min_normal_cosine", |p| {
                p.search_min_normal_cosine = -1.0
            }),
            ("damping", |p| p.damping = 0.0),
            ("tolerance", |p| p.tolerance = -1.0),
        ],
        JointParams::validate,
        |params| refine_jointly(&[], params, &Sequential).err(),
    );
}

#[test]
fn data_that_cannot_be_used_is_named() {
    let params = SurfaceParams::from_voxel_size(1.0);
    let (p, n) = (Point3::origin(), Vector3::z());
    let text = |points: &[Point3<f64>], normals: &[Vector3<f64>]| {
        Surface::new(points, normals, &params)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        text(&[p, p], &[n]),
        "2 points but 1 normals, need one normal for each point"
    );
    let nan = Point3::new(0.0, f64::NAN, 0.0);
    assert!(text(&[p, nan], &[n, n]).starts_with("point 1 has the coordinate NaN"));
    let huge = Vector3::new(0.0, 0.0, 1e200);
    assert!(text(&[p], &[huge]).starts_with("normal 0 has the coordinate 1"));
    assert_eq!(
        text(&[p, p], &[n, n * 2.0]),
        "normal 1 has length 2, allowed are 1, or 0 for unknown"
    );
    let far = Point3::new(0.0, 3e6, 0.0);
    assert_eq!(
        text(&[p, far], &[n, n]),
        "extent 3000000 along axis 1 exceeds 2097000 voxels of size 1"
    );
    // Large coordinates as such are no trouble.
    let remote = Point3::new(1e100, -1e100, 1e90);
    assert_eq!(
        Surface::new(&[remote; 2], &[n; 2], &params).unwrap().len(),
        2
    );

    let surface = || Surface::new(&[p], &[n], &params).unwrap();
    let error = surface().seen_from(p, &[p, nan]).unwrap_err().to_string();
    assert!(error.starts_with("raw point 1 has"), "{error}");
    let error = surface().seen_from(nan, &[p]).unwrap_err().to_string();
    assert!(error.starts_with("viewpoint 0 has"), "{error}");
}

#[test]
fn poses_that_are_no_numbers_are_refused() {
    let i = plain();
    let pose = Isometry3::translation(0.0, f64::NAN, 0.0);
    let posed = [
        PosedSurface::new(&i, Isometry3::identity()),
        PosedSurface::new(&i, pose),
    ];
    let errors = [
        verify_pair(&i, &i, &pose, &VerifyParams::default()).unwrap_err(),
        pair_equations(&i, &i, &pose, &EquationParams::default()).unwrap_err(),
        refine_pair(&i, &i, &pose, &IcpParams::default()).unwrap_err(),
        verify_sets(
            &posed[..1],
            &[],
            &pose,
            &VerifyParams::default(),
            &Sequential,
        )
        .unwrap_err(),
        refine_sets(
            &posed[1..],
            &[],
            &pose,
            &SetIcpParams::default(),
            &Sequential,
        )
        .unwrap_err(),
        refine_jointly(&posed, &JointParams::default(), &Sequential).unwrap_err(),
    ];
    for (k, error) in errors.iter().enumerate() {
        let index = usize::from(k == 5);
        let text = format!("transformation {index} has the coordinate NaN");
        assert!(error.to_string().starts_with(&text), "{error}");
    }
}

#[cfg(feature = "serde")]
mod files {
    use serde_json::{from_value, json, to_value};

    use super::*;

    #[test]
    fn results_come_back_as_they_were() {
        let i = plain();
        let pose = Isometry3::translation(0.3, 0.1, -0.2);
        let set = [Isometry3::identity(), pose].map(|pose| PosedSurface::new(&i, pose));
        let pair = refine_pair(&i, &i, &pose, &IcpParams::default()).unwrap();
        let sets = refine_sets(&set, &set, &pose, &SetIcpParams::default(), &Sequential).unwrap();
        let support =
            verify_sets(&set, &set, &pose, &VerifyParams::default(), &Sequential).unwrap();
        let joint = refine_jointly(&set, &JointParams::default(), &Sequential).unwrap();

        let written = to_value((&pair, &sets, &support, &joint)).unwrap();
        type Results = (PairRefinement, SetRefinement, SetSupport, JointRefinement);
        let read: Results = from_value(written.clone()).unwrap();
        // A rotation goes through a file as a matrix, so its quaternion may differ by rounding.
        let apart = |a: &Isometry3<f64>, b: &Isometry3<f64>| (a.to_matrix() - b.to_matrix()).norm();
        assert!(apart(&read.0.i_from_j, &pair.i_from_j) < 1e-14);
        assert!(apart(&read.1.a_from_b, &sets.a_from_b) < 1e-14);
        assert!(apart(&read.3.frame_from_scan[1], &joint.frame_from_scan[1]) < 1e-14);
        assert_eq!((read.0.equations, read.2), (pair.equations, support));
        assert_eq!(read.3.pairs, joint.pairs);
        assert_eq!(written[0]["i_from_j"].as_array().unwrap().len(), 12);
    }

    #[test]
    fn absent_parameters_are_the_default_and_unknown_ones_refused() {
        let partial: JointParams = from_value(json!({ "search_radius": 2.0 })).unwrap();
        let expected = JointParams {
            search_radius: 2.0,
            ..JointParams::default()
        };
        assert_eq!(partial, expected);
        assert_eq!(
            from_value::<SurfaceParams>(json!({})).unwrap(),
            SurfaceParams::default()
        );
        assert!(from_value::<IcpParams>(json!({ "step": 2 })).is_err());
        assert!(from_value::<EquationParams>(json!({ "step": 2 })).is_err());
        assert!(from_value::<SetIcpParams>(json!({ "step": 2 })).is_err());
    }
}
