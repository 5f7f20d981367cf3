//! Scans of terrestrial laser scanners, several in a file.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use ::e57::{E57Reader, PointCloud, RawValues, Record, RecordDataType, RecordName};
use nalgebra::Isometry3;

use crate::bytes::Source;
use crate::{Error, PointFile, rigid};

/// A scan of an E57 file.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct E57Scan {
    /// The name that the file gives the scan.
    pub name: Option<String>,
    /// The points in the frame of the scan, as stored, in meters: the scanner stood in the origin.
    /// (Some programs store all scans in the frame of the file already, and no pose.)
    pub points: PointFile,
    /// The pose of the scan in the frame of the file, which is common to all its scans. The identity if
    /// the file has no pose.
    #[cfg_attr(feature = "serde", serde(with = "gmpcr_geometry::matrix_rows"))]
    pub file_from_scan: Isometry3<f64>,
}

/// Reads the scans of an E57 file, each in its own frame, with its pose.
///
/// Cartesian coordinates are taken where a scan has them, otherwise spherical ones are converted,
/// `x = r cos(elevation) cos(azimuth)`, `y = r cos(elevation) sin(azimuth)`, `z = r sin(elevation)`.
/// Points that the file marks as invalid are left out and counted, see [`PointFile`]. Points with only a
/// direction count as invalid. The order is that of the file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if it is empty, foreign, cut off,
/// damaged (each kilobyte has a checksum), or false about a count; if it has no scan, or one without
/// coordinates; or if a pose has a quaternion whose length is off 1 by more than 0.01.
///
/// # Example
/// ```
/// use gmpcr_io::{PointFile, read_e57};
///
/// fn in_the_frame_of_the_file(path: &std::path::Path) -> Result<(), gmpcr_io::Error> {
///     for scan in read_e57(path)? {
///         let points = scan.points.points.iter();
///         let moved = points.map(|point| scan.file_from_scan * point);
///         println!("{:?}: {} points", scan.name, moved.count());
///     }
///     Ok(())
/// }
///
/// let missing = in_the_frame_of_the_file("missing.e57".as_ref());
/// assert!(missing.unwrap_err().to_string().contains("missing.e57"));
/// ```
pub fn read_e57(path: impl AsRef<Path>) -> Result<Vec<E57Scan>, Error> {
    let path = path.as_ref();
    let mut source = Source::open(path, "E57", b"ASTM-E57")?;
    let length = source.bytes_left()?;
    check_header(&mut source)?;

    // Each page is read at its place: a buffer would read all between time and again.
    let mut file = source.reader.into_inner();
    file.rewind().map_err(Error::io("read", path))?;
    let reader = E57Reader::new(file);
    let mut reader = reader.map_err(|error| Error::parser(path, None, "header", error))?;
    let clouds = reader.pointclouds();
    if clouds.is_empty() {
        return Err(Error::malformed(path, "the file has no scan"));
    }
    let scans = (1..).zip(&clouds).map(|(number, cloud)| {
        let context = format!("scan {number} of {}", clouds.len());
        let fault = |reason| Error::malformed(path, format!("{context}: {reason}"));
        check_size(cloud, length).map_err(fault)?;
        let layout = Layout::of(&cloud.prototype).ok_or_else(|| {
            fault("it has neither Cartesian nor spherical coordinates".to_owned())
        })?;
        let points = points(&mut reader, cloud, &layout);
        Ok(E57Scan {
            name: cloud.name.clone(),
            points: points.map_err(|error| Error::parser(path, None, &context, error))?,
            file_from_scan: pose(cloud).map_err(fault)?,
        })
    });
    scans.collect()
}

/// All scans of the file in its frame.
pub(crate) fn read_merged(path: &Path) -> Result<PointFile, Error> {
    let mut merged = PointFile::default();
    for scan in read_e57(path)? {
        let points = scan.points.points.iter();
        merged
            .points
            .extend(points.map(|point| scan.file_from_scan * point));
        merged.invalid += scan.points.invalid;
    }
    Ok(merged)
}

