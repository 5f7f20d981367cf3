//! Points in archives of NumPy arrays.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use zip::ZipArchive;
use zip::read::ZipFile;

use crate::bytes::Source;
use crate::{Error, PointFile, npy};

/// What people call an array of points, the most telling name first.
const NAMES: [&str; 5] = ["points", "xyz", "pcd", "pc", "positions"];

/// A match of deflate takes two bits at least and stands for 258 bytes at most.
const MOST_BYTES_OF_A_BYTE: u64 = 1032;

type Archive = ZipArchive<BufReader<File>>;

/// The points of a `.npz` file: the first three columns of the array that has one of the usual names,
/// otherwise of the only matrix that is wide enough.
///
/// Points are taken while the array is unpacked. No more is unpacked than its shape announces.
pub(crate) fn read_points(path: &Path) -> Result<PointFile, Error> {
    let source = Source::open(path, "NPZ", b"PK")?;
    let archive = ZipArchive::new(source.reader);
    let mut archive = archive.map_err(|error| Error::parser(path, None, "archive", error))?;
    let place = array_of_points(path, &mut archive)?;
    let mut array = array(path, &mut archive, place)?;
    let header = npy::Header::new(path, npy::read_header(path, &mut array)?)?;
    check_size(path, &header, array.get_ref().compressed_size())?;
    let scan = header.points(&mut array)?;
    // The checksum is looked at where the array ends.
    let rest = array.fill_buf();
    match rest.map_err(|error| Error::parser(path, None, "archive", error))? {
        [] => Ok(scan),
        _ => Err(Error::malformed(path, "the array is longer than its shape")),
    }
}

fn check_size(path: &Path, header: &npy::Header, packed: u64) -> Result<(), Error> {
    let most = packed.saturating_mul(MOST_BYTES_OF_A_BYTE);
    match header.num_bytes() {
        Some(needed) if needed <= most => Ok(()),
        _ => Err(Error::malformed(
            path,
            format!("{packed} bytes cannot unpack to {}", header.description()),
        )),
    }
}

/// The place in the archive.
fn array_of_points(path: &Path, archive: &mut Archive) -> Result<usize, Error> {
    let mut names = Vec::new();
    for place in 0..archive.len() {
        if let Some(Ok(name)) = archive.name_for_index(place)
            && let Some(name) = name.strip_suffix(".npy")
        {
            names.push((place, name.to_owned()));
        }
    }
    let named = |wanted: &&str| names.iter().find(|(_, name)| name == wanted);
    if let Some((place, _)) = NAMES.iter().find_map(named) {
        return Ok(*place);
    }
    let mut arrays = Vec::new();
    for (place, name) in names {
        arrays.push((place, name, shape(path, archive, place)?));
    }
    let mut wide = arrays
        .iter()
        .filter(|(_, _, shape)| matches!(shape.as_deref(), Some([_, columns]) if *columns >= 3));
    match (wide.next(), wide.next()) {
        (Some((place, ..)), None) => Ok(*place),
        _ => Err(Error::malformed(path, unclear(&arrays))),
    }
}

fn unclear(arrays: &[(usize, String, Option<Vec<u64>>)]) -> String {
    let list = arrays.iter().map(|(_, name, shape)| match shape {
        Some(shape) => format!("{name} {shape:?}"),
        None => format!("{name} of another kind"),
    });
    let list: Vec<String> = list.collect();
    let names = NAMES.join(", ");
    format!(
        "no array is called {names}, nor is one the only matrix of three or more columns; \
         the arrays are: {}",
        list.join(", ")
    )
}

/// The shape of an array, if it is one of plain numbers.
fn shape(path: &Path, archive: &mut Archive, place: usize) -> Result<Option<Vec<u64>>, Error> {
    let header = npy::read_header(path, &mut array(path, archive, place)?);
    Ok(header.ok().map(|header| header.shape().to_vec()))
}

/// An entry of the archive, unpacked as it is read.
fn array<'a>(
    path: &Path,
    archive: &'a mut Archive,
    place: usize,
) -> Result<BufReader<ZipFile<'a, BufReader<File>>>, Error> {
    let entry = archive.by_index(place);
    let entry = entry.map_err(|error| Error::parser(path, None, "archive", error))?;
    Ok(BufReader::with_capacity(1 << 16, entry))
}
