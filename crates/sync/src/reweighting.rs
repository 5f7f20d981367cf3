/// One weight update of all measurements of a graph.
#[derive(Clone, Debug)]
pub(crate) struct Reweighting {
    /// Overall rotation error `R = Σ w r²`.
    pub weighted_error: f64,
    /// Memory coefficient `λ` that was used; `None` in the first update and for methods without one.
    pub memory: Option<f64>,
    /// The new weights.
    pub weights: Vec<f64>,
}

/// Overall rotation error `R = Σ w r²` of normalized residuals.
pub(crate) fn weighted_error(weights: &[f64], residuals: &[f64]) -> f64 {
    let pairs = weights.iter().zip(residuals);
    pairs.map(|(w, r)| w * r * r).sum()
}
