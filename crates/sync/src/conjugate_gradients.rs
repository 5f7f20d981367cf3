use nalgebra::Vector3;

/// Iterations, at most.
const MAX_ITERATIONS: usize = 1000;

/// A symmetric positive definite matrix that acts alike on the three coordinates of points.
pub(crate) trait LinearSystem {
    /// `A x`.
    fn multiply(&self, x: &[Vector3<f64>]) -> Vec<Vector3<f64>>;
    /// The diagonal of `A`.
    fn diagonal(&self) -> Vec<f64>;
}

/// Solves `A x = b` by conjugate gradients, preconditioned by the diagonal (Hestenes and Stiefel 1952), until
/// the residual in the norm of the inverse diagonal is this share of that of `x = 0`. The solution is as
/// good as 1000 iterations make it where `A` is ill conditioned.
pub(crate) fn conjugate_gradients(
    system: &impl LinearSystem,
    right: &[Vector3<f64>],
    tolerance: f64,
) -> Vec<Vector3<f64>> {
    let diagonal = system.diagonal();
    let precondition = |residual: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        residual
            .iter()
            .zip(&diagonal)
            .map(|(r, d)| r / *d)
            .collect()
    };
    let mut solution = vec![Vector3::zeros(); right.len()];
    let mut residual = right.to_vec();
    let mut direction = precondition(&residual);
    let mut size = dot(&residual, &direction);
    let enough = tolerance * tolerance * size;
    for _ in 0..MAX_ITERATIONS {
        // Not a number means that the matrix is singular in floating point.
        if size <= enough || size.is_nan() {
            break;
        }
        let image = system.multiply(&direction);
        let step = size / dot(&direction, &image);
        for (k, d) in direction.iter_mut().enumerate() {
            solution[k] += *d * step;
            residual[k] -= image[k] * step;
        }
        let preconditioned = precondition(&residual);
        let smaller = dot(&residual, &preconditioned);
        for (d, p) in direction.iter_mut().zip(&preconditioned) {
            *d = p + *d * (smaller / size);
        }
        size = smaller;
    }
    solution
}

fn dot(x: &[Vector3<f64>], y: &[Vector3<f64>]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a.dot(b)).sum()
}
