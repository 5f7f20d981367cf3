//! Whether the overlap grows with the confidence.

use std::ops::Range;

use crate::error::{Error, check_length, check_numbers};
use crate::pooling::mean;
use crate::spread::Spread;

/// Groups that the pairs of a scene are divided into.
const NUM_DECILES: usize = 10;

/// Standard deviations of the normal distribution around the mean that hold 95 % of it.
const NORMAL_95: f64 = 1.96;

/// Mean overlaps of one scene's pairs, grouped by confidence; see [`overlap_deciles`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OverlapDeciles {
    /// Mean overlap of each tenth of the pairs, from the least to the most confident; `None` for
    /// a group without pairs.
    pub deciles: [Option<f64>; NUM_DECILES],
    /// Mean overlap of all pairs; `None` where there are none.
    pub all_pairs: Option<f64>,
}

/// Mean overlap of one scene's pairs in ten groups of ascending confidence.
///
/// Of n pairs, sorted by confidence, group g = 0, …, 9 holds the places ⌊g n / 10⌋ up to, not
/// including, ⌊(g + 1) n / 10⌋: the sizes differ by at most one, and with fewer than ten pairs
/// some groups are empty. Pairs of equal confidence stay in the order given. If the confidence
/// predicts the overlap, the means ascend (paper, figure "Spectral evidence for the two selection
/// stages", panel b). `confidence` and `overlap` hold one value per pair. `O(n log n)`.
///
/// # Errors
/// [`Error::LengthMismatch`] unless there is one overlap per confidence, [`Error::NotANumber`]
/// for a value in either list that is not a number.
///
/// ```
/// use gmpcr_eval::overlap_deciles;
///
/// let overlap: Vec<f64> = (0..20).map(f64::from).collect();
/// let confidence: Vec<f64> = overlap.iter().map(|overlap| overlap.sqrt()).collect();
/// let found = overlap_deciles(&confidence, &overlap)?;
/// assert_eq!((found.deciles[0], found.deciles[9]), (Some(0.5), Some(18.5)));
/// assert_eq!(found.all_pairs, Some(9.5));
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn overlap_deciles(confidence: &[f64], overlap: &[f64]) -> Result<OverlapDeciles, Error> {
    check_length("overlaps", confidence.len(), overlap.len())?;
    check_numbers("confidences", confidence)?;
    check_numbers("overlaps", overlap)?;
    let mut order: Vec<usize> = (0..confidence.len()).collect();
    // Adding 0 makes −0 the zero that it equals.
    order.sort_by(|&a, &b| (confidence[a] + 0.0).total_cmp(&(confidence[b] + 0.0)));
    let mean_of = |places: Range<usize>| mean(order[places].iter().map(|&pair| overlap[pair]));
    Ok(OverlapDeciles {
        deciles: std::array::from_fn(|group| mean_of(decile(group, order.len()))),
        all_pairs: mean(overlap.iter().copied()),
    })
}

/// Places of a group among `num_pairs` sorted ones.
fn decile(group: usize, num_pairs: usize) -> Range<usize> {
    group * num_pairs / NUM_DECILES..(group + 1) * num_pairs / NUM_DECILES
}

/// A mean over scenes, each scene weighing the same, and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SceneMean {
    /// Mean of the scenes' values.
    pub mean: f64,
    /// Half the width of the 95 % confidence interval around the mean, `1.96 · s / √S` with the
    /// sample standard deviation s over the S scenes; `None` for a single scene.
    pub half_width: Option<f64>,
}

impl SceneMean {
    fn of(values: &[f64]) -> Option<Self> {
        let spread = Spread::of(values)?;
        let half_width = NORMAL_95 * spread.std_dev / (spread.count as f64).sqrt();
        Some(Self {
            mean: spread.mean,
            half_width: (spread.count > 1).then_some(half_width),
        })
    }
}

/// Overlap by confidence over many scenes: the curve, the band and the dashed line of the
/// paper's figure "Spectral evidence for the two selection stages", panel b.
///
/// ```
/// use gmpcr_eval::{DecileSummary, OverlapDeciles};
///
/// let scene = |last| OverlapDeciles { deciles: [Some(last); 10], all_pairs: Some(0.25) };
/// let summary = DecileSummary::of(&[scene(0.25), scene(0.75)]);
/// let top = summary.and_then(|summary| summary.deciles[9]);
/// assert!(top.is_some_and(|top| top.mean == 0.5));
/// // The sample deviation of two values is their distance over √2.
/// let half_width = top.and_then(|top| top.half_width);
/// assert!(half_width.is_some_and(|half| (half - 1.96 * 0.25).abs() < 1e-12));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DecileSummary {
    /// Mean overlap of each decile over the scenes that have pairs in it, from the least to the
    /// most confident; `None` where no scene has.
    pub deciles: [Option<SceneMean>; NUM_DECILES],
    /// Mean overlap of all candidate pairs: the mean of the scenes' means.
    pub all_pairs: f64,
}

