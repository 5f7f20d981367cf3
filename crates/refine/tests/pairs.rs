//! Laws of verification and refinement of pairs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail")]

mod common;

use common::{Rectangle, distance, nudge, room, sample, scan, surface};
use gmpcr_refine::{
    EquationParams, IcpParams, PairRefinement, Surface, SurfaceParams, VerifyParams,
    pair_equations, refine_pair, verify_pair,
};
use nalgebra::{Isometry3, Matrix6, Point3, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;

fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-limit..limit)
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (vector(30.0), vector(1.5)).prop_map(|(t, r)| Isometry3::new(t.into(), r.into()))
}

/// A small transformation in the room.
fn error() -> impl Strategy<Value = Isometry3<f64>> {
    (vector(0.03), vector(0.8)).prop_map(|(r, t)| nudge(r, t))
}

fn refine(i: &Surface, j: &Surface, start: &Isometry3<f64>) -> PairRefinement {
    refine_pair(i, j, start, &IcpParams::precise()).unwrap()
}

/// Logarithm of a small transformation, translation first.
fn log(transformation: &Isometry3<f64>) -> Vector6<f64> {
    let (t, r) = (
        transformation.translation.vector,
        transformation.rotation.scaled_axis(),
    );
    Vector6::new(t.x, t.y, t.z, r.x, r.y, r.z)
}

/// A scan of the room that is not smoothed.
fn as_they_are(noise: f64, seed: u64) -> Surface {
    let (points, normals) = sample(&room(), &Isometry3::identity(), noise, seed);
    let params = SurfaceParams {
        smoothing_radius: 0.0,
        ..SurfaceParams::from_voxel_size(1.0)
    };
    Surface::new(&points, &normals, &params).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn noise_free_planes_lead_to_the_exact_pose(
        i_from_room in pose(), j_from_room in pose(), error in error(), seed in 1..1000_u64,
    ) {
        let i = scan(&room(), &i_from_room, 0.0, seed);
        let j = scan(&room(), &j_from_room, 0.0, seed + 1000);
        let found = refine(&i, &j, &(i_from_room * error * j_from_room.inverse()));
        let in_room = i_from_room.inverse() * found.i_from_j * j_from_room;
        prop_assert!(distance(&in_room, &Isometry3::identity()) < 1e-3, "{in_room}");
        prop_assert!(found.converged && found.undetermined.is_empty());
        prop_assert!(found.equations.median < 1e-4);
    }

    #[test]
    fn swapping_the_scans_inverts_the_pose(
        j_from_room in pose(), error in error(), seed in 1..1000_u64,
    ) {
        let i = scan(&room(), &Isometry3::identity(), 0.05, seed);
        let j = scan(&room(), &j_from_room, 0.05, seed + 1000);
        let start = error * j_from_room.inverse();
        let (forward, backward) = (refine(&i, &j, &start), refine(&j, &i, &start.inverse()));
        let product = forward.i_from_j * backward.i_from_j;
        prop_assert!(distance(&product, &Isometry3::identity()) < 1e-6, "{product}");
        let values = [&forward, &backward].map(|found| found.smallest_eigenvalue);
        prop_assert!((values[0] / values[1] - 1.0).abs() < 1e-6, "{values:?}");

        let params = VerifyParams::default();
        let there = verify_pair(&i, &j, &start, &params).unwrap();
        let back = verify_pair(&j, &i, &start.inverse(), &params).unwrap();
        prop_assert_eq!(there.overlap(), back.swapped().overlap());
        prop_assert_eq!(there.of_j_in_i.hits, back.of_i_in_j.hits);
    }

    /// The grid begins at the smallest coordinates of the points, so a translation changes rounding only.
    #[test]
    fn translating_a_frame_translates_the_pose(
        translation in vector(500.0), error in error(), seed in 1..1000_u64,
    ) {
        let i = scan(&room(), &Isometry3::identity(), 0.05, seed);
        let j = scan(&room(), &Isometry3::identity(), 0.05, seed + 1000);
        let moved_from_j = Isometry3::translation(translation[0], translation[1], translation[2]);
        let moved = scan(&room(), &moved_from_j, 0.05, seed + 1000);
        let here = refine(&i, &j, &error);
        let there = refine(&i, &moved, &(error * moved_from_j.inverse()));
        prop_assert!(distance(&(there.i_from_j * moved_from_j), &here.i_from_j) < 1e-6);
        prop_assert!((there.smallest_eigenvalue / here.smallest_eigenvalue - 1.0).abs() < 1e-6);
    }

    /// A rotation changes the cells and the choice of queries: results agree as far as the noise, 0.05, and
    /// the number of points permit.
    #[test]
    fn rotating_a_frame_rotates_the_pose_within_the_sampling(
        moved_from_j in pose(), error in error(), seed in 1..1000_u64,
    ) {
        let i = scan(&room(), &Isometry3::identity(), 0.05, seed);
        let j = scan(&room(), &Isometry3::identity(), 0.05, seed + 1000);
        let moved = scan(&room(), &moved_from_j, 0.05, seed + 1000);
        let here = refine(&i, &j, &error);
        let there = refine(&i, &moved, &(error * moved_from_j.inverse()));
        prop_assert!(distance(&(there.i_from_j * moved_from_j), &here.i_from_j) < 0.1);
        let params = VerifyParams::default();
        let counts = verify_pair(&i, &j, &here.i_from_j, &params).unwrap();
        let of_moved = verify_pair(&i, &moved, &there.i_from_j, &params).unwrap();
        prop_assert!(counts.overlap().abs_diff(of_moved.overlap()) < 60);
    }

    /// The squared error in units of the information matrix has six degrees of freedom: its mean is 6 for
    /// independent residuals. Points that are nearest to several queries bring it to about twice that.
    #[test]
    fn noise_permits_the_error_that_the_information_states(seed in 1..100_000_u64, error in error()) {
        let [i, j] = [seed, seed + 100_000].map(|seed| as_they_are(0.1, seed));
        let found = refine(&i, &j, &error);
        let xi = log(&found.i_from_j);
        let squared = xi.dot(&(found.information() * xi));
        prop_assert!(squared < 60.0, "{squared}");
        prop_assert!(distance(&found.i_from_j, &Isometry3::identity()) < 0.1);
        // Two independent errors of 0.1 in each residual.
        let sigma = found.variance.sqrt();
        prop_assert!((0.1..0.16).contains(&sigma), "{sigma}");
    }

    #[test]
    fn the_order_of_the_points_does_not_matter(seed in 1..1000_u64, error in error()) {
        let (mut points, mut normals) = sample(&room(), &Isometry3::identity(), 0.05, seed);
        let other = scan(&room(), &Isometry3::identity(), 0.05, seed + 1000);
        let here = refine(&surface(&points, &normals), &other, &error);
        points.reverse();
        normals.reverse();
        points.rotate_left(17);
        normals.rotate_left(17);
        prop_assert_eq!(refine(&surface(&points, &normals), &other, &error), here);
    }
}

