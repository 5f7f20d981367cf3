/// Residual, in units of `σ`, below which `r` and `√r` are replaced by parabolas.
const KNEE: f64 = 0.1;

/// Loss of iteratively reweighted rotation averaging, with `σ` the scale of the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RobustLoss {
    /// `ρ(r) = r`: weights `w⁰ min(1, σ / 10 r)`.
    L1,
    /// `ρ(r) = √r`: weights `w⁰ min(1, (σ / 10 r)^{3/2})`.
    LHalf,
    /// `ρ(r) = r² / (r² + σ²)`: weights `w⁰ / (1 + r²/σ²)²`.
    GemanMcClure,
}

impl RobustLoss {
    /// The factor of the weight, in [0, 1], for a residual in units of `σ`: `ρ'(r) / r` up to scale.
    pub fn factor(self, residual: f64) -> f64 {
        match self {
            Self::L1 => power_factor(residual, 1.0),
            Self::LHalf => power_factor(residual, 1.5),
            Self::GemanMcClure => (1.0 + residual * residual).powi(-2),
        }
    }
}

/// `r^−p`, one at the knee and below.
fn power_factor(residual: f64, power: f64) -> f64 {
    (KNEE / residual.max(KNEE)).powf(power)
}
