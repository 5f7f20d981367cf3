use crate::params::AdaptiveHistory;
use crate::reweighting::{Reweighting, weighted_error};

/// How the rotation residuals of the measurements become their next weights.
#[derive(Clone, Copy, Debug)]
pub(crate) enum History {
    /// See [`Method::Adaptive`](crate::Method::Adaptive).
    Adaptive(AdaptiveHistory),
    /// See [`Method::Sghr`](crate::Method::Sghr).
    Sghr,
    /// See [`Method::Memoryless`](crate::Method::Memoryless).
    Memoryless,
}

/// The running history of all measurements of a graph.
pub(crate) struct EdgeHistory {
    scheme: History,
    num_iterations: usize,
    initial_weights: Vec<f64>,
    weights: Vec<f64>,
    iteration: usize,
    /// `h_ij` after the last update.
    history: Vec<f64>,
    last_residuals: Vec<f64>,
    last_error: f64,
}

impl EdgeHistory {
    /// Starts with the initial weights `w⁰`; `num_iterations` is the planned number of updates.
    pub fn new(scheme: History, num_iterations: usize, initial_weights: Vec<f64>) -> Self {
        Self {
            scheme,
            num_iterations,
            weights: initial_weights.clone(),
            initial_weights,
            iteration: 0,
            history: Vec::new(),
            last_residuals: Vec::new(),
            last_error: 0.0,
        }
    }

    /// The current weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Takes the normalized residuals `r_ij` of one iteration into account. `residual_scale` is the
    /// `s_r` (radians) that normalized them; only [`History::Sghr`] needs it, to get degrees back.
    pub fn update(&mut self, residuals: &[f64], residual_scale: f64) -> Reweighting {
        let weighted_error = weighted_error(&self.weights, residuals);
        let memory = match self.scheme {
            History::Adaptive(params) => self.adaptive(residuals, weighted_error, &params),
            History::Sghr => self.accumulate(residuals, residual_scale.to_degrees()),
            History::Memoryless => self.forget(residuals),
        };
        self.iteration += 1;
        self.last_residuals = residuals.to_vec();
        self.last_error = weighted_error;
        Reweighting {
            weighted_error,
            memory,
            weights: self.weights.clone(),
        }
    }

    /// `h ← λ h + (1 − λ) r`, `g = max(0, r_last − r)`, `w = min(w⁰, w⁰ exp(−h + ρ g))`.
    /// The first iteration has history `r` and no recovery.
    fn adaptive(&mut self, residuals: &[f64], error: f64, params: &AdaptiveHistory) -> Option<f64> {
        let is_first = self.iteration == 0;
        let memory = (!is_first).then(|| memory(params, error, self.last_error));
        if is_first {
            self.history = residuals.to_vec();
            self.last_residuals = residuals.to_vec();
        }
        let lambda = memory.unwrap_or(0.0);
        for (k, &residual) in residuals.iter().enumerate() {
            self.history[k] = lambda * self.history[k] + (1.0 - lambda) * residual;
            let gain = (self.last_residuals[k] - residual).max(0.0);
            let exponent = params.recovery * gain - self.history[k];
            self.weights[k] = self.initial_weights[k] * exponent.exp().min(1.0);
        }
        memory
    }

    fn accumulate(&mut self, residuals: &[f64], degrees_per_unit: f64) -> Option<f64> {
        let count = self.num_iterations.max(1) as f64;
        let fraction = (self.iteration as f64 + 1.0) / (count * (count + 1.0) / 2.0);
        for (weight, residual) in self.weights.iter_mut().zip(residuals) {
            *weight *= (-2.0 * residual * degrees_per_unit * fraction).exp();
        }
        None
    }

    fn forget(&mut self, residuals: &[f64]) -> Option<f64> {
        let pairs = self.initial_weights.iter().zip(residuals);
        self.weights = pairs.map(|(initial, r)| initial * (-r).exp()).collect();
        None
    }
}

