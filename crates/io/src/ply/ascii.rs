//! The payload of a text file, an element per line.
//!
//! The parser crate knows no `nan` in text, which organised clouds are full of, so the lines are
//! taken apart here.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::str::SplitWhitespace;

use ply_rs_bw::ply::{ElementDef, PropertyType, ScalarType};

use super::{announced, axis};
use crate::bytes::Source;
use crate::{Error, PointFile};

/// The points of the last of `elements`, the vertices. The payload starts at line `first_line`.
pub(super) fn read_ascii(
    source: Source,
    elements: &[&ElementDef],
    first_line: usize,
) -> Result<PointFile, Error> {
    let mut lines = ElementLines {
        path: source.path,
        reader: source.reader,
        number: first_line - 1,
        content: String::new(),
    };
    let mut scan = PointFile::default();
    for element in elements {
        for _ in 0..element.count {
            let mut words = lines.next(element)?.split_whitespace();
            if element.name == "vertex" {
                let coordinates = coordinates(&mut words, element);
                scan.push(coordinates.map_err(|reason| lines.error(reason))?);
            }
        }
    }
    Ok(scan)
}

/// The lines of the elements, one for each.
struct ElementLines<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    number: usize,
    content: String,
}

impl ElementLines<'_> {
    /// The next line that is not blank.
    fn next(&mut self, element: &ElementDef) -> Result<&str, Error> {
        loop {
            self.content.clear();
            self.number += 1;
            match self.reader.read_line(&mut self.content) {
                Ok(0) => return Err(self.cut_off(element)),
                Ok(_) if self.content.trim_ascii().is_empty() => continue,
                Ok(_) => return Ok(&self.content),
                Err(error) => {
                    return Err(Error::parser(
                        self.path,
                        Some(self.number),
                        "no text",
                        error,
                    ));
                }
            }
        }
    }

    fn cut_off(&self, element: &ElementDef) -> Error {
        let announced = announced(element);
        self.error(format!(
            "the header announces {announced}, but the file ends before"
        ))
    }

    fn error(&self, reason: impl AsRef<str>) -> Error {
        Error::malformed_line(self.path, self.number, reason)
    }
}

fn coordinates(words: &mut SplitWhitespace, element: &ElementDef) -> Result<[f64; 3], String> {
    let mut coordinates = [0.0; 3];
    for property in element.properties.values() {
        let name = &property.name;
        let word = words
            .next()
            .ok_or_else(|| format!("property {name:?} is missing"))?;
        match &property.data_type {
            PropertyType::Scalar(kind) => {
                if let Some(axis) = axis(name) {
                    let value = number(word, kind);
                    coordinates[axis] =
                        value.ok_or_else(|| format!("{name:?} is {word:?}, not a number"))?;
                }
            }
            PropertyType::List(..) => skip_list(words, word)
                .ok_or_else(|| format!("the list {name:?} is shorter than it says"))?,
        }
    }
    Ok(coordinates)
}

fn skip_list(words: &mut SplitWhitespace, length: &str) -> Option<()> {
    match length.parse::<usize>().ok()?.checked_sub(1) {
        None => Some(()),
        Some(before_last) => words.nth(before_last).map(|_| ()),
    }
}

/// The number that the word stands for, rounded as a binary file of the same `kind` would have it.
fn number(word: &str, kind: &ScalarType) -> Option<f64> {
    if is_nan(word) {
        return Some(f64::NAN);
    }
    match kind {
        ScalarType::Float => word.parse::<f32>().ok().map(f64::from),
        _ => word.parse().ok(),
    }
}

/// Programs print what is no number as `nan`, `-nan` or `-nan(ind)`.
fn is_nan(word: &str) -> bool {
    let start = word.trim_start_matches(['-', '+']).get(..3);
    start.is_some_and(|start| start.eq_ignore_ascii_case("nan"))
}
