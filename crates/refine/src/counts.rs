use std::iter::Sum;
use std::ops::AddAssign;

/// What the queries of one scan find at the surface of another.
///
/// Counts of query points. They add up over pairs of scans.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DirectedCounts {
    /// Queries that were looked up.
    pub queries: usize,
    /// Queries near the other surface.
    pub hits: usize,
    /// Hits whose normals agree, too: the overlap.
    pub overlap: usize,
    /// Sum of the squared distances of the overlap's queries from the tangent planes of the other surface, in
    /// the squared unit of the points.
    pub squared_plane_distances: f64,
    /// Queries that were compared with the other scan's range image: all, or 0 where that scan's
    /// viewpoint is not known.
    pub judged: usize,
    /// Judged queries in a direction in which the other sensor saw something.
    pub in_view: usize,
    /// Queries in view that are no hit and lie in front of what the other sensor saw, in space that it
    /// looked through: free-space violations.
    pub violations: usize,
    /// Queries in view that are no hit and lie behind what the other sensor saw: occluded.
    pub behind: usize,
}

impl DirectedCounts {
    /// `overlap / (overlap + violations + 10)`, in [0, 1): how far this direction speaks for the
    /// transformation. The 10 keeps a handful of queries from being convincing.
    pub fn ratio(&self) -> f64 {
        self.overlap as f64 / (self.overlap + self.violations + 10) as f64
    }
}

impl AddAssign for DirectedCounts {
    fn add_assign(&mut self, other: Self) {
        self.queries += other.queries;
        self.hits += other.hits;
        self.overlap += other.overlap;
        self.squared_plane_distances += other.squared_plane_distances;
        self.judged += other.judged;
        self.in_view += other.in_view;
        self.violations += other.violations;
        self.behind += other.behind;
    }
}

/// The support of a relative pose by two surfaces, or the sum over several pairs.
///
/// ```
/// use gmpcr_refine::PairCounts;
///
/// let mut counts = PairCounts::default();
/// counts.of_j_in_i.overlap = 200;
/// counts.of_i_in_j.overlap = 180;
/// counts.of_i_in_j.violations = 60;
/// assert_eq!((counts.overlap(), counts.violations()), (380, 60));
/// assert_eq!(counts.ratio(), 380.0 / 460.0);
/// assert_eq!(counts.smaller_side_ratio(), 180.0 / 250.0);
/// assert!(!counts.is_contradicted());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairCounts {
    /// The queries of scan j at the surface of scan i.
    pub of_j_in_i: DirectedCounts,
    /// The queries of scan i at the surface of scan j.
    pub of_i_in_j: DirectedCounts,
}

impl PairCounts {
    /// Queries of both directions that are near the other surface and agree in the normal.
    pub fn overlap(&self) -> usize {
        self.of_j_in_i.overlap + self.of_i_in_j.overlap
    }

    /// Queries of both directions that are near the other surface.
    pub fn hits(&self) -> usize {
        self.of_j_in_i.hits + self.of_i_in_j.hits
    }

    /// Free-space violations of both directions; 0 where no viewpoint is known.
    pub fn violations(&self) -> usize {
        self.of_j_in_i.violations + self.of_i_in_j.violations
    }

    /// Whether free space was compared in one direction at least. Where it was not, violations are 0 and
    /// the ratios speak of the overlap only.
    pub fn has_visibility(&self) -> bool {
        self.of_j_in_i.judged + self.of_i_in_j.judged > 0
    }

    /// `overlap / (overlap + violations + 20)` of both directions together, in [0, 1).
    pub fn ratio(&self) -> f64 {
        self.overlap() as f64 / (self.overlap() + self.violations() + 20) as f64
    }

    /// The smaller [`ratio`](DirectedCounts::ratio) of the two directions. Of all single numbers it
    /// separates inliers from outliers best.
    pub fn smaller_side_ratio(&self) -> f64 {
        self.of_j_in_i.ratio().min(self.of_i_in_j.ratio())
    }

    /// `overlap / (hits + 20)`, in [0, 1): the fraction of hits whose normals agree.
    pub fn normal_agreement(&self) -> f64 {
        self.overlap() as f64 / (self.hits() + 20) as f64
    }

    /// Whether free space speaks against the pair: `violations > max(30, overlap)`.
    pub fn is_contradicted(&self) -> bool {
        self.violations() > self.overlap().max(30)
    }

    /// Root mean square of the distances from the tangent planes, in the unit of the points; `None` without
    /// overlap.
    pub fn plane_rms(&self) -> Option<f64> {
        let squares =
            self.of_j_in_i.squared_plane_distances + self.of_i_in_j.squared_plane_distances;
        (self.overlap() > 0).then(|| (squares / self.overlap() as f64).sqrt())
    }

    /// The counts with the roles of the scans exchanged.
    #[must_use]
    pub fn swapped(&self) -> Self {
        Self {
            of_j_in_i: self.of_i_in_j,
            of_i_in_j: self.of_j_in_i,
        }
    }
}

impl AddAssign for PairCounts {
    fn add_assign(&mut self, other: Self) {
        self.of_j_in_i += other.of_j_in_i;
        self.of_i_in_j += other.of_i_in_j;
    }
}

impl Sum for PairCounts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |mut sum, counts| {
            sum += counts;
            sum
        })
    }
}
