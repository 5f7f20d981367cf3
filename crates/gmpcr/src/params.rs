use gmpcr_cliques::CliqueParams;
use gmpcr_compatibility::CompatibilityParams;
use gmpcr_correspondence::CorrespondenceParams;
use gmpcr_posegraph::PoseGraphParams;
use gmpcr_retrieval::RetrievalParams;
use gmpcr_sync::{AdaptiveHistory, History, Method, SyncParams};

use crate::Error;

/// Parameters of all stages. The default is [`Params::threedmatch`].
///
/// The presets hold the paper's values for its four datasets (section "Implementation Details"):
///
/// | | 3DMatch | 3DLoMatch | ScanNet | ETH |
/// |---|---|---|---|---|
/// | keypoints per scan `N_s` | 200 | 240 | 200 | 400 |
/// | correspondences per pair `N_o` | 100 | 100 | 100 | 75 |
/// | retained share `r_s` | 0.50 | 0.65 | 0.50 | 0.25 |
/// | neighbours per scan `K` | 6 | 8 | 8 | 4 |
/// | cliques per pair `K_c` | 10 | 5 | 10 | 10 |
/// | reweighting iterations `L` | 10 | 90 | 80 | 5 |
/// | memory sensitivity `κ` | 3 | 1 | 5 | 20 |
/// | recovery `ρ` | 0.1 | 0.1 | 0.1 | 0.5 |
///
/// The paper gives no values for the others, which are the same in all presets: `τ_c = τ_in = 0.10`
/// metres, `s_r = 5°`, `λ` in [0.1, 0.9]. Lengths are in the unit of the points; for another unit or
/// scale see [`Params::with_tolerance`].
///
/// ```
/// use gmpcr::Params;
///
/// let mut params = Params::threedlomatch().with_tolerance(0.004); // an object of 15 cm
/// params.posegraph.neighbors = 10;
/// assert!(params.validate().is_ok());
/// params.compatibility.retained_fraction = 1.5;
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter compatibility.retained_fraction is 1.5: it must be in (0, 1]");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
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
    /// Synchronisation.
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

    /// The same parameters with `τ_c` and `τ_in`, the only lengths among them, set to `tolerance`.
    /// About two voxels of the clouds that the descriptors were computed on is a good value.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.compatibility.tolerance = tolerance;
        self.cliques.inlier_threshold = tolerance;
        self
    }

    fn set_synchronization(&mut self, iterations: usize, sensitivity: f64, recovery: f64) {
        self.sync.iterations = iterations;
        let history = AdaptiveHistory {
            sensitivity,
            recovery,
            ..Default::default()
        };
        self.sync.method = History::Adaptive(history).into();
    }

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first that is not, its value, and what is allowed.
    pub fn validate(&self) -> Result<(), Error> {
        let Self {
            correspondence,
            retrieval,
            compatibility,
            posegraph,
            cliques,
            sync,
        } = self;
        at_least(3, correspondence.num_samples, "correspondence.num_samples")?;
        at_least(
            3,
            correspondence.max_correspondences,
            "correspondence.max_correspondences",
        )?;
        let (per_scan, per_expansion) = (
            retrieval.candidates_per_scan,
            retrieval.candidates_per_expansion,
        );
        at_least(1, per_scan, "retrieval.candidates_per_scan")?;
        at_least(1, per_expansion, "retrieval.candidates_per_expansion")?;
        positive(compatibility.tolerance, "compatibility.tolerance")?;
        let fraction = compatibility.retained_fraction;
        let is_share = fraction > 0.0 && fraction <= 1.0;
        check(
            is_share,
            fraction,
            "compatibility.retained_fraction",
            "in (0, 1]",
        )?;
        at_least(1, posegraph.neighbors, "posegraph.neighbors")?;
        at_least(1, cliques.max_cliques, "cliques.max_cliques")?;
        positive(cliques.inlier_threshold, "cliques.inlier_threshold")?;
        let affinity = cliques.min_affinity;
        check(
            (0.0..1.0).contains(&affinity),
            affinity,
            "cliques.min_affinity",
            "in [0, 1)",
        )?;
        at_least(1, cliques.work_budget, "cliques.work_budget")?;
        let (iterations, allowed) = (sync.iterations, "at most 100000");
        check(
            iterations <= 100_000,
            iterations as f64,
            "sync.iterations",
            allowed,
        )?;
        positive(sync.residual_scale, "sync.residual_scale")?;
        match &sync.method {
            Method::HistoryAware(History::Adaptive(history)) => validate_history(history),
            _ => Ok(()),
        }
    }
}