/// Whether the file is as long as it says, and its description no longer than the file.
fn check_header(source: &mut Source) -> Result<(), Error> {
    let path = source.path;
    let length = source.bytes_left()?;
    let mut header = [0; 48];
    let read = source.reader.read_exact(&mut header);
    read.map_err(|error| Error::parser(path, None, "header", error))?;
    let number = |place: usize| {
        let bytes = std::array::from_fn(|k| header[place + k]);
        u64::from_le_bytes(bytes)
    };
    let (whole, description) = (number(16), number(32));
    if whole > length || description > length {
        let reason = format!(
            "the header announces {whole} bytes, {description} of them description, \
             but the file has {length}"
        );
        return Err(Error::malformed(path, reason));
    }
    Ok(())
}

/// Makes sure that the file can hold as many points as it announces.
///
/// What is the same for all points takes no bits, and a scan of nothing else would take none; the
/// parser would look for its end forever.
fn check_size(cloud: &PointCloud, length: u64) -> Result<(), String> {
    let records = cloud.prototype.iter();
    let bits: u64 = records.map(|record| bits(&record.data_type)).sum();
    let points = cloud.records;
    match bits.checked_mul(points) {
        _ if points == 0 => Ok(()),
        Some(needed) if bits > 0 && needed / 8 <= length => Ok(()),
        _ => Err(format!(
            "{points} points of {bits} bits are announced in a file of {length} bytes"
        )),
    }
}

fn bits(kind: &RecordDataType) -> u64 {
    match *kind {
        RecordDataType::Single { .. } => 32,
        RecordDataType::Double { .. } => 64,
        RecordDataType::Integer { min, max } | RecordDataType::ScaledInteger { min, max, .. } => {
            let range = max.abs_diff(min);
            u64::from(u64::BITS - range.leading_zeros())
        }
    }
}

fn pose(cloud: &PointCloud) -> Result<Isometry3<f64>, String> {
    let Some(pose) = &cloud.transform else {
        return Ok(Isometry3::identity());
    };
    let (t, q) = (&pose.translation, &pose.rotation);
    let row = [t.x, t.y, t.z, q.x, q.y, q.z, q.w];
    if row.iter().any(|number| !number.is_finite()) {
        return Err("the pose is not finite".to_owned());
    }
    rigid::from_quaternion_row(row)
}

fn points(
    reader: &mut E57Reader<File>,
    cloud: &PointCloud,
    layout: &Layout,
) -> ::e57::Result<PointFile> {
    let mut scan = PointFile::default();
    if cloud.records > 0 {
        for record in reader.pointcloud_raw(cloud)? {
            scan.push(layout.coordinates(&cloud.prototype, &record?)?);
        }
    }
    Ok(scan)
}

/// Where a record has its coordinates.
struct Layout {
    places: [usize; 3],
    /// Place of a number that is zero for valid points.
    invalid: Option<usize>,
    is_spherical: bool,
}

impl Layout {
    fn of(prototype: &[Record]) -> Option<Self> {
        use RecordName::*;
        let place = |name| prototype.iter().position(|record| record.name == name);
        let places = |[a, b, c]: [RecordName; 3]| Some([place(a)?, place(b)?, place(c)?]);
        let cartesian = places([CartesianX, CartesianY, CartesianZ]).map(|places| Self {
            places,
            invalid: place(CartesianInvalidState),
            is_spherical: false,
        });
        let spherical = || {
            Some(Self {
                places: places([SphericalRange, SphericalAzimuth, SphericalElevation])?,
                invalid: place(SphericalInvalidState),
                is_spherical: true,
            })
        };
        cartesian.or_else(spherical)
    }

    fn coordinates(&self, prototype: &[Record], record: &RawValues) -> ::e57::Result<[f64; 3]> {
        let number = |place: usize| record[place].to_f64(&prototype[place].data_type);
        let [a, b, c] = self.places;
        let (a, b, c) = (number(a)?, number(b)?, number(c)?);
        let is_invalid = match self.invalid {
            Some(place) => number(place)? != 0.0,
            None => false,
        };
        Ok(match self.is_spherical {
            _ if is_invalid => [f64::NAN; 3],
            false => [a, b, c],
            true => {
                let (range, azimuth, elevation) = (a, b, c);
                let across = range * elevation.cos();
                [
                    across * azimuth.cos(),
                    across * azimuth.sin(),
                    range * elevation.sin(),
                ]
            }
        })
    }
}
