use nalgebra::Vector3;

/// Iterations, at most.
const MAX_ITERATIONS: usize = 1000;

/// Solves `A x = b` by conjugate gradients, preconditioned by the diagonal (Hestenes and Stiefel 1952), until
/// the residual in the norm of the inverse diagonal is this fraction of that of `x = 0`. The solution is as
/// good as 1000 iterations make it where `A` is ill conditioned; `None` where its diagonal is not positive.
///
/// `A` is symmetric, positive definite, given by its products, and acts alike on the three coordinates of
/// points.
pub(crate) fn conjugate_gradients(
    multiply: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
    diagonal: &[f64],
    right: &[Vector3<f64>],
    tolerance: f64,
) -> Option<Vec<Vector3<f64>>> {
    if !diagonal.iter().all(|&entry| entry > 0.0) {
        return None;
    }
    let precondition = |residual: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        residual.iter().zip(diagonal).map(|(r, d)| r / *d).collect()
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
        let image = multiply(&direction);
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
    Some(solution)
}

fn dot(x: &[Vector3<f64>], y: &[Vector3<f64>]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a.dot(b)).sum()
}
