use gmpcr_geometry::InvalidParameter;

use crate::method::Method;

/// Reweighting iterations, at most.
const MAX_ITERATIONS: usize = 100_000;

/// Parameters of this stage. The default is the paper's setting for 3DMatch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SyncParams {
    /// Reweighting iterations, `L`, at most 100 000; 0 solves once with the initial weights.
    /// Default 10.
    pub iterations: usize,
    /// Rotation residual that counts as one, `s_r`, in radians; positive. Default 5°.
    pub residual_scale: f64,
    /// How the graph is synchronized. Default: the paper's adaptive history.
    pub method: Method,
    /// The residual history of [`Method::Adaptive`] and, without its recovery, of
    /// [`Method::NoRecovery`].
    pub history: AdaptiveHistory,
}

impl SyncParams {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not, its value, and what is allowed.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            iterations,
            residual_scale,
            method: _,
            ref history,
        } = self;
        InvalidParameter::check(
            iterations <= MAX_ITERATIONS,
            "iterations",
            iterations as f64,
            "at most 100000",
        )?;
        InvalidParameter::check_positive("residual_scale", residual_scale)?;
        history.validate().map_err(|error| error.within("history"))
    }
}

impl Default for SyncParams {
    fn default() -> Self {
        Self {
            iterations: 10,
            residual_scale: 5f64.to_radians(),
            method: Method::default(),
            history: AdaptiveHistory::default(),
        }
    }
}

/// Parameters of the adaptive residual history (paper, section "Adaptive History-aware Pose
/// Synchronization"). The default is the paper's setting for 3DMatch.
///
/// ```text
/// h ← λ h + (1 − λ) r,   λ = λ_min + (λ_max − λ_min) exp(−κ |R − R_last| / R_last)
/// w = min(w⁰, w⁰ exp(−h + ρ g)),   g = max(0, r_last − r)
/// ```
///
/// for the residuals `r` of the edges and the overall error `R = Σ w r²`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct AdaptiveHistory {
    /// Memory while the solution changes fast, `λ_min`; `0 ≤ λ_min ≤ λ_max`. Default 0.1.
    pub min_memory: f64,
    /// Memory of a settled solution, `λ_max < 1`. Default 0.9.
    pub max_memory: f64,
    /// Sensitivity of the memory to the relative variation of the overall error, `κ > 0`.
    /// Default 3.
    pub sensitivity: f64,
    /// Strength of the recovery, `ρ ≥ 0`; 0 switches it off. Default 0.1.
    pub recovery: f64,
}

impl AdaptiveHistory {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// [`InvalidParameter`] names the first that is not, its value, and what is allowed.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        let &Self {
            min_memory,
            max_memory,
            sensitivity,
            recovery,
        } = self;
        InvalidParameter::check(
            (0.0..1.0).contains(&max_memory),
            "max_memory",
            max_memory,
            "in [0, 1)",
        )?;
        InvalidParameter::check(
            (0.0..=max_memory).contains(&min_memory),
            "min_memory",
            min_memory,
            "in [0, max_memory]",
        )?;
        InvalidParameter::check_positive("sensitivity", sensitivity)?;
        InvalidParameter::check(
            recovery.is_finite() && recovery >= 0.0,
            "recovery",
            recovery,
            "finite and not negative",
        )
    }
}

impl Default for AdaptiveHistory {
    fn default() -> Self {
        Self {
            min_memory: 0.1,
            max_memory: 0.9,
            sensitivity: 3.0,
            recovery: 0.1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_out_of_range_is_named() {
        type Spoil = fn(&mut SyncParams);
        let cases: [(&str, Spoil); 10] = [
            ("iterations", |p| p.iterations = 100_001),
            ("residual_scale", |p| p.residual_scale = -1.0),
            ("residual_scale", |p| p.residual_scale = f64::NAN),
            ("history.max_memory", |p| p.history.max_memory = 1.0),
            ("history.max_memory", |p| p.history.max_memory = f64::NAN),
            ("history.min_memory", |p| p.history.min_memory = 0.95),
            ("history.min_memory", |p| p.history.min_memory = -0.1),
            ("history.sensitivity", |p| p.history.sensitivity = 0.0),
            ("history.recovery", |p| p.history.recovery = -0.1),
            ("history.recovery", |p| p.history.recovery = f64::INFINITY),
        ];
        for (name, spoil) in cases {
            let mut params = SyncParams::default();
            spoil(&mut params);
            assert_eq!(params.validate().unwrap_err().name, name);
        }
        let largest = SyncParams {
            iterations: 100_000,
            ..SyncParams::default()
        };
        assert!(largest.validate().is_ok());
    }
}
