//! Result files.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use gmpcr::nalgebra::{Isometry3, Matrix6, Point3, Vector6};
use gmpcr::{EdgeEvidence, Params, Registration};
use gmpcr_io::{
    Coordinates, G2o, G2oEdge, G2oVertex, distinct_color, write_g2o, write_merged_ply, write_poses_tum,
};

/// Writes all result files; returns how many scans `merged.ply`, `poses.tum` and `posegraph.g2o` hold.
pub fn write_results(
    folder: &Path,
    clouds: &[Vec<Point3<f64>>],
    registration: &Registration,
    params: &Params,
) -> Result<usize, Box<dyn Error>> {
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
    };
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    write("poses.txt", poses_text(registration))?;
    write("edges.csv", edges_text(registration))?;

    let scans = largest_component(registration);
    let moved = |&scan: &usize| {
        let world_from_scan = registration.world_from_scan[scan];
        let points = clouds[scan].iter();
        (
            points.map(move |point| world_from_scan * point),
            distinct_color(scan),
        )
    };
    write_merged_ply(
        folder.join("merged.ply"),
        Coordinates::Single,
        scans.iter().map(moved),
    )?;
    let stamped = |&scan: &usize| (scan as f64, registration.world_from_scan[scan]);
    let stamped: Vec<_> = scans.iter().map(stamped).collect();
    write_poses_tum(folder.join("poses.tum"), &stamped)?;
    write_g2o(
        folder.join("posegraph.g2o"),
        &pose_graph(registration, scans, params),
    )?;
    Ok(scans.len())
}

/// The scans of the largest component (the first of equal ones): one frame, one picture.
fn largest_component(registration: &Registration) -> &[usize] {
    let components = registration.components.members().iter();
    let largest = components.rev().max_by_key(|scans| scans.len());
    largest.map_or(&[], Vec::as_slice)
}

/// `index component` and the 12 row-major numbers of the pose, a line per scan that shares a frame with
/// another.
fn poses_text(registration: &Registration) -> String {
    let mut text = String::new();
    let scans = 0..registration.world_from_scan.len();
    for scan in scans.filter(|&scan| registration.is_registered(scan)) {
        let component = registration.components.label(scan);
        let numbers = row_major(&registration.world_from_scan[scan], " ");
        let _ = writeln!(text, "{scan} {component} {numbers}");
    }
    text
}

fn edges_text(registration: &Registration) -> String {
    let mut text = String::from(
        "i,j,confidence,inlier_ratio,cliques_seen,initial_weight,final_weight,residual_degrees,\
         r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz\n",
    );
    for (evidence, edge) in registration.evidence.iter().zip(registration.graph.edges()) {
        let &EdgeEvidence {
            i,
            j,
            confidence,
            inlier_ratio,
            cliques_seen,
            initial_weight,
            final_weight,
            rotation_residual,
            ..
        } = evidence;
        let residual =
            rotation_residual.map_or(String::new(), |angle| angle.to_degrees().to_string());
        let numbers = row_major(&edge.i_from_j, ",");
        let _ = writeln!(
            text,
            "{i},{j},{confidence},{inlier_ratio},{cliques_seen},{initial_weight},{final_weight},{residual},{numbers}"
        );
    }
    text
}

fn row_major(motion: &Isometry3<f64>, separator: &str) -> String {
    let matrix = motion.to_matrix();
    let rows = matrix.fixed_rows::<3>(0).transpose();
    let numbers: Vec<String> = rows.iter().map(f64::to_string).collect();
    numbers.join(separator)
}

/// The edges among `scans`, with the final poses as vertices. Information: an inlier threshold of
/// translation or a residual scale of rotation counts as one sigma of the edge of largest final weight;
/// g2o measures a rotation by the vector part of its quaternion, half of the angle. Edges of less than a
/// millionth of that weight are left out.
fn pose_graph(registration: &Registration, scans: &[usize], params: &Params) -> G2o {
    let final_weights = registration.evidence.iter().map(|edge| edge.final_weight);
    let largest = final_weights.fold(f64::MIN_POSITIVE, f64::max);
    let sigmas = [
        params.cliques.inlier_threshold,
        params.sync.residual_scale / 2.0,
    ];
    let [t, r] = sigmas.map(|sigma| 1.0 / (sigma * sigma));
    let unit = Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r));
    let weighted = registration.evidence.iter().zip(registration.graph.edges());
    let counts = |evidence: &EdgeEvidence| {
        scans.binary_search(&evidence.i).is_ok() && evidence.final_weight > 1e-6 * largest
    };
    let edges = weighted.filter(|(evidence, _)| counts(evidence));
    let vertex = |&id: &usize| G2oVertex {
        id,
        world_from_vertex: registration.world_from_scan[id],
    };
    G2o {
        vertices: scans.iter().map(vertex).collect(),
        edges: edges
            .map(|(evidence, edge)| G2oEdge {
                i: edge.i,
                j: edge.j,
                i_from_j: edge.i_from_j,
                information: unit * (evidence.final_weight / largest),
            })
            .collect(),
    }
}
