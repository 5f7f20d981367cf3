//! How far repeated runs lie apart.

use crate::pooling::mean;

/// Mean and spread of repeated runs, in the unit of the values.
///
/// ```
/// use gmpcr_eval::Spread;
///
/// let spread = Spread::of(&[7.0, 3.0, 5.0]);
/// assert!(spread.is_some_and(|s| (s.mean, s.std_dev, s.min, s.max, s.count) == (5.0, 2.0, 3.0, 7.0, 3)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Spread {
    /// Arithmetic mean x̄.
    pub mean: f64,
    /// Sample standard deviation `s = sqrt(Σ (x − x̄)² / (n − 1))`; 0 for a single value.
    pub std_dev: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Number of values, n.
    pub count: usize,
}

impl Spread {
    /// Spread of the values; `None` where there are none. A value that is not a number makes mean
    /// and deviation so, too; minimum and maximum are those of the others. `O(n)`.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len();
        let mean = mean(values.iter().copied())?;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Some(Self {
            mean,
            std_dev: (squares / (count - 1).max(1) as f64).sqrt(),
            min: values.iter().copied().fold(f64::NAN, f64::min),
            max: values.iter().copied().fold(f64::NAN, f64::max),
            count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn four_values_are_summarized_as_by_hand() {
        let spread = Spread::of(&[2.0, -1.0, 4.0, 3.0]).unwrap();
        assert_eq!((spread.mean, spread.count), (2.0, 4));
        assert_eq!((spread.min, spread.max), (-1.0, 4.0));
        assert_relative_eq!(spread.std_dev, (14.0_f64 / 3.0).sqrt());
    }

    #[test]
    fn one_value_has_no_deviation_and_no_values_have_no_spread() {
        let one = Spread::of(&[0.3]).unwrap();
        assert_eq!((one.mean, one.std_dev), (0.3, 0.0));
        assert_eq!((one.min, one.max, one.count), (0.3, 0.3, 1));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn a_value_that_is_not_a_number_shows_in_the_mean() {
        let spread = Spread::of(&[1.0, f64::NAN, 3.0]).unwrap();
        assert!(spread.mean.is_nan() && spread.std_dev.is_nan());
        assert_eq!((spread.min, spread.max, spread.count), (1.0, 3.0, 3));
    }
}
