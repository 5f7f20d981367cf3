//! From raw clouds to scans, and back to the coordinates of the clouds.
#![cfg(feature = "fpfh")]
#![allow(clippy::unwrap_used)]

use gmpcr::features::FeatureParams;
use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
use gmpcr::{
    Cloud, Error, Params, ScanSet, VoxelSize, compute_features, compute_features_with, register,
};
use gmpcr_sim::{SimParams, simulate};

/// Scans of a furnished room, and their poses.
fn room() -> (Vec<Cloud>, Vec<Isometry3<f64>>) {
    let params = SimParams {
        num_scans: 5,
        ..SimParams::default()
    };
    let scans = simulate(&params).unwrap();
    let clouds = scans.clouds.into_iter().map(Cloud::new);
    (clouds.collect(), scans.world_from_scan)
}

#[test]
fn one_wild_point_costs_nothing_but_itself() {
    let (clouds, _) = room();
    for wild in [f64::NAN, f64::INFINITY, f64::from(f32::MAX), 1e99, 1e200] {
        let mut clouds = clouds.clone();
        clouds[1].points.push(Point3::new(wild, 0.0, 0.0));
        let set = compute_features(clouds).unwrap();
        assert_eq!(set.num_strays, [0, 1, 0, 0, 0], "{wild}");
        assert!(set.problems.iter().all(Option::is_none));
        assert!(set.scans.iter().all(|scan| scan.len() > 100));
    }
}

#[test]
fn georeferenced_clouds_are_registered_near_zero_and_come_back() {
    let (clouds, world_from_scan) = room();
    // The axes of the room, far from zero: as files of a survey have them.
    let far = Vector3::new(448_262.0, 5_411_932.0, 120.0);
    let far_clouds = clouds.iter().zip(&world_from_scan).map(|(cloud, pose)| {
        let points = cloud.points.iter().map(|point| pose * point + far);
        Cloud::new(points.collect())
    });
    let params = FeatureParams::from_voxel_size(0.05);
    let set = compute_features_with(far_clouds.collect(), &params, VoxelSize::Given, &()).unwrap();
    let reach = |cloud: &gmpcr::features::LocalCloud| {
        let lengths = cloud.points.iter().map(|point| point.coords.norm());
        lengths.fold(0.0, f64::max)
    };
    assert!(set.clouds.iter().all(|cloud| reach(cloud) < 20.0));
    let registration = set.in_cloud_frames(register(&set.scans, &Params::default()).unwrap());
    assert!(registration.connectivity.is_connected);
    // The clouds share the coordinates of the survey already, so every pose nearly keeps its points.
    let world_from_local = set.world_from_local(&registration);
    for (k, cloud) in set.clouds.iter().enumerate() {
        let surveyed = cloud.original_from_local() * cloud.points[0];
        let moved = registration.world_from_scan[k] * surveyed;
        assert!((moved - surveyed).norm() < 0.5, "scan {k}: {moved}");
        assert!((world_from_local[k] * cloud.points[0] - moved).norm() < 1e-6);
    }
    let edge = &registration.edges[0];
    let between = set.between_clouds(edge.i, &Isometry3::identity(), edge.j);
    let origins = set.clouds[edge.i].origin - set.clouds[edge.j].origin;
    assert!((between.translation.vector - origins).norm() < 1e-9);
}

#[test]
fn features_from_elsewhere_are_taken_to_the_coordinates_of_their_clouds() {
    let (clouds, _) = room();
    let set = compute_features(clouds.clone()).unwrap();
    let same = ScanSet::with_scans(clouds.clone(), set.scans.clone(), None, &()).unwrap();
    assert_eq!((same.voxel_size, &same.scans), (set.voxel_size, &set.scans));
    let given = ScanSet::with_scans(clouds.clone(), set.scans.clone(), Some(0.3), &()).unwrap();
    assert_eq!(given.voxel_size, 0.3);
    let outcome = ScanSet::with_scans(clouds[1..].to_vec(), set.scans, None, &());
    assert!(matches!(
        outcome,
        Err(Error::ScansAndClouds {
            scans: 5,
            clouds: 4
        })
    ));
}

#[test]
fn clouds_without_extent_and_parameters_out_of_range_are_an_error() {
    let point = Cloud::new(vec![Point3::new(1.0, 2.0, 3.0); 50]);
    for clouds in [vec![], vec![Cloud::default()], vec![point]] {
        assert!(matches!(compute_features(clouds), Err(Error::NoExtent)));
    }
    let params = FeatureParams::from_voxel_size(-1.0);
    let outcome = compute_features_with(vec![], &params, VoxelSize::Given, &());
    let message = outcome.unwrap_err().to_string();
    assert!(
        message.starts_with("parameter features.voxel_size is -1"),
        "{message}"
    );
}
