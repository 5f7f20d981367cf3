//! What holds for every cloud.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{bumpy_sheet, uniform};
use gmpcr_features::{
    Error, FeatureParams, Features, Fpfh, FpfhParams, NormalParams, compute_features,
    estimate_normals, fpfh, voxel_grid,
};
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;

const NORMALS: NormalParams = NormalParams {
    radius: 0.12,
    max_neighbors: 30,
    viewpoint: Point3::new(0.1, 0.2, -0.3),
};
const FPFH: FpfhParams = FpfhParams {
    radius: 0.25,
    max_neighbors: 100,
};

fn assert_sound(features: &Features) {
    assert_eq!(features.points.len(), features.normals.len());
    assert_eq!(features.points.len(), features.descriptors.len());
    assert!(
        features
            .normals
            .iter()
            .all(|normal| (normal.norm() - 1.0).abs() < 1e-12)
    );
    for block in features.descriptors.iter().flat_map(|d| d.chunks(11)) {
        let sum: f32 = block.iter().sum();
        assert!(block.iter().all(|value| (0.0..=200.001).contains(value)));
        assert!(
            [0.0_f32, 100.0, 200.0]
                .iter()
                .any(|whole| (sum - whole).abs() < 1e-3),
            "sum {sum}"
        );
    }
}

/// All steps on the points as they are, without the voxel grid.
fn features_of_all(
    points: &[Point3<f64>],
    normals: &NormalParams,
    fpfh_params: &FpfhParams,
) -> Features {
    let normals = estimate_normals(points, normals).unwrap();
    let descriptors = fpfh(points, &normals, fpfh_params).unwrap();
    let mut features = Features::default();
    features.points = points.to_vec();
    features.normals = normals;
    features.descriptors = descriptors;
    features
}

fn largest_difference(a: &Fpfh, b: &Fpfh) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

/// Rounding moves some pairs to another bin: those at a border, and those whose normals were fitted
/// to the same points, so that rounding decides which of the two is the source.
fn assert_nearly_all_descriptors_agree(a: &[Fpfh], b: &[Fpfh]) {
    assert_eq!(a.len(), b.len());
    let moved = a
        .iter()
        .zip(b)
        .filter(|(a, b)| largest_difference(a, b) > 0.1)
        .count();
    assert!(
        20 * moved <= a.len(),
        "{moved} of {} descriptors differ",
        a.len()
    );
}

#[test]
fn computing_features_is_the_three_steps_in_a_row() {
    let cloud = bumpy_sheet(3000, 1);
    let shared = FeatureParams::from_voxel_size(0.04);
    let separate = FeatureParams {
        normals: NormalParams {
            radius: 0.3,
            max_neighbors: 120,
            ..NORMALS
        },
        ..shared
    };
    for params in [shared, separate] {
        let points = voxel_grid(&cloud, params.voxel_size).unwrap();
        let features = compute_features(&cloud, &params).unwrap();
        assert!(points.len() > 300 && points.len() < cloud.len());
        assert_eq!(
            features,
            features_of_all(&points, &params.normals, &params.fpfh)
        );
        assert_sound(&features);
    }
}

#[test]
fn the_same_cloud_gives_the_same_bits() {
    let cloud = bumpy_sheet(2000, 2);
    let params = FeatureParams::default();
    assert_eq!(
        compute_features(&cloud, &params),
        compute_features(&cloud, &params)
    );
}

#[test]
fn every_histogram_of_a_point_with_neighbors_sums_to_two_hundred() {
    let features = compute_features(&bumpy_sheet(2000, 3), &FeatureParams::default()).unwrap();
    for block in features.descriptors.iter().flat_map(|d| d.chunks(11)) {
        assert!((block.iter().sum::<f32>() - 200.0).abs() < 1e-3);
    }
}

#[test]
fn a_rigid_transformation_rotates_the_normals_and_leaves_the_descriptors() {
    let cloud = bumpy_sheet(800, 4);
    let transformation = Isometry3::new(Vector3::new(3.0, -2.0, 1.0), Vector3::new(0.4, -1.1, 2.0));
    let moved: Vec<_> = cloud.iter().map(|point| transformation * point).collect();
    let moved_params = NormalParams {
        viewpoint: transformation * NORMALS.viewpoint,
        ..NORMALS
    };

    let here = features_of_all(&cloud, &NORMALS, &FPFH);
    let there = features_of_all(&moved, &moved_params, &FPFH);

    for (here, there) in here.normals.iter().zip(&there.normals) {
        assert!((transformation * here - there).norm() < 1e-9);
    }
    assert_nearly_all_descriptors_agree(&here.descriptors, &there.descriptors);
    assert!(largest_difference(&here.descriptors[0], &there.descriptors[1]) > 1.0);
}

