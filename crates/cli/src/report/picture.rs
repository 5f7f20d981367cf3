//! The scans as the picture of the report has them: few points, upright, on a grid.

use std::f64::consts::FRAC_PI_2;

use gmpcr::features::LocalCloud;
use gmpcr::nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use gmpcr::posegraph::Components;

/// Points of a scan in the picture, at most.
const MOST_POINTS: usize = 5_000;

/// Points on a grid of 2^16 steps in the box of their component.
pub struct Picture {
    /// `x y z` of the points of each scan.
    pub positions: Vec<Vec<u16>>,
    /// Of each component.
    pub boxes: Vec<GridBox>,
    /// From each scan to the picture.
    pub poses: Vec<Isometry3<f64>>,
}

/// `world = origin + step · position`.
pub struct GridBox {
    pub origin: Vector3<f64>,
    pub step: f64,
}

impl Picture {
    /// `world_from_local` are the poses of the clouds.
    pub fn new(
        clouds: &[LocalCloud],
        world_from_local: &[Isometry3<f64>],
        components: &Components,
    ) -> Self {
        let poses = upright_poses(clouds, world_from_local, components);
        let clouds = clouds.iter().zip(&poses);
        let clouds: Vec<_> = clouds
            .map(|(cloud, pose)| shown(&cloud.points, pose))
            .collect();
        let members = components.members().iter();
        let of_component = |scans: &Vec<usize>| {
            let bounds = scans
                .iter()
                .filter_map(|&scan| Bounds::of_bulk(&clouds[scan]));
            GridBox::of(bounds.reduce(Bounds::union))
        };
        let boxes: Vec<_> = members.map(of_component).collect();
        let positions = clouds.iter().enumerate().map(|(scan, points)| {
            let grid = &boxes[components.label(scan)];
            points
                .iter()
                .filter_map(|point| grid.position(point))
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

/// The poses, with z upwards: the user rotates the picture about z.
///
/// The world has the axes of its first scan. Laser scans have their z upwards, cameras their y
/// downwards and z to the front.
fn upright_poses(
    clouds: &[LocalCloud],
    world_from_local: &[Isometry3<f64>],
    components: &Components,
) -> Vec<Isometry3<f64>> {
    let mut poses = world_from_local.to_vec();
    for scans in components.members() {
        if is_of_camera(&clouds[scans[0]].points) {
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
        let grid = GridBox::of(Bounds::of_bulk(&points));
        assert!(grid.step < 1e-3);
        for point in &points[..500] {
            let [x, y, z] = grid.position(point).unwrap().map(f64::from);
            let back = grid.origin + Vector3::new(x, y, z) * grid.step;
            assert!((back - point.coords).norm() < grid.step);
        }
        assert_eq!(grid.position(&points[500]), None);
    }

    #[test]
    fn a_misplaced_scan_stays_in_the_picture() {
        let [many, one] = [wall(0.0), wall(90.0)].map(|points| Bounds::of_bulk(&points));
        let grid = GridBox::of(many.into_iter().chain(one).reduce(Bounds::union));
        assert!(
            wall(90.0)
                .iter()
                .all(|point| grid.position(point).is_some())
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
        let place = |k: i32| (f64::from(k % 10) - 4.5, f64::from(k / 10) - 4.5);
        let wall: Vec<_> = (0..100)
            .map(place)
            .map(|(x, y)| Point3::new(x, y, 8.0))
            .collect();
        let floor: Vec<_> = wall.iter().map(|p| Point3::new(p.x, p.y, -1.5)).collect();
        assert!(is_of_camera(&wall));
        assert!(!is_of_camera(&floor));
    }
}
