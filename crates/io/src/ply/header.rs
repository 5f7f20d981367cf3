//! The header, simplified for its parser.
//!
//! The parser crate refuses blank lines, bytes that are not text, and names of properties that are not
//! identifiers. All of these occur in files of common programs, and none is needed here.

use super::names::{NORMAL, axis};

/// Whether the line ends the header.
pub(super) fn is_last_line(line: &str) -> bool {
    line.trim_ascii() == "end_header"
}

/// The header with the same number of lines. Lines that declare nothing become empty comments.
/// Properties other than coordinates and normals get neutral names.
pub(super) fn plain(header: &str) -> String {
    let lines = header.lines().enumerate();
    let plain = lines.map(|(place, line)| plain_line(line, place) + "\n");
    plain.collect()
}

fn plain_line(line: &str, place: usize) -> String {
    let mut words: Vec<&str> = line.split_ascii_whitespace().collect();
    let before_name = match words[..] {
        [] | ["comment" | "obj_info", ..] => return "comment".to_owned(),
        ["property", "list", ..] => 4,
        ["property", ..] => 2,
        _ => return words.join(" "),
    };
    let neutral = format!("p{place}");
    match words[before_name.min(words.len())..] {
        [] => {}
        [name] if axis(name).is_some() || NORMAL.contains(&name) => {}
        [..] => words.splice(before_name.., [&*neutral]).for_each(drop),
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_coordinates_and_normals_keep_their_name() {
        for (line, expected) in [
            ("property float x", "property float x"),
            ("property float nz", "property float nz"),
            ("  property\tfloat  y \r", "property float y"),
            ("property float R/G", "property float p7"),
            ("property float two words", "property float p7"),
            ("property list uchar int z", "property list uchar int z"),
            ("property list uchar int é", "property list uchar int p7"),
            ("property float", "property float"),
            ("property list uchar", "property list uchar"),
            ("element vertex 2", "element vertex 2"),
            ("obj_info x", "comment"),
            ("comment", "comment"),
            (" ", "comment"),
        ] {
            assert_eq!(plain_line(line, 7), expected);
        }
    }

    #[test]
    fn lines_keep_their_number() {
        assert_eq!(plain("ply\r\n\nend_header\n"), "ply\ncomment\nend_header\n");
    }
}
