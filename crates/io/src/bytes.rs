//! Binary files: opened, measured, and checked before memory is spent on them.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use crate::Error;

/// A file that is being read, and its length in bytes.
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    pub(crate) reader: BufReader<File>,
    length: u64,
}

impl<'a> Source<'a> {
    /// Opens the file and checks that it starts with `magic`, the mark of files of this `format`.
    pub(crate) fn open(path: &'a Path, format: &str, magic: &[u8]) -> Result<Self, Error> {
        let file = File::open(path).map_err(Error::io("open", path))?;
        let length = file.metadata().map_err(Error::io("open", path))?.len();
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let start = reader.fill_buf().map_err(Error::io("read", path))?;
        if start.is_empty() {
            return Err(Error::malformed(path, "the file is empty"));
        }
        if !start.starts_with(magic) {
            return Err(Error::malformed(path, format!("not a {format} file")));
        }
        Ok(Self {
            path,
            reader,
            length,
        })
    }

    /// Reads the lines up to the one that `is_last` accepts. Bytes that are not text are replaced.
    ///
    /// Without such a line these are all lines. The parser of the header has to notice that.
    pub(crate) fn header(&mut self, is_last: fn(&str) -> bool) -> Result<String, Error> {
        const LONGEST: u64 = 1 << 22;
        let mut reader = self.reader.by_ref().take(LONGEST);
        let mut header = String::new();
        let mut bytes = Vec::new();
        loop {
            bytes.clear();
            let length = reader.read_until(b'\n', &mut bytes);
            let length = length.map_err(Error::io("read", self.path))?;
            if reader.limit() == 0 {
                let reason = format!("the header takes {LONGEST} bytes or more");
                return Err(Error::malformed(self.path, reason));
            }
            let line = String::from_utf8_lossy(&bytes);
            header.push_str(&line);
            if length == 0 || is_last(&line) {
                return Ok(header);
            }
        }
    }

    /// Checks that the file holds what its header announces, before memory is reserved for it.
    ///
    /// `what` names the content, which needs at least `needed` bytes. `None` is a number of bytes that
    /// overflows.
    pub(crate) fn expect_left(&mut self, needed: Option<u64>, what: &str) -> Result<(), Error> {
        let left = self.bytes_left()?;
        match needed {
            Some(needed) if needed <= left => Ok(()),
            _ => Err(Error::malformed(
                self.path,
                format!("the header announces {what}, but only {left} bytes follow"),
            )),
        }
    }

    /// Continues at a place of the file, which may lie behind its end.
    #[cfg(feature = "las")]
    pub(crate) fn seek(&mut self, place: u64) -> Result<(), Error> {
        let sought = self.reader.seek(std::io::SeekFrom::Start(place));
        sought.map(drop).map_err(Error::io("read", self.path))
    }

    /// A number of eight bytes, the lowest first.
    #[cfg(feature = "las")]
    pub(crate) fn number(&mut self) -> Result<u64, Error> {
        let mut bytes = [0; 8];
        let read = self.reader.read_exact(&mut bytes);
        read.map_err(Error::io("read", self.path))?;
        Ok(u64::from_le_bytes(bytes))
    }

    #[cfg(feature = "laz")]
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    pub(crate) fn bytes_left(&mut self) -> Result<u64, Error> {
        let position = self.reader.stream_position();
        let position = position.map_err(Error::io("read", self.path))?;
        Ok(self.length.saturating_sub(position))
    }
}
