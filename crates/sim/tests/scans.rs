//! Laws that simulated scans obey as a whole.

#![allow(clippy::unwrap_used)]

use gmpcr_eval::{OverlapIndex, overlap_matrix};
use gmpcr_posegraph::Connectivity;
use gmpcr_sim::{DepthCamera, DepthNoise, Error, RoomParams, SimParams, SimulatedScans, simulate};
use nalgebra::DMatrix;

fn small(seed: u64) -> SimParams {
    let camera = DepthCamera {
        width: 80,
        height: 60,
        ..DepthCamera::default()
    };
    SimParams {
        seed,
        num_scans: 5,
        camera,
        ..SimParams::default()
    }
}

/// Overlap of all pairs, counted as indoor benchmarks do: within 1.5 voxels.
fn overlaps(scans: &SimulatedScans) -> DMatrix<f64> {
    let radius = 1.5 * SimParams::default().voxel;
    overlap_matrix(&scans.clouds, &scans.world_from_scan, radius).unwrap()
}

fn pairs(num_scans: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..num_scans).flat_map(move |i| (i + 1..num_scans).map(move |j| (i, j)))
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_other_scans() {
    let first = simulate(&small(1)).unwrap();
    assert_eq!(first, simulate(&small(1)).unwrap());
    assert_ne!(first, simulate(&small(2)).unwrap());
}

#[test]
fn more_scans_leave_the_first_ones_as_they_are() {
    let few = simulate(&small(1)).unwrap();
    let more = simulate(&SimParams {
        num_scans: 8,
        ..small(1)
    })
    .unwrap();
    assert_eq!(few.clouds[..], more.clouds[..5]);
    assert_eq!(few.world_from_scan[..], more.world_from_scan[..5]);
}

#[test]
fn the_ground_truth_aligns_consecutive_scans_and_the_identity_does_not() {
    let scans = simulate(&small(3)).unwrap();
    for k in 1..scans.clouds.len() {
        let i_from_j = scans.world_from_scan[k - 1].inv_mul(&scans.world_from_scan[k]);
        let index = |k: usize| OverlapIndex::new(&scans.clouds[k], 0.06);
        let (i, j) = (index(k - 1), index(k));
        let aligned = i.overlap(&j, &i_from_j);
        let as_they_are = i.overlap(&j, &nalgebra::Isometry3::identity());
        assert!(aligned > 0.25, "{aligned}");
        assert!(as_they_are < 0.5 * aligned, "{as_they_are} {aligned}");
    }
}

#[test]
fn default_scans_hold_enough_points_and_are_connected() {
    for seed in [SimParams::default().seed, 1, 2] {
        let scans = simulate(&SimParams {
            seed,
            ..SimParams::default()
        })
        .unwrap();
        assert_eq!(scans.clouds.len(), 24);
        for cloud in &scans.clouds {
            assert!(
                (6_000..35_000).contains(&cloud.len()),
                "seed {seed}: {}",
                cloud.len()
            );
        }
        let overlap = overlaps(&scans);
        let edges: Vec<_> = pairs(24).filter(|&pair| overlap[pair] >= 0.3).collect();
        assert!(Connectivity::new(24, &edges, 0).is_connected, "seed {seed}");
    }
}

#[test]
fn most_default_pairs_overlap_little() {
    let scans = simulate(&SimParams::default()).unwrap();
    let overlap = overlaps(&scans);
    let low = pairs(24).filter(|&pair| overlap[pair] < 0.3).count();
    assert!(low as f64 > 0.6 * pairs(24).count() as f64, "{low}");
}

#[test]
fn a_scan_is_rotated_at_random_about_its_sensor() {
    let params = SimParams {
        frames_per_scan: 1,
        voxel: 0.0,
        ..small(4)
    };
    let scans = simulate(&params).unwrap();
    let far = params.camera.max_range * 1.4;
    for cloud in &scans.clouds {
        assert!(cloud.iter().all(|point| point.coords.norm() < far));
    }
    let directions: Vec<_> = scans
        .clouds
        .iter()
        .map(|cloud| mean_direction(cloud))
        .collect();
    assert!(
        directions
            .windows(2)
            .any(|pair| pair[0].dot(&pair[1]) < 0.5)
    );
}

fn mean_direction(cloud: &[nalgebra::Point3<f64>]) -> nalgebra::Vector3<f64> {
    cloud
        .iter()
        .map(|point| point.coords)
        .sum::<nalgebra::Vector3<f64>>()
        .normalize()
}

#[test]
fn a_lone_scan_and_several_rooms_are_fine() {
    let room = RoomParams {
        num_rooms: 2,
        ..RoomParams::default()
    };
    let scans = simulate(&SimParams {
        num_scans: 1,
        room,
        ..small(2)
    })
    .unwrap();
    assert_eq!((scans.clouds.len(), scans.world_from_scan.len()), (1, 1));
    assert!(
        simulate(&SimParams {
            num_scans: 30,
            room,
            ..small(2)
        })
        .is_ok()
    );
}

#[test]
fn parameters_out_of_range_are_named() {
    let camera = DepthCamera::default();
    let noise = DepthNoise::default();
    let narrow = DepthCamera {
        horizontal_fov: f64::NAN,
        ..camera
    };
    let reversed = DepthCamera {
        max_range: 0.1,
        ..camera
    };
    let loud = DepthCamera {
        noise: DepthNoise {
            dropout: 2.0,
            ..noise
        },
        ..camera
    };
    let cases = [
        (
            SimParams {
                num_scans: 0,
                ..small(1)
            },
            "num_scans",
        ),
        (
            SimParams {
                frames_per_scan: 0,
                ..small(1)
            },
            "frames_per_scan",
        ),
        (
            SimParams {
                voxel: -1.0,
                ..small(1)
            },
            "voxel",
        ),
        (
            SimParams {
                half_pan: f64::INFINITY,
                ..small(1)
            },
            "half_pan",
        ),
        (
            SimParams {
                camera: DepthCamera { width: 0, ..camera },
                ..small(1)
            },
            "camera.width",
        ),
        (
            SimParams {
                camera: narrow,
                ..small(1)
            },
            "camera.horizontal_fov",
        ),
        (
            SimParams {
                camera: reversed,
                ..small(1)
            },
            "camera.max_range",
        ),
        (
            SimParams {
                camera: loud,
                ..small(1)
            },
            "camera.noise.dropout",
        ),
    ];
    for (params, expected) in cases {
        match simulate(&params).unwrap_err() {
            Error::Parameter(parameter) => assert_eq!(parameter.name, expected),
            other => panic!("{other}"),
        }
    }
}
