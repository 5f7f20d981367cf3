//! Scans from files: what of them can be read, each near the origin of its own coordinates.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use gmpcr::nalgebra::{Isometry3, Point3, Translation3, Vector3};
use gmpcr_io::{PointFile, read_points, scan_files};
use rayon::prelude::*;

use crate::outcome::Failure;
use crate::progress::Progress;

/// A scan as it was read.
pub struct Cloud {
    /// Its file, and its name within one that holds several.
    pub name: String,
    /// Points less the origin.
    pub points: Vec<Point3<f64>>,
    /// Where coordinates are counted from: zero, but for scans that lie far from it. Numbers of seven
    /// digits before the point have none left behind it in single precision.
    pub origin: Vector3<f64>,
    /// Where the sensor stood, less the origin.
    pub viewpoint: Point3<f64>,
    /// Points without a position.
    pub invalid: usize,
    pub has_normals: bool,
    /// Why the file could not be read.
    pub problem: Option<String>,
}

impl Cloud {
    pub fn new(name: String, file: PointFile) -> Self {
        let origin = origin_of(&file.points);
        let mut points = file.points;
        for point in &mut points {
            *point -= origin;
        }
        let viewpoint = file.viewpoint.map(|viewpoint| viewpoint - origin);
        let viewpoint = viewpoint.unwrap_or_else(|| likely_viewpoint(&origin));
        Self {
            name,
            points,
            origin,
            viewpoint,
            invalid: file.invalid,
            has_normals: file.has_normals,
            problem: None,
        }
    }

    fn unreadable(name: String, problem: String) -> Self {
        Self {
            problem: Some(problem),
            ..Self::new(name, PointFile::default())
        }
    }

    /// From the coordinates of `points` to those of the file.
    pub fn file_from_points(&self) -> Isometry3<f64> {
        Translation3::from(self.origin).into()
    }
}

/// How many times farther than its points from each other a cloud must lie from zero to count as
/// georeferenced.
const FAR: f64 = 100.0;

/// The point to count coordinates from: the median of the coordinates, if the cloud lies far from
/// zero for its size, and zero else.
fn origin_of(points: &[Point3<f64>]) -> Vector3<f64> {
    let median = |values: &mut Vec<f64>| {
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    if points.is_empty() {
        return Vector3::zeros();
    }
    let center = Vector3::from_fn(|axis, _| {
        let mut values: Vec<_> = points.iter().map(|point| point[axis]).collect();
        median(&mut values)
    });
    let mut distances: Vec<_> = points.iter().map(|p| (p.coords - center).norm()).collect();
    match center.norm() > FAR * median(&mut distances) {
        true => center,
        false => Vector3::zeros(),
    }
}

/// Where the sensor stood, as far as normals are concerned, in a file that does not tell: at the zero
/// point of the scan, but for georeferenced scans. Those share their axes, so a point far above and to
/// a side that is no wall's orients the normals of a surface alike in all of them.
fn likely_viewpoint(origin: &Vector3<f64>) -> Point3<f64> {
    Point3::from(Vector3::new(0.3, 0.5, 0.8) * origin.norm())
}

/// The files of folders and files, in order. What `gmpcr register` has written into a folder of scans is no
/// scan.
pub fn files_of(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for input in inputs {
        if input.is_dir() {
            let mut scans = scan_files(input)?;
            if input.join("result.json").exists() {
                scans.retain(|file| !file.ends_with("merged.ply"));
            }
            files.extend(scans);
        } else if input.exists() {
            files.push(input.clone());
        } else {
            return Err(format!(
                "{} does not exist: a folder or file of scans is needed",
                input.display()
            )
            .into());
        }
    }
    Ok(files)
}

/// Reads all scans. One that cannot be read is a cloud without points and with the reason.
pub fn read_clouds(files: &[PathBuf], progress: &Progress) -> Result<Vec<Cloud>, Failure> {
    let read = |file: &PathBuf| progress.item(|| read_file(file));
    let clouds: Result<Vec<_>, Failure> = files.par_iter().map(read).collect();
    let mut clouds: Vec<Cloud> = clouds?.into_iter().flatten().collect();
    make_names_differ(&mut clouds, files);
    for cloud in &clouds {
        if let Some(problem) = &cloud.problem {
            progress.say(&format!("left out: {problem}; mend or remove the file"));
        }
        if cloud.invalid > 0 {
            progress.say(&format!(
                "{}: {} points without a position left out",
                cloud.name, cloud.invalid
            ));
        }
    }
    Ok(clouds)
}

fn read_file(file: &Path) -> Vec<Cloud> {
    let name = file.file_name().unwrap_or(file.as_os_str());
    let name = name.to_string_lossy().into_owned();
    match read_parts(file, &name) {
        Ok(clouds) => clouds,
        Err(error) => vec![Cloud::unreadable(name, error.to_string())],
    }
}

/// The scans of a file: one, but for E57.
fn read_parts(file: &Path, name: &str) -> Result<Vec<Cloud>, gmpcr_io::Error> {
    #[cfg(feature = "e57")]
    if file
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("e57"))
    {
        let scans = gmpcr_io::read_e57(file)?;
        let is_one = scans.len() == 1;
        let clouds = scans.into_iter().enumerate().map(|(k, scan)| {
            let part = scan.name.unwrap_or_else(|| k.to_string());
            let name = if is_one {
                name.to_owned()
            } else {
                format!("{name}:{part}")
            };
            Cloud::new(name, scan.points)
        });
        return Ok(clouds.collect());
    }
    Ok(vec![Cloud::new(name.to_owned(), read_points(file)?)])
}

/// Where file names are the same in several folders, whole paths are the names.
fn make_names_differ(clouds: &mut [Cloud], files: &[PathBuf]) {
    let names: HashSet<_> = clouds.iter().map(|cloud| &cloud.name).collect();
    if names.len() == clouds.len() {
        return;
    }
    let one_each = files.len() == clouds.len();
    for (k, cloud) in clouds.iter_mut().enumerate() {
        cloud.name = match one_each {
            true => files[k].display().to_string(),
            false => format!("{}#{k}", cloud.name),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(center: [f64; 3], size: f64) -> Vec<Point3<f64>> {
        let corner = |k: usize| Vector3::from_fn(|axis, _| ((k >> axis) & 1) as f64 * size);
        (0..8).map(|k| Point3::from(center) + corner(k)).collect()
    }

    #[test]
    fn only_clouds_far_from_zero_for_their_size_have_an_origin() {
        assert_eq!(origin_of(&[]), Vector3::zeros());
        assert_eq!(origin_of(&cube([3.0, 0.0, 40.0], 5.0)), Vector3::zeros());
        let utm = cube([448_262.0, 5_411_932.0, 120.0], 5.0);
        let origin = origin_of(&utm);
        assert!((origin - utm[0].coords).norm() < 10.0);
    }

    #[test]
    fn points_and_viewpoint_are_counted_from_the_origin() {
        let points = cube([448_262.0, 5_411_932.0, 120.0], 5.0);
        let mut file = PointFile::default();
        file.points.clone_from(&points);
        file.viewpoint = Some(points[0]);
        let cloud = Cloud::new("utm".into(), file);
        assert!(cloud.points.iter().all(|point| point.coords.norm() < 10.0));
        let back = cloud.file_from_points();
        assert_eq!(back * cloud.points[7], points[7]);
        assert_eq!(back * cloud.viewpoint, points[0]);
    }
}
