use gmpcr_geometry::{InvalidParameter, PointPairs};

use crate::{CompatibilityGraph, CompatibilityParams, DominantEigenpair};

/// Correspondences that survive spectral filtering, with the graph rebuilt on them.
///
/// ```
/// use gmpcr_compatibility::{CompatibilityParams, SpectralFilter};
/// use gmpcr_geometry::PointPairs;
/// use nalgebra::{Point3, Vector3};
///
/// let target: Vec<_> = (0..6).map(|k| Point3::new(k as f64, (k * k) as f64, 1.0)).collect();
/// let mut source: Vec<_> = target.iter().map(|p| p + Vector3::new(5.0, 5.0, 5.0)).collect();
/// source[1].x += 0.7; // an outlier
/// let pairs = PointPairs::new(target, source)?;
/// let filter = SpectralFilter::new(&pairs, &CompatibilityParams::default())?;
/// assert_eq!(filter.retained, [0, 2, 3]); // half of six; equal responses: lower index
/// assert!((filter.raw_confidence() - 2.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SpectralFilter {
    /// Indices `S_ij` of the retained correspondences, ascending.
    pub retained: Vec<usize>,
    /// Refined graphs `Ã` and `B̃` on the retained correspondences.
    pub graph: CompatibilityGraph,
    /// Dominant eigenpair of `B̃`.
    pub dominant: DominantEigenpair,
}

impl SpectralFilter {
    /// Filters the correspondences of one scan pair: the two-pass construction of the paper.
    ///
    /// Retains the `⌈r_s M⌉` largest entries of the dominant eigenvector of the SCG (ties: lower
    /// index) and recomputes graph and eigenvector on them. `O(M³)` multiply-adds.
    ///
    /// Fewer than three correspondences have no second-order support and so no confidence.
    ///
    /// # Errors
    /// [`InvalidParameter`] if a parameter is out of range.
    pub fn new(pairs: &PointPairs, params: &CompatibilityParams) -> Result<Self, InvalidParameter> {
        params.validate()?;
        let initial = CompatibilityGraph::new(pairs, params.tolerance);
        let count = retained_count(initial.len(), params.retained_fraction);
        if count == initial.len() {
            return Ok(Self::of((0..count).collect(), initial));
        }
        let response = DominantEigenpair::new(initial.scg()).vector;
        let retained = largest(response.as_slice(), count);
        let graph = initial.restricted_to(&retained);
        Ok(Self::of(retained, graph))
    }

    fn of(retained: Vec<usize>, graph: CompatibilityGraph) -> Self {
        Self {
            dominant: DominantEigenpair::new(graph.scg()),
            retained,
            graph,
        }
    }

    /// Raw geometric confidence of the scan pair: the Rayleigh quotient `ŝ = ṽᵀ B̃ ṽ ≥ 0`.
    pub fn raw_confidence(&self) -> f64 {
        self.dominant.value
    }
}

/// `⌈r_s M⌉`, where a product such as `0.55 · 100` may exceed its exact value by rounding.
fn retained_count(size: usize, fraction: f64) -> usize {
    ((fraction * size as f64 - 1e-9).ceil() as usize)
        .max(1)
        .min(size)
}

/// Indices of the `count` largest values, ascending; equal values: lower index.
fn largest(values: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&m, &n| values[n].total_cmp(&values[m]).then(m.cmp(&n)));
    order.truncate(count);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Vector3};

    use super::*;

    fn filtered(pairs: &PointPairs, params: &CompatibilityParams) -> SpectralFilter {
        SpectralFilter::new(pairs, params).unwrap()
    }

    fn contaminated(num_inliers: usize, num_outliers: usize) -> PointPairs {
        let wave = |k: usize, f: f64| (k as f64 * f).sin() * 2.0;
        let count = num_inliers + num_outliers;
        let source: Vec<_> = (0..count)
            .map(|k| Point3::new(wave(k, 1.3), wave(k, 2.9), wave(k, 4.7)))
            .collect();
        let transformation =
            Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -1.0, 0.5));
        let target = (0..count)
            .map(|k| {
                if k < num_inliers {
                    transformation * source[k]
                } else {
                    source[(k * 7 + 3) % count]
                }
            })
            .collect();
        PointPairs::new(target, source).unwrap()
    }

    #[test]
    fn the_inliers_survive() {
        let filter = filtered(&contaminated(20, 20), &CompatibilityParams::default());
        assert_eq!(filter.retained, (0..20).collect::<Vec<_>>());
        // A perfect clique of 20: B̃ = 18 (1 1ᵀ − I), whose largest eigenvalue is 18 · 19.
        assert!((filter.raw_confidence() - 342.0).abs() < 1e-6);
    }

    #[test]
    fn the_confidence_is_the_same_with_the_scans_swapped() {
        let (pairs, params) = (contaminated(15, 25), CompatibilityParams::default());
        let forward = filtered(&pairs, &params);
        let backward = filtered(&pairs.swapped(), &params);
        assert_eq!(forward, backward);
    }

    #[test]
    fn permuted_correspondences_give_the_permuted_result() {
        let (pairs, params) = (contaminated(20, 20), CompatibilityParams::default());
        let order: Vec<usize> = (0..40).map(|k| (k * 13) % 40).collect();
        let filter = filtered(&pairs, &params);
        let permuted = filtered(&pairs.select(&order), &params);
        let mut retained: Vec<_> = permuted.retained.iter().map(|&k| order[k]).collect();
        retained.sort_unstable();
        assert_eq!(retained, filter.retained);
        assert!((permuted.raw_confidence() / filter.raw_confidence() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_fraction_of_one_filters_nothing() {
        let params = CompatibilityParams {
            retained_fraction: 1.0,
            ..Default::default()
        };
        let filter = filtered(&contaminated(5, 4), &params);
        assert_eq!(filter.retained, (0..9).collect::<Vec<_>>());
    }

    #[test]
    fn too_few_correspondences_have_no_confidence() {
        for count in 0..3 {
            let filter = filtered(&contaminated(count, 0), &CompatibilityParams::default());
            assert_eq!(filter.raw_confidence(), 0.0, "{count} correspondences");
        }
    }

    #[test]
    fn equal_points_are_compatible_and_finite() {
        let equal =
            PointPairs::new(vec![Point3::origin(); 10], vec![Point3::origin(); 10]).unwrap();
        let filter = filtered(&equal, &CompatibilityParams::default());
        assert_eq!(filter.retained, [0, 1, 2, 3, 4]);
        assert!((filter.raw_confidence() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn the_retained_count_is_the_exact_ceiling() {
        assert_eq!(retained_count(100, 0.55), 55);
        assert_eq!(retained_count(60, 0.65), 39);
        assert_eq!(retained_count(75, 0.25), 19);
        assert_eq!(retained_count(0, 0.5), 0);
        assert_eq!(retained_count(9, 1e-12), 1);
        assert_eq!(retained_count(3, 1.0), 3);
    }
}
