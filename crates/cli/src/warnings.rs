//! Warnings in words.

use gmpcr::{Edge, Registration, Warning};
use serde::{Deserialize, Serialize};

use crate::input::Input;
use crate::table::significant;

/// A warning, and what the user reads of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    #[serde(flatten)]
    pub warning: Warning,
    pub text: String,
}

/// Contradictions that are told, at most: those of the heaviest loss of weight.
const MAX_CONTRADICTIONS: usize = 5;

/// Puts the warnings of a registration into words, with the names of the scans.
pub fn in_words(input: &Input, registration: &Registration) -> Vec<Finding> {
    let mut num_contradictions = 0;
    let mut warnings = registration.warnings();
    warnings.retain(|warning| {
        num_contradictions += usize::from(matches!(warning, Warning::Contradiction { .. }));
        num_contradictions <= MAX_CONTRADICTIONS
    });
    let words = Words {
        input,
        registration,
    };
    let finding = |warning| Finding {
        text: words.of(&warning),
        warning,
    };
    warnings.into_iter().map(finding).collect()
}

struct Words<'a> {
    input: &'a Input,
    registration: &'a Registration,
}

impl Words<'_> {
    fn of(&self, warning: &Warning) -> String {
        match warning {
            Warning::Unregistered {
                scan,
                num_unresolved,
                ..
            } => format!(
                "{} is not registered: {}",
                self.input.name(*scan),
                self.reason(*scan, *num_unresolved)
            ),
            Warning::SeparateFrame { scans, .. } => format!(
                "{} share a frame of their own: no edge connects them to the largest one",
                self.names(scans)
            ),
            Warning::Loose { scans, .. } => format!(
                "{} may be misplaced as a whole: only edges that lost nine tenths of their weight connect {} to \
                 the rest",
                self.names(scans),
                if scans.len() == 1 { "it" } else { "them" }
            ),
            Warning::Bridge { edge, scans, .. } => self.bridge(*edge, scans),
            Warning::Contradiction { edge, .. } => self.contradiction(*edge),
            other => other.to_string(),
        }
    }

    fn reason(&self, scan: usize, num_unresolved: usize) -> String {
        if let Some(problem) = &self.input.files[scan].problem {
            return format!("it could not be read ({problem})");
        }
        if self.input.set.clouds[scan].points.is_empty() {
            return "it holds no points".into();
        }
        match num_unresolved {
            0 => "no other scan has correspondences with it that agree".into(),
            tried => format!(
                "none of the {tried} pairs that were tried has a transformation that explains its correspondences"
            ),
        }
    }

    fn bridge(&self, edge: usize, scans: &[usize]) -> String {
        let edge = &self.registration.edges[edge];
        format!(
            "only the edge {} – {} ({}) connects {} to the rest: nothing confirms {} pose{}",
            self.input.name(edge.i),
            self.input.name(edge.j),
            support(edge),
            self.names(scans),
            if scans.len() == 1 { "its" } else { "their" },
            if scans.len() == 1 { "" } else { "s" },
        )
    }

    fn contradiction(&self, edge: usize) -> String {
        let edge = &self.registration.edges[edge];
        format!(
            "the relative pose of {} and {} ({}) contradicts the result by {}: two similar places?",
            self.input.name(edge.i),
            self.input.name(edge.j),
            support(edge),
            residual(edge)
        )
    }

    fn names(&self, scans: &[usize]) -> String {
        const FEW: usize = 4;
        let names = scans.iter().take(FEW).map(|&scan| self.input.name(scan));
        let names = names.collect::<Vec<_>>().join(", ");
        match scans.len().saturating_sub(FEW) {
            0 => names,
            more => format!("{names} and {more} more"),
        }
    }
}

/// Rotation and translation residual.
fn residual(edge: &Edge) -> String {
    let report = &edge.synchronization;
    let residuals = report.rotation_residual.zip(report.translation_residual);
    residuals.map_or("an unknown amount".into(), |(angle, length)| {
        format!("{:.0}° and {}", angle.to_degrees(), significant(length))
    })
}

fn support(edge: &Edge) -> String {
    format!(
        "confidence {:.3}, {:.0} % inliers",
        edge.confidence,
        100.0 * edge.inlier_ratio
    )
}
