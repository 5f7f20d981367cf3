//! `gmpcr info`: what is known of scans before they are registered.

use std::fmt::Write;

use gmpcr::features::{estimate_resolution, estimate_voxel_size};
use gmpcr::nalgebra::{Isometry3, Point3, Vector3};
use gmpcr::{Scan, register_observed};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::arguments::InfoArguments;
use crate::config::Config;
use crate::described::DescribedScans;
use crate::outcome::{Answer, Failure};
use crate::progress::Progress;
use crate::scans::{Cloud, files_of};
use crate::table::{significant, table};

pub fn run(arguments: &InfoArguments, progress: &Progress) -> Result<Answer, Failure> {
    let config = Config::new(&arguments.tuning)?;
    let input = DescribedScans::by_fpfh(&files_of(&arguments.inputs)?, &config, progress)?;
    let voxel = input.voxel.size;
    let (facts, _) = progress.stage("resolution", input.clouds.len(), || {
        let facts = |cloud| progress.item(|| Facts::of(cloud))?;
        input
            .clouds
            .par_iter()
            .map(facts)
            .collect::<Result<Vec<_>, _>>()
    })?;
    let overlaps = overlaps(&input, &config, progress)?;
    progress.finish();
    let best = |scan: usize| {
        let of_scan = overlaps
            .iter()
            .filter(|overlap| overlap.i == scan || overlap.j == scan);
        of_scan.max_by(|a, b| a.share.total_cmp(&b.share))
    };
    let rows = input
        .clouds
        .iter()
        .zip(&facts)
        .enumerate()
        .map(|(k, (cloud, facts))| {
            let partner = best(k).map(|overlap| {
                let other = if overlap.i == k { overlap.j } else { overlap.i };
                format!(
                    "{:.0} % with {}",
                    100.0 * overlap.share,
                    input.clouds[other].name
                )
            });
            facts.row(cloud, partner)
        });
    let mut text = table(
        &[
            "scan",
            "points",
            "without position",
            "normals",
            "extent",
            "resolution",
            "voxel",
            "largest overlap",
        ],
        rows,
    );
    for cloud in &input.clouds {
        if let Some(problem) = &cloud.problem {
            let _ = writeln!(text, "unreadable: {problem}");
        }
        if cloud.origin.norm() > 0.0 {
            let [x, y, z] = cloud.origin.into();
            let _ = writeln!(text, "{} lies around ({x:.1}, {y:.1}, {z:.1})", cloud.name);
        }
    }
    let _ = writeln!(
        text,
        "\nworking voxel {}; overlaps are a guess from a registration of pairs",
        significant(voxel)
    );
    let scans = input
        .clouds
        .iter()
        .zip(&facts)
        .map(|(cloud, facts)| facts.to_json(cloud));
    let json = json!({
        "voxel": voxel,
        "scans": scans.collect::<Vec<_>>(),
        "overlaps": overlaps.iter().map(Overlap::to_json).collect::<Vec<_>>(),
    });
    Ok(Answer {
        text,
        json: Some(json),
        is_complete: input.clouds.iter().all(|cloud| cloud.problem.is_none()),
    })
}

/// What the points of a scan tell.
struct Facts {
    extent: Vector3<f64>,
    resolution: Option<f64>,
    voxel: Option<f64>,
}

impl Facts {
    fn of(cloud: &Cloud) -> Result<Self, Failure> {
        let named = |error| format!("{}: {error}", cloud.name);
        let coordinates = || cloud.points.iter().map(|point| point.coords);
        let min = coordinates().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let max = coordinates().reduce(|a, b| a.sup(&b)).unwrap_or_default();
        Ok(Self {
            extent: max - min,
            resolution: estimate_resolution(&cloud.points).map_err(named)?,
            voxel: estimate_voxel_size(&cloud.points).map_err(named)?,
        })
    }

    fn row(&self, cloud: &Cloud, partner: Option<String>) -> [String; 8] {
        let length = |length: Option<f64>| length.map_or("-".into(), significant);
        let extent: Vec<_> = self
            .extent
            .iter()
            .map(|&length| significant(length))
            .collect();
        [
            cloud.name.clone(),
            cloud.points.len().to_string(),
            cloud.invalid.to_string(),
            if cloud.has_normals { "yes" } else { "no" }.into(),
            extent.join(" × "),
            length(self.resolution),
            length(self.voxel),
            partner.unwrap_or("none found".into()),
        ]
    }

    fn to_json(&self, cloud: &Cloud) -> Value {
        json!({
            "name": cloud.name,
            "points": cloud.points.len(),
            "invalid": cloud.invalid,
            "has_normals": cloud.has_normals,
            "extent": self.extent.as_slice(),
            "origin": cloud.origin.as_slice(),
            "resolution": self.resolution,
            "voxel": self.voxel,
            "problem": cloud.problem,
        })
    }
}

/// How much of each other two scans see, by a motion between them alone.
struct Overlap {
    i: usize,
    j: usize,
    /// Share of the points of the smaller part: the mean of both shares.
    share: f64,
}

impl Overlap {
    fn to_json(&self) -> Value {
        json!({ "i": self.i, "j": self.j, "share": self.share })
    }
}

/// Guesses for the pairs that a registration selects, whatever the rest of the scans says of them.
fn overlaps(
    input: &DescribedScans,
    config: &Config,
    progress: &Progress,
) -> Result<Vec<Overlap>, Failure> {
    let voxel = input.voxel.size;
    let registration = register_observed(&input.scans, &config.params(voxel), progress)
        .map_err(Failure::of_registration)?;
    let trees: Result<Vec<_>, Failure> = input.scans.iter().map(search_tree).collect();
    let trees = trees?;
    let overlap = |edge: &gmpcr::posegraph::PoseEdge| {
        let [points_i, points_j] = [edge.i, edge.j].map(|scan| input.scans[scan].points());
        let share_i = share_near(points_i, &trees[edge.j], &edge.i_from_j.inverse(), voxel);
        let share_j = share_near(points_j, &trees[edge.i], &edge.i_from_j, voxel);
        Overlap {
            i: edge.i,
            j: edge.j,
            share: 0.5 * (share_i + share_j),
        }
    };
    let edges = registration.graph.edges();
    let (overlaps, _) = progress.stage("overlap", edges.len(), || {
        let overlaps = edges.par_iter().map(|edge| progress.item(|| overlap(edge)));
        overlaps.collect()
    })?;
    Ok(overlaps)
}

type SearchTree = Option<ImmutableKdTree<f64, 3>>;

fn search_tree(scan: &Scan) -> Result<SearchTree, Failure> {
    let points: Vec<[f64; 3]> = scan
        .points()
        .iter()
        .map(|point| point.coords.into())
        .collect();
    if points.is_empty() {
        return Ok(None);
    }
    let tree = ImmutableKdTree::new_from_slice(&points);
    tree.map(Some)
        .map_err(|error| format!("no search tree of {} points: {error:?}", points.len()).into())
}

/// Share of the points that, moved, have a neighbour within a voxel's diagonal.
fn share_near(
    points: &[Point3<f64>],
    tree: &SearchTree,
    motion: &Isometry3<f64>,
    voxel: f64,
) -> f64 {
    let Some(tree) = tree else { return 0.0 };
    let is_near = |point: &&Point3<f64>| {
        let query: [f64; 3] = (motion * **point).coords.into();
        let nearest = tree
            .query(&query)
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        nearest.distance <= 3.0 * voxel * voxel
    };
    points.iter().filter(is_near).count() as f64 / points.len().max(1) as f64
}
