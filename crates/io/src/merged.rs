//! Registered scans in one colored cloud, for viewers.

use std::io::{self, Seek, Write};
use std::path::Path;

use nalgebra::{Isometry3, Point3};

use crate::Error;
use crate::atomic::write_atomically;

/// How coordinates are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Coordinates {
    /// As `float`, rounded to 24 bits: 12 bytes a point. Half a meter is lost at 8 million meters
    /// from the origin, such as a northing in UTM.
    Single,
    /// As `double`, as they are: 24 bytes a point. For clouds far from the origin. Viewers may round
    /// them nevertheless.
    Double,
}

/// A cloud that becomes a part of a merged one.
///
/// `Points` is a slice, a vector or a `Cow` of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColoredCloud<Points> {
    /// The points, in their own frame.
    pub points: Points,
    /// The transformation into the frame of the merged cloud.
    pub world_from_points: Isometry3<f64>,
    /// Red, green and blue of all points.
    pub color: [u8; 3],
}

/// Writes clouds into one PLY file, each transformed into the common frame and in its color.
///
/// A point `p` of a cloud becomes `world_from_points * p`. Points are written one by one, so
/// `clouds` may compute each cloud when it is asked for. The file is binary little-endian with
/// `x y z` as `coordinates` says and `uchar red green blue`.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{ColoredCloud, Coordinates, distinct_color, read_ply, write_merged_ply};
/// use nalgebra::{Isometry3, Point3};
///
/// let scan = vec![Point3::new(0.0, 0.0, 1.0), Point3::new(0.5, 0.0, 1.0)];
/// let world_from_scan = [Isometry3::identity(), Isometry3::translation(2.0, 0.0, 0.0)];
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("merged.ply");
/// let clouds = world_from_scan.iter().enumerate().map(|(k, pose)| ColoredCloud {
///     points: &scan,
///     world_from_points: *pose,
///     color: distinct_color(k),
/// });
/// write_merged_ply(&path, Coordinates::Single, clouds)?;
///
/// let merged = read_ply(&path)?.points;
/// assert_eq!(merged.len(), 4);
/// assert_eq!(merged[3], Point3::new(2.5, 0.0, 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_merged_ply<Points: AsRef<[Point3<f64>]>>(
    path: impl AsRef<Path>,
    coordinates: Coordinates,
    clouds: impl IntoIterator<Item = ColoredCloud<Points>>,
) -> Result<(), Error> {
    write_atomically(path.as_ref(), |file| {
        file.write_all(header(0, coordinates).as_bytes())?;
        let mut num_points = 0;
        for cloud in clouds {
            for point in cloud.points.as_ref() {
                write_point(file, &(cloud.world_from_points * point), coordinates)?;
                file.write_all(&cloud.color)?;
                num_points += 1;
            }
        }
        file.rewind()?;
        file.write_all(header(num_points, coordinates).as_bytes())
    })
}

fn write_point(
    file: &mut impl Write,
    point: &Point3<f64>,
    coordinates: Coordinates,
) -> io::Result<()> {
    for coordinate in point.iter() {
        match coordinates {
            Coordinates::Single => file.write_all(&(*coordinate as f32).to_le_bytes())?,
            Coordinates::Double => file.write_all(&coordinate.to_le_bytes())?,
        }
    }
    Ok(())
}

/// The header. A comment fills it up to the same length for every count.
fn header(num_points: u64, coordinates: Coordinates) -> String {
    let kind = match coordinates {
        Coordinates::Single => "float",
        Coordinates::Double => "double",
    };
    let count = num_points.to_string();
    let slack = ".".repeat(20usize.saturating_sub(count.len()));
    format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment registered scans {slack}\n\
         element vertex {count}\n\
         property {kind} x\n\
         property {kind} y\n\
         property {kind} z\n\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n\
         end_header\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_header_is_equally_long_for_any_count() {
        for kind in [Coordinates::Single, Coordinates::Double] {
            for count in [0, 9, 10, 123_456, u64::MAX] {
                assert_eq!(header(count, kind).len(), header(0, kind).len());
            }
        }
    }

    fn cloud(points: Vec<Point3<f64>>, color: [u8; 3]) -> ColoredCloud<Vec<Point3<f64>>> {
        ColoredCloud {
            points,
            world_from_points: Isometry3::identity(),
            color,
        }
    }

    #[test]
    fn points_and_colors_stand_where_the_header_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("merged.ply");
        let points = |n: usize| vec![Point3::new(1.0, -2.0, 0.5); n];
        let clouds = [
            cloud(points(11), [1, 2, 3]),
            cloud(points(0), [4; 3]),
            cloud(points(1), [7, 8, 9]),
        ];
        write_merged_ply(&path, Coordinates::Single, clouds).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert_eq!(bytes.len(), header(12, Coordinates::Single).len() + 12 * 15);
        assert!(bytes.starts_with(header(12, Coordinates::Single).as_bytes()));
        let last = &bytes[bytes.len() - 15..];
        assert_eq!(last[..4], 1.0f32.to_le_bytes());
        assert_eq!(last[4..8], (-2.0f32).to_le_bytes());
        assert_eq!(last[12..], [7, 8, 9]);
        assert_eq!(crate::read_ply(&path).unwrap().points, points(12));
    }

    #[test]
    fn each_cloud_is_transformed_into_the_common_frame() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("merged.ply");
        let points = vec![Point3::new(1.0, -2.0, 0.5), Point3::new(7e6, 0.1, 3.0)];
        let pose = |k: f64| Isometry3::new([k, 2.0 * k, 3.0].into(), [0.1 * k, 0.5, -k].into());
        let poses = [pose(1.0), pose(-2.0)];
        let clouds = poses.iter().map(|pose| ColoredCloud {
            world_from_points: *pose,
            ..cloud(points.clone(), [1, 2, 3])
        });
        write_merged_ply(&path, Coordinates::Double, clouds).unwrap();
        let moved = poses
            .iter()
            .flat_map(|pose| points.iter().map(move |point| pose * point));
        let moved: Vec<_> = moved.collect();
        assert_eq!(crate::read_ply(&path).unwrap().points, moved);
    }

    #[test]
    fn coordinates_far_from_the_origin_keep_their_millimeters_as_double() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("merged.ply");
        let points = vec![Point3::new(672_345.123, 5_194_876.547, 561.009)];
        for (kind, keeps) in [(Coordinates::Double, true), (Coordinates::Single, false)] {
            write_merged_ply(&path, kind, [cloud(points.clone(), [1, 2, 3])]).unwrap();
            assert_eq!(crate::read_ply(&path).unwrap().points == points, keeps);
        }
    }
}
