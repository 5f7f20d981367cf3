use gmpcr_geometry::InvalidParameter;

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
///
/// ```
/// use gmpcr_correspondence::CorrespondenceParams;
///
/// let params = CorrespondenceParams { num_samples: 2, ..CorrespondenceParams::default() };
/// let error = params.validate().unwrap_err().to_string();
/// assert_eq!(error, "parameter num_samples is 2: it must be at least 3");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct CorrespondenceParams {
    /// Keypoints kept per scan, `N_s`; at least 3. A smaller scan keeps all its points.
    /// Default 200.
    pub num_samples: usize,
    /// Matches kept per scan pair, `N_o`; at least 3. Default 100.
    pub max_correspondences: usize,
}

impl Default for CorrespondenceParams {
    fn default() -> Self {
        Self {
            num_samples: 200,
            max_correspondences: 100,
        }
    }
}

impl CorrespondenceParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            num_samples,
            max_correspondences,
        } = self;
        at_least_three("num_samples", num_samples)?;
        at_least_three("max_correspondences", max_correspondences)
    }
}

/// Three correspondences are the fewest that determine a transformation.
fn at_least_three(name: &str, value: usize) -> Result<(), InvalidParameter> {
    InvalidParameter::check(value >= 3, name, value as f64, "at least 3")
}
