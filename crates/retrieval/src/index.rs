use std::cmp::Reverse;
use std::ops::Range;

use gmpcr_correspondence::{Descriptors, DimensionsDiffer};

use crate::leaf::Leaf;
use crate::ranking::Rankings;
use crate::rows::Rows;
use crate::tree::for_each_leaf;

/// Trees that are searched. More trees of smaller leaves find the same for the same number of
/// distances.
const NUM_TREES: usize = 8;

/// Most rows of a leaf.
const MAX_LEAF: usize = 64;

/// Which scans resemble which by their descriptors.
///
/// Every descriptor ranks the other scans by the distance to their nearest descriptor, as far as it
/// meets them in the leaves of random-projection trees, and votes for the first eight of them with
/// eight points to one. A scan that has a hundred copies of a descriptor thus gets no more votes
/// than one that has it once. Where a leaf holds all descriptors (64 or fewer) the rankings are exact.
///
/// Memory: 64 bytes for each descriptor; about `4 d + 100` more while it is made.
///
/// ```
/// use gmpcr_correspondence::Descriptors;
/// use gmpcr_retrieval::Index;
///
/// let a = Descriptors::new(vec![0.0, 1.0], 1)?;
/// let b = Descriptors::new(vec![7.0, 8.1], 1)?;
/// let c = Descriptors::new(vec![1.2, 7.1, 8.0], 1)?;
/// let index = Index::new(&[&a, &b, &c])?;
/// assert_eq!(index.candidates_of(2, 2), [1, 0]); // two of its descriptors come nearest to b's
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Index {
    /// The rows of each scan.
    rows_of_scan: Vec<Range<usize>>,
    rankings: Rankings,
    num_distances: usize,
}

impl Index {
    /// Compares the descriptors of the scans, on the calling thread.
    ///
    /// # Errors
    /// [`DimensionsDiffer`] if descriptors of two scans have different dimensions. A scan without
    /// descriptors has no dimension.
    ///
    /// # Panics
    /// If there are 2³² scans or descriptors, or more.
    pub fn new(scans: &[&Descriptors]) -> Result<Self, DimensionsDiffer> {
        let rows = Rows::new(scans)?;
        let mut rankings = Rankings::new(rows.len());
        let mut leaf = Leaf::default();
        let mut num_distances = 0;
        for tree in 0..NUM_TREES {
            for_each_leaf(&rows, tree, MAX_LEAF, |members| {
                num_distances += leaf.rank(&rows, members, &mut rankings);
            });
        }
        let rows_of_scan = scans.iter().scan(0, |start, scan| {
            let first = *start;
            *start += scan.len();
            Some(first..*start)
        });
        Ok(Self {
            rows_of_scan: rows_of_scan.collect(),
            rankings,
            num_distances,
        })
    }

    /// Number of scans.
    pub fn num_scans(&self) -> usize {
        self.rows_of_scan.len()
    }

    /// How many distances of descriptors were computed: the work that was done.
    pub fn num_distances(&self) -> usize {
        self.num_distances
    }

    /// The scans that `scan` proposes as its partners: those with most votes of its descriptors, best
    /// first, ties to the lower index, at most `max_candidates`.
    ///
    /// Scans without any vote are proposed only where all scans that have descriptors are, so that
    /// few scans are compared exhaustively. `O(n + N log N)`.
    ///
    /// # Panics
    /// If `scan` does not exist.
    pub fn candidates_of(&self, scan: usize, max_candidates: usize) -> Vec<usize> {
        if self.rows_of_scan[scan].is_empty() {
            return Vec::new();
        }
        let votes = self.votes_of(scan);
        let is_other = |&other: &usize| other != scan && !self.rows_of_scan[other].is_empty();
        let mut others: Vec<usize> = (0..self.num_scans()).filter(is_other).collect();
        if others.len() > max_candidates {
            others.retain(|&other| votes[other] > 0);
        }
        others.sort_by_key(|&other| (Reverse(votes[other]), other));
        others.truncate(max_candidates);
        others
    }

    fn votes_of(&self, scan: usize) -> Vec<usize> {
        let mut votes = vec![0; self.num_scans()];
        for row in self.rows_of_scan[scan].clone() {
            for (rank, other) in self.rankings.scans(row).enumerate() {
                votes[other] += Rankings::LENGTH - rank;
            }
        }
        votes
    }
}
