use gmpcr_cliques::CliqueParams;
use gmpcr_compatibility::CompatibilityParams;
use gmpcr_correspondence::CorrespondenceParams;
#[cfg(feature = "fpfh")]
use gmpcr_features::FeatureParams;
use gmpcr_geometry::InvalidParameter;
use gmpcr_posegraph::PoseGraphParams;
use gmpcr_retrieval::RetrievalParams;
use gmpcr_sync::SyncParams;

/// Parameters of all stages. The default is [`Params::threedmatch`].
///
/// The presets hold the paper's values for its four datasets (section "Implementation Details"):
///
/// | | 3DMatch | 3DLoMatch | ScanNet | ETH |
/// |---|---|---|---|---|
/// | keypoints per scan `N_s` | 200 | 240 | 200 | 400 |
/// | correspondences per pair `N_o` | 100 | 100 | 100 | 75 |
/// | retained fraction `r_s` | 0.50 | 0.65 | 0.50 | 0.25 |
/// | neighbors per scan `K` | 6 | 8 | 8 | 4 |
/// | cliques per pair `K_c` | 10 | 5 | 10 | 10 |
/// | reweighting iterations `L` | 10 | 90 | 80 | 5 |
/// | memory sensitivity `κ` | 3 | 1 | 5 | 20 |
/// | recovery `ρ` | 0.1 | 0.1 | 0.1 | 0.5 |
///
/// The paper gives no values for the others, which are the same in all presets: `τ_c = τ_in = 0.10`
/// meters, `s_r = 5°`, `λ` in [0.1, 0.9]. Lengths are in the unit of the points; for another unit or
/// scale see [`Params::with_voxel_size`].
///
/// ```
/// use gmpcr::Params;
///
/// let mut params = Params::threedlomatch().with_voxel_size(0.002); // an object of 15 cm
/// params.posegraph.neighbors = 10;
/// assert!(params.validate().is_ok());
/// params.compatibility.retained_fraction = 1.5;
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter compatibility.retained_fraction is 1.5: it must be in (0, 1]");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Params {
    /// Downsampling, normals and descriptors, for [`compute_features_with`](crate::compute_features_with).
    /// Registration of scans does not look at them. The field is there with the cargo feature `fpfh` only, so
    /// write parameters as `Params { ..Default::default() }`.
    #[cfg(feature = "fpfh")]
    pub features: FeatureParams,
    /// Sampling and matching.
    pub correspondence: CorrespondenceParams,
    /// Choice of the pairs that are scored, where scans are many.
    pub retrieval: RetrievalParams,
    /// Compatibility graphs and spectral filter.
    pub compatibility: CompatibilityParams,
    /// Selection of scan pairs.
    pub posegraph: PoseGraphParams,
    /// Relative poses.
    pub cliques: CliqueParams,
    /// Synchronization.
    pub sync: SyncParams,
}

impl Params {
    /// Indoor fragments with overlaps above 30 %.
    pub fn threedmatch() -> Self {
        Self::default()
    }

    /// Indoor fragments with overlaps of 10–30 %.
    pub fn threedlomatch() -> Self {
        let mut params = Self::default();
        params.correspondence.num_samples = 240;
        params.compatibility.retained_fraction = 0.65;
        params.posegraph.neighbors = 8;
        params.cliques.max_cliques = 5;
        params.set_synchronization(90, 1.0, 0.1);
        params
    }

    /// Indoor RGB-D sequences, 30 scans a scene.
    pub fn scannet() -> Self {
        let mut params = Self::default();
        params.posegraph.neighbors = 8;
        params.set_synchronization(80, 5.0, 0.1);
        params
    }

    /// Outdoor laser scans.
    pub fn eth() -> Self {
        let mut params = Self::default();
        params.correspondence.num_samples = 400;
        params.correspondence.max_correspondences = 75;
        params.compatibility.retained_fraction = 0.25;
        params.posegraph.neighbors = 4;
        params.set_synchronization(5, 20.0, 0.5);
        params
    }

    /// The same parameters with all lengths in their usual ratio to a voxel size, in the unit of the points:
    /// `τ_c = τ_in = 2 v`, and the radii of
    /// [`FeatureParams::from_voxel_size`](gmpcr_features::FeatureParams::from_voxel_size). The presets have the
    /// customary 5 cm of rooms in meters.
    ///
    /// For descriptors from elsewhere: the size of the voxels that their clouds were downsampled to. Lengths that were
    /// set before are replaced.
    #[must_use]
    pub fn with_voxel_size(mut self, voxel_size: f64) -> Self {
        self.compatibility.tolerance = 2.0 * voxel_size;
        self.cliques.inlier_threshold = 2.0 * voxel_size;
        #[cfg(feature = "fpfh")]
        {
            let usual = FeatureParams::from_voxel_size(voxel_size);
            self.features.voxel_size = usual.voxel_size;
            self.features.normals.radius = usual.normals.radius;
            self.features.fpfh.radius = usual.fpfh.radius;
        }
        self
    }

