//! From a seed to scans with ground truth.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::building::{Building, RoomParams};
use crate::camera::DepthCamera;
use crate::downsample::downsample;
use crate::error::{Error, InvalidParameter, check_count, check_range};
use crate::random::{Stream, generator, rigid_transformation, rotation, uniform};
use crate::scene::Scene;
use crate::tour;

/// What to simulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimParams {
    /// The same seed gives the same bits. Default 7.
    pub seed: u64,
    /// Scans to take, 1 to a million. Default 24. A walk through one room takes about 13 scans;
    /// more scans than the rooms need revisit them from other viewpoints.
    pub num_scans: usize,
    /// The flat.
    pub room: RoomParams,
    /// The camera.
    pub camera: DepthCamera,
    /// Depth images fused into one scan, 1 to a million, taken while the camera pans. Default 2.
    pub frames_per_scan: usize,
    /// Half the angle that the camera pans during a scan, in radians, 0 to 1. Default 6°.
    pub half_pan: f64,
    /// Points of the fused images are averaged over voxels of this size, in meters, 0 to 1;
    /// 0 keeps every point. Default 0.03.
    pub voxel: f64,
}

impl Default for SimParams {
    fn default() -> Self {
        Self {
            seed: 7,
            num_scans: 24,
            room: RoomParams::default(),
            camera: DepthCamera::default(),
            frames_per_scan: 2,
            half_pan: 6.0_f64.to_radians(),
            voxel: 0.03,
        }
    }
}

impl SimParams {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_count("num_scans", self.num_scans)?;
        check_count("frames_per_scan", self.frames_per_scan)?;
        check_range("half_pan", self.half_pan, 0.0..=1.0, "in [0, 1]")?;
        check_range("voxel", self.voxel, 0.0..=1.0, "in [0, 1]")?;
        self.room.validate().map_err(|e| e.within("room"))?;
        self.camera.validate().map_err(|e| e.within("camera"))
    }
}

/// Scans and their ground truth poses.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedScans {
    /// One cloud per scan, in the scan's own frame, the sensor at the origin. The frame is
    /// rotated at random, so that no common upward axis is given away.
    pub clouds: Vec<Vec<Point3<f64>>>,
    /// The ground truth pose of each scan. The world itself is rotated and translated at random.
    pub world_from_scan: Vec<Isometry3<f64>>,
}

/// Takes scans of a generated flat along a walk with a hand-held depth camera.
///
/// Each scan fuses a few depth images, as the fragments of RGB-D benchmarks do; their relative
/// poses are exact. Consecutive scans see about half of the same surfaces, most
/// other pairs few or none. Time is linear in the number of depth images.
///
/// # Errors
/// [`Error::Parameter`] for a parameter outside its documented range,
/// [`Error::NoViewpoint`] where the camera cannot see enough of the flat.
pub fn simulate(params: &SimParams) -> Result<SimulatedScans, Error> {
    params.validate()?;
    let building = Building::generate(params.seed, &params.room);
    let mut tour_rng = generator(params.seed, Stream::Tour);
    let walk = tour::walk(&building, &params.camera, params.num_scans, &mut tour_rng)?;
    let world_from_building = rigid_transformation(&mut generator(params.seed, Stream::World), 5.0);

    let mut scans = SimulatedScans {
        clouds: Vec::new(),
        world_from_scan: Vec::new(),
    };
    for (scan, building_from_camera) in walk.iter().enumerate() {
        let mut rng = generator(params.seed, Stream::Scan(scan));
        let scan_from_camera = rotation(&mut rng);
        let cloud = fuse(params, &building.scene, building_from_camera, &mut rng);
        scans
            .clouds
            .push(cloud.iter().map(|point| scan_from_camera * point).collect());
        let building_from_scan = building_from_camera * scan_from_camera.inverse();
        scans
            .world_from_scan
            .push(world_from_building * building_from_scan);
    }
    Ok(scans)
}

/// The images of one scan in the frame of its middle viewpoint, averaged over voxels.
fn fuse(
    params: &SimParams,
    scene: &Scene,
    building_from_camera: &Isometry3<f64>,
    rng: &mut ChaCha8Rng,
) -> Vec<Point3<f64>> {
    let mut fused = Vec::new();
    for frame in 0..params.frames_per_scan {
        let camera_from_frame = frame_pose(params, frame, rng);
        let image = params
            .camera
            .scan(scene, &(building_from_camera * camera_from_frame), rng);
        fused.extend(image.iter().map(|point| camera_from_frame * point));
    }
    downsample(&fused, params.voxel)
}

/// Where the camera is at one image of a scan: panned evenly, and unsteady by centimeters.
/// A scan of one image is taken from the middle exactly.
fn frame_pose(params: &SimParams, frame: usize, rng: &mut ChaCha8Rng) -> Isometry3<f64> {
    if params.frames_per_scan == 1 {
        return Isometry3::identity();
    }
    let along = 2.0 * frame as f64 / (params.frames_per_scan - 1) as f64 - 1.0;
    let pan = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), along * params.half_pan);
    let nod = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), uniform(rng, -0.04, 0.04));
    let sway = Vector3::from([(); 3].map(|()| uniform(rng, -0.04, 0.04)));
    Isometry3::from_parts(Translation3::from(sway), pan * nod)
}