#[test]
fn the_hessian_is_the_derivative_of_the_gradient() {
    // Around the exact pose of noise-free planes, where residuals vanish, the equations are those of the
    // cost, up to the rotation of the mean normals, which moves residuals by half the distance of the
    // corresponding points.
    let i = scan(&room(), &Isometry3::identity(), 0.0, 5);
    let j_from_room = Isometry3::new(Vector3::new(3.0, -2.0, 1.0), Vector3::new(0.3, 0.5, -1.0));
    let j = scan(&room(), &j_from_room, 0.0, 6);
    let pose = j_from_room.inverse();
    let at =
        |pose: &Isometry3<f64>| pair_equations(&i, &j, pose, &EquationParams::default()).unwrap();
    let step = 1e-5;
    let gradient = |xi: Vector6<f64>| {
        let (v, omega) = (xi.fixed_rows::<3>(0), xi.fixed_rows::<3>(3));
        let rotation = UnitQuaternion::from_scaled_axis(omega.into_owned());
        let exp = Isometry3::from_parts(v.into_owned().into(), rotation);
        at(&(pose * exp)).gradient
    };
    let columns = [0, 1, 2, 3, 4, 5].map(|k| {
        let along = Vector6::ith(k, step);
        (gradient(along) - gradient(-along)) / (2.0 * step)
    });
    let numerical = Matrix6::from_columns(&columns);
    let hessian = at(&pose).hessian;
    assert_eq!(hessian, hessian.transpose());
    let deviation = (numerical - hessian).norm() / hessian.norm();
    assert!(deviation < 0.01, "{deviation}");
    let translations = (numerical - hessian).fixed_view::<3, 3>(0, 0).norm();
    assert!(translations < 1e-4 * hessian.norm(), "{translations}");
}

#[test]
fn smoothed_surfaces_have_smaller_errors() {
    let start = nudge([0.01, -0.01, 0.02], [0.3, 0.2, -0.4]);
    let mean_error = |scan_of: &dyn Fn(u64) -> Surface| {
        let errors = (1..20).map(|seed| {
            let found = refine(&scan_of(seed), &scan_of(seed + 100), &start);
            distance(&found.i_from_j, &Isometry3::identity())
        });
        errors.sum::<f64>() / 19.0
    };
    let as_they_are = mean_error(&|seed| as_they_are(0.2, seed));
    let smoothed = mean_error(&|seed| scan(&room(), &Isometry3::identity(), 0.2, seed));
    assert!(smoothed < 0.8 * as_they_are, "{smoothed} {as_they_are}");
}

