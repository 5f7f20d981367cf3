use gmpcr_geometry::InvalidParameter;

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
///
/// ```
/// use gmpcr_compatibility::CompatibilityParams;
///
/// let params = CompatibilityParams { retained_fraction: 1.5, ..CompatibilityParams::default() };
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter retained_fraction is 1.5: it must be in (0, 1]");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct CompatibilityParams {
    /// Rigidity discrepancy at which two correspondences stop being compatible, `τ_c`, in the unit
    /// of the points; positive. Default 0.10 (meters, indoor scans).
    pub tolerance: f64,
    /// Fraction of the correspondences that is retained, `r_s`, in (0, 1]. One retains all: no
    /// spectral filtering. Default 0.5.
    pub retained_fraction: f64,
}

impl Default for CompatibilityParams {
    fn default() -> Self {
        Self {
            tolerance: 0.10,
            retained_fraction: 0.5,
        }
    }
}

impl CompatibilityParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            tolerance,
            retained_fraction,
        } = self;
        InvalidParameter::check_positive("tolerance", tolerance)?;
        let is_fraction = retained_fraction > 0.0 && retained_fraction <= 1.0;
        let allowed = "in (0, 1]";
        InvalidParameter::check(is_fraction, "retained_fraction", retained_fraction, allowed)
    }
}