#[test]
fn a_scaled_cloud_with_scaled_radii_has_the_same_descriptors() {
    let cloud = bumpy_sheet(800, 5);
    let scaled: Vec<_> = cloud.iter().map(|point| point * 1000.0).collect();
    let scaled_normals = NormalParams {
        radius: 120.0,
        viewpoint: NORMALS.viewpoint * 1000.0,
        ..NORMALS
    };
    let scaled_fpfh = FpfhParams {
        radius: 250.0,
        ..FPFH
    };
    let here = features_of_all(&cloud, &NORMALS, &FPFH);
    let there = features_of_all(&scaled, &scaled_normals, &scaled_fpfh);
    assert_nearly_all_descriptors_agree(&here.descriptors, &there.descriptors);
}

#[test]
fn permuting_the_points_permutes_normals_and_descriptors() {
    let cloud = bumpy_sheet(800, 6);
    let mut next = uniform(7);
    let mut order: Vec<usize> = (0..cloud.len()).collect();
    order.sort_by_cached_key(|_| next().to_bits());
    let shuffled: Vec<_> = order.iter().map(|&k| cloud[k]).collect();

    let straight = features_of_all(&cloud, &NORMALS, &FPFH);
    let shuffled = features_of_all(&shuffled, &NORMALS, &FPFH);

    for (position, &k) in order.iter().enumerate() {
        assert_eq!(straight.normals[k], shuffled.normals[position]);
    }
    let expected: Vec<_> = order.iter().map(|&k| straight.descriptors[k]).collect();
    assert_eq!(expected, shuffled.descriptors);
}

#[test]
fn an_empty_cloud_has_no_features() {
    assert_eq!(
        compute_features(&[], &FeatureParams::default()),
        Ok(Features::default())
    );
    assert_eq!(estimate_normals(&[], &NORMALS), Ok(vec![]));
    assert_eq!(fpfh(&[], &[], &FPFH), Ok(vec![]));
}

#[test]
fn a_single_point_faces_the_viewpoint_and_has_a_zero_descriptor() {
    let features =
        compute_features(&[Point3::new(0.0, 3.0, 4.0)], &FeatureParams::default()).unwrap();
    assert_eq!(features.normals, [Vector3::new(0.0, -0.6, -0.8)]);
    assert_eq!(features.descriptors, [[0.0; 33]]);
}

#[test]
fn degenerate_clouds_have_finite_features() {
    let line = |k: usize| Point3::new(0.1, 0.2, 0.3) * k as f64;
    let plane = |k: usize| Point3::new((k % 30) as f64, (k / 30) as f64, 0.0) * 0.05;
    let clouds: [(&str, Vec<Point3<f64>>); 7] = [
        ("two points", vec![line(1), line(2)]),
        ("three points", vec![line(1), line(2), plane(1)]),
        ("a line", (0..1000).map(line).collect()),
        ("a plane", (0..1000).map(plane).collect()),
        ("one place", vec![line(3); 1000]),
        ("two places", (0..1000).map(|k| line(k % 2)).collect()),
        (
            "far away",
            (0..1000).map(|k| plane(k) + Vector3::repeat(1e9)).collect(),
        ),
    ];
    for (name, cloud) in clouds {
        println!("{name}");
        for radius in [1e-100, 0.1, 2.0, 1e100] {
            let normals = NormalParams {
                radius,
                ..NormalParams::default()
            };
            assert_sound(&features_of_all(
                &cloud,
                &normals,
                &FpfhParams {
                    radius,
                    max_neighbors: 50,
                },
            ));
        }
        assert_sound(&compute_features(&cloud, &FeatureParams::default()).unwrap());
    }
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e101] {
        let mut cloud = bumpy_sheet(10, 8);
        cloud[7].y = value;
        let is_named = |error: Error| {
            matches!(
                error,
                Error::Coordinate {
                    what: "point",
                    index: 7,
                    ..
                }
            )
        };
        assert!(is_named(
            compute_features(&cloud, &FeatureParams::default()).unwrap_err()
        ));
        assert!(is_named(voxel_grid(&cloud, 0.1).unwrap_err()));
        assert!(is_named(estimate_normals(&cloud, &NORMALS).unwrap_err()));
        assert!(is_named(
            fpfh(&cloud, &[Vector3::z(); 10], &FPFH).unwrap_err()
        ));
    }
    let mut normals = [Vector3::z(); 10];
    normals[3].x = f64::NAN;
    let error = fpfh(&bumpy_sheet(10, 8), &normals, &FPFH).unwrap_err();
    assert!(matches!(
        error,
        Error::Coordinate {
            what: "normal",
            index: 3,
            ..
        }
    ));
}

