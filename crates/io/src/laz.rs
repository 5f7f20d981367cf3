//! Checks of what a compressed LAS file says about its chunks, before the decompressor relies on it.
//!
//! Points come in chunks. All chunks have the same number of points, or a table lists their numbers. Up to
//! format 5 a chunk is compressed point by point. From format 6 on it is compressed by layers, and the
//! sizes of the layers precede it.

use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::las::raw;
use ::laz::laszip::ChunkTable;
use ::laz::{LazItemRecordBuilder, LazVlr};

use crate::bytes::Source;
use crate::{Error, PointFile};

/// A point is coded by its difference to the one before. Three symbols of it are never left out, and the
/// probability of none comes closer to 1 than by 1/32768. Together they take a hundredth of a bit.
const MOST_POINTS_OF_A_BYTE: u64 = 1000;

/// Checks that the decompressor can follow the file. It reserves as much as sizes of tables and layers
/// announce, and looks up chunks without checking that they exist.
pub(crate) fn check(source: &mut Source, header: &raw::Header, points: u64) -> Result<(), Error> {
    let path = source.path;
    let fault = |reason: &str| Err(Error::malformed(path, reason));
    let record = u64::from(header.point_data_record_length);
    if points > MOST_POINTS_OF_A_BYTE.saturating_mul(source.length()) {
        let reason = format!("{} bytes cannot unpack to {points} points", source.length());
        return fault(&reason);
    }
    let vlr = description(source)?;
    let format = header.point_data_record_format & 0x3f;
    if !describes(&vlr, format, header.point_data_record_length) {
        return fault("its compressed records are not those of its point format");
    }
    if points == 0 {
        return Ok(());
    }
    let start = u64::from(header.offset_to_point_data);
    let chunks = chunk_sizes(source, start, record, &vlr)?;
    if vlr.uses_variable_size_chunks() && chunks.iter().sum::<u64>() < points {
        return fault("its table of chunks has fewer points than its header");
    }
    if is_layered(format) {
        let layers = Layers {
            record,
            number: num_layers(format, &vlr),
        };
        let size = u64::from(vlr.chunk_size());
        let chunks = chunks.into_iter().chain(std::iter::repeat(size));
        layers.check(source, start + 8, chunks, points)?;
    }
    Ok(())
}

/// Turns panics of the decompressor, whose assertions only damaged data violate, into errors.
///
/// The panic hook of the program is called nevertheless. By default it prints a line.
pub(crate) fn guard(
    path: &Path,
    read: impl FnOnce() -> Result<PointFile, Error>,
) -> Result<PointFile, Error> {
    // The closure owns what it changes, so nothing half-changed can be seen.
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(Error::malformed(path, "the compressed points are damaged")))
}

/// The record of the file that describes its compression.
fn description(source: &mut Source) -> Result<LazVlr, Error> {
    let path = source.path;
    let fault = |error| Error::parser(path, None, "header", error);
    source.seek(0)?;
    let header = ::las::Header::new(&mut source.reader).map_err(fault)?;
    header.laz_vlr().map_err(fault)
}

/// Whether the parts of a compressed record are those of a point format.
fn describes(vlr: &LazVlr, format: u8, record: u16) -> bool {
    let parts = |extra| LazItemRecordBuilder::default_for_point_format_id(format, extra).ok();
    let length = |extra| Some(parts(extra)?.iter().map(|item| item.size()).sum());
    let plain: Option<u16> = length(0);
    let extra = plain.and_then(|plain| record.checked_sub(plain));
    let Some(parts) = extra.and_then(parts) else {
        return false;
    };
    let found = vlr
        .items()
        .iter()
        .map(|item| (item.item_type(), item.size()));
    found.eq(parts.iter().map(|item| (item.item_type(), item.size())))
}

fn is_layered(format: u8) -> bool {
    format >= 6
}

/// A point of format 6 has nine layers. Each further part has one, and each extra byte.
fn num_layers(format: u8, vlr: &LazVlr) -> u64 {
    let extra: u64 = vlr
        .items()
        .iter()
        .map(|item| match item.item_type() {
            ::laz::LazItemType::Byte14(count) => count.into(),
            _ => 0,
        })
        .sum();
    let parts = match format {
        6 => 0,
        7 | 9 => 1,
        _ => 2,
    };
    9 + parts + extra
}

/// The numbers of points of the chunks; empty if all are equal.
fn chunk_sizes(
    source: &mut Source,
    start: u64,
    record: u64,
    vlr: &LazVlr,
) -> Result<Vec<u64>, Error> {
    let path = source.path;
    source.seek(start)?;
    source.expect_left(Some(8), "a table of chunks")?;
    let mut table = source.number()?;
    // Writers that cannot go back leave the place of the table at the end.
    if table as i64 <= start as i64 {
        let length = source.length();
        source.seek(length.saturating_sub(8))?;
        table = source.number()?;
    }
    let is_variable = vlr.uses_variable_size_chunks();
    if table as i64 <= start as i64 {
        return match is_variable {
            true => Err(Error::malformed(path, "it has no table of chunks")),
            false => Ok(Vec::new()),
        };
    }
    source.seek(table)?;
    source.expect_left(Some(8), "a table of chunks")?;
    let num_chunks = source.number()? >> 32;
    // Each starts with a point that is not compressed.
    if num_chunks.saturating_mul(record) > source.length() {
        let reason = format!("{} bytes cannot hold {num_chunks} chunks", source.length());
        return Err(Error::malformed(path, reason));
    }
    if !is_variable {
        return Ok(Vec::new());
    }
    source.seek(table)?;
    let table = ChunkTable::read(&mut source.reader, true);
    let table = table.map_err(|error| Error::parser(path, None, "table of chunks", error))?;
    let sizes: Vec<u64> = table
        .as_ref()
        .iter()
        .map(|chunk| chunk.point_count)
        .collect();
    match sizes
        .iter()
        .any(|&size| size == 0 || size > u64::from(u32::MAX))
    {
        true => Err(Error::malformed(
            path,
            "its table of chunks has sizes out of range",
        )),
        false => Ok(sizes),
    }
}

struct Layers {
    record: u64,
    number: u64,
}

impl Layers {
    /// Follows the chunks to the last point and checks that all layers fit into the file.
    fn check(
        &self,
        source: &mut Source,
        first: u64,
        chunks: impl Iterator<Item = u64>,
        points: u64,
    ) -> Result<(), Error> {
        let mut place = first;
        let mut left = points;
        for size in chunks {
            if left == 0 {
                break;
            }
            source.seek(place)?;
            let sizes_end = self.record + 4 + 4 * self.number;
            source.expect_left(Some(sizes_end), "another chunk")?;
            source.seek(place + self.record + 4)?;
            let mut sizes = Vec::new();
            let read = source
                .reader
                .by_ref()
                .take(4 * self.number)
                .read_to_end(&mut sizes);
            read.map_err(Error::io("read", source.path))?;
            let layers: u64 = sizes
                .chunks_exact(4)
                .map(|bytes| {
                    bytes
                        .iter()
                        .rev()
                        .fold(0, |sum, &byte| sum << 8 | u64::from(byte))
                })
                .sum();
            source.expect_left(Some(layers), &format!("layers of {layers} bytes"))?;
            place += sizes_end + layers;
            left -= size.min(left);
        }
        Ok(())
    }
}
