use gmpcr_posegraph::{Components, Connectivity, PairConfidences, PoseGraph};
use gmpcr_sync::{ComponentReport, Synchronization};
use nalgebra::Isometry3;

use crate::selected_pair::SelectedPair;
use crate::{Edge, Params, ScanId, StageTimes, UnresolvedPair};

/// Poses of all scans, with their support and diagnostics.
///
/// Scans are named by their positions `0..ids.len()`, the order in which they were given.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "crate::unchecked::Unchecked")
)]
#[non_exhaustive]
pub struct Registration {
    /// The scans, by position. In a batch they are numbered `0..n`.
    pub ids: Vec<ScanId>,
    /// `T_i`, from each scan's frame into the frame of the lowest scan of its component, which has
    /// the identity. Poses of different components do not compare.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows::list"))]
    pub world_from_scan: Vec<Isometry3<f64>>,
    /// Which scans share a frame.
    pub components: Components,
    /// The relative poses that were synchronized, ascending by their scans.
    pub edges: Vec<Edge>,
    /// Pairs that were selected, but whose cliques determine no relative pose that a correspondence supports.
    pub unresolved: Vec<UnresolvedPair>,
    /// Confidences of the scored pairs: all, or those that were retrieved where there are
    /// [`retrieval.min_scans`](gmpcr_retrieval::RetrievalParams::min_scans) scans or more.
    pub confidences: PairConfidences,
    /// Connectivity of the pose graph, the reference being the first scan.
    pub connectivity: Connectivity,
    /// Course of the synchronization of each component.
    pub synchronization: Vec<ComponentReport>,
    /// Wall time of each stage.
    pub times: StageTimes,
    /// The parameters that it was made with.
    pub params: Params,
}

impl Registration {
    pub(crate) fn new(
        ids: Vec<ScanId>,
        selected: Vec<SelectedPair>,
        confidences: PairConfidences,
        synchronization: Synchronization,
        times: StageTimes,
        params: Params,
    ) -> Self {
        let is_edge = |pair: &&SelectedPair| pair.edge().is_some();
        let (resolved, unresolved): (Vec<_>, Vec<_>) = selected.iter().partition(is_edge);
        let reports = resolved.iter().zip(synchronization.edges);
        let edges: Vec<Edge> = reports
            .filter_map(|(pair, report)| Edge::new(pair, report))
            .collect();
        let ends: Vec<_> = edges.iter().map(|edge| (edge.i, edge.j)).collect();
        Self {
            connectivity: Connectivity::new(ids.len(), &ends, 0),
            ids,
            world_from_scan: synchronization.world_from_scan,
            components: synchronization.components,
            edges,
            unresolved: unresolved.into_iter().map(UnresolvedPair::new).collect(),
            confidences,
            synchronization: synchronization.reports,
            times,
            params,
        }
    }

    /// The pose of a scan, from its frame into that of its component; `None` if it is not among
    /// [`ids`](Self::ids).
    pub fn pose_of(&self, scan: ScanId) -> Option<&Isometry3<f64>> {
        let position = self.ids.binary_search(&scan).ok()?;
        self.world_from_scan.get(position)
    }

    /// Relative pose `T_ij = T_i⁻¹ T_j` from scan j's frame into scan i's; `None` if they share no frame.
    ///
    /// # Panics
    /// If a scan does not exist.
    pub fn i_from_j(&self, i: usize, j: usize) -> Option<Isometry3<f64>> {
        let share_frame = self.components.label(i) == self.components.label(j);
        share_frame.then(|| self.world_from_scan[i].inv_mul(&self.world_from_scan[j]))
    }

    /// Whether a scan shares a frame with another one.
    ///
    /// # Panics
    /// If the scan does not exist.
    pub fn is_registered(&self, scan: usize) -> bool {
        self.components.members()[self.components.label(scan)].len() > 1
    }

    /// The pose graph that was synchronized, with the initial weights: to be edited and
    /// [synchronized](gmpcr_sync::synchronize) again.
    ///
    /// Take it before the registration goes to [other coordinates](Self::with_scan_frames): translations are solved
    /// at the origins of the scans, and far origins make noise of rotations large errors of translations.
    ///
    /// # Panics
    /// If edges were changed such that one names a scan that does not exist.
    ///
    /// ```
    /// use gmpcr::posegraph::PoseGraph;
    /// use gmpcr::sync::{SyncParams, synchronize};
    ///
    /// # fn scans() -> Result<Vec<gmpcr::Scan>, gmpcr::Error> {
    /// #     let rows = gmpcr::Descriptors::new((0..40).map(|k| k as f32).collect(), 1)?;
    /// #     let points = (0..40).map(f64::from).map(|k| [k.sin(), (2.0 * k).cos(), 0.1 * k].into());
    /// #     let scan = gmpcr::Scan::new(points.collect(), rows)?;
    /// #     Ok(vec![scan.clone(), scan.clone(), scan])
    /// # }
    /// let registration = gmpcr::register(&scans()?, &gmpcr::Params::default())?;
    /// let mut edges = registration.pose_graph().into_edges();
    /// edges.retain(|edge| (edge.i, edge.j) != (0, 2)); // known to be an outlier
    /// let graph = PoseGraph::new(registration.ids.len(), edges)?;
    /// let again = synchronize(&graph, &SyncParams::default())?;
    /// assert_eq!(again.components.largest(), [0, 1, 2]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pose_graph(&self) -> PoseGraph {
        let edges = self.edges.iter().map(Edge::pose_edge);
        PoseGraph::new(self.ids.len(), edges.collect())
            .expect("the edges have been a pose graph before")
    }

    /// The same registration with the world of one component in the frame of `reference`, whose pose
    /// becomes the identity; other components stay as they are.
    ///
    /// # Panics
    /// If the scan does not exist.
    #[must_use]
    pub fn in_frame_of(mut self, reference: usize) -> Self {
        let reference_from_world = self.world_from_scan[reference].inverse();
        for &scan in &self.components.members()[self.components.label(reference)] {
            self.world_from_scan[scan] = reference_from_world * self.world_from_scan[scan];
        }
        self.world_from_scan[reference] = Isometry3::identity();
        self
    }

    /// The same registration where scan k has coordinates of another frame: `new_from_old[k]` maps the
    /// coordinates that were registered to the new ones. For poses that go with the clouds of the new coordinates.
    ///
    /// The world of a component follows the coordinates of its lowest scan `r`, which keeps the identity: a pose
    /// `T_k` becomes `N_r T_k N_k⁻¹`, a relative pose `T̂_ij` becomes `N_i T̂_ij N_j⁻¹`. Residuals stay those of the
    /// coordinates that were registered.
    ///
    /// # Panics
    /// If there is not one transformation per scan.
    #[must_use]
    pub fn with_scan_frames(mut self, new_from_old: &[Isometry3<f64>]) -> Self {
        assert_eq!(new_from_old.len(), self.ids.len(), "one frame per scan");
        let changed = |i: usize, i_from_j: &Isometry3<f64>, j: usize| {
            new_from_old[i] * i_from_j * new_from_old[j].inverse()
        };
        for (k, pose) in self.world_from_scan.iter_mut().enumerate() {
            let reference = self.components.members()[self.components.label(k)][0];
            *pose = changed(reference, pose, k);
        }
        for edge in &mut self.edges {
            edge.i_from_j = changed(edge.i, &edge.i_from_j, edge.j);
        }
        self
    }
}