    /// The same parameters for points in another unit: every length times `factor`. Points times `factor`
    /// and parameters times `factor` give the same rotations, and translations times `factor`.
    ///
    /// ```
    /// use gmpcr::Params;
    ///
    /// let in_voxels = Params::eth().with_voxel_size(1.0);
    /// assert_eq!(in_voxels.scaled(0.05), Params::eth());
    /// ```
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.compatibility.tolerance *= factor;
        self.cliques.inlier_threshold *= factor;
        #[cfg(feature = "fpfh")]
        {
            self.features = self.features.scaled(factor);
        }
        self
    }

    fn set_synchronization(&mut self, iterations: usize, sensitivity: f64, recovery: f64) {
        self.sync.iterations = iterations;
        self.sync.history.sensitivity = sensitivity;
        self.sync.history.recovery = recovery;
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// The first that is not, by its path within these parameters, with its value and what is allowed.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let within = |checked: Result<(), InvalidParameter>, stage: &str| {
            checked.map_err(|error| error.within(stage))
        };
        #[cfg(feature = "fpfh")]
        within(self.features.validate(), "features")?;
        within(self.correspondence.validate(), "correspondence")?;
        within(self.retrieval.validate(), "retrieval")?;
        within(self.compatibility.validate(), "compatibility")?;
        within(self.posegraph.validate(), "posegraph")?;
        within(self.cliques.validate(), "cliques")?;
        within(self.sync.validate(), "sync")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (N_s, N_o, r_s, K, K_c, L, κ, ρ)
    fn numbers(params: &Params) -> (usize, usize, f64, usize, usize, usize, f64, f64) {
        (
            params.correspondence.num_samples,
            params.correspondence.max_correspondences,
            params.compatibility.retained_fraction,
            params.posegraph.neighbors,
            params.cliques.max_cliques,
            params.sync.iterations,
            params.sync.history.sensitivity,
            params.sync.history.recovery,
        )
    }

    #[test]
    fn the_presets_hold_the_numbers_of_the_paper() {
        let expected = [
            (Params::threedmatch(), (200, 100, 0.50, 6, 10, 10, 3.0, 0.1)),
            (
                Params::threedlomatch(),
                (240, 100, 0.65, 8, 5, 90, 1.0, 0.1),
            ),
            (Params::scannet(), (200, 100, 0.50, 8, 10, 80, 5.0, 0.1)),
            (Params::eth(), (400, 75, 0.25, 4, 10, 5, 20.0, 0.5)),
        ];
        for (params, values) in expected {
            assert_eq!(numbers(&params), values);
            assert_eq!(params.sync.residual_scale, 5f64.to_radians());
            assert_eq!(
                (
                    params.compatibility.tolerance,
                    params.cliques.inlier_threshold
                ),
                (0.1, 0.1)
            );
            assert_eq!(params.clone().with_voxel_size(0.05), params);
            assert_eq!(params.validate(), Ok(()));
        }
    }

    #[test]
    fn a_parameter_out_of_range_is_named_by_its_path() {
        type Spoil = fn(&mut Params);
        let cases: [(&str, Spoil); 7] = [
            ("sync.iterations", |p| p.sync.iterations = usize::MAX),
            ("sync.history.max_memory", |p| {
                p.sync.history.max_memory = 1.0
            }),
            ("correspondence.num_samples", |p| {
                p.correspondence.num_samples = 2
            }),
            ("retrieval.candidates_per_scan", |p| {
                p.retrieval.candidates_per_scan = 0
            }),
            ("compatibility.tolerance", |p| {
                p.compatibility.tolerance = f64::NAN
            }),
            ("posegraph.neighbors", |p| p.posegraph.neighbors = 0),
            ("cliques.inlier_threshold", |p| {
                p.cliques.inlier_threshold = f64::INFINITY
            }),
        ];
        for (name, spoil) in cases {
            let mut params = Params::default();
            spoil(&mut params);
            assert_eq!(params.validate().unwrap_err().name, name);
        }
    }

    #[cfg(feature = "fpfh")]
    #[test]
    fn parameters_of_features_are_named_by_their_path() {
        let mut params = Params::default();
        params.features.normals.radius = -1.0;
        assert_eq!(
            params.validate().unwrap_err().name,
            "features.normals.radius"
        );
    }
}
