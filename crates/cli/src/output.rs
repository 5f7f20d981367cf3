//! The files of a registration.

use std::fs;
use std::path::{Path, PathBuf};

use gmpcr::nalgebra::{Matrix6, Point3, Vector6};
use gmpcr::{Params, Registration, features::voxel_grid};
use gmpcr_io::{
    Coordinates, G2o, G2oEdge, G2oVertex, Open3dEdge, Open3dPoseGraph, distinct_color, write_g2o,
    write_merged_ply, write_open3d_pose_graph, write_poses_3x4, write_poses_tum, write_text,
};

use crate::attention::main_component;
use crate::described::DescribedScans;
use crate::georeference::FileFrames;
use crate::outcome::Failure;
use crate::progress::Progress;
use crate::report::report_html;
use crate::result::ResultFile;

/// Names of the files, in the order in which they are written.
pub const FILES: [&str; 7] = [
    "result.json",
    "poses.tum",
    "poses.txt",
    "posegraph.g2o",
    "posegraph.json",
    "report.html",
    "merged.ply",
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

/// Creates the folder, and makes sure that files can be written into it before hours are spent on
/// their content.
pub fn prepare(folder: &Path) -> Result<(), Failure> {
    let remedy = "choose another folder with --out, or make room";
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create {}: {error}; {remedy}", folder.display()))?;
    let probe = folder.join(".gmpcr-probe");
    write_text(&probe, "").map_err(|error| format!("{error}; {remedy}"))?;
    fs::remove_file(&probe).map_err(|error| format!("{}: {error}", folder.display()).into())
}

impl Output<'_> {
    /// Writes all files. One that cannot be written does not keep the others from it.
    pub fn write(&self, folder: &Path, progress: &Progress) -> Result<(), Failure> {
        let ((), _) = progress.stage("writing", FILES.len(), || {
            let mut problems = Vec::new();
            for name in FILES {
                let outcome = progress.item(|| self.write_one(name, &folder.join(name)))?;
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

    fn write_one(&self, name: &str, path: &PathBuf) -> Result<(), gmpcr_io::Error> {
        match name {
            "result.json" => write_text(path, &format!("{:#}\n", serde_json::json!(self.result))),
            "poses.tum" => {
                let poses = self.indexed_poses();
                let stamped: Vec<_> = poses.iter().map(|&(k, pose)| (k as f64, pose)).collect();
                write_poses_tum(path, &stamped)
            }
            "poses.txt" => write_poses_3x4(path, &self.indexed_poses()),
            "posegraph.g2o" => write_g2o(path, &self.g2o()),
            "posegraph.json" => write_open3d_pose_graph(path, &self.open3d()),
            "report.html" => write_text(path, &report_html(self)),
            _ => self.write_merged(path),
        }
    }

    /// The scans of the largest component: one frame, one picture.
    fn scans(&self) -> &[usize] {
        &self.registration.components.members()[main_component(self.registration)]
    }

    fn indexed_poses(&self) -> Vec<(usize, gmpcr::nalgebra::Isometry3<f64>)> {
        let scans = self.scans().iter();
        scans
            .map(|&scan| (scan, self.frames.world_from_scan[scan]))
            .collect()
    }

    fn write_merged(&self, path: &Path) -> Result<(), gmpcr_io::Error> {
        let clouds = &self.input.clouds;
        let is_shifted = |&scan: &usize| clouds[scan].origin.norm() > 0.0;
        let coordinates = match self.scans().iter().any(is_shifted) {
            true => Coordinates::Double,
            false => Coordinates::Single,
        };
        let moved = self.scans().iter().map(|&scan| {
            let cloud = &clouds[scan];
            let world_from_points = self.frames.world_from_scan[scan] * cloud.file_from_points();
            let points = self.thinned(&cloud.points);
            let points = points
                .into_iter()
                .map(move |point| world_from_points * point);
            (points, distinct_color(scan))
        });
        write_merged_ply(path, coordinates, moved)
    }

    fn thinned(&self, points: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let grid = self.thin.and_then(|voxel| voxel_grid(points, voxel).ok());
        grid.unwrap_or_else(|| points.to_vec())
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
                confidence: edge.weight,
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

    /// The edges of the largest component of more than a millionth of the largest weight.
    fn edges(&self) -> impl Iterator<Item = WeightedEdge> {
        let evidence = &self.registration.evidence;
        let weights = evidence.iter().map(|edge| edge.final_weight);
        let largest = weights.fold(f64::MIN_POSITIVE, f64::max);
        let weighted = evidence
            .iter()
            .enumerate()
            .map(move |(position, edge)| WeightedEdge {
                position,
                i: edge.i,
                j: edge.j,
                weight: edge.final_weight / largest,
            });
        let scans = self.scans();
        weighted.filter(|edge| scans.binary_search(&edge.i).is_ok() && edge.weight > 1e-6)
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
