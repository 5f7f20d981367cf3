//! The rules by which a registration finds what a person should check.

use gmpcr_posegraph::Bridge;

use crate::{Edge, Params, Registration, Warning};

impl Registration {
    /// All warnings, the gravest kind first: unregistered scans, other frames, loose parts, bridges (those of
    /// the lowest inlier ratio first), and contradictions (those of the heaviest loss of weight first).
    ///
    /// An edge contradicts the result if that is off by more than two residual scales or five inlier thresholds of
    /// the [parameters](Self::params).
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.unregistered();
        warnings.extend(self.separate_frames());
        warnings.extend(self.loose_parts());
        warnings.extend(self.single_connections());
        warnings.extend(self.contradictions());
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
            ends: self.ends(bridge.edge),
            scans: bridge.smaller_side,
        })
    }

    fn contradictions(&self) -> impl Iterator<Item = Warning> {
        let lost = |k: usize| {
            let report = &self.edges[k].synchronization;
            report.initial_weight - report.final_weight
        };
        let mut edges: Vec<usize> = (0..self.edges.len()).collect();
        edges.retain(|&k| self.edges[k].is_contradicted(&self.params));
        edges.sort_by(|&a, &b| lost(b).total_cmp(&lost(a)));
        let ends = |edge: usize| self.ends(edge);
        edges.into_iter().map(move |edge| Warning::Contradiction {
            edge,
            ends: ends(edge),
        })
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
