/// Laguerre steps to an eigenvalue, of which five or six are usual.
const MAX_STEPS: usize = 100;

/// A symmetric tridiagonal matrix `T` with positive entries beside its diagonal, that grows.
#[derive(Default)]
pub(super) struct Tridiagonal {
    diagonal: Vec<f64>,
    /// What ties each row to the one before; zero for the first.
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// Adds a row, which is tied to the last by `beside`: zero for the first.
    pub fn push(&mut self, diagonal: f64, beside: f64) {
        self.diagonal.push(diagonal);
        self.beside.push(beside);
    }

    /// The largest eigenvalue, which is to be positive, and its unit eigenvector. `None` for the zero matrix
    /// and where entries are not finite.
    ///
    /// Laguerre's iteration comes down on the largest root of the characteristic polynomial from above,
    /// without ever passing it but for rounding, and cubically at the end. Two solves with `σ I − T`,
    /// positive definite for a shift just above, give the vector. `O(k)` per step and solve.
    pub fn dominant(&self) -> Option<(f64, Vec<f64>)> {
        let bound = self.bound();
        if !(bound > 0.0 && bound.is_finite()) {
            return None;
        }
        // Relative to the bound, so that no power of an entry overflows.
        let scaled = Self {
            diagonal: self.diagonal.iter().map(|entry| entry / bound).collect(),
            beside: self.beside.iter().map(|entry| entry / bound).collect(),
        };
        let mut value = 1.0;
        for _ in 0..MAX_STEPS {
            let Some(step) = scaled.laguerre_step(value) else {
                break;
            };
            value -= step;
            if step <= f64::EPSILON * value {
                break;
            }
        }
        let shift = value + 8.0 * f64::EPSILON;
        // The eigenvector is positive, as the entries beside the diagonal are: this has a part of it.
        let mut vector = vec![1.0; self.diagonal.len()];
        for _ in 0..2 {
            scaled.solve_shifted(shift, &mut vector);
            let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|v| *v /= norm);
        }
        let is_finite = vector.iter().all(|v| v.is_finite());
        is_finite.then_some((value * bound, vector))
    }

    /// The largest row sum of absolute values (Gershgorin).
    fn bound(&self) -> f64 {
        let row = |k: usize| {
            let after = self.beside.get(k + 1).copied().unwrap_or(0.0);
            self.diagonal[k].abs() + self.beside[k] + after
        };
        (0..self.diagonal.len()).map(row).fold(0.0, f64::max)
    }

    /// How far Laguerre's iteration goes from `shift`, no smaller than the largest eigenvalue, towards it.
    ///
    /// The characteristic polynomial is the product of the pivots of `σ I − T`, all positive above the
    /// largest eigenvalue; the sums are of the logarithmic derivatives of the pivots. `None` where a pivot is
    /// not positive.
    fn laguerre_step(&self, shift: f64) -> Option<f64> {
        let (mut first_sum, mut second_sum) = (0.0, 0.0);
        // A pivot and its first two derivatives by the shift.
        let (mut pivot, mut slope, mut curvature) = (1.0, 0.0, 0.0);
        for (diagonal, tie) in self.diagonal.iter().zip(&self.beside) {
            let inverse = 1.0 / pivot;
            let square = tie * tie * inverse;
            let relative = slope * inverse;
            curvature = square * (curvature * inverse - 2.0 * relative * relative);
            slope = 1.0 + square * relative;
            pivot = shift - diagonal - square;
            if pivot <= 0.0 || pivot.is_nan() {
                return None;
            }
            first_sum += slope / pivot;
            second_sum += (slope / pivot).powi(2) - curvature / pivot;
        }
        let degree = self.diagonal.len() as f64;
        let spread = (degree - 1.0) * (degree * second_sum - first_sum * first_sum);
        Some(degree / (first_sum + spread.max(0.0).sqrt()))
    }

    /// Replaces `x` by `(σ I − T)⁻¹ x`.
    fn solve_shifted(&self, shift: f64, x: &mut [f64]) {
        let mut pivots = Vec::with_capacity(x.len());
        for k in 0..x.len() {
            let mut pivot = shift - self.diagonal[k];
            if k > 0 {
                let factor = self.beside[k] / pivots[k - 1];
                pivot -= factor * self.beside[k];
                x[k] += factor * x[k - 1];
            }
            pivots.push(pivot.max(f64::EPSILON)); // the scale is one
        }
        for k in (0..x.len()).rev() {
            if k + 1 < x.len() {
                x[k] += self.beside[k + 1] * x[k + 1];
            }
            x[k] /= pivots[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;

    fn dense(matrix: &Tridiagonal) -> DMatrix<f64> {
        let size = matrix.diagonal.len();
        DMatrix::from_fn(size, size, |row, column| match row.abs_diff(column) {
            0 => matrix.diagonal[row],
            1 => matrix.beside[row.max(column)],
            _ => 0.0,
        })
    }

    proptest! {
        #[test]
        fn the_dominant_pair_is_that_of_the_dense_decomposition(
            first in 0.1..1.0f64,
            entries in prop::collection::vec((-1.0..1.0f64, -15.0..0.0f64), 0..40),
            scale in prop_oneof![Just(1.0), Just(1e-200), Just(1e200)],
        ) {
            let mut matrix = Tridiagonal::default();
            matrix.push(first * scale, 0.0);
            for (diagonal, digits) in entries {
                matrix.push(diagonal * scale, 10f64.powf(digits) * scale);
            }
            let (value, vector) = matrix.dominant().unwrap();
            let dense = dense(&matrix) / scale;
            let expected = dense.clone().symmetric_eigenvalues().max();
            prop_assert!((value / scale - expected).abs() < 1e-13 * expected, "{value} {expected}");
            let vector = nalgebra::DVector::from_vec(vector);
            let residual = (&dense * &vector - &vector * (value / scale)).norm();
            prop_assert!(residual < 1e-13 * expected, "{residual}");
        }
    }

    #[test]
    fn nothing_has_no_dominant_pair() {
        let mut matrix = Tridiagonal::default();
        matrix.push(0.0, 0.0);
        assert!(matrix.dominant().is_none());
        matrix.push(f64::INFINITY, 1.0);
        assert!(matrix.dominant().is_none());
    }
}
