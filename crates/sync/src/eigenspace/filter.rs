use nalgebra::DMatrix;

use super::problem::{LOWEST_SHIFT, SemidefiniteMatrix, TOLERANCE};
use super::ritz::Ritz;

/// Largest degree of a polynomial of the inverse: solves between two projections.
const MAX_SOLVES: usize = 4;
/// Largest degree of a polynomial of the matrix: products between two projections.
const MAX_PRODUCTS: usize = 60;
/// Natural logarithm by which a filter may separate wanted vectors from each other, so that they stay
/// independent in floating point.
const MAX_SPREAD: f64 = 23.0;
/// Distance of a shift from the smallest value, as a fraction of the spread of the block, that keeps the
/// system well conditioned.
const MARGIN: f64 = 0.03;
/// Solves that take as long as a factorization.
const SOLVES_PER_FACTOR: f64 = 6.0;

/// A Chebyshev polynomial `T_d` of a matrix, mapped so that the eigenvalues beyond the block are in
/// [−1, 1], where `T_d` stays small, and the wanted ones above, where it grows fastest.
pub(super) enum Filter {
    /// Of the inverse of the matrix minus this shift.
    Inverse {
        shift: f64,
        /// A shift that turned out to be above the smallest eigenvalue.
        too_high: f64,
    },
    /// Of the matrix itself, whose eigenvalues are at most this.
    Direct { largest: f64 },
}

impl Filter {
    /// With the shift that the last search ended with, if it is still below all eigenvalues, or else with
    /// one that certainly is.
    pub fn new(matrix: &mut impl SemidefiniteMatrix, last_shift: f64) -> Self {
        let scale = matrix.scale();
        let mut too_high = f64::INFINITY;
        for shift in [last_shift * scale, LOWEST_SHIFT * scale] {
            if matrix.factorize(shift).is_ok() {
                return Self::Inverse { shift, too_high };
            }
            too_high = shift;
        }
        Self::Direct {
            largest: matrix.upper_bound(),
        }
    }

    pub fn shift(&self) -> f64 {
        match self {
            Self::Inverse { shift, .. } => *shift,
            Self::Direct { .. } => 0.0,
        }
    }

    /// Where an eigenvalue is mapped to.
    fn place(&self, ritz: &Ritz, value: f64) -> f64 {
        match self {
            Self::Inverse { shift, .. } => 2.0 * (ritz.last() - shift) / (value - shift) - 1.0,
            Self::Direct { largest } => 1.0 + 2.0 * (ritz.last() - value) / (largest - ritz.last()),
        }
    }

    /// Natural logarithm by which the eigenvectors of a value grow with each degree.
    fn growth(&self, ritz: &Ritz, value: f64) -> f64 {
        self.place(ritz, value).acosh().max(1e-3)
    }

    /// The degree that takes this error to the tolerance, or as much of the way as keeps the vectors
    /// independent.
    pub fn degree(&self, ritz: &Ritz, error: f64) -> usize {
        let needed = (error / TOLERANCE).ln() / self.growth(ritz, ritz.last_wanted());
        let independent = MAX_SPREAD / self.growth(ritz, ritz.values[0]);
        let max_degree = match self {
            Self::Inverse { .. } => MAX_SOLVES,
            Self::Direct { .. } => MAX_PRODUCTS,
        };
        (needed.ceil().min(independent) as usize).clamp(1, max_degree)
    }

    /// `T_d` of the mapped matrix times the Ritz vectors, by the three-term recurrence.
    pub fn apply(
        &self,
        matrix: &mut impl SemidefiniteMatrix,
        ritz: &Ritz,
        degree: usize,
    ) -> DMatrix<f64> {
        let mut mapped = |x: &DMatrix<f64>| match self {
            Self::Inverse { shift, .. } => {
                let mut y = x * (2.0 * (ritz.last() - shift));
                matrix.solve_in_place(&mut y);
                y - x
            }
            Self::Direct { largest } => {
                let width = largest - ritz.last();
                x * ((largest + ritz.last()) / width) - matrix.multiply(x) * (2.0 / width)
            }
        };
        let mut before = ritz.vectors.clone();
        let mut now = mapped(&before);
        for _ in 1..degree {
            let next = mapped(&now) * 2.0 - &before;
            before = std::mem::replace(&mut now, next);
        }
        now
    }

    /// Moves the shift up behind the smallest eigenvalue, where that saves more solves than a
    /// factorization costs. That the factorization succeeds proves that the shift is below.
    ///
    /// The smallest eigenvalue is at least `θ₁ − ‖A x₁ − θ₁ x₁‖` once the iteration has found it.
    pub fn move_closer(&mut self, matrix: &mut impl SemidefiniteMatrix, ritz: &Ritz, error: f64) {
        let Self::Inverse { shift, too_high } = *self else {
            return;
        };
        let spread = ritz.last() - ritz.values[0];
        let distance = (MARGIN * spread).max(2.0 * ritz.residuals.column(0).norm());
        let closer = Self::Inverse {
            shift: ritz.values[0] - distance,
            too_high,
        };
        let solves =
            |filter: &Self| (error / TOLERANCE).ln() / filter.growth(ritz, ritz.last_wanted());
        let is_allowed = closer.shift() > shift && closer.shift() < too_high;
        if is_allowed && solves(self) - solves(&closer) > SOLVES_PER_FACTOR {
            if matrix.factorize(closer.shift()).is_ok() {
                *self = closer;
            } else {
                // The current shift was factored before, so it can be again.
                let _ = matrix.factorize(shift);
                *self = Self::Inverse {
                    shift,
                    too_high: closer.shift(),
                };
            }
        }
    }
}
