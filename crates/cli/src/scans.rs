//! Scans from files: what of them can be read, each near the origin of its own coordinates.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use gmpcr::nalgebra::{Isometry3, Point3, Translation3, Vector3};
use gmpcr_io::{PointFile, read_points, scan_files};
use rayon::prelude::*;

use crate::outcome::Failure;
use crate::progress::Progress;
use crate::table::counted;

/// A scan as it was read.
pub struct Cloud {
    /// Name of its file, and its own within one that holds several.
    pub name: String,
    pub file: PathBuf,
    /// Points less the origin.
    pub points: Vec<Point3<f64>>,
    /// Where coordinates are counted from: zero, but for georeferenced scans. Numbers of seven digits
    /// before the point have none left behind it in single precision.
    pub origin: Vector3<f64>,
    /// Where the sensor stood, less the origin.
    pub viewpoint: Point3<f64>,
    /// Points without a position.
    pub invalid: usize,
    pub has_normals: bool,
    /// Why it cannot be used.
    pub problem: Option<String>,
}

impl Cloud {
    pub fn new(name: &str, file: &Path, content: PointFile) -> Self {
        Self {
            name: name.replace(char::is_control, "\u{fffd}"),
            file: file.to_owned(),
            points: content.points,
            origin: Vector3::zeros(),
            viewpoint: content.viewpoint.unwrap_or_else(Point3::origin),
            invalid: content.invalid,
            has_normals: content.has_normals,
            problem: None,
        }
    }

    fn unreadable(name: &str, file: &Path, problem: String) -> Self {
        Self {
            problem: Some(problem),
            ..Self::new(name, file, PointFile::default())
        }
    }

    /// From the coordinates of `points` to those of the file.
    pub fn file_from_points(&self) -> Isometry3<f64> {
        Translation3::from(self.origin).into()
    }

    /// Leaves out points that are farther from the median point than a million voxels: sensors that write
    /// a huge number where nothing returned. Returns how many.
    pub fn drop_strays(&mut self, voxel: f64) -> usize {
        let before = self.points.len();
        let center = median_point(&self.points);
        self.points
            .retain(|point| (point - center).norm() < 1e6 * voxel);
        before - self.points.len()
    }

    /// How far the cloud lies from zero, relative to its size.
    fn remoteness(&self) -> f64 {
        let center = median_point(&self.points);
        let mut distances: Vec<_> = self
            .points
            .iter()
            .map(|point| (point - center).norm())
            .collect();
        center.coords.norm() / median(&mut distances).max(f64::MIN_POSITIVE)
    }

    /// Counts coordinates from the median point. Georeferenced files do not tell where the sensor
    /// stood, and zero is no guess; but they have their axes in common. So a viewpoint far above and to a
    /// side that is no wall's gives a surface the same normals in all of them.
    fn localize(&mut self) {
        self.origin = median_point(&self.points).coords;
        for point in &mut self.points {
            *point -= self.origin;
        }
        self.viewpoint = match self.viewpoint == Point3::origin() {
            true => Point3::from(Vector3::new(0.3, 0.5, 0.8) * self.origin.norm()),
            false => self.viewpoint - self.origin,
        };
    }
}

/// The upper median; 0 of nothing.
fn median(values: &mut [f64]) -> f64 {
    match values.len() {
        0 => 0.0,
        n => *values.select_nth_unstable_by(n / 2, f64::total_cmp).1,
    }
}

/// The point of the median coordinates.
fn median_point(points: &[Point3<f64>]) -> Point3<f64> {
    Vector3::from_fn(|axis, _| {
        let mut values: Vec<_> = points.iter().map(|point| point[axis]).collect();
        median(&mut values)
    })
    .into()
}

/// Shifts scans to zero if most of them lie a thousand times farther from it than they are large.
pub fn localize_georeferenced(clouds: &mut [Cloud]) {
    const REMOTE: f64 = 1000.0;
    let filled = || clouds.iter().filter(|cloud| !cloud.points.is_empty());
    let remote = filled().filter(|cloud| cloud.remoteness() > REMOTE).count();
    if 2 * remote > filled().count() {
        clouds.iter_mut().for_each(Cloud::localize);
    }
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
            let reason = "there is no such folder or file of scans";
            return Err(Failure::of(input, reason));
        }
    }
    Ok(files)
}

