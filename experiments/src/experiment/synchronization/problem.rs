//! Pose graphs with ground truth, simulated or in files.

use std::path::Path;

use gmpcr::posegraph::{PoseEdge, PoseGraph};
use gmpcr_io::{G2oPoseGraph, MeasuredEdge, PosedGraph, read_g2o, write_g2o};
use gmpcr_sim::{PoseGraphSimParams, simulate_pose_graph};
use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::failure::Failure;

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
        let read = G2oPoseGraph::new(&read_g2o(file)?)?;
        let pose = |(id, pose): (&usize, &Option<_>)| {
            pose.ok_or_else(|| format!("vertex {id} of an edge has no VERTEX_SE3:QUAT"))
        };
        let poses = read.ids.iter().zip(&read.initial_poses).map(pose);
        let world_from_scan = poses.collect::<Result<_, String>>()?;
        Ok(Self {
            graph: read.graph,
            world_from_scan,
        })
    }

    /// Writes the graph with the ground truth as vertices, for other programs and for `--graphs`.
    ///
    /// The information of an edge is that of the noise times its weight.
    pub fn write(&self, file: &Path, params: &PoseGraphSimParams) -> Result<(), Failure> {
        let [t, r] = [params.translation_noise, params.rotation_noise].map(|sigma| sigma.powi(-2));
        let information = Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r));
        let edges = self.graph.edges().iter().map(|edge| MeasuredEdge {
            i: edge.i,
            j: edge.j,
            i_from_j: edge.i_from_j,
            information: information * edge.weight,
        });
        let poses = self.world_from_scan.iter().copied().enumerate();
        let graph = PosedGraph::new(poses.collect(), edges.collect())?;
        Ok(write_g2o(file, &graph.to_g2o())?)
    }
}
