//! The files of a registration.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use gmpcr::Registration;
use gmpcr::features::voxel_grid;
use gmpcr::nalgebra::{Isometry3, Point3};
use gmpcr_io::{
    ColoredCloud, Coordinates, PosedGraph, distinct_color, write_g2o, write_merged_ply,
    write_open3d_pose_graph, write_poses_3x4, write_poses_tum, write_text,
};

use crate::input::Input;
use crate::outcome::Failure;
use crate::progress::Progress;
use crate::report::Report;
use crate::result::ResultFile;

type Write = fn(&Output, &Path) -> Result<(), Failure>;

/// The files in the order in which they are written: `result.json` is the last, so that all are there where it is.
pub const FILES: [(&str, Write); 7] = [
    ("poses.tum", |output, path| output.write_tum(path)),
    ("poses.txt", |output, path| output.write_rows(path)),
    ("posegraph.g2o", |output, path| output.write_g2o(path)),
    ("posegraph.json", |output, path| output.write_open3d(path)),
    ("report.html", |output, path| output.write_report(path)),
    ("merged.ply", |output, path| output.write_merged(path)),
    ("result.json", |output, path| output.write_result(path)),
];

/// What there is to write.
pub struct Output<'a> {
    pub title: &'a str,
    pub input: &'a Input,
    pub result: &'a ResultFile,
    pub graph: &'a PosedGraph,
    /// The poses in the coordinates that registration saw, for the picture.
    pub world_from_local: &'a [Isometry3<f64>],
    /// Voxel size that the merged cloud is downsampled to.
    pub downsample: Option<f64>,
}

/// Creates the folder, and makes sure that files can be written into it, over none of the scans, before
/// hours are spent on their content.
pub fn prepare(folder: &Path, scans: &[PathBuf]) -> Result<(), Failure> {
    const REMEDY: &str = "choose another folder with --out";
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}; {REMEDY}", folder.display()))?;
    let probe = folder.join(".gmpcr-probe");
    write_text(&probe, "").map_err(|error| format!("{error}; {REMEDY}"))?;
    fs::remove_file(&probe).map_err(|error| Failure::of(folder, error))?;
    let merged = folder.join("merged.ply").canonicalize();
    let is_merged =
        |scan: &&PathBuf| matches!((scan.canonicalize(), &merged), (Ok(a), Ok(b)) if a == *b);
    match scans.iter().find(is_merged) {
        Some(scan) => Err(Failure::of(
            scan,
            format!("the scan would be overwritten: {REMEDY}"),
        )),
        None => Ok(()),
    }
}

impl Output<'_> {
    /// Writes all files. One that cannot be written does not keep the others from it.
    pub fn write(&self, folder: &Path, progress: &Progress) -> Result<(), Failure> {
        let ((), _) = progress.stage("writing", FILES.len(), || {
            // Without it, files of an earlier run are no result of this one.
            let _ = fs::remove_file(folder.join("result.json"));
            let mut problems = Vec::new();
            for (name, write) in FILES {
                let outcome = progress.file(|| write(self, &folder.join(name)))?;
                problems.extend(outcome.err().map(|problem| problem.to_string()));
            }
            match problems.as_slice() {
                [] => Ok(()),
                _ => Err(format!(
                    "{}; make room or choose another folder with --out; the other files are complete",
                    problems.join("; ")
                )
                .into()),
            }
        })?;
        Ok(())
    }

    fn write_tum(&self, path: &Path) -> Result<(), Failure> {
        let poses = self.registration().indexed_poses();
        let stamped: Vec<_> = poses.iter().map(|&(k, pose)| (k as f64, pose)).collect();
        Ok(write_poses_tum(path, &stamped)?)
    }

    fn write_rows(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_poses_3x4(path, &self.registration().indexed_poses())?)
    }

    fn write_g2o(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_g2o(path, &self.graph.to_g2o())?)
    }

    fn write_open3d(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_open3d_pose_graph(path, &self.graph.to_open3d())?)
    }

    fn write_report(&self, path: &Path) -> Result<(), Failure> {
        let report = Report {
            title: self.title,
            result: self.result,
            clouds: &self.input.set.clouds,
            world_from_local: self.world_from_local,
        };
        Ok(write_text(path, &report.to_html())?)
    }

    fn write_result(&self, path: &Path) -> Result<(), Failure> {
        // Programs read it: on one line it has half the size.
        let text = serde_json::to_string(self.result)? + "\n";
        Ok(write_text(path, &text)?)
    }

    fn write_merged(&self, path: &Path) -> Result<(), Failure> {
        let (set, scans) = (&self.input.set, self.registration().components.largest());
        let is_shifted = |&scan: &usize| set.clouds[scan].origin.norm() > 0.0;
        let coordinates = match scans.iter().any(is_shifted) {
            true => Coordinates::Double,
            false => Coordinates::Single,
        };
        let points = scans
            .iter()
            .map(|&scan| self.downsampled(&set.clouds[scan].points));
        let points = points.collect::<Result<Vec<_>, Failure>>()?;
        let world_from_points = set.world_from_local(self.registration());
        let clouds = scans
            .iter()
            .zip(points)
            .map(|(&scan, points)| ColoredCloud {
                points,
                world_from_points: world_from_points[scan],
                color: distinct_color(scan),
            });
        Ok(write_merged_ply(path, coordinates, clouds)?)
    }

    fn downsampled<'p>(
        &self,
        points: &'p [Point3<f64>],
    ) -> Result<Cow<'p, [Point3<f64>]>, Failure> {
        let Some(voxel_size) = self.downsample else {
            return Ok(points.into());
        };
        let downsampled = voxel_grid(points, voxel_size)
            .map_err(|error| format!("merged.ply: --downsample: {error}"))?;
        Ok(downsampled.into())
    }

    /// In the coordinates of the files.
    fn registration(&self) -> &Registration {
        &self.result.registration
    }
}
