//! Whether a score tells inliers from outliers.

use crate::error::{Error, check_length, check_numbers};

/// Area under the ROC curve of scores that should be high for positives.
///
/// As the Mann–Whitney statistic: the probability that a random positive scores higher than a
/// random negative, where a tie counts one half,
///
/// ```text
/// AUC = 1/(P·N) · Σ_{p positive} Σ_{n negative} ([s_p > s_n] + ½ [s_p = s_n])
/// ```
///
/// 1 is perfect, 0.5 is chance. `None` without positives or without negatives. The paper judges
/// the spectral responses of correspondences so, inliers being the positives (figure "Spectral
/// evidence for the two selection stages", panel a). `O(n log n)`.
///
/// # Errors
/// [`Error::LengthMismatch`] unless there is one label per score, [`Error::NotANumber`] for a
/// score without a rank.
///
/// ```
/// use gmpcr_eval::auc;
///
/// assert_eq!(auc(&[0.9, 0.1, 0.5, 0.4], &[true, false, false, true])?, Some(0.75));
/// assert_eq!(auc(&[0.9, 0.1], &[true, true])?, None);
/// # Ok::<(), gmpcr_eval::Error>(())
/// ```
pub fn auc(scores: &[f64], is_positive: &[bool]) -> Result<Option<f64>, Error> {
    check_length("labels", scores.len(), is_positive.len())?;
    check_numbers("scores", scores)?;
    let mut samples: Vec<(f64, bool)> = scores
        .iter()
        .copied()
        .zip(is_positive.iter().copied())
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));

    let (mut positives, mut negatives, mut wins) = (0.0, 0.0, 0.0);
    for tied in samples.chunk_by(|a, b| a.0 == b.0) {
        let tied_positives = tied.iter().filter(|sample| sample.1).count() as f64;
        let tied_negatives = tied.len() as f64 - tied_positives;
        wins += tied_positives * (negatives + tied_negatives / 2.0);
        positives += tied_positives;
        negatives += tied_negatives;
    }
    let comparisons = positives * negatives;
    Ok((comparisons > 0.0).then(|| wins / comparisons))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_count_one_half_and_so_do_the_two_zeros() {
        let labels = [true, false, true, false];
        assert_eq!(auc(&[0.5; 4], &labels).unwrap(), Some(0.5));
        assert_eq!(auc(&[0.0, -0.0, -0.0, 0.0], &labels).unwrap(), Some(0.5));
        // Of four comparisons the positives win two, tie one and lose one.
        assert_eq!(auc(&[2.0, 2.0, 1.5, 1.0], &labels).unwrap(), Some(0.625));
    }

    #[test]
    fn infinite_scores_have_a_rank() {
        let scores = [f64::INFINITY, f64::NEG_INFINITY, 0.0];
        assert_eq!(auc(&scores, &[true, false, false]).unwrap(), Some(1.0));
    }

    #[test]
    fn one_kind_alone_has_no_area() {
        assert_eq!(auc(&[], &[]).unwrap(), None);
        assert_eq!(auc(&[1.0, 2.0], &[false, false]).unwrap(), None);
    }

    #[test]
    fn lists_of_different_length_and_values_that_are_no_numbers_are_refused() {
        let error = auc(&[1.0, 2.0], &[true]).unwrap_err();
        assert_eq!(error.to_string(), "2 labels are needed, but there are 1");
        let error = auc(&[1.0, f64::NAN], &[true, false]).unwrap_err();
        assert_eq!(error.to_string(), "scores[1] is not a number");
    }
}
