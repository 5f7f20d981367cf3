//! `report.html`: one file that shows the result in any browser.

use std::f64::consts::FRAC_PI_2;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gmpcr::nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use gmpcr_io::distinct_color;
use serde_json::{Value, json};

use gmpcr::geometry::matrix_rows::rows;
use gmpcr::{Edge, Warning};

use crate::output::Output;
use crate::warnings::Notice;

/// Points of a scan in the picture, at most.
const MOST_POINTS: usize = 5_000;

/// The page, with everything that it needs inside.
pub fn report_html(output: &Output) -> String {
    // A name may hold "</script>", but within a JSON string `<` may also be written like this.
    let data = data(output).to_string().replace('<', "\\u003c");
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

fn data(output: &Output) -> Value {
    let result = output.result;
    let picture = Picture::new(output);
    let registration = output.registration();
    let components = registration.components.members().iter().zip(&picture.boxes);
    let components = components.map(|(scans, part)| {
        json!({ "scans": scans, "origin": part.origin.as_slice(), "step": part.step })
    });
    let confidences = &registration.confidences;
    let scored = confidences.pairs().iter().zip(confidences.normalized());
    let scored = scored.map(|(pair, s)| json!([pair.i, pair.j, rounded(*s)]));
    json!({
        "title": output.title,
        "version": format!("gmpcr {}", result.version),
        "features": result.features,
        "voxel_size": result.voxel_size,
        "voxel_is_estimated": result.voxel_is_estimated,
        "scans": scans(output, &picture),
        "components": components.collect::<Vec<_>>(),
        "poses": picture.poses.iter().map(rows).collect::<Vec<_>>(),
        "edges": registration.edges.iter().map(edge).collect::<Vec<_>>(),
        "unresolved": registration.unresolved,
        "scored_pairs": scored.collect::<Vec<_>>(),
        "stages": result.stages,
        "warnings": result.warnings.iter().map(|notice| warning(notice, output)).collect::<Vec<_>>(),
    })
}

fn scans(output: &Output, picture: &Picture) -> Value {
    let registration = output.registration();
    let mut has_warning = vec![false; registration.ids.len()];
    for notice in &output.result.warnings {
        if !matches!(notice.warning, Warning::Contradiction { .. }) {
            for scan in notice.warning.scans(registration) {
                has_warning[scan] = true;
            }
        }
    }
    let scans = output.result.scans.iter().enumerate().map(|(k, scan)| {
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

fn warning(notice: &Notice, output: &Output) -> Value {
    let registration = output.registration();
    let edge = notice.warning.edge().map(|edge| {
        let Edge { i, j, .. } = registration.edges[edge];
        [i, j]
    });
    json!({
        "kind": kind(&notice.warning),
        "scans": notice.warning.scans(registration),
        "edge": edge,
        "text": notice.text,
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

/// Points on a grid of 2^16 steps in the box of their component.
struct Picture {
    /// `x y z` of the points of each scan.
    positions: Vec<Vec<u16>>,
    boxes: Vec<GridBox>,
    /// From each scan to the picture.
    poses: Vec<Isometry3<f64>>,
}

/// `world = origin + step · position`.
struct GridBox {
    origin: Vector3<f64>,
    step: f64,
}

impl Picture {
    fn new(output: &Output) -> Self {
        let registration = output.registration();
        let poses = upright_poses(output);
        let clouds = output.input.set.clouds.iter().zip(&poses);
        let clouds: Vec<_> = clouds
            .map(|(cloud, pose)| shown(&cloud.points, pose))
            .collect();
        let members = registration.components.members().iter();
        let of_component = |scans: &Vec<usize>| {
            let bounds = scans
                .iter()
                .filter_map(|&scan| Bounds::of_bulk(&clouds[scan]));
            GridBox::of(bounds.reduce(Bounds::union))
        };
        let boxes: Vec<_> = members.map(of_component).collect();
        let positions = clouds.iter().enumerate().map(|(scan, points)| {
            let part = &boxes[registration.components.label(scan)];
            points
                .iter()
                .filter_map(|point| part.position(point))
                .flatten()
                .collect()
        });
        Self {
            positions: positions.collect(),
            boxes,
            poses,
        }
    }
}

/// The poses, with z upwards: the picture turns about z.
///
/// The world has the axes of its first scan. Laser scans have their z upwards, cameras their y
/// downwards and z to the front.
fn upright_poses(output: &Output) -> Vec<Isometry3<f64>> {
    let mut poses = output.world_from_local.to_vec();
    for scans in output.registration().components.members() {
        if is_of_camera(&output.input.set.clouds[scans[0]].points) {
            let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2);
            for &scan in scans {
                poses[scan] = upright * poses[scan];
            }
        }
    }
    poses
}

/// Whether points lie in a cone before a camera: all but a hundredth within 56° of the z axis.
fn is_of_camera(points: &[Point3<f64>]) -> bool {
    let inside = points
        .iter()
        .filter(|point| point.x.hypot(point.y) < 1.5 * point.z);
    100 * inside.count() > 99 * points.len()
}

/// Some of the points of a scan, evenly over the file, in the picture.
fn shown(points: &[Point3<f64>], pose: &Isometry3<f64>) -> Vec<Point3<f64>> {
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    points
        .iter()
        .step_by(stride)
        .map(|point| pose * point)
        .collect()
}

/// A box along the axes.
struct Bounds {
    min: Vector3<f64>,
    max: Vector3<f64>,
}

impl Bounds {
    /// The box of a scan without what lies farther off than the bulk of its points is wide: a stray
    /// return must not make the picture coarse.
    fn of_bulk(points: &[Point3<f64>]) -> Option<Self> {
        let mut bounds = Self {
            min: points.first()?.coords,
            max: points.first()?.coords,
        };
        for axis in 0..3 {
            let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
            values.sort_by(f64::total_cmp);
            let last = values.len() - 1;
            let cut = values.len() / 50;
            let (low, high) = (values[cut], values[last - cut]);
            bounds.min[axis] = values[0].max(2.0 * low - high);
            bounds.max[axis] = values[last].min(2.0 * high - low);
        }
        Some(bounds)
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }
}

impl GridBox {
    fn of(bounds: Option<Bounds>) -> Self {
        let (origin, extent) = bounds.map_or((Vector3::zeros(), 0.0), |bounds| {
            (bounds.min, (bounds.max - bounds.min).max())
        });
        Self {
            origin,
            step: (extent / f64::from(u16::MAX)).max(f64::MIN_POSITIVE),
        }
    }

    fn position(&self, point: &Point3<f64>) -> Option<[u16; 3]> {
        let steps = ((point.coords - self.origin) / self.step).map(f64::round);
        let inside = steps
            .iter()
            .all(|step| (0.0..=f64::from(u16::MAX)).contains(step));
        inside.then(|| steps.map(|step| step as u16).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(height: f64) -> Vec<Point3<f64>> {
        (0..500)
            .map(|k| Point3::new(f64::from(k) * 0.01, 1.0, height))
            .collect()
    }

    #[test]
    fn a_stray_point_does_not_make_the_picture_coarse() {
        let mut points = wall(-2.0);
        points.push(Point3::new(1e7, 0.0, 0.0));
        let part = GridBox::of(Bounds::of_bulk(&points));
        assert!(part.step < 1e-3);
        for point in &points[..500] {
            let [x, y, z] = part.position(point).unwrap().map(f64::from);
            let back = part.origin + Vector3::new(x, y, z) * part.step;
            assert!((back - point.coords).norm() < part.step);
        }
        assert_eq!(part.position(&points[500]), None);
    }

    #[test]
    fn a_misplaced_scan_stays_in_the_picture() {
        let [many, one] = [wall(0.0), wall(90.0)].map(|points| Bounds::of_bulk(&points));
        let part = GridBox::of(many.into_iter().chain(one).reduce(Bounds::union));
        assert!(
            wall(90.0)
                .iter()
                .all(|point| part.position(point).is_some())
        );
    }

    #[test]
    fn nothing_and_a_single_point_have_a_box() {
        assert!(GridBox::of(None).step > 0.0);
        let point = Point3::new(3.0, -1.0, 2.0);
        assert_eq!(
            GridBox::of(Bounds::of_bulk(&[point])).position(&point),
            Some([0; 3])
        );
    }

    #[test]
    fn cameras_look_along_z_and_lasers_around() {
        let grid = |k: i32| (f64::from(k % 10) - 4.5, f64::from(k / 10) - 4.5);
        let wall: Vec<_> = (0..100)
            .map(grid)
            .map(|(x, y)| Point3::new(x, y, 8.0))
            .collect();
        let floor: Vec<_> = wall.iter().map(|p| Point3::new(p.x, p.y, -1.5)).collect();
        assert!(is_of_camera(&wall));
        assert!(!is_of_camera(&floor));
    }
}
