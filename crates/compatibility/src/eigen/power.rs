use nalgebra::{DMatrix, DVector};

use super::products::{inner_products, power_step};
use super::{DominantEigenpair, Route};

/// Bound of the error of the unit eigenvector at which the iteration stops.
const TOLERANCE: f64 = 1e-13;
/// Beyond this many products Lanczos's method is cheaper.
const MAX_ITERATIONS: usize = 60;
/// Products before the ratio of the steps tells how many are left.
const TRUSTED_ITERATIONS: usize = 8;

/// How far an iteration came that takes too long.
pub(super) struct Approximation {
    pub vector: DVector<f64>,
    pub iterations: usize,
}

/// The dominant pair by `v ← B v / ‖B v‖` from the row sums, or an approximate unit vector where that
/// is slow.
pub(super) fn by_power_iteration(
    matrix: &DMatrix<f64>,
) -> Result<DominantEigenpair, Approximation> {
    let ones = DVector::repeat(matrix.nrows(), 1.0);
    let mut vector = inner_products(matrix.as_slice(), &ones).normalize();
    let mut next = DVector::zeros(matrix.nrows());
    let mut last_change = f64::INFINITY;
    let mut iterations = 0;
    while iterations < MAX_ITERATIONS {
        let change = power_step(matrix.as_slice(), &vector, &mut next);
        std::mem::swap(&mut vector, &mut next);
        iterations += 1;
        let ratio = change / last_change;
        let error = remaining_error(change, ratio);
        if error <= TOLERANCE {
            let route = Route::Power { iterations };
            return Ok(DominantEigenpair::certified(matrix, vector, route));
        }
        let num_left = (TOLERANCE / error).ln() / ratio.min(0.999).ln();
        if iterations >= TRUSTED_ITERATIONS && iterations as f64 + num_left > MAX_ITERATIONS as f64
        {
            break;
        }
        last_change = change;
    }
    Err(Approximation { vector, iterations })
}

/// Distance to the limit of a sequence whose last step had this length and this ratio to the one before: the
/// errors shrink geometrically by the ratio `λ₂/λ₁`. A slow part of the error may still hide behind a
/// fast one, so no ratio below one half is believed.
fn remaining_error(change: f64, ratio: f64) -> f64 {
    if change <= 4.0 * f64::EPSILON {
        return 0.0; // rounding: nothing is left to gain
    }
    if ratio == 0.0 {
        return f64::INFINITY; // the first step reveals no ratio
    }
    let ratio = ratio.clamp(0.5, 0.999);
    change * ratio / (1.0 - ratio)
}
