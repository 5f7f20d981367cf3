//! Tables and numbers for people.

use comfy_table::{CellAlignment, Table, presets};

/// A table with a first column of words and others of numbers.
pub fn table<Row: IntoIterator<Item = String>>(
    header: &[&str],
    rows: impl IntoIterator<Item = Row>,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header);
    for row in rows {
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = String::new();
    for line in table.lines() {
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Three significant digits, whatever the unit of the scans.
pub fn significant(length: f64) -> String {
    let digits_before = length.abs().log10().floor() as i32;
    match length {
        0.0 => "0".into(),
        _ if digits_before < -4 => format!("{length:.1e}"),
        _ => format!("{length:.*}", (2 - digits_before).max(0) as usize),
    }
}

/// `1 edge`, `2 edges`.
pub fn counted(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_three_digits() {
        for (length, text) in [
            (0.0, "0"),
            (0.043_41, "0.0434"),
            (-2.5, "-2.50"),
            (1234.5, "1234"),
            (4.62e-12, "4.6e-12"),
        ] {
            assert_eq!(significant(length), text);
        }
    }
}
