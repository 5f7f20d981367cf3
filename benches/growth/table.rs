//! The table of all measurements, a CSV file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Columns of a row; seconds are processor time, "before" is the memory with the data.
const HEAD: &str = "part,what,size,edges or pairs,seconds,scoring seconds,before MiB,peak MiB";
/// Columns behind the size.
pub const SECONDS: usize = 1;
pub const SCORING_SECONDS: usize = 2;
pub const BEFORE: usize = 3;
pub const PEAK: usize = 4;

/// Cells behind the size, by part, variant and size.
pub struct Table(BTreeMap<(String, String, usize), String>);

impl Table {
    /// What was measured earlier, or nothing.
    pub fn read() -> Self {
        let text = std::fs::read_to_string(docs("growth.csv")).unwrap_or_default();
        let row = |line: &str| {
            let mut cells = line.splitn(4, ',').map(str::to_owned);
            let key = (cells.next()?, cells.next()?, cells.next()?.parse().ok()?);
            Some((key, cells.next()?))
        };
        let rows = text.lines().skip(1);
        Self(rows.map(|line| row(line).expect(line)).collect())
    }

    /// Writes the file anew with one more row, or another in its place.
    pub fn insert(&mut self, part: &str, what: &str, size: usize, cells: String) {
        println!("{part},{what},{size},{cells}");
        let key = (part.to_owned(), what.to_owned(), size);
        self.0.insert(key, cells);
        let rows = self.0.iter();
        let rows =
            rows.map(|((part, what, size), cells)| format!("\n{part},{what},{size},{cells}"));
        let text = HEAD.to_owned() + &rows.collect::<String>() + "\n";
        std::fs::write(docs("growth.csv"), text).unwrap();
    }

    /// The sizes, ascending, and the sums of columns times factors, where these are positive.
    pub fn points(&self, part: &str, what: &str, columns: &[(usize, f64)]) -> Vec<(f64, f64)> {
        let point = |((a, b, size), cells): (&(String, String, usize), &String)| {
            let cells: Vec<_> = cells.split(',').collect();
            let terms = columns.iter().map(|(column, factor)| {
                let value = cells.get(*column)?.parse::<f64>().ok()?;
                Some(factor * value)
            });
            let sum = terms.sum::<Option<f64>>()?;
            (a == part && b == what && sum > 0.0).then_some((*size as f64, sum))
        };
        self.0.iter().filter_map(point).collect()
    }
}

/// A file beside the documents.
pub fn docs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../docs")
        .join(name)
}
