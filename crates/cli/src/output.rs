//! The files of a registration.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use gmpcr::nalgebra::{Matrix6, Point3, Vector6};
use gmpcr::{Params, Registration, features::voxel_grid};
use gmpcr_io::{
    Coordinates, G2o, G2oEdge, G2oVertex, Open3dEdge, Open3dPoseGraph, distinct_color, write_g2o,
    write_merged_ply, write_open3d_pose_graph, write_poses_3x4, write_poses_tum, write_text,
};

use crate::described::DescribedScans;
use crate::georeference::FileFrames;
use crate::links::Links;
use crate::outcome::Failure;
use crate::progress::Progress;
use crate::report::report_html;
use crate::result::ResultFile;

type Write = fn(&Output, &Path) -> Result<(), Failure>;

/// The files in the order in which they are written: `result.json` says that all are there.
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
    pub input: &'a DescribedScans,
    pub params: &'a Params,
    pub registration: &'a Registration,
    pub frames: &'a FileFrames,
    pub result: &'a ResultFile,
    /// Voxel that thins the merged cloud.
    pub thin: Option<f64>,
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
        let poses = self.indexed_poses();
        let stamped: Vec<_> = poses.iter().map(|&(k, pose)| (k as f64, pose)).collect();
        Ok(write_poses_tum(path, &stamped)?)
    }

    fn write_rows(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_poses_3x4(path, &self.indexed_poses())?)
    }

    fn write_g2o(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_g2o(path, &self.g2o())?)
    }

    fn write_open3d(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_open3d_pose_graph(path, &self.open3d())?)
    }

    fn write_report(&self, path: &Path) -> Result<(), Failure> {
        Ok(write_text(path, &report_html(self))?)
    }

    fn write_result(&self, path: &Path) -> Result<(), Failure> {
        let text = format!("{:#}\n", serde_json::json!(self.result));
        Ok(write_text(path, &text)?)
    }

    /// The scans of the largest component: one frame, one picture.
    fn scans(&self) -> &[usize] {
        self.registration.components.largest()
    }

    fn indexed_poses(&self) -> Vec<(usize, gmpcr::nalgebra::Isometry3<f64>)> {
        let scans = self.scans().iter();
        scans
            .map(|&scan| (scan, self.frames.world_from_scan[scan]))
            .collect()
    }

    fn write_merged(&self, path: &Path) -> Result<(), Failure> {
        let clouds = &self.input.clouds;
        let is_shifted = |&scan: &usize| clouds[scan].origin.norm() > 0.0;
        let coordinates = match self.scans().iter().any(is_shifted) {
            true => Coordinates::Double,
            false => Coordinates::Single,
        };
        let points = |&scan: &usize| self.thinned(&clouds[scan].points);
        let points: Result<Vec<_>, Failure> = self.scans().iter().map(points).collect();
        let moved = self.scans().iter().zip(points?).map(|(&scan, points)| {
            let shift = clouds[scan].file_from_points();
            let world_from_points = self.frames.world_from_scan[scan] * shift;
            let mut points = points.into_owned();
            for point in &mut points {
                *point = world_from_points * *point;
            }
            (points, distinct_color(scan))
        });
        Ok(write_merged_ply(path, coordinates, moved)?)
    }

    fn thinned<'p>(&self, points: &'p [Point3<f64>]) -> Result<Cow<'p, [Point3<f64>]>, Failure> {
        let Some(voxel) = self.thin else {
            return Ok(points.into());
        };
        let thinned =
            voxel_grid(points, voxel).map_err(|error| format!("merged.ply: --thin: {error}"))?;
        Ok(thinned.into())
    }

    /// The edges of the largest component with the final poses as vertices.
    fn g2o(&self) -> G2o {
        let vertex = |(id, world_from_vertex)| G2oVertex {
            id,
            world_from_vertex,
        };
        let edge = |edge: WeightedEdge| {
            let i_from_j = self.frames.i_from_j[edge.position];
            let [t, r] = self.certainties();
            G2oEdge {
                i: edge.i,
                j: edge.j,
                i_from_j,
                // g2o measures a rotation by the vector part of its quaternion, half of the angle.
                information: diagonal([t, 4.0 * r]) * edge.weight,
            }
        };
        G2o {
            vertices: self.indexed_poses().into_iter().map(vertex).collect(),
            edges: self.edges().map(edge).collect(),
        }
    }

    /// The same as Open3D has it: nodes are counted without gaps, and rotation comes first.
    fn open3d(&self) -> Open3dPoseGraph {
        let poses = self.indexed_poses();
        let node = |scan: usize| poses.partition_point(|&(other, _)| other < scan);
        let edge = |edge: WeightedEdge| {
            let [t, r] = self.certainties();
            Open3dEdge {
                source: node(edge.j),
                target: node(edge.i),
                target_from_source: self.frames.i_from_j[edge.position],
                information: diagonal([r, t]) * edge.weight,
                uncertain: true,
                confidence: 1.0,
            }
        };
        Open3dPoseGraph {
            edges: self.edges().map(edge).collect(),
            nodes: poses.iter().map(|&(_, pose)| pose).collect(),
        }
    }

    /// Information of translation and rotation (radians) of the edge of largest weight: an inlier
    /// threshold, or a residual scale, counts as one standard deviation.
    fn certainties(&self) -> [f64; 2] {
        let deviations = [
            self.params.cliques.inlier_threshold,
            self.params.sync.residual_scale,
        ];
        deviations.map(|sigma| 1.0 / (sigma * sigma))
    }

    /// The edges of the largest component, but for those of less than a millionth of the largest weight
    /// that nothing depends on.
    fn edges(&self) -> impl Iterator<Item = WeightedEdge> {
        const LEAST: f64 = 1e-6;
        let evidence = &self.registration.evidence;
        let scans = self.scans();
        let inside = |k: &usize| scans.binary_search(&evidence[*k].i).is_ok();
        let positions: Vec<usize> = (0..evidence.len()).filter(inside).collect();
        let weights = positions.iter().map(|&k| evidence[k].final_weight);
        let largest = weights.fold(f64::MIN_POSITIVE, f64::max);
        let tree = Links::of(self.registration).weakest();
        let edges = positions.into_iter().map(move |position| WeightedEdge {
            position,
            i: evidence[position].i,
            j: evidence[position].j,
            weight: (evidence[position].final_weight / largest).max(LEAST),
        });
        edges.filter(move |edge| edge.weight > LEAST || tree.contains(&edge.position))
    }
}

struct WeightedEdge {
    position: usize,
    i: usize,
    j: usize,
    /// Final weight relative to the largest.
    weight: f64,
}

/// A diagonal matrix of two blocks.
fn diagonal([first, last]: [f64; 2]) -> Matrix6<f64> {
    Matrix6::from_diagonal(&Vector6::new(first, first, first, last, last, last))
}
