use std::collections::BTreeMap;

use gmpcr_correspondence::{Keypoints, correspondences};
use gmpcr_geometry::PointPairs;

use crate::{Error, Params};

/// Two positions in the list of scans, the lower first.
pub(crate) type Pair = (usize, usize);

/// Where the correspondences of scan pairs come from.
pub(crate) enum Source<'a> {
    /// Keypoints of every scan, matched by their descriptors.
    Keypoints(&'a [Keypoints]),
    /// Somebody else's matches of some pairs.
    Matches(&'a BTreeMap<Pair, PointPairs>),
}

impl Source<'_> {
    /// The pairs that have correspondences, in order.
    pub fn pairs(&self) -> Vec<Pair> {
        match self {
            Self::Keypoints(keypoints) => {
                let n = keypoints.len();
                (0..n)
                    .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
                    .collect()
            }
            Self::Matches(matches) => matches.keys().copied().collect(),
        }
    }

    /// The correspondences `C_ij` of two scans; target is scan i.
    pub fn correspondences(
        &self,
        i: usize,
        j: usize,
        params: &Params,
    ) -> Result<PointPairs, Error> {
        match self {
            Self::Keypoints(keypoints) => {
                let matched = correspondences(&keypoints[i], &keypoints[j], &params.correspondence);
                matched.map_err(|error| Error::of_pair(i, j, error))
            }
            Self::Matches(matches) => Ok(matches.get(&(i, j)).cloned().unwrap_or_default()),
        }
    }
}
