use gmpcr_geometry::InvalidParameter;

/// How many pairs are proposed. More of them miss less.
///
/// ```
/// use gmpcr_retrieval::RetrievalParams;
///
/// let params = RetrievalParams { candidates_per_scan: 0, ..RetrievalParams::default() };
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter candidates_per_scan is 0: it must be at least 1");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct RetrievalParams {
    /// Number of scans from which on pairs are retrieved; fewer scans have all their pairs scored.
    /// 0 always retrieves, [`usize::MAX`] never. Default 500; time is saved from about 150 on.
    pub min_scans: usize,
    /// Partners that each scan proposes by its descriptors, at least 1. Default 15.
    pub candidates_per_scan: usize,
    /// Rounds, at most, in which scans then propose neighbors of their neighbors, until there are no new
    /// ones; may be 0. Default 20.
    pub expansions: usize,
    /// Most confident partners of each scan that count as its neighbors in such a round, as do scans that
    /// count it as theirs; and partners that it then proposes, at least 1. Default 8.
    pub candidates_per_expansion: usize,
}

impl Default for RetrievalParams {
    fn default() -> Self {
        Self {
            min_scans: 500,
            candidates_per_scan: 15,
            expansions: 20,
            candidates_per_expansion: 8,
        }
    }
}

impl RetrievalParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            min_scans: _,
            candidates_per_scan,
            expansions: _,
            candidates_per_expansion,
        } = self;
        let at_least_one = |name: &str, value: usize| {
            InvalidParameter::check(value >= 1, name, value as f64, "at least 1")
        };
        at_least_one("candidates_per_scan", candidates_per_scan)?;
        at_least_one("candidates_per_expansion", candidates_per_expansion)
    }
}
