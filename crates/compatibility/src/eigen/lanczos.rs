use nalgebra::{DMatrix, DVector};

use super::power::Approximation;
use super::products::{inner_products, subtract};
use super::tridiagonal::Tridiagonal;
use super::{DominantEigenpair, Route, without_noise};

/// Steps, at most: the basis costs `2 M k²` multiply-adds.
const MAX_STEPS: usize = 150;
/// Steps before the first look at what they have found, and between two of them.
const STEPS_PER_LOOK: usize = 6;
/// Residual of the eigenpair, as a fraction of the eigenvalue, at which it is as good as rounding allows.
const TOLERANCE: f64 = 1e-15;

/// The dominant pair of `B` from the space of `v, B v, B² v, …` (Lanczos 1950), which takes about the square
/// root of as many products as a power iteration.
///
/// In the orthonormal basis `Q` that each new product extends, `B` is a tridiagonal matrix `T`. Its
/// dominant eigenpair `(θ, y)` gives that of `B` as `(θ, Q y)`, with a residual of `β |y_k|`, where `β` is the
/// length of what the next product adds. Each product is made orthogonal to all of the basis twice, as
/// rounding demands. `None` where the steps do not suffice.
pub(super) fn by_lanczos(matrix: &DMatrix<f64>, start: Approximation) -> Option<DominantEigenpair> {
    let size = matrix.nrows();
    let mut basis = Vec::new();
    let mut tridiagonal = Tridiagonal::default();
    let (mut vector, mut length) = (start.vector, 0.0);
    for steps in 1..=size.min(MAX_STEPS) {
        basis.extend_from_slice(vector.as_slice());
        let mut next = inner_products(matrix.as_slice(), &vector);
        let overlaps = inner_products(&basis, &next);
        subtract(&mut next, &basis, &overlaps);
        let rest = inner_products(&basis, &next);
        subtract(&mut next, &basis, &rest);
        tridiagonal.push(overlaps[steps - 1], length);
        length = next.norm();
        let is_invariant = length <= TOLERANCE * overlaps.norm();
        if steps % STEPS_PER_LOOK == 0 || steps == size || is_invariant {
            let (value, coordinates) = tridiagonal.dominant()?;
            if is_invariant || length * coordinates[steps - 1].abs() <= TOLERANCE * value {
                let mut dominant = DVector::zeros(size);
                subtract(&mut dominant, &basis, &DVector::from_vec(coordinates));
                let iterations = start.iterations + steps;
                let route = Route::Lanczos { iterations, steps };
                let vector = dominant.map(without_noise);
                return Some(DominantEigenpair::certified(matrix, vector, route));
            }
        }
        vector = next / length;
    }
    None
}
