use std::fmt;

/// A finding about a registration that a person should check. Scans and edges are named by their positions.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum Warning {
    /// A scan shares its frame with no other.
    #[non_exhaustive]
    Unregistered {
        /// The scan.
        scan: usize,
        /// Selected pairs of this scan that have no relative pose.
        num_unresolved: usize,
    },
    /// Scans share a frame, but not that of the largest component.
    #[non_exhaustive]
    SeparateFrame {
        /// The scans of the frame.
        scans: Vec<usize>,
    },
    /// Only edges that lost nine tenths of their weight connect scans to the rest of their frame.
    #[non_exhaustive]
    Loose {
        /// The scans.
        scans: Vec<usize>,
    },
    /// A single edge connects scans to the rest of their frame.
    #[non_exhaustive]
    Bridge {
        /// The position of the edge.
        edge: usize,
        /// The scans of the edge, the lower first.
        ends: (usize, usize),
        /// The scans of the smaller side.
        scans: Vec<usize>,
    },
    /// An edge that lost more than half of its weight, and that the result contradicts.
    #[non_exhaustive]
    Contradiction {
        /// The position of the edge.
        edge: usize,
        /// The scans of the edge, the lower first.
        ends: (usize, usize),
    },
}

impl Warning {
    /// The scans that it concerns.
    pub fn scans(&self) -> Vec<usize> {
        match self {
            Self::Unregistered { scan, .. } => vec![*scan],
            Self::SeparateFrame { scans } | Self::Loose { scans } | Self::Bridge { scans, .. } => {
                scans.clone()
            }
            Self::Contradiction { ends: (i, j), .. } => vec![*i, *j],
        }
    }

    /// The scans of the edge that it concerns, if it concerns one.
    pub fn ends(&self) -> Option<(usize, usize)> {
        match self {
            Self::Bridge { ends, .. } | Self::Contradiction { ends, .. } => Some(*ends),
            _ => None,
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Unregistered { scan, .. } => write!(formatter, "scan {scan} is not registered"),
            Self::SeparateFrame { scans } => {
                write!(formatter, "scans {scans:?} share a frame of their own")
            }
            Self::Loose { scans } => write!(
                formatter,
                "only distrusted edges connect scans {scans:?} to their frame"
            ),
            Self::Bridge {
                ends: (i, j),
                scans,
                ..
            } => write!(
                formatter,
                "only the edge ({i}, {j}) connects scans {scans:?} to their frame"
            ),
            Self::Contradiction { ends: (i, j), .. } => {
                write!(formatter, "the result contradicts the edge ({i}, {j})")
            }
        }
    }
}
