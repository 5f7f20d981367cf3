use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::problem::{Eigenspace, SemidefiniteMatrix};

/// The best approximation of the eigenvectors within a subspace.
pub(super) struct Ritz {
    wanted: usize,
    /// The Ritz values `θ`, ascending.
    pub values: Vec<f64>,
    pub vectors: DMatrix<f64>,
    /// `A x − θ x` of each vector.
    pub residuals: DMatrix<f64>,
}

impl Ritz {
    pub fn residual(&self) -> f64 {
        (0..self.num_wanted())
            .map(|k| self.residuals.column(k).norm())
            .fold(0.0, f64::max)
    }

    /// The largest value of the block.
    pub fn last(&self) -> f64 {
        self.values[self.values.len() - 1]
    }

    fn num_wanted(&self) -> usize {
        self.wanted.min(self.values.len())
    }

    pub fn last_wanted(&self) -> f64 {
        self.values[self.num_wanted() - 1]
    }

    /// The largest change of a row of the wanted vectors, relative to the row, apart from a change of
    /// their basis.
    pub fn change_since(&self, before: &DMatrix<f64>) -> f64 {
        let (now, before) = (
            self.vectors.columns(0, self.num_wanted()),
            before.columns(0, self.num_wanted()),
        );
        let moved = now - before * before.tr_mul(&now);
        let rows = moved.row_iter().zip(now.row_iter());
        let squares = rows.map(|(moved, now)| moved.norm_squared() / now.norm_squared());
        squares.fold(0.0, f64::max).sqrt()
    }

    pub fn into_eigenspace(self, scale: f64, shift: f64) -> Eigenspace {
        Eigenspace {
            shift: if scale > 0.0 { shift / scale } else { shift },
            residual: if scale > 0.0 {
                self.residual() / scale
            } else {
                0.0
            },
            vectors: self.vectors,
        }
    }
}

pub(super) fn rayleigh_ritz(
    matrix: &impl SemidefiniteMatrix,
    wanted: usize,
    mut basis: DMatrix<f64>,
) -> Ritz {
    orthonormalize(&mut basis);
    let image = matrix.multiply(&basis);
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::new(basis.tr_mul(&image));
    let mut order: Vec<usize> = (0..eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    let rotation = eigenvectors.select_columns(&order);
    let values: Vec<f64> = order.iter().map(|&k| eigenvalues[k]).collect();
    let vectors = basis * &rotation;
    let mut residuals = image * &rotation;
    for (k, &value) in values.iter().enumerate() {
        residuals
            .column_mut(k)
            .axpy(-value, &vectors.column(k), 1.0);
    }
    Ritz {
        wanted,
        values,
        vectors,
        residuals,
    }
}

/// `start` with columns cut or added to make `columns` of them.
pub(super) fn padded(start: &DMatrix<f64>, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(start.nrows(), columns, |row, column| {
        if column < start.ncols() {
            start[(row, column)]
        } else {
            scattered(row, column)
        }
    })
}

/// A fixed number in (−1, 1) that looks random (Weyl sequence, golden ratio and √2).
fn scattered(row: usize, column: usize) -> f64 {
    let phase =
        (row + 1) as f64 * 0.618_033_988_749_895 + (column + 1) as f64 * std::f64::consts::SQRT_2;
    2.0 * (phase * phase).fract() - 1.0
}

/// Gram–Schmidt, twice. A column that depends on the others, or overflowed, is replaced by a
/// scattered one.
fn orthonormalize(basis: &mut DMatrix<f64>) {
    for column in 0..basis.ncols() {
        let original = basis.column(column).norm();
        project_out_previous(basis, column);
        let is_independent = basis.column(column).norm() > 1e-14 * original;
        if !(is_independent && original.is_finite()) {
            let fresh = DVector::from_fn(basis.nrows(), |row, _| scattered(row, column + 7));
            basis.set_column(column, &fresh);
            project_out_previous(basis, column);
        }
        basis.column_mut(column).normalize_mut();
        project_out_previous(basis, column);
        basis.column_mut(column).normalize_mut();
    }
}

fn project_out_previous(basis: &mut DMatrix<f64>, column: usize) {
    for previous in 0..column {
        let (before, mut after) = basis.columns_range_pair_mut(..column, column..);
        let previous = before.column(previous);
        let overlap = previous.dot(&after.column(0));
        after.column_mut(0).axpy(-overlap, &previous, 1.0);
    }
}
