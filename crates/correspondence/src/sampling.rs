use std::cmp::Reverse;
use std::collections::BinaryHeap;

use gmpcr_geometry::InvalidParameter;
use nalgebra::Point3;

use crate::descriptors::squared_distance;
use crate::{CorrespondenceParams, Descriptors, Scan};

/// The representative points of a scan: what pairs of scans are matched by.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Unchecked")
)]
pub struct Keypoints {
    rows: Vec<usize>,
    points: Vec<Point3<f64>>,
    descriptors: Descriptors,
}

/// Keypoints as a file has them.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Keypoints", deny_unknown_fields)]
struct Unchecked {
    rows: Vec<usize>,
    points: Vec<Point3<f64>>,
    descriptors: Descriptors,
}

#[cfg(feature = "serde")]
impl TryFrom<Unchecked> for Keypoints {
    type Error = String;

    fn try_from(keypoints: Unchecked) -> Result<Self, String> {
        let Unchecked {
            rows,
            points,
            descriptors,
        } = keypoints;
        // The coordinates and the number of descriptors are checked as those of a scan.
        let scan = Scan::new(points, descriptors).map_err(|error| error.to_string())?;
        if rows.len() != scan.len() {
            return Err(format!("{} rows, but {} points", rows.len(), scan.len()));
        }
        let (points, descriptors) = scan.into_parts();
        Ok(Self {
            rows,
            points,
            descriptors,
        })
    }
}

impl Keypoints {
    /// Samples `N_s = num_samples` points of `scan` by [`farthest_point_sampling`] of its descriptors;
    /// all of them where the scan has fewer.
    ///
    /// # Errors
    /// [`InvalidParameter`] if a parameter is out of range.
    ///
    /// ```
    /// use gmpcr_correspondence::{CorrespondenceParams, Descriptors, Keypoints, Scan};
    /// use nalgebra::Point3;
    ///
    /// let points = (0..4).map(|k| Point3::new(k as f64, 0.0, 0.0)).collect();
    /// let scan = Scan::new(points, Descriptors::new(vec![0.0, 0.1, 0.2, 5.0], 1)?)?;
    /// let params = CorrespondenceParams { num_samples: 3, ..CorrespondenceParams::default() };
    /// let keypoints = Keypoints::sample(&scan, &params)?;
    /// assert_eq!(keypoints.rows(), &[3, 0, 2]); // the rare descriptor first
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sample(scan: &Scan, params: &CorrespondenceParams) -> Result<Self, InvalidParameter> {
        params.validate()?;
        let rows = farthest_point_sampling(scan.descriptors(), params.num_samples);
        Ok(Self {
            points: rows.iter().map(|&k| scan.points()[k]).collect(),
            descriptors: scan.descriptors().select(&rows),
            rows,
        })
    }

    /// Number of keypoints.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Which points of the scan these are, in sampling order.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Their coordinates, in the scan's frame.
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// Their descriptors.
    pub fn descriptors(&self) -> &Descriptors {
        &self.descriptors
    }
}

/// Farthest-point sampling in descriptor space (paper, "Initial Correspondence Construction").
///
/// The first sample is the descriptor farthest from the mean; each further one maximizes its
/// squared L2 distance to the nearest sample so far. Ties go to the lowest index. Because the start
/// is a property of the set, the sampled set does not depend on the order of the points. All
/// indices come back, each once, where `num_samples` is the number of descriptors or more.
///
/// A descriptor's distance to the samples can only shrink, so an outdated distance bounds the current
/// one from above. Only the descriptor of largest bound is brought up to date, and chosen once its
/// bound is exact: the plain algorithm's samples for a fraction of its `n · num_samples` distances,
/// which remain the worst case.
///
/// ```
/// use gmpcr_correspondence::{Descriptors, farthest_point_sampling};
///
/// let descriptors = Descriptors::new(vec![1.0, 0.0, 9.0, 4.0], 1)?;
/// assert_eq!(farthest_point_sampling(&descriptors, 3), [2, 1, 3]);
/// # Ok::<(), gmpcr_correspondence::DescriptorsError>(())
/// ```
pub fn farthest_point_sampling(descriptors: &Descriptors, num_samples: usize) -> Vec<usize> {
    match farthest_from_mean(descriptors) {
        Some(first) => farthest_point_sampling_from(descriptors, first, num_samples),
        None => Vec::new(),
    }
}

/// [`farthest_point_sampling`] with another first sample, such as a random one: how much results
/// owe to the luck of the start shows where it varies.
///
/// # Panics
/// If `first` is not the index of a descriptor.
///
/// ```
/// use gmpcr_correspondence::{Descriptors, farthest_point_sampling_from};
///
/// let descriptors = Descriptors::new(vec![1.0, 0.0, 9.0, 4.0], 1)?;
/// assert_eq!(farthest_point_sampling_from(&descriptors, 3, 3), [3, 2, 1]);
/// # Ok::<(), gmpcr_correspondence::DescriptorsError>(())
/// ```
pub fn farthest_point_sampling_from(
    descriptors: &Descriptors,
    first: usize,
    num_samples: usize,
) -> Vec<usize> {
    assert!(
        first < descriptors.len(),
        "descriptor {first} is outside 0..{}",
        descriptors.len()
    );
    let mut samples = Vec::with_capacity(num_samples.min(descriptors.len()));
    let mut candidates: BinaryHeap<Candidate> = (0..descriptors.len())
        .filter(|&index| index != first)
        .map(unseen)
        .collect();
    samples.extend((num_samples > 0).then_some(first));
    while samples.len() < num_samples
        && let Some(mut candidate) = candidates.pop()
    {
        let runner_up = candidates.peek().copied();
        candidate.update(descriptors, &samples, runner_up);
        if candidate.num_seen == samples.len() && runner_up.is_none_or(|other| candidate > other) {
            samples.push(candidate.index.0);
        } else {
            candidates.push(candidate);
        }
    }
    samples
}

