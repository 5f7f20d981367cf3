//! A registration from a file, which may contradict itself.

use gmpcr_posegraph::{Components, Connectivity, PairConfidences, PoseGraph};
use gmpcr_sync::ComponentReport;
use nalgebra::Isometry3;

use crate::{Edge, Params, Registration, ScanId, StageTimes, UnresolvedPair};

/// The fields of a [`Registration`] before they are checked against each other.
#[derive(serde::Deserialize)]
pub(crate) struct Unchecked {
    ids: Vec<ScanId>,
    #[serde(with = "gmpcr_geometry::matrix_rows::list")]
    world_from_scan: Vec<Isometry3<f64>>,
    components: Components,
    edges: Vec<Edge>,
    unresolved: Vec<UnresolvedPair>,
    confidences: PairConfidences,
    connectivity: Connectivity,
    synchronization: Vec<ComponentReport>,
    times: StageTimes,
    params: Params,
}

impl Unchecked {
    /// What is wrong with it, if something is.
    fn problem(&self) -> Option<String> {
        let n = self.ids.len();
        if !self.ids.is_sorted_by(|a, b| a < b) {
            return Some("the ids of the scans do not ascend".into());
        }
        for (what, count) in [
            ("poses", self.world_from_scan.len()),
            ("scans in components", self.components.labels().len()),
            ("scans with confidences", self.confidences.num_scans()),
        ] {
            if count != n {
                return Some(format!("{count} {what} for {n} scans"));
            }
        }
        let pairs = self.unresolved.iter().map(|pair| (pair.i, pair.j));
        let pairs = pairs.chain(self.edges.iter().map(|edge| (edge.i, edge.j)));
        if let Some((i, j)) = pairs.into_iter().find(|&(i, j)| i >= j || j >= n) {
            return Some(format!("pair ({i}, {j}) is not of the form i < j < {n}"));
        }
        let edges = self.edges.iter().map(Edge::pose_edge);
        let graph = PoseGraph::new(n, edges.collect());
        graph.err().map(|error| error.to_string())
    }
}

impl TryFrom<Unchecked> for Registration {
    type Error = String;

    fn try_from(file: Unchecked) -> Result<Self, String> {
        if let Some(problem) = file.problem() {
            return Err(problem);
        }
        file.params.validate().map_err(|error| error.to_string())?;
        Ok(Self {
            ids: file.ids,
            world_from_scan: file.world_from_scan,
            components: file.components,
            edges: file.edges,
            unresolved: file.unresolved,
            confidences: file.confidences,
            connectivity: file.connectivity,
            synchronization: file.synchronization,
            times: file.times,
            params: file.params,
        })
    }
}
