//! What `gmpcr register` does, in a program of your own: voxel size, scans, poses, warnings, files.
//!
//! ```text
//! cargo run --release --example 02_folder -- path/to/scans out
//! ```

use std::env;
use std::error::Error;
use std::fs;
use std::path::Path;

use gmpcr::io::{
    ColoredCloud, Coordinates, distinct_color, read_points, scan_files, write_g2o,
    write_merged_ply, write_poses_tum,
};
use gmpcr::{Cloud, Params, compute_features, register};

fn main() -> Result<(), Box<dyn Error>> {
    let folders: Vec<String> = env::args().skip(1).collect();
    let [scans, out] = folders.as_slice() else {
        return Err("name a folder of scans, and one for the results".into());
    };
    let out = Path::new(out);
    fs::create_dir_all(out)?;

    // PLY, PCD, text or NPY; LAS, LAZ, E57 and NPZ are cargo features of gmpcr.
    let files = scan_files(scans)?;
    let clouds = files.iter().map(|file| Ok(read_points(file)?.into()));
    let clouds = clouds.collect::<Result<Vec<Cloud>, Box<dyn Error>>>()?;

    // Far coordinates and stray points are taken care of; all lengths follow from the voxel size.
    let set = compute_features(clouds)?;
    let params = Params::default().with_voxel_size(set.voxel_size);
    let registration = register(&set.scans, &params)?;

    let scans = registration.components.largest().to_vec();
    println!("{} of {} scans in one frame", scans.len(), files.len());
    for (file, problem) in files.iter().zip(&set.problems) {
        if let Some(problem) = problem {
            println!("warning: {} has no features: {problem}", file.display());
        }
    }
    for warning in registration.warnings() {
        println!("warning: {warning}");
    }

    // Poses and pose graph in the coordinates of the files.
    let graph = set.posed_graph(&registration);
    write_g2o(out.join("posegraph.g2o"), &graph.to_g2o())?;
    let registration = set.in_cloud_frames(registration);
    let poses = registration.indexed_poses().into_iter();
    let poses: Vec<_> = poses.map(|(k, pose)| (k as f64, pose)).collect();
    write_poses_tum(out.join("poses.tum"), &poses)?;
    let world_from_local = set.world_from_local(&registration);
    let merged = scans.iter().map(|&k| ColoredCloud {
        points: &set.clouds[k].points,
        world_from_points: world_from_local[k],
        color: distinct_color(k),
    });
    write_merged_ply(out.join("merged.ply"), Coordinates::Double, merged)?;
    Ok(())
}
