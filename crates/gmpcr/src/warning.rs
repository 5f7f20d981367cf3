//! What a person should check.

use std::fmt;

use gmpcr_posegraph::Bridge;

use crate::{Edge, Params, Registration};

/// A finding about a registration that a person should check. Scans and edges are named by their positions.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum Warning {
    /// A scan shares its frame with no other.
    Unregistered {
        /// The scan.
        scan: usize,
        /// Selected pairs of this scan that have no relative pose.
        num_unresolved: usize,
    },
    /// Scans share a frame, but not that of the largest component.
    SeparateFrame {
        /// The scans of the frame.
        scans: Vec<usize>,
    },
    /// Only edges that lost nine tenths of their weight connect scans to the rest of their frame.
    Loose {
        /// The scans.
        scans: Vec<usize>,
    },
    /// A single edge connects scans to the rest of their frame.
    Bridge {
        /// The edge.
        edge: usize,
        /// The scans of the smaller side.
        scans: Vec<usize>,
    },
    /// An edge that lost more than half of its weight, and that the result contradicts.
    Contradiction {
        /// The edge.
        edge: usize,
    },
}

impl Warning {
    /// The scans that it concerns.
    pub fn scans(&self, registration: &Registration) -> Vec<usize> {
        match self {
            Self::Unregistered { scan, .. } => vec![*scan],
            Self::SeparateFrame { scans } | Self::Loose { scans } | Self::Bridge { scans, .. } => {
                scans.clone()
            }
            Self::Contradiction { edge } => {
                let edge = registration.edges.get(*edge);
                edge.map_or(Vec::new(), |edge| vec![edge.i, edge.j])
            }
        }
    }

    /// The edge that it concerns.
    pub fn edge(&self) -> Option<usize> {
        match self {
            Self::Bridge { edge, .. } | Self::Contradiction { edge } => Some(*edge),
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
            Self::Loose { scans } => {
                write!(
                    formatter,
                    "only distrusted edges connect scans {scans:?} to their frame"
                )
            }
            Self::Bridge { edge, scans } => {
                write!(
                    formatter,
                    "only edge {edge} connects scans {scans:?} to their frame"
                )
            }
            Self::Contradiction { edge } => {
                write!(formatter, "the result contradicts edge {edge}")
            }
        }
    }
}

impl Registration {
    /// All warnings, the gravest kind first: unregistered scans, other frames, loose parts, bridges (those of
    /// the lowest inlier ratio first), and the five contradictions of the heaviest loss of weight.
    ///
    /// `params` are those of the registration: an edge contradicts the result if that is off by more than two
    /// residual scales or five inlier thresholds.
    pub fn warnings(&self, params: &Params) -> Vec<Warning> {
        let mut warnings = self.unregistered();
        warnings.extend(self.separate_frames());
        warnings.extend(self.loose_parts());
        warnings.extend(self.single_connections());
        warnings.extend(self.contradictions(params));
        warnings
    }

    /// A single scan is where it belongs.
    fn unregistered(&self) -> Vec<Warning> {
        let members = self.components.members();
        if members.len() == 1 {
            return Vec::new();
        }
        let alone = members.iter().filter(|scans| scans.len() == 1);
        let warning = |scans: &Vec<usize>| {
            let scan = scans[0];
            let unresolved = self.unresolved.iter();
            let of_scan = unresolved.filter(|pair| pair.i == scan || pair.j == scan);
            Warning::Unregistered {
                scan,
                num_unresolved: of_scan.count(),
            }
        };
        alone.map(warning).collect()
    }

    fn separate_frames(&self) -> impl Iterator<Item = Warning> {
        let largest = self.components.largest();
        let others = self.components.members().iter();
        let others = others.filter(move |scans| scans.len() > 1 && *scans != largest);
        others.map(|scans| Warning::SeparateFrame {
            scans: scans.clone(),
        })
    }

    /// All but the largest of the parts of each component.
    fn loose_parts(&self) -> Vec<Warning> {
        let parts = self.trusted_parts();
        let mut warnings = Vec::new();
        for component in self.components.members() {
            let inside = |part: &&Vec<usize>| component.binary_search(&part[0]).is_ok();
            let mut parts: Vec<_> = parts.members().iter().filter(inside).cloned().collect();
            parts.sort_by_key(|part| part.len());
            parts.pop();
            warnings.extend(parts.into_iter().map(|scans| Warning::Loose { scans }));
        }
        warnings
    }

    /// Two scans alone cannot be more than a bridge to each other.
    fn single_connections(&self) -> impl Iterator<Item = Warning> {
        let size = |scan: usize| self.components.members()[self.components.label(scan)].len();
        let mut bridges = self.bridges();
        bridges.retain(|bridge| size(bridge.smaller_side[0]) > 2);
        let inlier_ratio = |bridge: &Bridge| self.edges[bridge.edge].inlier_ratio;
        bridges.sort_by(|a, b| inlier_ratio(a).total_cmp(&inlier_ratio(b)));
        bridges.into_iter().map(|bridge| Warning::Bridge {
            edge: bridge.edge,
            scans: bridge.smaller_side,
        })
    }

    fn contradictions(&self, params: &Params) -> impl Iterator<Item = Warning> {
        const MOST: usize = 5;
        let lost = |k: usize| {
            let report = &self.edges[k].synchronization;
            report.initial_weight - report.final_weight
        };
        let mut edges: Vec<usize> = (0..self.edges.len()).collect();
        edges.retain(|&k| self.edges[k].is_contradicted(params));
        edges.sort_by(|&a, &b| lost(b).total_cmp(&lost(a)));
        edges
            .into_iter()
            .take(MOST)
            .map(|edge| Warning::Contradiction { edge })
    }
}

impl Edge {
    fn is_contradicted(&self, params: &Params) -> bool {
        let report = &self.synchronization;
        let exceeds = |residual: Option<f64>, limit| residual.is_some_and(|value| value > limit);
        report.final_weight < 0.5 * report.initial_weight
            && (exceeds(report.rotation_residual, 2.0 * params.sync.residual_scale)
                || exceeds(
                    report.translation_residual,
                    5.0 * params.cliques.inlier_threshold,
                ))
    }
}
