//! Data of the benchmarks, synthetic and real.

#![allow(dead_code, reason = "each benchmark uses a part")]

use std::path::PathBuf;

use gmpcr::cliques::PointPairs;
use gmpcr::features::FeatureParams;
use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
use gmpcr::{Descriptors, Scan, compute_scan};
use gmpcr_io::descriptor_files;
use gmpcr_sim::{RoomParams, SimParams, simulate};

/// A fixed number in (−1, 1) that looks random.
pub fn scattered(k: usize) -> f64 {
    let x = (k as f64 + 1.0) * 0.754_877_666_246_692_7;
    2.0 * (x * x * 91.7).fract() - 1.0
}

pub fn descriptors(num_rows: usize, dimension: usize, salt: usize) -> Descriptors {
    let values = (0..num_rows * dimension).map(|k| scattered(k + salt) as f32);
    Descriptors::new(values.collect(), dimension).unwrap()
}

pub fn point(k: usize) -> Point3<f64> {
    Vector3::from_fn(|axis, _| 2.0 * scattered(3 * k + axis)).into()
}

/// Correspondences of a transformation, of which every second is an outlier.
pub fn half_inlier_pairs(num_pairs: usize) -> PointPairs {
    let transformation = Isometry3::new(Vector3::new(1.0, 2.0, 0.5), Vector3::new(0.3, -0.2, 1.0));
    let source: Vec<_> = (0..num_pairs).map(point).collect();
    let target = source.iter().enumerate().map(|(k, p)| match k % 2 {
        0 => transformation * p,
        _ => point(k + 7919),
    });
    PointPairs::new(target.collect(), source).unwrap()
}

/// A flat that grows with the number of scans: a room for every fifty.
pub fn flat(num_scans: usize) -> SimParams {
    let room = RoomParams {
        num_rooms: num_scans.div_ceil(50),
        ..RoomParams::default()
    };
    SimParams {
        num_scans,
        room,
        ..SimParams::default()
    }
}

/// Scans with FPFH.
pub fn fpfh_scans(clouds: &[Vec<Point3<f64>>]) -> Vec<Scan> {
    let scan = |cloud: &Vec<_>| compute_scan(cloud, &FeatureParams::default()).unwrap();
    clouds.iter().map(scan).collect()
}

/// Scans of a [`flat`], with FPFH.
pub fn scans(num_scans: usize) -> Vec<Scan> {
    fpfh_scans(&simulate(&flat(num_scans)).unwrap().clouds)
}

/// Where the real scans are: what `GMPCR_DATA` names, or a folder `data` here.
pub fn folder() -> PathBuf {
    std::env::var_os("GMPCR_DATA").map_or("data".into(), PathBuf::from)
}

/// Real scans with their learned descriptors.
pub fn learned(scene: &str) -> Result<Vec<Scan>, gmpcr_io::Error> {
    let files = descriptor_files(folder().join("descriptors").join(scene))?;
    files.iter().map(|files| files.read()).collect()
}
