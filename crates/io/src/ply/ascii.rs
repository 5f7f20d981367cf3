//! The payload of a text file, an element per line.
//!
//! The parser crate knows no `nan` in text, so the lines are taken apart here.

use std::str::SplitWhitespace;

use ply_rs_bw::ply::{ElementDef, PropertyType, ScalarType};

use super::names::{announced, axis};
use crate::bytes::Source;
use crate::rows::{self, Rows};
use crate::{Error, PointFile};

/// The points of the last of `elements`, the vertices. The payload starts at line `first_line`.
pub(super) fn read_ascii(
    source: Source,
    elements: &[&ElementDef],
    first_line: usize,
) -> Result<PointFile, Error> {
    let mut rows = Rows::new(source, first_line);
    let mut scan = PointFile::default();
    for element in elements {
        for _ in 0..element.count {
            let mut words = rows.next(|| announced(element))?.split_whitespace();
            if element.name == "vertex" {
                let coordinates = coordinates(&mut words, element);
                scan.push(coordinates.map_err(|reason| rows.error(reason))?);
            }
        }
    }
    Ok(scan)
}

fn coordinates(words: &mut SplitWhitespace, element: &ElementDef) -> Result<[f64; 3], String> {
    let mut coordinates = [0.0; 3];
    for (place, property) in (1..).zip(element.properties.values()) {
        let name = &property.name;
        let word = words
            .next()
            .ok_or_else(|| format!("{} is missing", called(name, place)))?;
        match &property.data_type {
            PropertyType::Scalar(kind) => {
                if let Some(axis) = axis(name) {
                    let single = *kind == ScalarType::Float;
                    coordinates[axis] = rows::coordinate(name, word, single)?;
                }
            }
            PropertyType::List(..) => skip_list(words, word).ok_or_else(|| {
                format!("the list {} is shorter than it says", called(name, place))
            })?,
        }
    }
    Ok(coordinates)
}

/// Only coordinates still have the name that they have in the file.
fn called(name: &str, place: usize) -> String {
    match axis(name) {
        Some(_) => format!("property {name:?}"),
        None => format!("property {place}"),
    }
}

fn skip_list(words: &mut SplitWhitespace, length: &str) -> Option<()> {
    match length.parse::<usize>().ok()?.checked_sub(1) {
        None => Some(()),
        Some(before_last) => words.nth(before_last).map(|_| ()),
    }
}