impl DecileSummary {
    /// Summary of the scenes; those without pairs are left out, and it is `None` where that leaves
    /// none. `O(scenes)`.
    #[must_use]
    pub fn of(scenes: &[OverlapDeciles]) -> Option<Self> {
        let of_decile = |group: usize| {
            let means = scenes.iter().filter_map(|scene| scene.deciles[group]);
            SceneMean::of(&means.collect::<Vec<_>>())
        };
        Some(Self {
            deciles: std::array::from_fn(of_decile),
            all_pairs: mean(scenes.iter().filter_map(|scene| scene.all_pairs))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn lists_of_different_length_and_values_that_are_no_numbers_are_refused() {
        let short = overlap_deciles(&[1.0, 2.0], &[0.5]).unwrap_err();
        assert!(matches!(
            short,
            Error::LengthMismatch {
                what: "overlaps",
                ..
            }
        ));
        for (confidence, overlap, what) in
            [(f64::NAN, 0.5, "confidences"), (0.5, f64::NAN, "overlaps")]
        {
            let error = overlap_deciles(&[confidence], &[overlap]).unwrap_err();
            assert_eq!(error, Error::NotANumber { what, index: 0 });
        }
    }

    #[test]
    fn the_groups_are_consecutive_of_nearly_equal_size_and_hold_all_pairs() {
        for num_pairs in 0..64 {
            let groups: Vec<_> = (0..NUM_DECILES)
                .map(|group| decile(group, num_pairs))
                .collect();
            assert!(groups.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert_eq!((groups[0].start, groups[9].end), (0, num_pairs));
            assert!(
                groups
                    .iter()
                    .all(|group| group.len().abs_diff(num_pairs / 10) <= 1)
            );
        }
    }

    #[test]
    fn few_pairs_leave_groups_empty() {
        // ⌊3 g / 10⌋ steps after the groups 3, 6 and 9.
        let found = overlap_deciles(&[3.0, 1.0, 2.0], &[0.9, 0.1, 0.3]).unwrap();
        let mut expected = [None; 10];
        (expected[3], expected[6], expected[9]) = (Some(0.1), Some(0.3), Some(0.9));
        assert_eq!(found.deciles, expected);
        let none = overlap_deciles(&[], &[]).unwrap();
        assert_eq!((none.deciles, none.all_pairs), ([None; 10], None));
    }

    #[test]
    fn pairs_of_equal_confidence_stay_in_order() {
        let confidence = [0.0, -0.0, 0.0, -0.0, 0.0, 0.0, -0.0, 0.0, 0.0, 0.0];
        let overlap: Vec<f64> = (0..10).map(f64::from).collect();
        let found = overlap_deciles(&confidence, &overlap).unwrap();
        assert_eq!(
            found.deciles.to_vec(),
            overlap.into_iter().map(Some).collect::<Vec<_>>()
        );
    }

    #[test]
    fn scenes_without_pairs_in_a_decile_do_not_count_there() {
        let mut few = overlap_deciles(&[], &[]).unwrap();
        let none = few;
        (few.deciles[9], few.all_pairs) = (Some(0.4), Some(0.4));
        let full = |overlap| OverlapDeciles {
            deciles: [Some(overlap); 10],
            all_pairs: Some(overlap),
        };
        let summary = DecileSummary::of(&[few, full(0.1), none, full(0.1)]).unwrap();
        assert_relative_eq!(summary.all_pairs, 0.2, epsilon = 1e-15);
        let top = summary.deciles[9].unwrap();
        assert_relative_eq!(top.mean, 0.2, epsilon = 1e-15);
        // Three scenes: s = √((0.2² + 0.1² + 0.1²) / 2) = √0.03, and s / √3 = 0.1.
        assert_relative_eq!(top.half_width.unwrap(), 0.196, epsilon = 1e-15);
        assert_relative_eq!(summary.deciles[0].unwrap().mean, 0.1, epsilon = 1e-15);
        assert_eq!(DecileSummary::of(&[none]), None);
    }

    #[test]
    fn one_scene_has_a_mean_without_an_interval() {
        let one = overlap_deciles(&[1.0], &[0.5]).unwrap();
        let summary = DecileSummary::of(&[one]).unwrap();
        let expected = SceneMean {
            mean: 0.5,
            half_width: None,
        };
        assert_eq!(summary.deciles[9], Some(expected));
        assert_eq!(summary.deciles[0], None);
        assert_eq!(summary.all_pairs, 0.5);
    }
}
