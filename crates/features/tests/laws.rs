//! What holds for every cloud.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{bumpy_sheet, uniform};
use gmpcr_features::{
    Described, Error, FeatureParams, Fpfh, FpfhParams, NormalParams, describe, estimate_normals,
    fpfh, voxel_grid,
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

fn assert_sound(described: &Described) {
    assert_eq!(described.points.len(), described.normals.len());
    assert_eq!(described.points.len(), described.descriptors.len());
    assert!(
        described
            .normals
            .iter()
            .all(|normal| (normal.norm() - 1.0).abs() < 1e-12)
    );
    for block in described.descriptors.iter().flat_map(|d| d.chunks(11)) {
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
fn describe_all(
    points: &[Point3<f64>],
    normals: &NormalParams,
    fpfh_params: &FpfhParams,
) -> Described {
    let normals = estimate_normals(points, normals).unwrap();
    let descriptors = fpfh(points, &normals, fpfh_params).unwrap();
    Described {
        points: points.to_vec(),
        normals,
        descriptors,
    }
}

fn largest_difference(a: &Fpfh, b: &Fpfh) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

/// Rounding moves some pairs to another bin: those at a border, and those whose normals were fitted
/// to the same points, so that which of the two is the source is a toss-up.
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
fn describing_is_the_three_steps_in_a_row() {
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
        let described = describe(&cloud, &params).unwrap();
        assert!(points.len() > 300 && points.len() < cloud.len());
        assert_eq!(
            described,
            describe_all(&points, &params.normals, &params.fpfh)
        );
        assert_sound(&described);
    }
}

#[test]
fn the_same_cloud_gives_the_same_bits() {
    let cloud = bumpy_sheet(2000, 2);
    let params = FeatureParams::default();
    assert_eq!(describe(&cloud, &params), describe(&cloud, &params));
}

#[test]
fn every_histogram_of_a_point_with_neighbors_sums_to_two_hundred() {
    let described = describe(&bumpy_sheet(2000, 3), &FeatureParams::default()).unwrap();
    for block in described.descriptors.iter().flat_map(|d| d.chunks(11)) {
        assert!((block.iter().sum::<f32>() - 200.0).abs() < 1e-3);
    }
}

#[test]
fn a_rigid_transformation_turns_the_normals_and_leaves_the_descriptors() {
    let cloud = bumpy_sheet(800, 4);
    let transformation = Isometry3::new(Vector3::new(3.0, -2.0, 1.0), Vector3::new(0.4, -1.1, 2.0));
    let moved: Vec<_> = cloud.iter().map(|point| transformation * point).collect();
    let moved_params = NormalParams {
        viewpoint: transformation * NORMALS.viewpoint,
        ..NORMALS
    };

    let here = describe_all(&cloud, &NORMALS, &FPFH);
    let there = describe_all(&moved, &moved_params, &FPFH);

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
    let here = describe_all(&cloud, &NORMALS, &FPFH);
    let there = describe_all(&scaled, &scaled_normals, &scaled_fpfh);
    assert_nearly_all_descriptors_agree(&here.descriptors, &there.descriptors);
}

#[test]
fn permuting_the_points_permutes_normals_and_descriptors() {
    let cloud = bumpy_sheet(800, 6);
    let mut next = uniform(7);
    let mut order: Vec<usize> = (0..cloud.len()).collect();
    order.sort_by_cached_key(|_| next().to_bits());
    let shuffled: Vec<_> = order.iter().map(|&k| cloud[k]).collect();

    let straight = describe_all(&cloud, &NORMALS, &FPFH);
    let shuffled = describe_all(&shuffled, &NORMALS, &FPFH);

    for (position, &k) in order.iter().enumerate() {
        assert_eq!(straight.normals[k], shuffled.normals[position]);
    }
    let expected: Vec<_> = order.iter().map(|&k| straight.descriptors[k]).collect();
    assert_eq!(expected, shuffled.descriptors);
}

#[test]
fn an_empty_cloud_is_described_by_nothing() {
    assert_eq!(
        describe(&[], &FeatureParams::default()),
        Ok(Described::default())
    );
    assert_eq!(estimate_normals(&[], &NORMALS), Ok(vec![]));
    assert_eq!(fpfh(&[], &[], &FPFH), Ok(vec![]));
}

#[test]
fn a_single_point_faces_the_viewpoint_and_has_a_zero_descriptor() {
    let described = describe(&[Point3::new(0.0, 3.0, 4.0)], &FeatureParams::default()).unwrap();
    assert_eq!(described.normals, [Vector3::new(0.0, -0.6, -0.8)]);
    assert_eq!(described.descriptors, [[0.0; 33]]);
}

#[test]
fn degenerate_clouds_are_described_by_finite_numbers() {
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
            assert_sound(&describe_all(
                &cloud,
                &normals,
                &FpfhParams {
                    radius,
                    max_neighbors: 50,
                },
            ));
        }
        assert_sound(&describe(&cloud, &FeatureParams::default()).unwrap());
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
            describe(&cloud, &FeatureParams::default()).unwrap_err()
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
    let nowhere = NormalParams {
        viewpoint: Point3::new(f64::NAN, 0.0, 0.0),
        ..NORMALS
    };
    assert!(matches!(
        estimate_normals(&[], &nowhere),
        Err(Error::Coordinate {
            what: "viewpoint",
            ..
        })
    ));
}

#[test]
fn parameters_out_of_range_are_named() {
    let names = |error: Error| match error {
        Error::Parameter { name, .. } => name,
        other => panic!("{other}"),
    };
    let good = FeatureParams::default();
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-101, 1e101] {
        let normals = NormalParams {
            radius: length,
            ..good.normals
        };
        let fpfh_params = FpfhParams {
            radius: length,
            ..good.fpfh
        };
        for (params, name) in [
            (
                FeatureParams {
                    voxel_size: length,
                    ..good
                },
                "voxel_size",
            ),
            (FeatureParams { normals, ..good }, "normals.radius"),
            (
                FeatureParams {
                    fpfh: fpfh_params,
                    ..good
                },
                "fpfh.radius",
            ),
        ] {
            assert_eq!(names(describe(&[], &params).unwrap_err()), name);
        }
        assert_eq!(names(voxel_grid(&[], length).unwrap_err()), "voxel_size");
        assert_eq!(
            names(estimate_normals(&[], &normals).unwrap_err()),
            "normals.radius"
        );
        assert_eq!(
            names(fpfh(&[], &[], &fpfh_params).unwrap_err()),
            "fpfh.radius"
        );
    }
    let none = NormalParams {
        max_neighbors: 0,
        ..NORMALS
    };
    assert_eq!(
        names(estimate_normals(&[], &none).unwrap_err()),
        "normals.max_neighbors"
    );
    let none = FpfhParams {
        max_neighbors: 0,
        ..FPFH
    };
    assert_eq!(
        names(fpfh(&[], &[], &none).unwrap_err()),
        "fpfh.max_neighbors"
    );
}

#[test]
fn the_message_of_a_bad_parameter_names_the_range() {
    let error = voxel_grid(&[], -0.5).unwrap_err();
    assert_eq!(
        error.to_string(),
        "voxel_size is -0.5, allowed is a length from 1e-100 to 1e100"
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
    fn any_cloud_is_described_or_refused(
        coordinates in prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 0..60),
        voxel_size in prop::sample::select(vec![1e-100, 1e-3, 0.05, 1.0, 1e9, 1e100]),
        max_neighbors in prop::sample::select(vec![1, 2, 3, 10, usize::MAX]),
    ) {
        let cloud: Vec<_> = coordinates.into_iter().map(Point3::from).collect();
        let mut params = FeatureParams {
            voxel_size, ..FeatureParams::from_voxel_size(voxel_size.clamp(1e-90, 1e90))
        };
        params.fpfh.max_neighbors = max_neighbors;
        match describe(&cloud, &params) {
            Ok(described) => assert_sound(&described),
            Err(error) => prop_assert!(matches!(error, Error::ExtentTooLarge { .. }), "{}", error),
        }
        assert_sound(&describe_all(&cloud, &params.normals, &params.fpfh));
    }
}
