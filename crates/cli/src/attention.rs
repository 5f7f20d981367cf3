//! What deserves a look, in words.

use gmpcr::{EdgeEvidence, Params, Registration};
use serde::{Deserialize, Serialize};

use crate::links::{Bridge, Links};
use crate::scans::Cloud;
use crate::table::significant;

/// A remark on scans or an edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Notice {
    pub kind: NoticeKind,
    /// The scans that it concerns.
    pub scans: Vec<usize>,
    /// The edge that it concerns.
    pub edge: Option<(usize, usize)>,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoticeKind {
    /// A scan shares its frame with no other.
    Alone,
    /// Scans share a frame, but not the largest one.
    Frame,
    /// Scans of a frame that only distrusted edges join to the rest.
    Loose,
    /// Scans of a frame that a single edge joins to the rest.
    Bridge,
    /// An edge that the result contradicts.
    Contradiction,
}

/// All remarks, the gravest kind first.
pub fn notices(clouds: &[Cloud], registration: &Registration, params: &Params) -> Vec<Notice> {
    let view = View {
        clouds,
        registration,
        params,
        links: Links::of(registration),
    };
    let mut notices = view.scans_alone();
    notices.extend(view.other_frames());
    notices.extend(view.loose_parts());
    notices.extend(view.single_links());
    notices.extend(view.contradictions());
    notices
}

struct View<'a> {
    clouds: &'a [Cloud],
    registration: &'a Registration,
    params: &'a Params,
    links: Links<'a>,
}