/// `λ = λ_min + (λ_max − λ_min) exp(−κ ΔR)` with `ΔR = |R − R_last| / R_last`; an overall error
/// that was zero counts as settled, `ΔR = 0`.
fn memory(params: &AdaptiveHistory, error: f64, last_error: f64) -> f64 {
    let variation = if last_error > 0.0 {
        (error - last_error).abs() / last_error
    } else {
        0.0
    };
    let range = params.max_memory - params.min_memory;
    params.min_memory + range * (-params.sensitivity * variation).exp()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    use super::*;

    fn residual_runs() -> impl Strategy<Value = Vec<Vec<f64>>> {
        prop::collection::vec(prop::collection::vec(0.0..36.0f64, 5), 1..8)
    }

    proptest! {
        #[test]
        fn no_weight_exceeds_its_initial_value(runs in residual_runs(), recovery in 0.0..50.0f64) {
            let params = AdaptiveHistory { recovery, ..Default::default() };
            for scheme in [History::Adaptive(params), History::Sghr, History::Memoryless] {
                let initial = vec![0.1, 0.5, 1.0, 2.0, 0.0];
                let mut history = EdgeHistory::new(scheme, runs.len(), initial.clone());
                for residuals in &runs {
                    let update = history.update(residuals, 0.1);
                    prop_assert!(update.weights.iter().zip(&initial).all(|(w, w0)| *w <= *w0 && *w >= 0.0));
                }
            }
        }

        #[test]
        fn the_scale_of_the_weights_does_not_matter(runs in residual_runs(), scale in 0.01..100.0f64) {
            for scheme in [History::Adaptive(AdaptiveHistory::default()), History::Sghr, History::Memoryless] {
                let mut one = EdgeHistory::new(scheme, runs.len(), vec![0.3; 5]);
                let mut other = EdgeHistory::new(scheme, runs.len(), vec![0.3 * scale; 5]);
                for residuals in &runs {
                    let (a, b) = (one.update(residuals, 0.1), other.update(residuals, 0.1));
                    for (w, v) in a.weights.iter().zip(&b.weights) {
                        assert_relative_eq!(w * scale, *v, max_relative = 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn memory_is_long_when_settled_and_short_when_the_error_jumps() {
        let params = AdaptiveHistory::default();
        assert_eq!(memory(&params, 1.0, 1.0), 0.9);
        assert_eq!(memory(&params, 1.0, 0.0), 0.9);
        assert_relative_eq!(memory(&params, 1e9, 1.0), 0.1);
        assert_relative_eq!(memory(&params, 1.5, 1.0), 0.1 + 0.8 * (-1.5f64).exp());
    }

    #[test]
    fn a_falling_residual_recovers_and_a_rising_one_does_not() {
        let with = |recovery| {
            let params = AdaptiveHistory {
                recovery,
                ..Default::default()
            };
            let mut history = EdgeHistory::new(History::Adaptive(params), 2, vec![1.0, 1.0]);
            history.update(&[4.0, 1.0], 0.1);
            history.update(&[1.0, 4.0], 0.1).weights
        };
        assert!(with(0.1)[0] > with(0.0)[0]);
        assert_eq!(with(0.1)[1], with(0.0)[1]);
    }

    #[test]
    fn the_sghr_exponents_add_up_to_twice_the_mean_angle() {
        let mut history = EdgeHistory::new(History::Sghr, 4, vec![1.0]);
        for _ in 0..4 {
            history.update(&[1.5], 2f64.to_radians());
        }
        assert_relative_eq!(
            history.weights()[0],
            (-2.0 * 3.0f64).exp(),
            max_relative = 1e-12
        );
    }

    #[test]
    fn weights_and_errors_are_the_reference_ones() {
        let golden = include_str!("../tests/golden/sync.json");
        let golden: serde_json::Value = serde_json::from_str(golden).unwrap();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            value.as_array().unwrap().iter().map(number).collect()
        };
        for case in golden["cases"].as_array().unwrap() {
            let params = &case["params"];
            let scheme = match params["history"].as_str().unwrap() {
                "sghr" => History::Sghr,
                _ => History::Adaptive(AdaptiveHistory {
                    min_memory: number(&params["lambda_min"]),
                    max_memory: number(&params["lambda_max"]),
                    sensitivity: number(&params["kappa"]),
                    recovery: number(&params["rho"]),
                }),
            };
            let scale = number(&params["residual_scale_deg"]).to_radians();
            let trace = case["trace"].as_array().unwrap();
            let initial_weights = numbers(&case["initial_weights"]);
            let mut history = EdgeHistory::new(scheme, trace.len(), initial_weights);
            for expected in trace {
                let update = history.update(&numbers(&expected["residual"]), scale);
                let error = number(&expected["weighted_error"]);
                assert_relative_eq!(update.weighted_error, error, max_relative = 1e-9);
                for (weight, expected) in update
                    .weights
                    .iter()
                    .zip(numbers(&expected["weights_after"]))
                {
                    assert_relative_eq!(*weight, expected, epsilon = 1e-12, max_relative = 1e-9);
                }
            }
        }
    }
}
