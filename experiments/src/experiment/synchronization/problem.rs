//! Pose graphs with ground truth, simulated or in files.

use std::collections::BTreeMap;
use std::path::Path;

use crate::failure::Failure;

use gmpcr::posegraph::{PoseEdge, PoseGraph};
use gmpcr_io::{G2o, G2oEdge, G2oVertex, read_g2o, write_g2o};
use gmpcr_sim::{PoseGraphSimParams, simulate_pose_graph};
use nalgebra::{Isometry3, Matrix6, Vector6};

/// A pose graph and its ground truth.
pub struct Problem {
    pub graph: PoseGraph,
    pub world_from_scan: Vec<Isometry3<f64>>,
}

impl Problem {
    pub fn simulate(params: &PoseGraphSimParams) -> Result<Self, Failure> {
        let simulated = simulate_pose_graph(params)?;
        let edges = simulated.edges.iter().map(|edge| PoseEdge {
            i: edge.i,
            j: edge.j,
            i_from_j: edge.i_from_j,
            weight: edge.weight,
        });
        Ok(Self {
            graph: PoseGraph::new(params.num_scans, edges.collect())?,
            world_from_scan: simulated.world_from_scan,
        })
    }

    /// Reads a graph whose vertices are the ground truth.
    pub fn read(file: &Path) -> Result<Self, Failure> {
        let read = read_g2o(file)?;
        let poses = read.vertices.iter().map(|vertex| vertex.world_from_vertex);
        Ok(Self {
            graph: pose_graph(&read)?,
            world_from_scan: poses.collect(),
        })
    }

    /// Writes the graph with the ground truth as vertices, for other programs and for `--graphs`.
    pub fn write(&self, file: &Path, params: &PoseGraphSimParams) -> Result<(), gmpcr_io::Error> {
        let [t, r] = [params.translation_noise, params.rotation_noise].map(|sigma| sigma.powi(-2));
        let information = Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r));
        let vertex = |(id, pose): (usize, &Isometry3<f64>)| G2oVertex {
            id,
            world_from_vertex: *pose,
        };
        let edge = |edge: &PoseEdge| G2oEdge {
            i: edge.i,
            j: edge.j,
            i_from_j: edge.i_from_j,
            information,
        };
        let graph = G2o {
            vertices: self
                .world_from_scan
                .iter()
                .enumerate()
                .map(vertex)
                .collect(),
            edges: self.graph.edges().iter().map(edge).collect(),
        };
        write_g2o(file, &graph)
    }
}

/// The pose graph of a file, its scans the vertices in their order; all edges weigh the same.
fn pose_graph(file: &G2o) -> Result<PoseGraph, Failure> {
    let vertices = file.vertices.iter().enumerate();
    let scans: BTreeMap<usize, usize> = vertices.map(|(scan, v)| (v.id, scan)).collect();
    let scan = |id: usize| {
        let scan = scans.get(&id).copied();
        scan.ok_or_else(|| format!("vertex {id} of an edge has no VERTEX_SE3:QUAT"))
    };
    let edge = |edge: &G2oEdge| {
        Ok(PoseEdge {
            i: scan(edge.i)?,
            j: scan(edge.j)?,
            i_from_j: edge.i_from_j,
            weight: 1.0,
        })
    };
    let edges: Result<Vec<_>, String> = file.edges.iter().map(edge).collect();
    Ok(PoseGraph::new(file.vertices.len(), edges?)?)
}