#[test]
fn the_information_counts_each_correspondence_by_the_variance() {
    let i = scan(&room(), &Isometry3::identity(), 0.1, 1);
    let j = scan(&room(), &Isometry3::identity(), 0.1, 2);
    let found = refine(&i, &j, &Isometry3::identity());
    let trace = found.information().fixed_view::<3, 3>(0, 0).trace();
    assert!((trace / (found.equations.weight / found.variance) - 1.0).abs() < 1e-12);
}

#[test]
fn a_plane_alone_leaves_three_directions_as_they_were() {
    let plane = [room()[0]];
    let (i, j) = (
        scan(&plane, &Isometry3::identity(), 0.02, 1),
        scan(&plane, &Isometry3::identity(), 0.02, 2),
    );
    let start = nudge([0.02, -0.01, 0.05], [0.7, -0.4, 0.5]);
    let found = refine(&i, &j, &start);
    assert_eq!(found.undetermined.len(), 3);
    // Back in the plane, but neither rotated nor moved along it.
    let (moved, rotation) = (
        found.i_from_j * Point3::new(12.0, 10.0, 0.0),
        found.i_from_j.rotation,
    );
    assert!(moved.z.abs() < 0.02 && (rotation * Vector3::z()).z > 1.0 - 1e-5);
    assert!((moved.xy() - (start * Point3::new(12.0, 10.0, 0.0)).xy()).norm() < 0.02);
    assert!((rotation.scaled_axis().z - 0.05).abs() < 1e-3);
    assert!(found.smallest_eigenvalue < 1e-6);
}

#[test]
fn a_corridor_lets_scans_slide() {
    let corridor = [room()[0], room()[1], room()[3]];
    let (i, j) = (
        scan(&corridor, &Isometry3::identity(), 0.02, 1),
        scan(&corridor, &Isometry3::identity(), 0.02, 2),
    );
    let start = nudge([0.01, 0.01, 0.02], [0.5, 0.8, -0.4]);
    let found = refine(&i, &j, &start);
    assert_eq!(found.undetermined.len(), 1);
    let slide = found.undetermined[0].fixed_rows::<3>(0).normalize();
    assert!(slide.y.abs() > 0.999, "{slide}");
    let moved = found.i_from_j * Point3::new(12.0, 10.0, 5.0) - Point3::new(12.0, 10.0, 5.0);
    assert!(
        moved.x.abs() < 0.02 && moved.z.abs() < 0.02 && (moved.y - 0.8).abs() < 0.1,
        "{moved}"
    );
}

#[test]
fn a_scan_and_itself_stay_where_they_are() {
    let i = scan(&room(), &Isometry3::identity(), 0.1, 1);
    let found = refine(&i, &i, &Isometry3::identity());
    assert!(distance(&found.i_from_j, &Isometry3::identity()) < 1e-9);
    let counts = verify_pair(&i, &i, &Isometry3::identity(), &VerifyParams::default()).unwrap();
    assert_eq!(counts.of_j_in_i, counts.of_i_in_j);
    assert!(counts.overlap() > 1100, "{counts:?}");
}

#[test]
fn few_points_refine_nothing_and_overlap_with_little() {
    let whole = scan(&room(), &Isometry3::identity(), 0.0, 1);
    let (points, normals) = sample(&room(), &Isometry3::identity(), 0.0, 2);
    let start = nudge([0.01, 0.0, 0.0], [0.1, 0.2, 0.3]);
    for count in 0..4 {
        let few = surface(&points[..count], &normals[..count]);
        assert_eq!((few.len(), few.is_empty()), (count, count == 0));
        for (i, j) in [(&whole, &few), (&few, &whole), (&few, &few)] {
            let counts =
                verify_pair(i, j, &Isometry3::identity(), &VerifyParams::default()).unwrap();
            assert!(counts.overlap() <= 20 * count, "{counts:?}");
            let found = refine_pair(&few, &few, &start, &IcpParams::default()).unwrap();
            assert_eq!(
                (found.i_from_j, found.converged, found.steps),
                (start, false, 0)
            );
            assert_eq!(found.undetermined.len(), 6);
            assert!(found.information().iter().all(|entry| entry.is_finite()));
        }
    }
}

#[test]
fn points_at_one_place_determine_nothing() {
    let place = surface(&[Point3::origin(); 20], &[Vector3::z(); 20]);
    let found = refine(&place, &place, &Isometry3::translation(0.0, 0.0, 0.3));
    assert!(found.i_from_j.translation.vector.norm() < 0.31);
    assert!(
        found
            .i_from_j
            .to_matrix()
            .iter()
            .all(|entry| entry.is_finite())
    );
}

