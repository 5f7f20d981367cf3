//! Rows of numbers in the text payload of point files.
//!
//! Organized clouds are full of `nan`, which programs spell in many ways.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use crate::Error;
use crate::bytes::Source;

/// The lines of a payload that are not blank. Bytes that are not Unicode are replaced, since names and
/// remarks beside the numbers may be in any encoding.
pub(crate) struct Rows<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    number: usize,
    bytes: Vec<u8>,
    content: String,
}

impl<'a> Rows<'a> {
    /// The rows of the rest of `source`, which continues with line `first_line` of the file.
    pub(crate) fn new(source: Source<'a>, first_line: usize) -> Self {
        Self {
            path: source.path,
            reader: source.reader,
            number: first_line - 1,
            bytes: Vec::new(),
            content: String::new(),
        }
    }

    /// The next row. If there is none, `announced` says what the header promised.
    pub(crate) fn next(&mut self, announced: impl Fn() -> String) -> Result<&str, Error> {
        if self.advance()? {
            return Ok(&self.content);
        }
        let announced = announced();
        Err(self.error(format!(
            "the header announces {announced}, but the file ends before"
        )))
    }

    /// The next row, if there is one.
    pub(crate) fn next_if_any(&mut self) -> Result<Option<&str>, Error> {
        Ok(self.advance()?.then_some(&*self.content))
    }

    /// Moves to the next row, if there is one.
    fn advance(&mut self) -> Result<bool, Error> {
        /// Bytes that no row of numbers needs.
        const TOO_LONG: u64 = 1 << 20;
        loop {
            self.bytes.clear();
            self.number += 1;
            let mut reader = self.reader.by_ref().take(TOO_LONG);
            let length = reader.read_until(b'\n', &mut self.bytes);
            let length = length.map_err(Error::io("read", self.path))?;
            if reader.limit() == 0 {
                let reason = format!("not text: the line takes {TOO_LONG} bytes or more");
                return Err(self.error(reason));
            }
            if self.bytes.contains(&0) {
                return Err(self.error("not text: the line has a zero byte, as UTF-16 has"));
            }
            if length == 0 || !self.bytes.trim_ascii().is_empty() {
                self.content.clear();
                self.content.push_str(&String::from_utf8_lossy(&self.bytes));
                return Ok(length > 0);
            }
        }
    }

    /// An error in the row that was read last.
    pub(crate) fn error(&self, reason: impl AsRef<str>) -> Error {
        Error::malformed_line(self.path, self.number, reason)
    }
}

/// The coordinate `name` that the word stands for, rounded as a binary file would have it if it is
/// of `single` precision. The exponent may be marked by `D`, as Fortran does.
pub(crate) fn coordinate(name: &str, word: &str, single: bool) -> Result<f64, String> {
    let number = |word: &str| match single {
        true => word.parse::<f32>().ok().map(f64::from),
        false => word.parse().ok(),
    };
    let value = if is_nan(word) {
        Some(f64::NAN)
    } else {
        number(word).or_else(|| number(&word.replace(['D', 'd'], "e")))
    };
    value.ok_or_else(|| format!("{name:?} is {word:?}, not a number"))
}

/// Programs print numbers that are not finite as `nan`, `-nan`, `-nan(ind)`, `1.#QNAN`, `-1.#IND` or
/// `1.#INF`.
fn is_nan(word: &str) -> bool {
    let start = word.trim_start_matches(['-', '+']).get(..3);
    start.is_some_and(|start| start.eq_ignore_ascii_case("nan") || start == "1.#")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_without_a_value_are_not_finite_in_every_spelling() {
        for word in [
            "nan",
            "NaN",
            "-nan",
            "-nan(ind)",
            "+NAN",
            "1.#QNAN",
            "-1.#IND00",
            "1.#INF",
            "-1.#INF",
            "inf",
            "-Infinity",
        ] {
            for single in [false, true] {
                assert!(
                    !coordinate("x", word, single).unwrap().is_finite(),
                    "{word}"
                );
            }
        }
    }

    #[test]
    fn words_that_are_no_numbers_are_named() {
        for word in ["a", "1,5", "#", "--1", "0x1", "é1", "D", "1D", "d5"] {
            let said = coordinate("x", word, true).unwrap_err();
            assert!(said.contains(word), "{said}");
        }
    }

    #[test]
    fn exponents_of_fortran_are_read() {
        for (word, value) in [("1.0D+00", 1.0), ("-2.5d3", -2500.0), ("0.1D-2", 0.001)] {
            assert_eq!(coordinate("x", word, false).unwrap(), value);
        }
    }

    #[test]
    fn numbers_are_rounded_to_their_type() {
        assert_eq!(coordinate("x", "0.1", false).unwrap(), 0.1);
        assert_eq!(coordinate("x", "0.1", true).unwrap(), f64::from(0.1f32));
    }
}
