//! Which scans hang together by overlap.

use nalgebra::DMatrix;

/// Labels the connected components of the graph that joins scans whose overlap is at least
/// `min_overlap`; labels count from 0 in the order of each component's first scan.
///
/// The scans hang together where every label is 0. `overlap` is a square matrix such as
/// [`overlap_matrix`](crate::overlap_matrix) returns; only entries above the diagonal are read.
///
/// ```
/// use gmpcr_sim::overlap_components;
/// use nalgebra::dmatrix;
///
/// let overlap = dmatrix![1.0, 0.0, 0.4; 0.0, 1.0, 0.1; 0.4, 0.1, 1.0];
/// assert_eq!(overlap_components(&overlap, 0.3), [0, 1, 0]);
/// assert_eq!(overlap_components(&overlap, 0.05), [0, 0, 0]);
/// ```
#[must_use]
pub fn overlap_components(overlap: &DMatrix<f64>, min_overlap: f64) -> Vec<usize> {
    let size = overlap.nrows().min(overlap.ncols());
    let joined = |a: usize, b: usize| overlap[(a.min(b), a.max(b))] >= min_overlap;
    let mut labels = vec![usize::MAX; size];
    let mut next_label = 0;
    for seed in 0..size {
        if labels[seed] != usize::MAX {
            continue;
        }
        labels[seed] = next_label;
        let mut open = vec![seed];
        while let Some(scan) = open.pop() {
            for (other, label) in labels.iter_mut().enumerate() {
                if *label == usize::MAX && joined(scan, other) {
                    *label = next_label;
                    open.push(other);
                }
            }
        }
        next_label += 1;
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_scans_have_no_components_and_a_lone_scan_has_one() {
        assert!(overlap_components(&DMatrix::zeros(0, 0), 0.3).is_empty());
        assert_eq!(overlap_components(&DMatrix::identity(1, 1), 0.3), [0]);
    }

    #[test]
    fn a_chain_hangs_together_until_a_link_breaks() {
        let mut chain = DMatrix::identity(4, 4);
        for k in 0..3 {
            chain[(k, k + 1)] = 0.5;
        }
        assert_eq!(overlap_components(&chain, 0.3), [0, 0, 0, 0]);
        chain[(1, 2)] = 0.2;
        assert_eq!(overlap_components(&chain, 0.3), [0, 0, 1, 1]);
    }
}