#[test]
fn strangers_overlap_with_nothing() {
    let whole = scan(&room(), &Isometry3::identity(), 0.0, 1);
    let stranger = scan(&room(), &Isometry3::translation(300.0, 0.0, 0.0), 0.0, 2);
    let counts = verify_pair(
        &whole,
        &stranger,
        &Isometry3::identity(),
        &VerifyParams::default(),
    )
    .unwrap();
    assert_eq!(
        (counts.hits(), counts.overlap(), counts.plane_rms()),
        (0, 0, None)
    );
    let found = refine(&whole, &stranger, &Isometry3::identity());
    assert_eq!(found.i_from_j, Isometry3::identity());
}

#[test]
fn opposite_sides_of_a_wall_are_hits_but_no_overlap() {
    let mut back = room()[0];
    back.normal = -back.normal;
    let (front, back) = (
        scan(&room()[..1], &Isometry3::identity(), 0.0, 1),
        scan(&[back], &Isometry3::identity(), 0.0, 2),
    );
    let counts = verify_pair(
        &front,
        &back,
        &Isometry3::identity(),
        &VerifyParams::default(),
    )
    .unwrap();
    assert!(counts.hits() > 850 && counts.overlap() == 0);
    assert!(counts.normal_agreement() == 0.0);
}

#[test]
fn points_without_normals_are_left_out() {
    let (points, mut normals) = sample(&room(), &Isometry3::identity(), 0.0, 1);
    for normal in normals.iter_mut().step_by(2) {
        *normal = Vector3::zeros();
    }
    assert_eq!(surface(&points, &normals).len(), points.len() / 2);
}

/// A wall in front of a sensor at the origin, with raw points that fill its image.
fn wall(depth: f64, seed: u64) -> (Surface, Vec<Point3<f64>>) {
    let rectangle = Rectangle::new(
        [-15.0, -15.0, depth],
        [30.0, 0.0, 0.0],
        [0.0, 30.0, 0.0],
        [0.0, 0.0, -1.0],
    );
    let raw = (0..40_000).map(|k| {
        Point3::new(
            f64::from(k % 200) * 0.15 - 15.0,
            f64::from(k / 200) * 0.15 - 15.0,
            depth,
        )
    });
    (
        scan(&[rectangle], &Isometry3::identity(), 0.0, seed),
        raw.collect(),
    )
}

#[test]
fn a_wall_in_front_of_anothers_view_violates_free_space() {
    let ((far, raw), (near, _)) = (wall(40.0, 1), wall(20.0, 2));
    let blind = verify_pair(
        &far,
        &near,
        &Isometry3::identity(),
        &VerifyParams::default(),
    )
    .unwrap();
    assert!(!blind.has_visibility() && blind.violations() == 0);

    for viewpoint in [Point3::origin(), Point3::new(-7.0, 3.0, -1.0)] {
        let far = far.clone().seen_from(viewpoint, &raw).unwrap();
        let at = |pose: &Isometry3<f64>| {
            verify_pair(&far, &near, pose, &VerifyParams::default()).unwrap()
        };
        let before = at(&Isometry3::identity());
        assert!(before.has_visibility() && before.is_contradicted());
        assert!(
            before.of_j_in_i.violations > 80 && before.of_i_in_j.violations == 0,
            "{before:?}"
        );
        assert_eq!(before.of_i_in_j.judged, 0);
        let same = at(&Isometry3::translation(0.0, 0.0, 20.0));
        assert_eq!((same.violations(), same.is_contradicted()), (0, false));
        assert!(same.overlap() > 1100 && same.smaller_side_ratio() > 0.95);
        let behind = at(&Isometry3::translation(0.0, 0.0, 30.0));
        assert!(
            behind.violations() == 0 && behind.of_j_in_i.behind > 250,
            "{behind:?}"
        );
    }
}

#[test]
fn surfaces_of_other_units_give_the_same_counts() {
    let scaled = |factor: f64, seed: u64| {
        let (points, normals) = sample(&room(), &Isometry3::identity(), 0.0, seed);
        let points: Vec<_> = points.iter().map(|point| point * factor).collect();
        Surface::new(&points, &normals, &SurfaceParams::from_voxel_size(factor)).unwrap()
    };
    let start = nudge([0.01, 0.0, 0.02], [0.3, 0.1, -0.2]);
    let found = [1.0, 64.0].map(|factor| {
        let mut start = start;
        start.translation.vector *= factor;
        refine(&scaled(factor, 1), &scaled(factor, 2), &start)
    });
    let translations = [
        found[0].i_from_j.translation.vector * 64.0,
        found[1].i_from_j.translation.vector,
    ];
    assert!((translations[0] - translations[1]).norm() < 1e-6);
    assert!((found[0].smallest_eigenvalue / found[1].smallest_eigenvalue - 1.0).abs() < 1e-6);
}
