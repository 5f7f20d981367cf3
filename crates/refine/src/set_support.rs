use nalgebra::Isometry3;

use crate::posed::{check_poses, spheres_meet};
use crate::verify::count_pair;
use crate::{Error, PairCounts, PairMap, PosedSurface, VerifyParams, check};

/// Overlap above which a pair counts as overlapping.
const MIN_OVERLAP: usize = 60;

/// What a scan of one set and a scan of the other say of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct CrossPair {
    /// Position in set A.
    pub i: usize,
    /// Position in set B.
    pub j: usize,
    /// The support of their relative pose.
    pub counts: PairCounts,
}

/// What two sets of scans say of the transformation between their frames.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct SetSupport {
    /// Sum over all pairs.
    pub total: PairCounts,
    /// Pairs of one scan of A and one of B whose bounding spheres meet, by A, then by B.
    pub pairs: Vec<CrossPair>,
}

impl SetSupport {
    /// Pairs with an overlap above 60.
    pub fn num_overlapping(&self) -> usize {
        let overlapping = |pair: &&CrossPair| pair.counts.overlap() > MIN_OVERLAP;
        self.pairs.iter().filter(overlapping).count()
    }

    /// Pairs that free space [contradicts](PairCounts::is_contradicted).
    pub fn num_contradicted(&self) -> usize {
        let contradicted = |pair: &&CrossPair| pair.counts.is_contradicted();
        self.pairs.iter().filter(contradicted).count()
    }
}

/// Counts what speaks for a transformation between two rigid sets of scans, and what against it:
/// [`verify_pair`](crate::verify_pair) over all pairs of one scan of each whose bounding spheres meet.
///
/// `a` and `b` have the poses of their scans in the frame of the set. Time is that of the pairs, plus
/// `|a| · |b|` tests of spheres.
///
/// # Errors
/// [`Error::Parameter`] if a parameter is out of range, [`Error::Coordinate`] if a pose is not of finite
/// numbers.
///
/// ```
/// use gmpcr_refine::{PosedSurface, Sequential, Surface, SurfaceParams, VerifyParams, verify_sets};
/// use nalgebra::{Isometry3, Point3, Vector3};
///
/// let sheet: Vec<_> = (0..400).map(|k| Point3::new(f64::from(k % 20), f64::from(k / 20), 9.0)).collect();
/// let surface = Surface::new(&sheet, &vec![-Vector3::z(); 400], &SurfaceParams::from_voxel_size(1.0))?;
/// let a = [PosedSurface::new(&surface, Isometry3::identity())];
/// let b = [0.0, 100.0].map(|x| PosedSurface::new(&surface, Isometry3::translation(x, 0.0, 0.0)));
/// let params = VerifyParams::default();
/// let support = verify_sets(&a, &b, &Isometry3::identity(), &params, &Sequential)?;
/// assert_eq!((support.pairs.len(), support.total.overlap()), (1, 800));
/// # Ok::<(), gmpcr_refine::Error>(())
/// ```
pub fn verify_sets(
    a: &[PosedSurface],
    b: &[PosedSurface],
    a_from_b: &Isometry3<f64>,
    params: &VerifyParams,
    map: &impl PairMap,
) -> Result<SetSupport, Error> {
    params.validate()?;
    check_sets(a, b, a_from_b)?;
    let pairs = cross_pairs(a, b, a_from_b, params, map);
    Ok(SetSupport {
        total: pairs.iter().map(|pair| pair.counts).sum(),
        pairs,
    })
}

pub(crate) fn check_sets(
    a: &[PosedSurface],
    b: &[PosedSurface],
    a_from_b: &Isometry3<f64>,
) -> Result<(), Error> {
    check_poses(a)?;
    check_poses(b)?;
    check::transformations([a_from_b])
}

/// The counts of all pairs whose bounding spheres meet.
pub(crate) fn cross_pairs(
    a: &[PosedSurface],
    b: &[PosedSurface],
    a_from_b: &Isometry3<f64>,
    params: &VerifyParams,
    map: &impl PairMap,
) -> Vec<CrossPair> {
    let relative = |i: usize, j: usize| relative_pose(&a[i], &b[j], a_from_b);
    let all = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j)));
    let near: Vec<_> = all
        .filter(|&(i, j)| spheres_meet(a[i].surface, b[j].surface, &relative(i, j)))
        .collect();
    map.map(near.len(), |k| {
        let (i, j) = near[k];
        let counts = count_pair(a[i].surface, b[j].surface, &relative(i, j), params);
        CrossPair { i, j, counts }
    })
}

/// `i_from_j` of a scan of A and one of B.
pub(crate) fn relative_pose(
    scan_i: &PosedSurface,
    scan_j: &PosedSurface,
    a_from_b: &Isometry3<f64>,
) -> Isometry3<f64> {
    scan_i.frame_from_scan.inverse() * a_from_b * scan_j.frame_from_scan
}
