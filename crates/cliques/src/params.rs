use gmpcr_geometry::InvalidParameter;

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
///
/// ```
/// use gmpcr_cliques::CliqueParams;
///
/// let params = CliqueParams { min_affinity: 1.0, ..CliqueParams::default() };
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter min_affinity is 1: it must be in [0, 1)");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct CliqueParams {
    /// Cliques that generate hypotheses, `K_c`; at least 1. Default 10.
    pub max_cliques: usize,
    /// Distance below which a correspondence supports a transformation, `τ_in`, in the unit of the points;
    /// positive. Default 0.10 (meters, indoor scans).
    pub inlier_threshold: f64,
    /// First-order affinity above which two correspondences may be in one clique, in [0, 1). The
    /// default 0 keeps every compatible pair; higher values leave out edges of dense graphs.
    pub min_affinity: f64,
    /// Enumeration steps per pair before the best cliques so far are used; at least 1. A graph may
    /// have `3^(M/3)` maximal cliques (Moon and Moser 1965). Default 200 000, which takes some tens
    /// of milliseconds; ordinary pairs need a few hundred.
    pub work_budget: usize,
}

impl Default for CliqueParams {
    fn default() -> Self {
        Self {
            max_cliques: 10,
            inlier_threshold: 0.10,
            min_affinity: 0.0,
            work_budget: 200_000,
        }
    }
}

impl CliqueParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            max_cliques,
            inlier_threshold,
            min_affinity,
            work_budget,
        } = self;
        let at_least_one = |name: &str, value: usize| {
            InvalidParameter::check(value >= 1, name, value as f64, "at least 1")
        };
        at_least_one("max_cliques", max_cliques)?;
        InvalidParameter::check_positive("inlier_threshold", inlier_threshold)?;
        let is_affinity = (0.0..1.0).contains(&min_affinity);
        InvalidParameter::check(is_affinity, "min_affinity", min_affinity, "in [0, 1)")?;
        at_least_one("work_budget", work_budget)
    }
}