/// A descriptor that is not sampled yet. Ordered by its bound, then the lower index first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Bits of the squared distance to the nearest of the first `num_seen` samples: an upper bound
    /// of the distance to all. The bits of nonnegative numbers are ordered as the numbers are.
    bound: u64,
    index: Reverse<usize>,
    num_seen: usize,
}

fn unseen(index: usize) -> Candidate {
    Candidate {
        bound: f64::INFINITY.to_bits(),
        index: Reverse(index),
        num_seen: 0,
    }
}

impl Candidate {
    /// Takes further samples into account until all are, or the candidate falls behind another.
    fn update(&mut self, descriptors: &Descriptors, samples: &[usize], other: Option<Candidate>) {
        let row = descriptors.row(self.index.0);
        while self.num_seen < samples.len() && other.is_none_or(|other| *self > other) {
            let distance = squared_distance(row, descriptors.row(samples[self.num_seen]));
            self.bound = self.bound.min(distance.to_bits());
            self.num_seen += 1;
        }
    }
}

fn farthest_from_mean(descriptors: &Descriptors) -> Option<usize> {
    let mut mean = vec![0.0; descriptors.dimension()];
    for row in descriptors.rows() {
        for (sum, &value) in mean.iter_mut().zip(row) {
            *sum += f64::from(value);
        }
    }
    for sum in &mut mean {
        *sum /= descriptors.len() as f64;
    }
    let distance_to_mean = |row: &[f32]| -> f64 {
        let entries = row.iter().zip(&mean);
        entries
            .map(|(&value, m)| (f64::from(value) - m).powi(2))
            .sum()
    };
    let distances = descriptors.rows().map(distance_to_mean).enumerate();
    distances
        .max_by(|(i, a), (j, b)| a.total_cmp(b).then(j.cmp(i)))
        .map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The algorithm as it is defined, with all distances.
    fn plain_farthest_point_sampling(
        descriptors: &Descriptors,
        first: Option<usize>,
        num_samples: usize,
    ) -> Vec<usize> {
        let n = descriptors.len();
        let mut distance = vec![f64::INFINITY; n];
        let mut samples = Vec::new();
        let mut next = first;
        while let Some(sample) = next.filter(|_| samples.len() < num_samples) {
            samples.push(sample);
            for (k, d) in distance.iter_mut().enumerate() {
                *d = d.min(squared_distance(
                    descriptors.row(k),
                    descriptors.row(sample),
                ));
            }
            next = (0..n)
                .filter(|k| !samples.contains(k))
                .max_by(|&i, &j| distance[i].total_cmp(&distance[j]).then(j.cmp(&i)));
        }
        samples
    }

    fn descriptors() -> impl Strategy<Value = Descriptors> {
        // Few distinct values make many ties.
        let entry = prop_oneof![(-2..3i32).prop_map(|k| k as f32), -1.0..1.0f32];
        (1..5usize).prop_flat_map(move |dimension| {
            prop::collection::vec(prop::collection::vec(entry.clone(), dimension), 1..40).prop_map(
                move |rows| {
                    Descriptors::new(rows.into_iter().flatten().collect(), dimension).unwrap()
                },
            )
        })
    }

    proptest! {
        #[test]
        fn the_lazy_sampling_is_the_plain_one(d in descriptors(), num_samples in 0..45usize) {
            let samples = farthest_point_sampling(&d, num_samples);
            let plain = plain_farthest_point_sampling(&d, farthest_from_mean(&d), num_samples);
            prop_assert_eq!(samples, plain);
            for first in 0..d.len() {
                let samples = farthest_point_sampling_from(&d, first, num_samples);
                prop_assert_eq!(samples, plain_farthest_point_sampling(&d, Some(first), num_samples));
            }
        }

        #[test]
        fn every_sample_comes_once(d in descriptors(), num_samples in 0..45usize) {
            let mut samples = farthest_point_sampling(&d, num_samples);
            prop_assert_eq!(samples.len(), num_samples.min(d.len()));
            samples.sort_unstable();
            samples.dedup();
            prop_assert_eq!(samples.len(), num_samples.min(d.len()));
        }
    }

    #[test]
    fn the_sampled_set_does_not_depend_on_the_order_of_the_points() {
        let n = 50;
        let values: Vec<f32> = (0..n * 3).map(|k| ((k * k) as f32 * 0.37).sin()).collect();
        let forward = Descriptors::new(values, 3).unwrap();
        let order: Vec<usize> = (0..n).rev().collect();
        let backward = forward.select(&order);
        let samples = farthest_point_sampling(&forward, 20);
        let reversed = farthest_point_sampling(&backward, 20);
        assert_eq!(
            samples,
            reversed.iter().map(|&k| order[k]).collect::<Vec<_>>()
        );
    }

    #[test]
    fn equal_descriptors_are_sampled_in_index_order() {
        let d = Descriptors::new(vec![0.25; 5 * 33], 33).unwrap();
        assert_eq!(farthest_point_sampling(&d, 3), [0, 1, 2]);
        assert_eq!(farthest_point_sampling(&d, 9), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn an_empty_set_has_no_samples() {
        let d = Descriptors::new(vec![], 33).unwrap();
        assert!(farthest_point_sampling(&d, 200).is_empty());
    }
}
