use gmpcr_geometry::InvalidParameter;

/// Parameters of the selection of scan pairs. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PoseGraphParams {
    /// Most confident neighbors that each scan proposes as edges, `K`; at least 1. Default 6.
    pub neighbors: usize,
}

impl PoseGraphParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not, its value, and what is allowed.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self { neighbors } = self;
        InvalidParameter::check(neighbors >= 1, "neighbors", neighbors as f64, "at least 1")
    }
}

impl Default for PoseGraphParams {
    fn default() -> Self {
        Self { neighbors: 6 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_out_of_range_is_named() {
        let error = PoseGraphParams { neighbors: 0 }.validate().unwrap_err();
        assert_eq!(
            error.to_string(),
            "parameter neighbors is 0: it must be at least 1"
        );
        assert!(PoseGraphParams::default().validate().is_ok());
    }
}
