//! Laws that simulated scans obey as a whole.

use gmpcr_sim::{
    DepthCamera, DepthNoise, Error, RoomParams, SimParams, SimulatedScans, overlap,
    overlap_components, overlap_matrix, simulate, thin,
};

/// Overlap is counted as indoor benchmarks do: 2.5 cm voxels, a radius of 1.5 voxels.
const VOXEL: f64 = 0.025;
const RADIUS: f64 = 0.0375;

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

fn thinned(scans: &SimulatedScans) -> SimulatedScans {
    SimulatedScans {
        clouds: scans
            .clouds
            .iter()
            .map(|cloud| thin(cloud, VOXEL))
            .collect(),
        world_from_scan: scans.world_from_scan.clone(),
    }
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
fn the_true_poses_align_consecutive_scans_and_the_identity_does_not() {
    let scans = simulate(&small(3)).unwrap();
    for k in 1..scans.clouds.len() {
        let i_from_j = scans.world_from_scan[k - 1].inv_mul(&scans.world_from_scan[k]);
        let (i, j) = (&scans.clouds[k - 1], &scans.clouds[k]);
        let aligned = overlap(i, j, &i_from_j, 0.06);
        let as_they_are = overlap(i, j, &nalgebra::Isometry3::identity(), 0.06);
        assert!(aligned > 0.25, "{aligned}");
        assert!(as_they_are < 0.5 * aligned, "{as_they_are} {aligned}");
    }
}

#[test]
fn default_scans_hold_enough_points_and_hang_together() {
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
        let overlap = overlap_matrix(&thinned(&scans), RADIUS);
        assert_eq!(overlap_components(&overlap, 0.3), [0; 24], "seed {seed}");
    }
}

#[test]
fn most_default_pairs_overlap_little() {
    let scans = simulate(&SimParams::default()).unwrap();
    let overlap = overlap_matrix(&thinned(&scans), RADIUS);
    let pairs = || (0..24).flat_map(|i| (i + 1..24).map(move |j| (i, j)));
    let low = pairs().filter(|&(i, j)| overlap[(i, j)] < 0.3).count();
    assert!(low as f64 > 0.6 * pairs().count() as f64, "{low}");
}

#[test]
fn a_scan_is_turned_at_random_about_its_sensor() {
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
fn nonsense_parameters_are_refused_by_name() {
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
            "camera width",
        ),
        (
            SimParams {
                camera: narrow,
                ..small(1)
            },
            "horizontal_fov",
        ),
        (
            SimParams {
                camera: reversed,
                ..small(1)
            },
            "max_range",
        ),
        (
            SimParams {
                camera: loud,
                ..small(1)
            },
            "dropout",
        ),
    ];
    for (params, expected) in cases {
        match simulate(&params).unwrap_err() {
            Error::Zero { name } | Error::OutOfRange { name, .. } => assert_eq!(name, expected),
            other => panic!("{other}"),
        }
    }
}