#[test]
fn every_parameter_out_of_range_is_named() {
    fn name(error: Error) -> String {
        match error {
            Error::Parameter(error) => error.name,
            other => panic!("{other}"),
        }
    }
    let lengths = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-101, 1e101];
    type Spoil = fn(&mut FeatureParams, f64);
    let cases: [(&str, Spoil, &[f64]); 8] = [
        ("voxel_size", |p, value| p.voxel_size = value, &lengths),
        (
            "normals.radius",
            |p, value| p.normals.radius = value,
            &lengths,
        ),
        (
            "normals.max_neighbors",
            |p, _| p.normals.max_neighbors = 0,
            &[0.0],
        ),
        (
            "normals.viewpoint.x",
            |p, value| p.normals.viewpoint.x = value,
            &[f64::NAN, 1e101],
        ),
        (
            "normals.viewpoint.y",
            |p, value| p.normals.viewpoint.y = value,
            &[f64::INFINITY],
        ),
        (
            "normals.viewpoint.z",
            |p, value| p.normals.viewpoint.z = value,
            &[-1e101],
        ),
        ("fpfh.radius", |p, value| p.fpfh.radius = value, &lengths),
        (
            "fpfh.max_neighbors",
            |p, _| p.fpfh.max_neighbors = 0,
            &[0.0],
        ),
    ];
    for (expected, spoil, values) in cases {
        for &value in values {
            let mut params = FeatureParams::default();
            assert_eq!(params.validate(), Ok(()));
            spoil(&mut params, value);
            assert_eq!(params.validate().unwrap_err().name, expected);
            assert_eq!(name(compute_features(&[], &params).unwrap_err()), expected);
            let single_step = match expected.split_once('.') {
                Some(("normals", _)) => estimate_normals(&[], &params.normals).unwrap_err(),
                Some(_) => fpfh(&[], &[], &params.fpfh).unwrap_err(),
                None => voxel_grid(&[], params.voxel_size).unwrap_err(),
            };
            let field = expected
                .split_once('.')
                .map_or(expected, |(_, field)| field);
            assert_eq!(name(single_step), field);
        }
    }
}

#[test]
fn the_message_of_a_bad_parameter_names_the_range() {
    let error = voxel_grid(&[], -0.5).unwrap_err();
    assert_eq!(
        error.to_string(),
        "parameter voxel_size is -0.5: it must be a length from 1e-100 to 1e100"
    );
}

#[test]
fn points_and_normals_must_be_equally_many() {
    let error = fpfh(&bumpy_sheet(3, 9), &[Vector3::z(); 2], &FPFH).unwrap_err();
    assert_eq!(
        error,
        Error::LengthMismatch {
            num_points: 3,
            num_normals: 2
        }
    );
}

/// Coordinates that provoke ties, duplicates, overflow and underflow.
fn awkward_coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (-3_i32..3).prop_map(|k| f64::from(k) * 0.05),
        2 => -1.0..1.0,
        1 => prop::sample::select(vec![-0.0, 1e-300, 1e-160, -1e9, 1e9, 1e100, -1e100]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_cloud_has_features_or_is_refused(
        coordinates in prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 0..60),
        voxel_size in prop::sample::select(vec![1e-100, 1e-3, 0.05, 1.0, 1e9, 1e100]),
        max_neighbors in prop::sample::select(vec![1, 2, 3, 10, usize::MAX]),
    ) {
        let cloud: Vec<_> = coordinates.into_iter().map(Point3::from).collect();
        let mut params = FeatureParams {
            voxel_size, ..FeatureParams::from_voxel_size(voxel_size.clamp(1e-90, 1e90))
        };
        params.fpfh.max_neighbors = max_neighbors;
        match compute_features(&cloud, &params) {
            Ok(features) => assert_sound(&features),
            Err(error) => prop_assert!(matches!(error, Error::ExtentTooLarge { .. }), "{}", error),
        }
        assert_sound(&features_of_all(&cloud, &params.normals, &params.fpfh));
    }
}
