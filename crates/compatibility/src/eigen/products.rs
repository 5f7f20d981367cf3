use faer::traits::pulp::{Arch, Simd, WithSimd};
use nalgebra::DVector;

/// Inner products of the columns of a matrix with a vector of their length: `B v` of a symmetric matrix,
/// `Qᵀ v` of a basis.
pub(super) fn inner_products(columns: &[f64], vector: &DVector<f64>) -> DVector<f64> {
    Arch::new().dispatch(InnerProducts { columns, vector })
}

/// Subtracts a combination of the columns of a matrix: `v − Q c`.
pub(super) fn subtract(vector: &mut DVector<f64>, columns: &[f64], coefficients: &DVector<f64>) {
    Arch::new().dispatch(Subtraction {
        vector,
        columns,
        coefficients,
    });
}

/// One step of the power iteration, `next = B v / ‖B v‖`, from a unit vector. Returns its length
/// `‖next − v‖`.
pub(super) fn power_step(matrix: &[f64], vector: &DVector<f64>, next: &mut DVector<f64>) -> f64 {
    Arch::new().dispatch(PowerStep {
        matrix,
        vector,
        next,
    })
}

/// In the widest vectors that the machine has, as all that follows.
struct InnerProducts<'a> {
    columns: &'a [f64],
    vector: &'a DVector<f64>,
}

impl WithSimd for InnerProducts<'_> {
    type Output = DVector<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DVector<f64> {
        let size = self.vector.len().max(1);
        let mut products = DVector::zeros(self.columns.len() / size);
        let columns = self.columns.chunks_exact(size);
        for (product, column) in products.as_mut_slice().iter_mut().zip(columns) {
            *product = inner_product(simd, column, self.vector.as_slice());
        }
        products
    }
}

struct PowerStep<'a> {
    matrix: &'a [f64],
    vector: &'a DVector<f64>,
    next: &'a mut DVector<f64>,
}

impl WithSimd for PowerStep<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (vector, next) = (self.vector.as_slice(), self.next.as_mut_slice());
        let columns = self.matrix.chunks_exact(vector.len().max(1));
        for (entry, column) in next.iter_mut().zip(columns) {
            *entry = inner_product(simd, column, vector);
        }
        let norm = inner_product(simd, next, next).sqrt();
        let mut squares = 0.0;
        for (entry, last) in next.iter_mut().zip(vector) {
            *entry /= norm;
            squares += (*entry - last) * (*entry - last);
        }
        squares.sqrt()
    }
}

/// Four partial sums hide the time that an addition takes.
#[inline(always)]
fn inner_product<S: Simd>(simd: S, x: &[f64], y: &[f64]) -> f64 {
    let ((x, x_tail), (y, y_tail)) = (S::as_simd_f64s(x), S::as_simd_f64s(y));
    let ((x_fours, x_rest), (y_fours, y_rest)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
    let mut sums = [simd.splat_f64s(0.0); 4];
    for (x, y) in x_fours.iter().zip(y_fours) {
        for lane in 0..4 {
            sums[lane] = simd.mul_add_f64s(x[lane], y[lane], sums[lane]);
        }
    }
    for (&x, &y) in x_rest.iter().zip(y_rest) {
        sums[0] = simd.mul_add_f64s(x, y, sums[0]);
    }
    let [a, b, c, d] = sums;
    let sum = simd.reduce_sum_f64s(simd.add_f64s(simd.add_f64s(a, b), simd.add_f64s(c, d)));
    let tail = x_tail.iter().zip(y_tail);
    tail.fold(sum, |sum, (x, y)| sum + x * y)
}

struct Subtraction<'a> {
    vector: &'a mut DVector<f64>,
    columns: &'a [f64],
    coefficients: &'a DVector<f64>,
}

impl WithSimd for Subtraction<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let columns = self.columns.chunks_exact(self.vector.len().max(1));
        let (blocks, rest) = S::as_mut_simd_f64s(self.vector.as_mut_slice());
        for (column, &coefficient) in columns.zip(self.coefficients) {
            let (column_blocks, column_rest) = S::as_simd_f64s(column);
            let factor = simd.splat_f64s(-coefficient);
            for (x, &y) in blocks.iter_mut().zip(column_blocks) {
                *x = simd.mul_add_f64s(factor, y, *x);
            }
            for (x, y) in rest.iter_mut().zip(column_rest) {
                *x -= coefficient * y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use nalgebra::DMatrix;

    use super::*;

    /// All lengths of what vector registers leave over.
    #[test]
    fn products_are_those_of_plain_loops() {
        for size in 0..40usize {
            let wave = |k: usize| (1.3 * k as f64).sin() + 1.1;
            let matrix = DMatrix::from_fn(size, 5, |row, column| wave(row + 7 * column));
            let vector = DVector::from_fn(size, |row, _| wave(3 * row));
            if size > 0 {
                let products = inner_products(matrix.as_slice(), &vector);
                assert_relative_eq!(products, matrix.tr_mul(&vector), max_relative = 1e-13);
            }
            let coefficients = DVector::from_fn(5, |row, _| wave(row));
            let mut rest = vector.clone();
            subtract(&mut rest, matrix.as_slice(), &coefficients);
            assert_relative_eq!(rest, &vector - &matrix * &coefficients, epsilon = 1e-13);

            let square = DMatrix::from_fn(size, size, |m, n| wave(m + n));
            let mut next = DVector::zeros(size);
            let change = power_step(square.as_slice(), &vector, &mut next);
            if size > 0 {
                let expected = (&square * &vector).normalize();
                assert_relative_eq!(next, expected, max_relative = 1e-13);
                assert_relative_eq!(change, (expected - &vector).norm(), max_relative = 1e-13);
            }
        }
    }
}