fn validate_history(history: &AdaptiveHistory) -> Result<(), Error> {
    let &AdaptiveHistory {
        min_memory,
        max_memory,
        sensitivity,
        recovery,
    } = history;
    let (name, allowed) = ("sync.method.max_memory", "in [0, 1)");
    check((0.0..1.0).contains(&max_memory), max_memory, name, allowed)?;
    let (name, allowed) = ("sync.method.min_memory", "in [0, max_memory]");
    check(
        (0.0..=max_memory).contains(&min_memory),
        min_memory,
        name,
        allowed,
    )?;
    positive(sensitivity, "sync.method.sensitivity")?;
    let is_strength = recovery.is_finite() && recovery >= 0.0;
    check(
        is_strength,
        recovery,
        "sync.method.recovery",
        "finite and not negative",
    )
}

fn at_least(least: usize, value: usize, name: &'static str) -> Result<(), Error> {
    let allowed = if least == 3 {
        "at least 3"
    } else {
        "at least 1"
    };
    check(value >= least, value as f64, name, allowed)
}

fn positive(value: f64, name: &'static str) -> Result<(), Error> {
    let is_positive = value.is_finite() && value > 0.0;
    check(is_positive, value, name, "finite and positive")
}

fn check(holds: bool, value: f64, name: &'static str, allowed: &'static str) -> Result<(), Error> {
    if holds {
        return Ok(());
    }
    Err(Error::Parameter {
        name,
        value,
        allowed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (N_s, N_o, r_s, K, K_c, L, κ, ρ)
    fn numbers(params: &Params) -> (usize, usize, f64, usize, usize, usize, f64, f64) {
        let Method::HistoryAware(History::Adaptive(history)) = params.sync.method else {
            panic!("the presets have an adaptive history");
        };
        (
            params.correspondence.num_samples,
            params.correspondence.max_correspondences,
            params.compatibility.retained_fraction,
            params.posegraph.neighbors,
            params.cliques.max_cliques,
            params.sync.iterations,
            history.sensitivity,
            history.recovery,
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
            assert!(params.validate().is_ok());
        }
    }

    #[test]
    fn every_parameter_out_of_range_is_named() {
        fn history(params: &mut Params) -> &mut AdaptiveHistory {
            match &mut params.sync.method {
                Method::HistoryAware(History::Adaptive(history)) => history,
                _ => panic!("the default history is adaptive"),
            }
        }
        type Spoil = fn(&mut Params);
        let cases: [(&str, Spoil); 16] = [
            ("sync.iterations", |p| p.sync.iterations = usize::MAX),
            ("correspondence.num_samples", |p| {
                p.correspondence.num_samples = 2
            }),
            ("correspondence.max_correspondences", |p| {
                p.correspondence.max_correspondences = 0
            }),
            ("compatibility.tolerance", |p| {
                p.compatibility.tolerance = 0.0
            }),
            ("compatibility.tolerance", |p| {
                p.compatibility.tolerance = f64::NAN
            }),
            ("compatibility.retained_fraction", |p| {
                p.compatibility.retained_fraction = 0.0
            }),
            ("posegraph.neighbors", |p| p.posegraph.neighbors = 0),
            ("cliques.max_cliques", |p| p.cliques.max_cliques = 0),
            ("cliques.inlier_threshold", |p| {
                p.cliques.inlier_threshold = f64::INFINITY
            }),
            ("cliques.min_affinity", |p| p.cliques.min_affinity = 1.0),
            ("cliques.work_budget", |p| p.cliques.work_budget = 0),
            ("sync.residual_scale", |p| p.sync.residual_scale = -1.0),
            ("sync.method.max_memory", |p| history(p).max_memory = 1.0),
            ("sync.method.min_memory", |p| history(p).min_memory = 0.95),
            ("sync.method.sensitivity", |p| history(p).sensitivity = 0.0),
            ("sync.method.recovery", |p| history(p).recovery = -0.1),
        ];
        for (name, spoil) in cases {
            let mut params = Params::default();
            spoil(&mut params);
            let message = params.validate().unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("parameter {name} is ")),
                "{message}"
            );
        }
    }
}
