//! `report.html`: one file that shows the result in any browser.

mod picture;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gmpcr::features::LocalCloud;
use gmpcr::geometry::matrix_rows::rows;
use gmpcr::nalgebra::Isometry3;
use gmpcr::{Edge, Warning};
use gmpcr_io::distinct_color;
use serde_json::{Value, json};

use crate::result::ResultFile;
use crate::warnings::Finding;
use picture::Picture;

/// What there is to show.
pub struct Report<'a> {
    pub title: &'a str,
    pub result: &'a ResultFile,
    /// The points of the scans, in the coordinates that registration saw.
    pub clouds: &'a [LocalCloud],
    /// The poses in these coordinates.
    pub world_from_local: &'a [Isometry3<f64>],
}

impl Report<'_> {
    /// The page, with everything that it needs inside.
    pub fn to_html(&self) -> String {
        // A name may hold "</script>", but within a JSON string `<` may also be written like this.
        let data = self.data().to_string().replace('<', "\\u003c");
        // Piece by piece: what is inserted may itself look like a place.
        let mut page = String::new();
        let mut rest = include_str!("report.html");
        for (place, content) in [
            ("/*{{style}}*/", include_str!("report.css")),
            ("{{data}}", &data),
            ("/*{{libraries}}*/", include_str!("libraries.min.js")),
            ("/*{{program}}*/", include_str!("report.js")),
        ] {
            let (before, after) = rest
                .split_once(place)
                .expect("the page has its places in this order");
            page.push_str(before);
            page.push_str(content);
            rest = after;
        }
        page + rest
    }

    fn data(&self) -> Value {
        let result = self.result;
        let registration = &result.registration;
        let picture = Picture::new(self.clouds, self.world_from_local, &registration.components);
        let components = registration.components.members().iter().zip(&picture.boxes);
        let components = components.map(|(scans, grid)| {
            json!({ "scans": scans, "origin": grid.origin.as_slice(), "step": grid.step })
        });
        let confidences = &registration.confidences;
        let scored = confidences.pairs().iter().zip(confidences.normalized());
        let scored = scored.map(|(pair, s)| json!([pair.i, pair.j, rounded(*s)]));
        let warnings = result.warnings.iter().map(warning);
        json!({
            "title": self.title,
            "version": format!("gmpcr {}", result.version),
            "features": result.features,
            "voxel_size": result.voxel_size,
            "voxel_is_estimated": result.voxel_is_estimated,
            "scans": self.scans(&picture),
            "components": components.collect::<Vec<_>>(),
            "poses": picture.poses.iter().map(rows).collect::<Vec<_>>(),
            "edges": registration.edges.iter().map(edge).collect::<Vec<_>>(),
            "unresolved": registration.unresolved,
            "scored_pairs": scored.collect::<Vec<_>>(),
            "stages": result.stages,
            "warnings": warnings.collect::<Vec<_>>(),
        })
    }

    fn scans(&self, picture: &Picture) -> Value {
        let registration = &self.result.registration;
        let mut has_warning = vec![false; registration.ids.len()];
        for finding in &self.result.warnings {
            if !matches!(finding.warning, Warning::Contradiction { .. }) {
                for scan in finding.warning.scans() {
                    has_warning[scan] = true;
                }
            }
        }
        let scans = self.result.scans.iter().enumerate().map(|(k, scan)| {
            json!({
                "name": scan.name,
                "component": registration.components.label(k),
                "color": distinct_color(k),
                "points": scan.points,
                "count": picture.positions[k].len() / 3,
                "positions": STANDARD.encode(bytes(&picture.positions[k])),
                "has_warning": has_warning[k],
            })
        });
        scans.collect()
    }
}

fn warning(finding: &Finding) -> Value {
    json!({
        "kind": kind(&finding.warning),
        "scans": finding.warning.scans(),
        "edge": finding.warning.ends(),
        "text": finding.text,
    })
}

fn kind(warning: &Warning) -> &'static str {
    match warning {
        Warning::Unregistered { .. } => "unregistered",
        Warning::SeparateFrame { .. } => "separate_frame",
        Warning::Loose { .. } => "loose",
        Warning::Bridge { .. } => "bridge",
        Warning::Contradiction { .. } => "contradiction",
        _ => "other",
    }
}

fn edge(edge: &Edge) -> Value {
    let report = &edge.synchronization;
    json!({
        "i": edge.i,
        "j": edge.j,
        "confidence": edge.confidence,
        "inlier_ratio": edge.inlier_ratio,
        "correspondences": edge.num_correspondences,
        "clique_size": edge.clique_size,
        "cliques_seen": edge.cliques_seen,
        "budget_exhausted": edge.budget_exhausted,
        "initial_weight": report.initial_weight,
        "final_weight": report.final_weight,
        "rotation_residual": report.rotation_residual.map(f64::to_degrees),
        "translation_residual": report.translation_residual,
        "weights": report.weights.iter().map(|w| rounded(*w)).collect::<Vec<_>>(),
    })
}

/// Enough digits for a picture.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn bytes(positions: &[u16]) -> Vec<u8> {
    positions
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}
