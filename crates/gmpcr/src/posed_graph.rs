//! From a registration to pose graphs of other programs.

use gmpcr_io::{MeasuredEdge, PosedGraph};
use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::{Edge, Params, Registration};

impl Registration {
    /// The poses of the largest component, by position.
    pub fn indexed_poses(&self) -> Vec<(usize, Isometry3<f64>)> {
        let scans = self.components.largest().iter();
        scans
            .map(|&scan| (scan, self.world_from_scan[scan]))
            .collect()
    }

    /// The pose graph of the largest component with the final poses, for g2o or Open3D. Scans have their
    /// positions as numbers.
    ///
    /// The information of an edge is diagonal and proportional to its final weight; for the edge of the largest
    /// weight an inlier threshold and a residual scale count as one standard deviation. Edges of less than a
    /// millionth of the largest weight are left out unless the graph would be disconnected without them.
    ///
    /// Take it before the registration goes to [other coordinates](Self::with_scan_frames), and move the graph
    /// ([`PosedGraph::with_scan_frames`]), so that the information moves along.
    ///
    /// ```
    /// # use gmpcr::{Descriptors, Params, Scan, register};
    /// # let rows = Descriptors::new((0..40).map(|k| k as f32).collect(), 1)?;
    /// # let points = (0..40).map(f64::from).map(|k| [k.sin(), (2.0 * k).cos(), 0.1 * k].into());
    /// # let scan = Scan::new(points.collect(), rows)?;
    /// # let scans = [scan.clone(), scan];
    /// let registration = register(&scans, &Params::default())?;
    /// let g2o = registration.posed_graph().to_g2o();
    /// assert_eq!((g2o.vertices.len(), g2o.edges.len()), (2, 1));
    /// # Ok::<(), gmpcr::Error>(())
    /// ```
    pub fn posed_graph(&self) -> PosedGraph {
        const LEAST: f64 = 1e-6;
        let scans = self.components.largest();
        let inside = |edge: &Edge| scans.binary_search(&edge.i).is_ok();
        let mut positions: Vec<usize> = (0..self.edges.len()).collect();
        positions.retain(|&k| inside(&self.edges[k]));
        let weight = |k: usize| self.edges[k].synchronization.final_weight;
        let largest = positions
            .iter()
            .map(|&k| weight(k))
            .fold(f64::MIN_POSITIVE, f64::max);
        let relative = |k: usize| (weight(k) / largest).max(LEAST);
        let mut is_needed = vec![false; self.edges.len()];
        for edge in self.weakest_edges() {
            is_needed[edge] = true;
        }
        positions.retain(|&k| relative(k) > LEAST || is_needed[k]);
        let of_heaviest = information(&self.params);
        let edges = positions.into_iter().map(|k| MeasuredEdge {
            i: self.edges[k].i,
            j: self.edges[k].j,
            i_from_j: self.edges[k].i_from_j,
            information: of_heaviest * relative(k),
        });
        PosedGraph::new(self.indexed_poses(), edges.collect())
            .expect("both scans of an edge are in one component")
    }
}

/// Information of translation and rotation (radians) of the edge of the largest weight.
fn information(params: &Params) -> Matrix6<f64> {
    let deviations = [params.cliques.inlier_threshold, params.sync.residual_scale];
    let [t, r] = deviations.map(|sigma| 1.0 / (sigma * sigma));
    Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r))
}
