//! Scans from files or from the simulator, with the ground truth where it is known.

use std::error::Error;
use std::path::Path;

use gmpcr::features::FeatureParams;
use gmpcr::io::{Layout, Scene, read_points, read_scene};
use gmpcr::{Cloud, ScanSet, VoxelSize, compute_features_with};
use gmpcr_sim::{RoomParams, SimParams, simulate};

use crate::Arguments;
use crate::ground_truth::{self, GroundTruth};

/// What is to be registered.
pub struct Input {
    pub set: ScanSet,
    pub ground_truth: Vec<GroundTruth>,
}

impl Input {
    pub fn simulate(arguments: &Arguments) -> Result<Self, Box<dyn Error>> {
        let room = RoomParams {
            num_rooms: arguments.rooms,
            ..RoomParams::default()
        };
        let scans = simulate(&SimParams {
            num_scans: arguments.scans,
            seed: arguments.seed,
            room,
            ..SimParams::default()
        })?;
        let ground_truth = ground_truth::of_simulation(&scans)?;
        let clouds = scans.clouds.into_iter().map(Cloud::new);
        Ok(Self {
            set: with_fpfh(clouds.collect(), arguments.voxel)?,
            ground_truth,
        })
    }

    /// Scans with learned descriptors if all have some, with FPFH otherwise.
    pub fn read(folder: &Path, arguments: &Arguments) -> Result<Self, Box<dyn Error>> {
        let mut scene = match Layout::of(folder)? {
            Some(layout) => read_scene(folder, layout)?,
            None => Scene::of_clouds(folder)?,
        };
        if let Some(descriptors) = &arguments.descriptors {
            scene.attach_descriptors(descriptors)?;
        }
        let clouds = scene.scans.iter().map(|scan| match &scan.cloud {
            Some(file) => Ok(read_points(file)?.into()),
            None => Err("the scene has descriptors but no clouds".into()),
        });
        let clouds = clouds.collect::<Result<_, Box<dyn Error>>>()?;
        let descriptors = scene.scans.iter().map(|scan| scan.descriptors.as_ref());
        let set = match descriptors.collect::<Option<Vec<_>>>() {
            Some(files) => {
                let scans = files.into_iter().map(|files| files.read());
                let scans = scans.collect::<Result<_, _>>()?;
                ScanSet::with_scans(clouds, scans, Some(arguments.voxel), &())?
            }
            None => with_fpfh(clouds, arguments.voxel)?,
        };
        Ok(Self {
            set,
            ground_truth: ground_truth::of_scene(&scene.ground_truth)?,
        })
    }
}

fn with_fpfh(clouds: Vec<Cloud>, voxel: f64) -> Result<ScanSet, gmpcr::Error> {
    let params = FeatureParams::from_voxel_size(voxel);
    compute_features_with(clouds, &params, VoxelSize::Given, &())
}
