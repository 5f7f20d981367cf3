//! The payload of a binary file.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Header, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::names::{announced, axis};
use crate::bytes::Source;
use crate::{Error, PointFile};

/// The points of the last of `elements`, the vertices.
pub(super) fn read_binary(
    mut source: Source,
    elements: &[&ElementDef],
    header: &Header,
) -> Result<PointFile, Error> {
    let mut scan = PointFile::default();
    for element in elements {
        source.expect_left(least_bytes(element), &announced(element))?;
        let path = source.path;
        let mut reader = Reader::new(&mut source.reader);
        if element.name == "vertex" {
            for Vertex(coordinates) in read_elements(path, &mut reader, element, header)? {
                scan.push(coordinates);
            }
        } else {
            read_elements::<Skipped>(path, &mut reader, element, header)?;
        }
    }
    Ok(scan)
}

fn read_elements<E: PropertyAccess>(
    path: &Path,
    reader: &mut Reader<&mut BufReader<File>>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, Error> {
    Parser::new()
        .read_payload_for_element(reader, element, header)
        .map_err(|error| Error::parser(path, None, &format!("element {:?}", element.name), error))
}

/// The bytes of `count` elements whose lists are all empty; `None` if no number can hold them.
///
/// An element without properties takes no bytes at all, and any count of it would fit into any
/// file: it is charged one byte, which refuses absurd counts.
fn least_bytes(element: &ElementDef) -> Option<u64> {
    let properties = element.properties.values();
    let one: u64 = properties
        .map(|property| match &property.data_type {
            PropertyType::Scalar(kind) | PropertyType::List(kind, _) => bytes(kind),
        })
        .sum();
    one.max(1).checked_mul(element.count as u64)
}

fn bytes(kind: &ScalarType) -> u64 {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Takes `x`, `y`, `z` of an element and ignores the rest.
struct Vertex([f64; 3]);

impl Vertex {
    fn set(&mut self, name: &str, value: impl Into<f64>) -> PropertyAccessResult {
        let Some(axis) = axis(name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = value.into();
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 3])
    }
    fn set_char(&mut self, name: &str, value: i8) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_uchar(&mut self, name: &str, value: u8) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_short(&mut self, name: &str, value: i16) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_ushort(&mut self, name: &str, value: u16) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_int(&mut self, name: &str, value: i32) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_uint(&mut self, name: &str, value: u32) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        self.set(name, value)
    }
    fn set_double(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        self.set(name, value)
    }
}

/// An element of which nothing is kept.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
