//! What the estimated lengths of a cloud keep to.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{bumpy_sheet, uniform};
use gmpcr_features::{
    Error, common_voxel_size, estimate_resolution, estimate_voxel_size, voxel_grid,
};
use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;

fn voxel_size(points: &[Point3<f64>]) -> f64 {
    estimate_voxel_size(points).unwrap().unwrap()
}

fn resolution(points: &[Point3<f64>]) -> f64 {
    estimate_resolution(points).unwrap().unwrap()
}

fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    let change = actual / expected - 1.0;
    assert!(
        change.abs() <= tolerance,
        "{actual} is off {expected} by {change}"
    );
}

fn scaled(points: &[Point3<f64>], factor: f64) -> Vec<Point3<f64>> {
    points.iter().map(|point| point * factor).collect()
}

fn in_a_box(count: usize, half_side: f64, seed: u64) -> impl Iterator<Item = Point3<f64>> {
    let mut next = uniform(seed);
    let mut point = move || Vector3::from_fn(|_, _| half_side * (2.0 * next() - 1.0)).into();
    (0..count).map(move |_| point())
}

fn on_a_line(count: u32, step: Vector3<f64>) -> Vec<Point3<f64>> {
    (0..count).map(|k| (step * f64::from(k)).into()).collect()
}

#[test]
fn a_downsampled_scan_keeps_four_thousand_points_and_the_voxels_that_the_surface_grazes() {
    for num_points in [12_000, 20_000, 100_000] {
        let cloud = bumpy_sheet(num_points, 1);
        let downsampled = voxel_grid(&cloud, voxel_size(&cloud)).unwrap();
        assert!(
            (3800..4800).contains(&downsampled.len()),
            "{}",
            downsampled.len()
        );
    }
}

#[test]
fn a_downsampled_sparse_cloud_keeps_about_half_of_its_points() {
    for num_points in [300, 1000, 5000] {
        let cloud = bumpy_sheet(num_points, 2);
        let downsampled = voxel_grid(&cloud, voxel_size(&cloud)).unwrap();
        assert_close(downsampled.len() as f64, 0.5 * num_points as f64, 0.1);
    }
}

#[test]
fn the_voxel_size_does_not_follow_the_density_of_a_dense_cloud() {
    let expected = voxel_size(&bumpy_sheet(30_000, 3));
    for num_points in [16_000, 60_000, 300_000] {
        assert_close(voxel_size(&bumpy_sheet(num_points, 4)), expected, 0.03);
    }
}

#[test]
fn the_voxel_size_follows_the_extent_of_the_surface() {
    // Four sheets side by side: four times the area, twice the voxel.
    let sheet = bumpy_sheet(30_000, 5);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let corners = corners.map(|(x, y)| Vector3::new(x, y, 0.0));
    let moved = |corner| sheet.iter().map(move |point| point + corner);
    let four: Vec<_> = corners.into_iter().flat_map(moved).collect();
    assert_close(voxel_size(&four), 2.0 * voxel_size(&sheet), 0.05);
}

#[test]
fn one_percent_of_outliers_moves_the_voxel_size_by_a_few_percent() {
    for num_points in [4000, 20_000, 200_000] {
        let cloud = bumpy_sheet(num_points, 6);
        let outliers = in_a_box(num_points / 100, 20.0, 7);
        let dirty: Vec<_> = cloud.iter().copied().chain(outliers).collect();
        assert_close(voxel_size(&dirty), voxel_size(&cloud), 0.06);
        assert_close(resolution(&dirty), resolution(&cloud), 0.1);
    }
}

#[test]
fn a_few_points_far_away_hardly_move_the_estimates() {
    for distance in [1e3, 1e12, 1e100] {
        let cloud = bumpy_sheet(20_000, 8);
        let far = in_a_box(5, distance, 9);
        let dirty: Vec<_> = far.chain(cloud.iter().copied()).collect();
        assert_close(voxel_size(&dirty), voxel_size(&cloud), 0.03);
        assert_close(resolution(&dirty), resolution(&cloud), 0.03);
    }
}

#[test]
fn an_outlier_is_never_the_centre_of_the_grid() {
    for seed in 0..30 {
        let cloud = bumpy_sheet(18_000, seed);
        let far = in_a_box(900, 1e30, seed + 100);
        let dirty: Vec<_> = cloud.iter().copied().chain(far).collect();
        assert_close(voxel_size(&dirty), voxel_size(&cloud), 0.02);
    }
}

#[test]
fn pixels_without_depth_at_the_origin_do_not_matter() {
    let cloud = bumpy_sheet(10_000, 10);
    let mut pixels = vec![Point3::origin(); 30_000];
    pixels.extend(&cloud);
    assert_close(voxel_size(&pixels), voxel_size(&cloud), 0.02);
    assert_close(resolution(&pixels), resolution(&cloud), 0.03);
}

#[test]
fn rows_of_a_lattice_are_not_skipped() {
    // Every sixteenth point would come from the same 32 of the 512 places in a row.
    let cloud: Vec<_> = (0..256_000)
        .map(|k| Point3::new(f64::from(k / 512), f64::from(k % 512), 7.0))
        .collect();
    assert_close(voxel_size(&cloud), 8.0, 0.05);
}

#[test]
fn a_cloud_without_extent_has_no_estimate() {
    let point = Point3::new(1.0, -2.0, 3.0);
    for cloud in [vec![], vec![point], vec![point; 20_000]] {
        assert_eq!(estimate_voxel_size(&cloud), Ok(None));
        assert_eq!(estimate_resolution(&cloud), Ok(None));
    }
    let zeros = [Point3::new(0.0, 0.0, 0.0), Point3::new(-0.0, 0.0, -0.0)];
    assert_eq!(estimate_voxel_size(&zeros), Ok(None));
    assert_eq!(estimate_resolution(&zeros), Ok(None));
}

