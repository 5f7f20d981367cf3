//! Points in archives of NumPy arrays.

use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use zip::ZipArchive;

use crate::bytes::Source;
use crate::{Error, PointFile, npy};

/// What people call an array of points, the most telling name first.
const NAMES: [&str; 5] = ["points", "xyz", "pcd", "pc", "positions"];

type Archive = ZipArchive<BufReader<File>>;

/// The points of a `.npz` file: the first three columns of the array that has one of the usual names,
/// otherwise of the only matrix that is wide enough.
pub(crate) fn read_points(path: &Path) -> Result<PointFile, Error> {
    let source = Source::open(path, "NPZ", b"PK")?;
    let archive = ZipArchive::new(source.reader);
    let mut archive = archive.map_err(|error| Error::parser(path, None, "archive", error))?;
    let place = array_of_points(path, &mut archive)?;
    let bytes = entry(path, &mut archive, place, u64::MAX)?;
    let matrix = npy::read_matrix(array(path, &bytes)?)?;
    npy::points(path, &matrix)
}

/// The place in the archive.
fn array_of_points(path: &Path, archive: &mut Archive) -> Result<usize, Error> {
    let mut arrays = Vec::new();
    for place in 0..archive.len() {
        let name = match archive.name_for_index(place) {
            Some(Ok(name)) => name.into_owned(),
            _ => continue,
        };
        if let Some(name) = name.strip_suffix(".npy") {
            let shape = shape(path, archive, place)?;
            arrays.push((place, name.to_owned(), shape));
        }
    }
    let named = NAMES
        .iter()
        .find_map(|wanted| arrays.iter().find(|(_, name, _)| name == wanted));
    if let Some((place, ..)) = named {
        return Ok(*place);
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
    // The header of a plain array is shorter.
    let start = entry(path, archive, place, 1 << 14)?;
    let mut source = array(path, &start)?;
    let header = npy::read_header(&mut source);
    Ok(header.ok().map(|header| header.shape().to_vec()))
}

/// The first bytes of an entry of the archive.
///
/// Memory grows with what is unpacked in fact, whatever the archive says about it.
fn entry(path: &Path, archive: &mut Archive, place: usize, at_most: u64) -> Result<Vec<u8>, Error> {
    let fault = |error| Error::parser(path, None, "archive", error);
    let entry = archive.by_index(place).map_err(fault)?;
    let mut bytes = Vec::new();
    let read = entry.take(at_most).read_to_end(&mut bytes);
    read.map_err(|error| Error::parser(path, None, "archive", error))?;
    Ok(bytes)
}

fn array<'a>(path: &'a Path, bytes: &'a [u8]) -> Result<Source<'a, Cursor<&'a [u8]>>, Error> {
    if !bytes.starts_with(npy::MAGIC) {
        return Err(Error::malformed(
            path,
            "an array of the archive is no NPY file",
        ));
    }
    Ok(Source::of_bytes(path, bytes))
}