/// Reads all scans. One that cannot be read is a cloud without points and with the reason.
pub fn read_clouds(files: &[PathBuf], progress: &Progress) -> Result<Vec<Cloud>, Failure> {
    let read = |file: &PathBuf| progress.item(|| read_file(file));
    let clouds: Result<Vec<_>, Failure> = files.par_iter().map(read).collect();
    let mut clouds: Vec<Cloud> = clouds?.into_iter().flatten().collect();
    make_names_differ(&mut clouds);
    for cloud in &clouds {
        if let Some(problem) = &cloud.problem {
            progress.say(&format!("left out: {problem}; mend or remove the file"));
        }
        if cloud.invalid > 0 {
            let invalid = counted(cloud.invalid, "point");
            progress.say(&format!(
                "{}: {invalid} without a position left out",
                cloud.name
            ));
        }
    }
    Ok(clouds)
}

fn read_file(file: &Path) -> Vec<Cloud> {
    let name = file.file_name().unwrap_or(file.as_os_str());
    let name = name.to_string_lossy();
    read_parts(file, &name)
        .unwrap_or_else(|error| vec![Cloud::unreadable(&name, file, error.to_string())])
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
            match is_one {
                true => Cloud::new(name, file, scan.points),
                false => Cloud::new(&format!("{name}:{part}"), file, scan.points),
            }
        });
        return Ok(clouds.collect());
    }
    Ok(vec![Cloud::new(name, file, read_points(file)?)])
}

/// Where names are not unique, as those of files of several folders, the number of the scan is added.
fn make_names_differ(clouds: &mut [Cloud]) {
    let names: HashSet<_> = clouds.iter().map(|cloud| &cloud.name).collect();
    if names.len() < clouds.len() {
        for (k, cloud) in clouds.iter_mut().enumerate() {
            cloud.name = format!("{}#{k}", cloud.name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UTM: [f64; 3] = [448_262.0, 5_411_932.0, 120.0];

    /// The corners of a cube of 5 m.
    fn cube(corner: [f64; 3]) -> Cloud {
        let mut content = PointFile::default();
        let place = |k: usize| Vector3::from_fn(|axis, _| ((k >> axis) & 1) as f64 * 5.0);
        content.points = (0..8).map(|k| Point3::from(corner) + place(k)).collect();
        Cloud::new("cube", Path::new("cube.las"), content)
    }

    #[test]
    fn georeferenced_scans_are_counted_from_an_origin_of_their_own() {
        let mut clouds = [cube(UTM), cube([448_300.0, 5_411_932.0, 120.0])];
        let before = clouds[0].points.clone();
        localize_georeferenced(&mut clouds);
        assert!(
            clouds[1]
                .points
                .iter()
                .all(|point| point.coords.norm() < 10.0)
        );
        assert_ne!(clouds[0].origin, clouds[1].origin);
        assert_eq!(
            clouds[0].file_from_points() * clouds[0].points[7],
            before[7]
        );
    }

    #[test]
    fn one_far_scan_among_others_changes_nothing() {
        let mut clouds = [cube([3.0, 0.0, 40.0]), cube([0.0; 3]), cube(UTM)];
        localize_georeferenced(&mut clouds);
        assert!(clouds.iter().all(|cloud| cloud.origin == Vector3::zeros()));
        localize_georeferenced(&mut []);
    }

    #[test]
    fn a_known_viewpoint_moves_with_the_points() {
        let mut cloud = cube(UTM);
        cloud.viewpoint = cloud.points[0];
        cloud.localize();
        assert_eq!(cloud.viewpoint, cloud.points[0]);
    }

    #[test]
    fn huge_coordinates_are_strays_and_names_stay_on_their_line() {
        let mut content = PointFile::default();
        content.points = cube([0.0; 3]).points;
        content
            .points
            .push(Point3::new(f64::from(f32::MAX), 0.0, 0.0));
        let mut cloud = Cloud::new("a\nb", Path::new("a\nb"), content);
        assert_eq!((cloud.drop_strays(0.05), cloud.points.len()), (1, 8));
        assert_eq!(cloud.name, "a\u{fffd}b");
    }
}
