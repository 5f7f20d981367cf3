//! Result files.

use std::error::Error;
use std::fs;
use std::path::Path;

use gmpcr::Registration;
use gmpcr::nalgebra::Point3;
use gmpcr_io::{Coordinates, distinct_color, write_merged_ply, write_poses_3x4};

/// Writes cloud and poses of the largest component; returns how many scans that has.
pub fn write_results(
    folder: &Path,
    clouds: &[Vec<Point3<f64>>],
    registration: &Registration,
) -> Result<usize, Box<dyn Error>> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    // One frame, one picture.
    let scans = registration.components.largest();
    let moved = |&scan: &usize| {
        let world_from_scan = registration.world_from_scan[scan];
        let points = clouds[scan].iter();
        (
            points.map(move |point| world_from_scan * point),
            distinct_color(scan),
        )
    };
    let merged = folder.join("merged.ply");
    write_merged_ply(merged, Coordinates::Single, scans.iter().map(moved))?;
    let indexed = |&scan: &usize| (scan, registration.world_from_scan[scan]);
    let poses: Vec<_> = scans.iter().map(indexed).collect();
    write_poses_3x4(folder.join("poses.txt"), &poses)?;
    Ok(scans.len())
}
