//! Points in the exchange format of laser scanning.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ::las::Reader;
use ::las::raw::Header;

use crate::bytes::Source;
use crate::{Error, PointFile};

/// Reads the points of a LAS file, or with the feature `laz` of a LAZ file.
///
/// The versions 1.0 to 1.4 and all point formats are read. A coordinate is `offset + scale * n` for a
/// whole number `n`. All points are kept, also those marked as withheld or classified as noise.
/// Coordinates are in the unit and the frame of the file, often a projection of the Earth. The projection
/// is not read.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::FeatureOff`] if it is compressed and this build
/// reads no LAZ. [`Error::Malformed`] if it is empty, foreign, cut off before its last point, or of an
/// unknown version. The file is checked before memory is reserved, so a false count in the header is
/// an error too.
///
/// # Panics
/// Never. The decompressor of LAZ may panic inside if the data are damaged. That is caught and becomes
/// [`Error::Malformed`]. Before that the panic hook of the program is called, which by default prints a
/// line. A program built with `panic = "abort"` ends there.
pub fn read_las(path: impl AsRef<Path>) -> Result<PointFile, Error> {
    let path = path.as_ref();
    let mut source = Source::open(path, "LAS", b"LASF")?;
    let header = Header::read_from(&mut source.reader);
    let header = header.map_err(|error| Error::parser(path, None, "header", error))?;
    check_extended_record(&mut source, &header)?;
    if is_compressed(&header) {
        #[cfg(feature = "laz")]
        return crate::laz::check(&mut source, &header, num_points(&header)).and_then(|()| {
            source.seek(0)?;
            crate::laz::guard(path, || read_all(path, source.reader))
        });
        #[cfg(not(feature = "laz"))]
        return Err(Error::FeatureOff {
            path: path.to_owned(),
            format: "LAZ",
            feature: "laz",
        });
    }
    check_size(&mut source, &header)?;
    source.seek(0)?;
    read_all(path, source.reader)
}

fn read_all(path: &Path, file: BufReader<File>) -> Result<PointFile, Error> {
    /// Points at a time: memory grows with the points that are there.
    const BATCH: u64 = 1 << 16;
    let fault = |context: &str, error| Error::parser(path, None, context, error);
    let mut reader = Reader::new(file).map_err(|error| fault("header", error))?;
    let num_points = reader.header().number_of_points();
    let mut scan = PointFile::default();
    let mut row = 0;
    while row < num_points {
        let batch = reader.read_points(BATCH.min(num_points - row));
        let batch = batch.map_err(|error| fault(&format!("points from {row} on"), error))?;
        for ((x, y), z) in batch.x().zip(batch.y()).zip(batch.z()) {
            scan.push([x, y, z]);
        }
        row += batch.len() as u64;
    }
    Ok(scan)
}

/// The two highest bits of the format mark compression.
fn is_compressed(header: &Header) -> bool {
    header.point_data_record_format & 0xC0 != 0
}

/// How many points the header announces. As in the reader, the 32 bits of old versions come first.
fn num_points(header: &Header) -> u64 {
    let large = header
        .large_file
        .map_or(0, |large| large.number_of_point_records);
    match header.number_of_point_records {
        0 => large,
        small => small.into(),
    }
}

fn check_size(source: &mut Source, header: &Header) -> Result<(), Error> {
    let points = num_points(header);
    let start = u64::from(header.offset_to_point_data);
    source.seek(start)?;
    let needed = points.checked_mul(header.point_data_record_length.into());
    source.expect_left(needed, &format!("{points} points"))
}

/// Checks the length of the first extended record, which the reader reserves.
fn check_extended_record(source: &mut Source, header: &Header) -> Result<(), Error> {
    let Some(records) = &header.evlr else {
        return Ok(());
    };
    const BEFORE_LENGTH: u64 = 20;
    const AFTER_LENGTH: u64 = 32;
    source.seek(records.start_of_first_evlr)?;
    source.expect_left(Some(BEFORE_LENGTH + 8 + AFTER_LENGTH), "an extended record")?;
    source.seek(records.start_of_first_evlr + BEFORE_LENGTH)?;
    let length = source.number()?;
    let what = format!("an extended record of {length} bytes");
    source.expect_left(length.checked_add(AFTER_LENGTH), &what)
}