impl View<'_> {
    fn scans_alone(&self) -> Vec<Notice> {
        let members = self.registration.components.members();
        let alone = members.iter().filter(|scans| scans.len() == 1);
        let notice = |scans: &Vec<usize>| Notice {
            kind: NoticeKind::Alone,
            scans: scans.clone(),
            edge: None,
            text: format!(
                "{} is not registered: {}",
                self.name(scans[0]),
                self.reason(scans[0])
            ),
        };
        match members.len() {
            1 => Vec::new(),
            _ => alone.map(notice).collect(),
        }
    }

    fn reason(&self, scan: usize) -> String {
        let cloud = &self.clouds[scan];
        if let Some(problem) = &cloud.problem {
            return format!("it could not be read ({problem})");
        }
        if cloud.points.is_empty() {
            return "it holds no points".into();
        }
        let unresolved = self.registration.unresolved.iter();
        let tried = unresolved
            .filter(|pair| pair.i == scan || pair.j == scan)
            .count();
        match tried {
            0 => "no other scan has correspondences with it that agree".into(),
            _ => format!(
                "none of the {tried} pairs that were tried has a motion that explains its correspondences"
            ),
        }
    }

    fn other_frames(&self) -> Vec<Notice> {
        let components = &self.registration.components;
        let members = components.members().iter();
        let others = members.filter(|scans| scans.len() > 1 && *scans != components.largest());
        let notice = |scans: &Vec<usize>| Notice {
            kind: NoticeKind::Frame,
            scans: scans.clone(),
            edge: None,
            text: format!(
                "{} share a frame of their own: no edge joins them to the largest one",
                self.names(scans)
            ),
        };
        others.map(notice).collect()
    }

    /// Parts of a frame that only distrusted edges join.
    fn loose_parts(&self) -> Vec<Notice> {
        let parts = self.links.trusted_parts();
        let mut notices = Vec::new();
        for component in self.registration.components.members() {
            let inside = |part: &&Vec<usize>| component.binary_search(&part[0]).is_ok();
            let mut parts: Vec<_> = parts.members().iter().filter(inside).cloned().collect();
            if parts.len() < 2 {
                continue;
            }
            parts.sort_by_key(|part| part.len());
            parts.pop();
            notices.extend(parts.into_iter().map(|part| Notice {
                kind: NoticeKind::Loose,
                edge: None,
                text: format!(
                    "{} may be misplaced as a whole: only edges that lost nine tenths of their weight join \
                     {} to the rest",
                    self.names(&part),
                    if part.len() == 1 { "it" } else { "them" }
                ),
                scans: part,
            }));
        }
        notices
    }

    /// Parts that a single edge joins to the rest, those of the least support first. Two scans alone
    /// cannot be more than that to each other.
    fn single_links(&self) -> Vec<Notice> {
        let edge = |bridge: &Bridge| &self.registration.evidence[bridge.edge];
        let notice = |bridge: Bridge| {
            let EdgeEvidence { i, j, .. } = *edge(&bridge);
            Notice {
                kind: NoticeKind::Bridge,
                edge: Some((i, j)),
                text: format!(
                    "only the edge {} – {} ({}) holds {} in place: nothing confirms where {} to be",
                    self.name(i),
                    self.name(j),
                    strength(edge(&bridge)),
                    self.names(&bridge.part),
                    if bridge.part.len() == 1 {
                        "it has"
                    } else {
                        "they have"
                    }
                ),
                scans: bridge.part,
            }
        };
        let components = &self.registration.components;
        let size = |scan: usize| components.members()[components.label(scan)].len();
        let mut bridges = self.links.bridges();
        bridges.retain(|bridge| size(bridge.part[0]) > 2);
        bridges.sort_by(|a, b| edge(a).inlier_ratio.total_cmp(&edge(b).inlier_ratio));
        bridges.into_iter().map(notice).collect()
    }

    /// Edges that lost more than half of their weight and disagree with the result by more than the
    /// noise of a good motion: those of the heaviest loss.
    fn contradictions(&self) -> Vec<Notice> {
        const MOST: usize = 5;
        let lost = |edge: &EdgeEvidence| edge.initial_weight - edge.final_weight;
        let evidence = self.registration.evidence.iter();
        let mut edges: Vec<_> = evidence.filter(|edge| self.is_contradicted(edge)).collect();
        edges.sort_by(|a, b| lost(b).total_cmp(&lost(a)));
        let notice = |edge: &&EdgeEvidence| Notice {
            kind: NoticeKind::Contradiction,
            scans: vec![edge.i, edge.j],
            edge: Some((edge.i, edge.j)),
            text: format!(
                "the motion between {} and {} ({}) is off the result by {}: two similar places?",
                self.name(edge.i),
                self.name(edge.j),
                strength(edge),
                offset(edge)
            ),
        };
        edges.iter().take(MOST).map(notice).collect()
    }

    /// Whether the result is off the motion by more than two residual scales or five inlier
    /// thresholds.
    fn is_contradicted(&self, edge: &EdgeEvidence) -> bool {
        let exceeds = |residual: Option<f64>, limit| residual.is_some_and(|value| value > limit);
        edge.final_weight < 0.5 * edge.initial_weight
            && (exceeds(
                edge.rotation_residual,
                2.0 * self.params.sync.residual_scale,
            ) || exceeds(
                edge.translation_residual,
                5.0 * self.params.cliques.inlier_threshold,
            ))
    }

    fn name(&self, scan: usize) -> &str {
        &self.clouds[scan].name
    }

    fn names(&self, scans: &[usize]) -> String {
        const FEW: usize = 4;
        let names: Vec<_> = scans
            .iter()
            .take(FEW)
            .map(|&scan| self.name(scan))
            .collect();
        match scans.len().saturating_sub(FEW) {
            0 => names.join(", "),
            more => format!("{} and {more} more", names.join(", ")),
        }
    }
}

/// Rotation and translation residual.
fn offset(edge: &EdgeEvidence) -> String {
    let residuals = edge.rotation_residual.zip(edge.translation_residual);
    residuals.map_or("an unknown motion".into(), |(angle, length)| {
        format!("{:.0}° and {}", angle.to_degrees(), significant(length))
    })
}

fn strength(edge: &EdgeEvidence) -> String {
    format!(
        "confidence {:.3}, {:.0} % inliers",
        edge.confidence,
        100.0 * edge.inlier_ratio
    )
}