#[test]
fn two_points_fall_into_a_voxel_of_twice_their_distance_along_an_axis() {
    let cloud = on_a_line(2, Vector3::new(0.0, 0.25, 0.0));
    assert_close(voxel_size(&cloud), 0.5, 0.01);
    assert_eq!(resolution(&cloud), 0.25);
}

#[test]
fn points_on_a_line_fall_by_twos_into_voxels() {
    for step in [Vector3::x(), Vector3::z(), Vector3::new(1.0, 1.0, 1.0)] {
        let cloud = on_a_line(1000, step);
        assert_close(voxel_size(&cloud), 2.0, 0.02);
        assert_eq!(resolution(&cloud), step.norm());
    }
    // Where they are many, 4000 voxels cover the line.
    assert_close(voxel_size(&on_a_line(40_000, Vector3::y())), 10.0, 0.02);
}

#[test]
fn coordinates_that_are_not_numbers_or_too_large_are_refused() {
    for value in [f64::NAN, f64::INFINITY, -1.1e100] {
        let cloud = [Point3::origin(), Point3::new(0.0, 1.0, value)];
        for estimate in [estimate_voxel_size(&cloud), estimate_resolution(&cloud)] {
            match estimate.unwrap_err() {
                Error::Coordinate { what, index, .. } => assert_eq!((what, index), ("point", 1)),
                error => panic!("{error}"),
            }
        }
    }
}

#[test]
fn the_common_voxel_size_is_the_lower_median() {
    assert_eq!(common_voxel_size([]), None);
    assert_eq!(common_voxel_size([0.3]), Some(0.3));
    assert_eq!(common_voxel_size([9.0, 0.2, 0.3, 0.1]), Some(0.2));
    assert_eq!(common_voxel_size([9.0, 0.2, 0.3, 0.1, 0.4]), Some(0.3));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]

    #[test]
    fn the_estimates_scale_with_the_cloud(
        seed: u64, num_points in 2_usize..20_000, exponent in -60..60, factor in 1e-3..1e3,
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let power = f64::from(exponent).exp2();
        prop_assert_eq!(voxel_size(&scaled(&cloud, power)), power * voxel_size(&cloud));
        prop_assert_eq!(resolution(&scaled(&cloud, power)), power * resolution(&cloud));
        assert_close(voxel_size(&scaled(&cloud, factor)), factor * voxel_size(&cloud), 1e-12);
        assert_close(resolution(&scaled(&cloud, factor)), factor * resolution(&cloud), 1e-12);
    }

    #[test]
    fn the_estimates_stay_when_the_cloud_is_translated(
        seed: u64, num_points in 2_usize..20_000, shift in prop::array::uniform3(-100.0..100.0),
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let shift = Vector3::from(shift);
        let shifted: Vec<_> = cloud.iter().map(|point| point + shift).collect();
        assert_close(voxel_size(&shifted), voxel_size(&cloud), 1e-9);
        assert_close(resolution(&shifted), resolution(&cloud), 1e-9);
    }

    #[test]
    fn a_rotation_changes_the_voxel_size_by_less_than_the_cut_of_a_plane_through_cubes(
        seed: u64, axis in prop::array::uniform3(-3.0..3.0),
    ) {
        // A plane of normal n meets |n_x| + |n_y| + |n_z| times as many cubes as one along an axis.
        let cloud = bumpy_sheet(20_000, seed);
        let rotation = Isometry3::rotation(Vector3::from(axis));
        let rotated: Vec<_> = cloud.iter().map(|point| rotation * point).collect();
        let change = voxel_size(&rotated) / voxel_size(&cloud);
        prop_assert!((0.9..1.35).contains(&change), "{}", change);
        // The rotation draws other 1000 points, whose medians differ by 3 % (one standard deviation).
        assert_close(resolution(&rotated), resolution(&cloud), 0.25);
    }

    #[test]
    fn the_estimates_depend_neither_on_the_order_of_the_points_nor_on_repeated_points(
        cloud in Just(bumpy_sheet(20_000, 11)).prop_shuffle(), repeated in 0_usize..20_000,
    ) {
        let mut more = cloud.clone();
        more.extend_from_within(..repeated);
        let sheet = bumpy_sheet(20_000, 11);
        prop_assert_eq!(voxel_size(&more), voxel_size(&sheet));
        prop_assert_eq!(resolution(&more), resolution(&sheet));
    }

    #[test]
    fn the_resolution_is_the_median_distance_to_the_nearest_other_point(
        seed: u64, num_points in 2_usize..300,
    ) {
        let cloud = bumpy_sheet(num_points, seed);
        let nearest = |k: usize| {
            let others = (0..num_points).filter(|&other| other != k);
            others.map(|other| (cloud[other] - cloud[k]).norm()).fold(f64::INFINITY, f64::min)
        };
        let mut distances: Vec<f64> = (0..num_points).map(nearest).collect();
        distances.sort_by(f64::total_cmp);
        assert_close(resolution(&cloud), distances[num_points / 2], 1e-12);
    }

    #[test]
    fn estimates_of_any_cloud_are_valid_lengths(
        exponents in prop::collection::vec(prop::array::uniform3(-330.0..100.0_f64), 2..50),
    ) {
        let power = |exponent: f64| 10.0_f64.powf(exponent);
        let cloud: Vec<_> = exponents.iter().map(|e| Point3::from(e.map(power))).collect();
        for estimate in [estimate_voxel_size(&cloud), estimate_resolution(&cloud)] {
            prop_assert!(estimate.unwrap().is_none_or(|length| (1e-100..=1e100).contains(&length)));
        }
    }
}
