//! Lines of whitespace-separated words, with errors that name the line.

use std::fs;
use std::path::Path;
use std::str::SplitWhitespace;

use crate::{Error, rows};

/// The whole file as text.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    let bytes = fs::read(path).map_err(Error::io("read", path))?;
    // The error's own copy of the bytes would fill screens in debug output.
    String::from_utf8(bytes)
        .map_err(|error| Error::parser(path, None, "not a text file", error.utf8_error()))
}

/// The lines with content: neither blank nor a comment, which starts with `#`.
pub(crate) fn lines<'a>(path: &'a Path, text: &'a str) -> impl Iterator<Item = Line<'a>> {
    (1..)
        .zip(text.lines())
        .map(move |(number, content)| Line {
            path,
            number,
            words: content.split_whitespace(),
        })
        .filter(|line| line.first().is_some_and(|word| !word.starts_with('#')))
}

/// A line, read word by word from the left.
pub(crate) struct Line<'a> {
    path: &'a Path,
    number: usize,
    words: SplitWhitespace<'a>,
}

impl<'a> Line<'a> {
    pub(crate) fn error(&self, reason: impl AsRef<str>) -> Error {
        Error::malformed_line(self.path, self.number, reason)
    }

    pub(crate) fn words_left(&self) -> usize {
        self.words.clone().count()
    }

    pub(crate) fn first(&self) -> Option<&'a str> {
        self.words.clone().next()
    }

    pub(crate) fn word(&mut self, what: &str) -> Result<&'a str, Error> {
        let word = self.words.next();
        word.ok_or_else(|| self.error(format!("the line ends where {what} should stand")))
    }

    pub(crate) fn index(&mut self, what: &str) -> Result<usize, Error> {
        let word = self.word(what)?;
        let index = word.parse();
        index.map_err(|_| self.error(format!("{what} is {word:?}, not a whole number from 0 on")))
    }

    pub(crate) fn number(&mut self, what: &str) -> Result<f64, Error> {
        let word = self.word(what)?;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(format!("{what} is {word:?}, not a finite number"))),
        }
    }

    pub(crate) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Error> {
        self.array(what, Self::number)
    }

    /// Numbers that need not be finite, in any spelling that programs print.
    pub(crate) fn any_numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N], Error> {
        self.array(what, |line, name| {
            let word = line.word(name)?;
            rows::coordinate(name, word, false).map_err(|reason| line.error(reason))
        })
    }

    fn array<const N: usize>(
        &mut self,
        what: &str,
        number: impl Fn(&mut Self, &str) -> Result<f64, Error>,
    ) -> Result<[f64; N], Error> {
        let mut numbers = [0.0; N];
        for (k, entry) in (1..).zip(&mut numbers) {
            *entry = number(self, &format!("number {k} of {N} of {what}"))?;
        }
        Ok(numbers)
    }

    /// Nothing may follow: an unnoticed extra column would change the meaning of all others.
    pub(crate) fn end(&mut self) -> Result<(), Error> {
        match self.words.next() {
            None => Ok(()),
            Some(word) => Err(self.error(format!("{word:?} follows the last entry"))),
        }
    }

    /// Nothing but a comment may follow.
    pub(crate) fn end_or_comment(&mut self) -> Result<(), Error> {
        if self.first().is_some_and(|word| word.starts_with('#')) {
            return Ok(());
        }
        self.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only_line(text: &str) -> Line<'_> {
        lines(Path::new("file"), text).next().unwrap()
    }

    #[test]
    fn the_error_of_a_large_binary_file_is_short() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large.g2o");
        fs::write(&path, [0xff; 100_000]).unwrap();
        let error = read_text(&path).unwrap_err();
        assert!(format!("{error} {error:?}").len() < 1000);
    }

    #[test]
    fn blank_lines_and_comments_are_passed_over_but_counted() {
        let text = "# heading\n\n 1 2\r\n\t# more\n3\n";
        let numbers: Vec<usize> = lines(Path::new("file"), text).map(|l| l.number).collect();
        assert_eq!(numbers, [3, 5]);
    }

    #[test]
    fn unexpected_words_are_named_with_their_line() {
        let error = only_line("\nabc").index("the scan").unwrap_err();
        let said = "file:2: the scan is \"abc\", not a whole number from 0 on";
        assert_eq!(error.to_string(), said);
        for text in ["nan", "inf", "1e999", "1,5"] {
            assert!(only_line(text).number("x").is_err(), "{text}");
        }
        let error = only_line("1 2").numbers::<3>("the row").unwrap_err();
        assert!(error.to_string().contains("number 3 of 3 of the row"));
        assert!(only_line("7").end().is_err());
    }
}
