//! `gmpcr info`: what is known of scans before they are registered.

use std::fmt::Write;

use gmpcr::features::{LocalCloud, estimate_resolution, estimate_voxel_size, extent};
use gmpcr::nalgebra::Vector3;
use gmpcr::{Edge, register_observed};
use gmpcr_eval::OverlapIndex;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::arguments::InfoArguments;
use crate::config::Config;
use crate::input::Input;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::scan_files::{ScanFile, files_of};
use crate::table::{significant, table};

pub fn run(arguments: &InfoArguments, progress: &Progress) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let input = Input::with_fpfh(&files_of(&arguments.inputs)?, &config, progress)?;
    let facts = facts(&input, progress)?;
    let overlaps = overlaps(&input, &config, progress)?;
    progress.finish();
    Ok(Answer {
        text: text(&input, &facts, &overlaps),
        json: Some(json(&input, &facts, &overlaps)),
        is_complete: input.files.iter().all(|file| file.problem.is_none()),
    })
}

/// What the points of a scan tell.
struct Facts {
    num_points: usize,
    extent: Vector3<f64>,
    resolution: Option<f64>,
    voxel_size: Option<f64>,
}

fn facts(input: &Input, progress: &Progress) -> Result<Vec<Facts>, Failure> {
    let clouds = input.files.par_iter().zip(&input.set.clouds);
    let facts = |(file, cloud)| progress.item(|| Facts::of(file, cloud))?;
    let (facts, _) = progress.stage("resolution", input.files.len(), || {
        clouds.map(facts).collect::<Result<Vec<_>, _>>()
    })?;
    Ok(facts)
}

impl Facts {
    fn of(file: &ScanFile, cloud: &LocalCloud) -> Result<Self, Failure> {
        let named = |error| format!("{}: {error}", file.name);
        Ok(Self {
            num_points: cloud.points.len(),
            extent: extent(&cloud.points),
            resolution: estimate_resolution(&cloud.points).map_err(named)?,
            voxel_size: estimate_voxel_size(&cloud.points).map_err(named)?,
        })
    }

    fn row(&self, file: &ScanFile, partner: Option<String>) -> [String; 8] {
        let length = |length: Option<f64>| length.map_or("-".into(), significant);
        let extent = self.extent.iter().map(|&length| significant(length));
        let extent: Vec<_> = extent.collect();
        [
            file.name.clone(),
            self.num_points.to_string(),
            file.invalid.to_string(),
            if file.has_normals { "yes" } else { "no" }.into(),
            extent.join(" × "),
            length(self.resolution),
            length(self.voxel_size),
            partner.unwrap_or("none found".into()),
        ]
    }

    fn to_json(&self, file: &ScanFile, cloud: &LocalCloud) -> Value {
        json!({
            "name": file.name,
            "points": self.num_points,
            "invalid": file.invalid,
            "has_normals": file.has_normals,
            "extent": self.extent.as_slice(),
            "origin": cloud.origin.as_slice(),
            "resolution": self.resolution,
            "voxel_size": self.voxel_size,
            "problem": file.problem,
        })
    }
}

/// How much of each other two scans see, by a relative pose of the two alone.
struct Overlap {
    i: usize,
    j: usize,
    /// The mean of both fractions.
    ratio: f64,
}

/// Guesses for the pairs that a registration selects, whatever the rest of the scans says of them.
fn overlaps(input: &Input, config: &Config, progress: &Progress) -> Result<Vec<Overlap>, Failure> {
    let voxel_size = input.set.voxel_size;
    let scans = &input.set.scans;
    let registration = register_observed(scans, &config.params(voxel_size), progress)
        .map_err(Failure::of_registration)?;
    // Within the diagonal of a voxel.
    let radius = 3f64.sqrt() * voxel_size;
    let indices: Vec<_> = scans
        .iter()
        .map(|scan| OverlapIndex::new(scan.points(), radius))
        .collect();
    let overlap = |edge: &Edge| Overlap {
        i: edge.i,
        j: edge.j,
        ratio: indices[edge.i].overlap(&indices[edge.j], &edge.i_from_j),
    };
    let edges = &registration.edges;
    let (overlaps, _) = progress.stage("overlap", edges.len(), || {
        let overlaps = edges.par_iter().map(|edge| progress.item(|| overlap(edge)));
        overlaps.collect()
    })?;
    Ok(overlaps)
}

/// The scan that seems to overlap most with one, and how much.
fn partner(scan: usize, input: &Input, overlaps: &[Overlap]) -> Option<String> {
    let of_scan = overlaps.iter();
    let of_scan = of_scan.filter(|overlap| overlap.i == scan || overlap.j == scan);
    let largest = of_scan.max_by(|a, b| a.ratio.total_cmp(&b.ratio))?;
    let other = match largest.i == scan {
        true => largest.j,
        false => largest.i,
    };
    let percent = 100.0 * largest.ratio;
    Some(format!("{percent:.0} % with {}", input.name(other)))
}

fn text(input: &Input, facts: &[Facts], overlaps: &[Overlap]) -> String {
    let header = [
        "scan",
        "points",
        "without position",
        "normals",
        "extent",
        "resolution",
        "voxel size",
        "largest overlap",
    ];
    let rows = input.files.iter().zip(facts).enumerate();
    let rows = rows.map(|(k, (file, facts))| facts.row(file, partner(k, input, overlaps)));
    let mut text = table(&header, rows);
    for (file, cloud) in input.files.iter().zip(&input.set.clouds) {
        if let Some(problem) = &file.problem {
            let _ = writeln!(text, "unreadable: {problem}");
        }
        if cloud.origin.norm() > 0.0 {
            let [x, y, z] = cloud.origin.into();
            let _ = writeln!(text, "{} lies around ({x:.1}, {y:.1}, {z:.1})", file.name);
        }
    }
    let _ = writeln!(
        text,
        "\nvoxel size {}; overlaps are a guess from a registration of pairs",
        significant(input.set.voxel_size)
    );
    text
}

fn json(input: &Input, facts: &[Facts], overlaps: &[Overlap]) -> Value {
    let clouds = facts.iter().zip(&input.set.clouds);
    let scans = input.files.iter().zip(clouds);
    let scans = scans.map(|(file, (facts, cloud))| facts.to_json(file, cloud));
    let overlaps = overlaps
        .iter()
        .map(|overlap| json!({ "i": overlap.i, "j": overlap.j, "ratio": overlap.ratio }));
    json!({
        "voxel_size": input.set.voxel_size,
        "scans": scans.collect::<Vec<_>>(),
        "overlaps": overlaps.collect::<Vec<_>>(),
    })
}
