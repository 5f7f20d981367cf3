/// Local descriptors, one row of `dimension` numbers per point, stored row by row in `f32`.
///
/// ```
/// use gmpcr_correspondence::Descriptors;
///
/// let descriptors = Descriptors::new(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 2)?;
/// assert_eq!(descriptors.len(), 3);
/// assert_eq!(descriptors.row(1), &[2.0, 3.0]);
/// # Ok::<(), gmpcr_correspondence::DescriptorsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct Descriptors {
    values: Vec<f32>,
    dimension: usize,
    /// Squared norm of each row.
    #[cfg_attr(feature = "serde", serde(skip_serializing))]
    squared_norms: Vec<f32>,
}

/// Descriptors as a file has them.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Descriptors", deny_unknown_fields)]
struct Unchecked {
    values: Vec<f32>,
    dimension: usize,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Descriptors {
    type Error = DescriptorsError;

    fn try_from(descriptors: Unchecked) -> Result<Self, DescriptorsError> {
        Self::new(descriptors.values, descriptors.dimension)
    }
}

/// Why a list of numbers is no set of descriptors.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptorsError {
    /// The dimension is zero.
    #[error("descriptors of dimension 0: at least 1 is needed")]
    ZeroDimension,
    /// The numbers do not fill whole rows.
    #[error("{values} numbers do not fill rows of {dimension}")]
    Ragged {
        /// How many numbers were given.
        values: usize,
        /// Length of a row.
        dimension: usize,
    },
    /// A number is NaN or infinite.
    #[error("descriptor {row} has an entry that is not finite")]
    NotFinite {
        /// The first such row.
        row: usize,
    },
}

impl Descriptors {
    /// Descriptors from their rows, one after the other in `values`.
    ///
    /// # Errors
    /// [`DescriptorsError`] if `dimension` is 0, does not divide the number of values, or a value
    /// is not finite.
    pub fn new(values: Vec<f32>, dimension: usize) -> Result<Self, DescriptorsError> {
        if dimension == 0 {
            return Err(DescriptorsError::ZeroDimension);
        }
        if !values.len().is_multiple_of(dimension) {
            return Err(DescriptorsError::Ragged {
                values: values.len(),
                dimension,
            });
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(k) => Err(DescriptorsError::NotFinite { row: k / dimension }),
            None => Ok(Self::of_finite(values, dimension)),
        }
    }

    fn of_finite(values: Vec<f32>, dimension: usize) -> Self {
        let origin = vec![0.0; dimension];
        let rows = values.chunks_exact(dimension);
        Self {
            squared_norms: rows
                .map(|row| squared_distance(row, &origin) as f32)
                .collect(),
            values,
            dimension,
        }
    }

    /// Number of descriptors.
    pub fn len(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// Whether there is no descriptor.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Numbers per descriptor.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// All numbers, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The descriptor of point `index`.
    ///
    /// # Panics
    /// If `index` is [`len`](Self::len) or more.
    pub fn row(&self, index: usize) -> &[f32] {
        &self.values[index * self.dimension..(index + 1) * self.dimension]
    }

    /// The descriptors in order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.values.chunks_exact(self.dimension)
    }

    /// Squared norms of the descriptors, rounded from `f64`.
    pub(crate) fn squared_norms(&self) -> &[f32] {
        &self.squared_norms
    }

    /// The descriptors at `indices`, in that order.
    ///
    /// # Panics
    /// If an index is [`len`](Self::len) or more.
    pub fn select(&self, indices: &[usize]) -> Self {
        let rows = indices.iter().flat_map(|&k| self.row(k));
        let norms = indices.iter().map(|&k| self.squared_norms[k]);
        Self {
            values: rows.copied().collect(),
            dimension: self.dimension,
            squared_norms: norms.collect(),
        }
    }
}

/// Independent partial sums: the compiler turns them into vector registers, and the order of
/// summation, and so every bit of the result, stays fixed.
const LANES: usize = 8;

/// Squared Euclidean distance of two rows of equal length, in `f64`.
#[inline(always)]
pub(crate) fn squared_distance(a: &[f32], b: &[f32]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a_blocks, b_blocks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a_blocks.remainder().iter().zip(b_blocks.remainder());
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..LANES {
            let difference = f64::from(x[lane]) - f64::from(y[lane]);
            sums[lane] += difference * difference;
        }
    }
    for (lane, (&x, &y)) in rest.enumerate() {
        let difference = f64::from(x) - f64::from(y);
        sums[lane] += difference * difference;
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_what_makes_numbers_no_descriptors() {
        use DescriptorsError::*;
        assert_eq!(Descriptors::new(vec![], 0), Err(ZeroDimension));
        let ragged = Ragged {
            values: 5,
            dimension: 2,
        };
        assert_eq!(Descriptors::new(vec![1.0; 5], 2), Err(ragged));
        let nan = vec![0.0, 0.0, 0.0, f32::NAN];
        assert_eq!(Descriptors::new(nan, 2), Err(NotFinite { row: 1 }));
    }

    #[test]
    fn the_blocked_distance_is_the_plain_sum_for_every_length() {
        for dimension in 1..40 {
            let a: Vec<f32> = (0..dimension).map(|k| (k as f32).sin()).collect();
            let b: Vec<f32> = (0..dimension).map(|k| (k as f32 * 0.7).cos()).collect();
            let plain: f64 = a
                .iter()
                .zip(&b)
                .map(|(x, y)| f64::from(x - y).powi(2))
                .sum();
            assert!((squared_distance(&a, &b) - plain).abs() < 1e-5);
        }
    }

    #[test]
    fn selects_rows_in_the_order_asked_for() {
        let d = Descriptors::new((0..6).map(|k| k as f32).collect(), 2).unwrap();
        assert_eq!(d.select(&[2, 0]).values(), &[4.0, 5.0, 0.0, 1.0]);
    }
}
