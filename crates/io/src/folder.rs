//! The files and folders in a folder, in natural order.

use std::cmp::Ordering;
use std::fs;
use std::path::Path;

use crate::Error;
use crate::formats::Format;

/// Names of the visible files of a folder in natural order. A name that is not Unicode is left out; it
/// is an error if it is that of a point cloud.
pub(crate) fn file_names(folder: &Path) -> Result<Vec<String>, Error> {
    names(folder, Path::is_file)
}

/// Names of the visible subfolders of a folder in natural order.
pub(crate) fn folder_names(folder: &Path) -> Result<Vec<String>, Error> {
    names(folder, Path::is_dir)
}

fn names(folder: &Path, is_wanted: fn(&Path) -> bool) -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io("list", folder))? {
        let entry = entry.map_err(Error::io("list", folder))?;
        let path = entry.path();
        match entry.file_name().into_string() {
            Ok(name) if !name.starts_with('.') && is_wanted(&path) => names.push(name),
            // A scan must not be missing silently.
            Err(_) if Format::of(&path).is_some() => {
                return Err(Error::malformed(
                    &path,
                    "its name is not Unicode text: rename it",
                ));
            }
            _ => {}
        }
    }
    names.sort_by(|a, b| natural_order(a, b));
    Ok(names)
}

/// Compares runs of digits by their value and everything else letter by letter.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while let (Some(first_a), Some(first_b)) = (rest_a.chars().next(), rest_b.chars().next()) {
        let order = if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (number_a, number_b) = (take_digits(&mut rest_a), take_digits(&mut rest_b));
            (number_a.len(), number_a).cmp(&(number_b.len(), number_b))
        } else {
            rest_a = &rest_a[first_a.len_utf8()..];
            rest_b = &rest_b[first_b.len_utf8()..];
            first_a.cmp(&first_b)
        };
        if order.is_ne() {
            return order;
        }
    }
    (rest_a.len(), a).cmp(&(rest_b.len(), b))
}

/// Takes the digits at the front of `text`, without leading zeros.
fn take_digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    *text = rest;
    digits.trim_start_matches('0')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_count_by_value_however_long() {
        let sorted = [
            "a1",
            "a2",
            "a02",
            "a10",
            "a10b",
            "a99999999999999999999",
            "a100000000000000000000",
            "b0",
            "scan",
            "scan-1",
            "scan1",
            "scan_1",
        ];
        let mut names = sorted;
        names.reverse();
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names[..7],
            [
                "a1",
                "a02",
                "a2",
                "a10",
                "a10b",
                "a99999999999999999999",
                "a100000000000000000000"
            ]
        );
        assert_eq!(names[7], "b0");
    }

    proptest! {
        #[test]
        fn natural_order_is_an_order(names in prop::collection::vec("[a01é9]{0,6}", 3)) {
            let [a, b, c] = [&names[0], &names[1], &names[2]];
            prop_assert_eq!(natural_order(a, b), natural_order(b, a).reverse());
            prop_assert_eq!(natural_order(a, b).is_eq(), a == b);
            if natural_order(a, b).is_le() && natural_order(b, c).is_le() {
                prop_assert!(natural_order(a, c).is_le());
            }
        }
    }
}
