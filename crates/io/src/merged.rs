//! Registered scans in one coloured cloud, to look at.

use std::io::{self, Seek, Write};
use std::path::Path;

use nalgebra::Point3;

use crate::Error;
use crate::atomic::write_atomically;

/// How coordinates are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// As `float`, rounded to 24 bits: 12 bytes a point. Half a metre is lost at 8 million metres
    /// from the origin, such as a northing in UTM.
    Single,
    /// As `double`, as they are: 24 bytes a point. For clouds far from the origin; viewers may round
    /// them nevertheless.
    Double,
}

/// Writes clouds into one PLY file, each in its colour.
///
/// `clouds` yields the points of a cloud, already in the common frame, with red, green and blue.
/// Points are written as they come and never gathered, so the motion into the world can be applied
/// on the way. The file is binary little-endian with `x y z` as `coordinates` says and
/// `uchar red green blue`.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written; then it is as it was before.
///
/// # Example
/// ```
/// use gmpcr_io::{Coordinates, distinct_color, read_ply, write_merged_ply};
/// use nalgebra::{Isometry3, Point3};
///
/// let scan = vec![Point3::new(0.0, 0.0, 1.0), Point3::new(0.5, 0.0, 1.0)];
/// let world_from_scan = [Isometry3::identity(), Isometry3::translation(2.0, 0.0, 0.0)];
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("merged.ply");
/// write_merged_ply(
///     &path,
///     Coordinates::Single,
///     world_from_scan.iter().enumerate().map(|(k, pose)| {
///         (scan.iter().map(move |point| pose * point), distinct_color(k))
///     }),
/// )?;
///
/// let merged = read_ply(&path)?.points;
/// assert_eq!(merged.len(), 4);
/// assert_eq!(merged[3], Point3::new(2.5, 0.0, 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_merged_ply<Clouds, Points>(
    path: impl AsRef<Path>,
    coordinates: Coordinates,
    clouds: Clouds,
) -> Result<(), Error>
where
    Clouds: IntoIterator<Item = (Points, [u8; 3])>,
    Points: IntoIterator<Item = Point3<f64>>,
{
    write_atomically(path.as_ref(), |file| {
        file.write_all(header(0, coordinates).as_bytes())?;
        let mut num_points = 0;
        for (points, color) in clouds {
            for point in points {
                write_point(file, &point, coordinates)?;
                file.write_all(&color)?;
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

/// The header, equally long for any count: a comment takes up the slack.
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

/// Red, green and blue of the `k`-th of any number of colours that are easy to tell apart.
///
/// Hue, saturation (0.4 to 1) and value (0.5 to 1) each advance by their own step and start anew at
/// their end: the steps are `1/p`, `1/p^2` and `1/p^3` of the range for `p^4 = p + 1`, the golden
/// ratio of three dimensions, which spreads any number of first colours evenly over all that are
/// neither pale nor dark (Roberts 2018, sequence R3).
///
/// # Example
/// ```
/// use gmpcr_io::distinct_color;
///
/// assert_eq!(distinct_color(0), [242, 73, 73]);
/// assert_ne!(distinct_color(1), distinct_color(2));
/// ```
pub fn distinct_color(k: usize) -> [u8; 3] {
    let advanced = |start: f64, step: f64| (start + k as f64 * step).fract();
    let hue = advanced(0.0, HUE_STEP);
    let saturation = 0.4 + 0.6 * advanced(0.5, SATURATION_STEP);
    let value = 0.5 + 0.5 * advanced(0.9, VALUE_STEP);
    // Each channel is a trapezoid over the hue.
    [5.0, 3.0, 1.0].map(|offset| {
        let place = (offset + 6.0 * hue) % 6.0;
        let darkening = place.min(4.0 - place).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation * darkening)).round() as u8
    })
}

const SATURATION_STEP: f64 = 0.819_172_513_396_164_4; // 1/p
const VALUE_STEP: f64 = 0.671_043_606_703_789_2; // 1/p^2
const HUE_STEP: f64 = 0.549_700_477_901_970_2; // 1/p^3

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

    #[test]
    fn points_and_colours_stand_where_the_header_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("merged.ply");
        let cloud = |n: usize| vec![Point3::new(1.0, -2.0, 0.5); n];
        write_merged_ply(
            &path,
            Coordinates::Single,
            [
                (cloud(11), [1, 2, 3]),
                (cloud(0), [4; 3]),
                (cloud(1), [7, 8, 9]),
            ],
        )
        .unwrap();
        let bytes = fs::read(&path).unwrap();
        assert_eq!(bytes.len(), header(12, Coordinates::Single).len() + 12 * 15);
        assert!(bytes.starts_with(header(12, Coordinates::Single).as_bytes()));
        let last = &bytes[bytes.len() - 15..];
        assert_eq!(last[..4], 1.0f32.to_le_bytes());
        assert_eq!(last[4..8], (-2.0f32).to_le_bytes());
        assert_eq!(last[12..], [7, 8, 9]);
        assert_eq!(crate::read_ply(&path).unwrap().points, cloud(12));
    }

    #[test]
    fn coordinates_far_from_the_origin_keep_their_millimetres_as_double() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("merged.ply");
        let cloud = vec![Point3::new(672_345.123, 5_194_876.547, 561.009)];
        for (kind, keeps) in [(Coordinates::Double, true), (Coordinates::Single, false)] {
            write_merged_ply(&path, kind, [(cloud.clone(), [1, 2, 3])]).unwrap();
            assert_eq!(crate::read_ply(&path).unwrap().points == cloud, keeps);
        }
    }

    /// CIE L*a*b*, in which a distance of 2 can just be noticed.
    fn lab(color: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = color.map(|channel| match f64::from(channel) / 255.0 {
            dark if dark <= 0.04045 => dark / 12.92,
            bright => ((bright + 0.055) / 1.055).powf(2.4),
        });
        let [x, y, z] = [
            (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
            0.2126 * r + 0.7152 * g + 0.0722 * b,
            (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089,
        ]
        .map(|part| match part {
            dark if dark <= 0.008856 => 7.787 * dark + 16.0 / 116.0,
            bright => bright.cbrt(),
        });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn the_first_hundred_colours_differ_clearly() {
        for (num_colors, least) in [(12, 20.0), (30, 16.0), (100, 9.0)] {
            let colors: Vec<_> = (0..num_colors).map(|k| lab(distinct_color(k))).collect();
            for (k, a) in colors.iter().enumerate() {
                for (j, b) in colors[..k].iter().enumerate() {
                    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
                    let distance = squares.sum::<f64>().sqrt();
                    assert!(distance >= least, "{j} and {k}: {distance}");
                }
            }
        }
    }

    #[test]
    fn no_colour_is_pale_or_dark() {
        for k in (0..1000).chain([usize::MAX]) {
            let color = distinct_color(k).map(f64::from);
            let most = color.iter().copied().fold(0.0, f64::max);
            let least = color.iter().copied().fold(255.0, f64::min);
            assert!(most >= 127.0 && least <= 0.61 * most, "{color:?}");
        }
    }
}
