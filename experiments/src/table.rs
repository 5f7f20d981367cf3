//! Tables in Markdown, which a terminal shows as well.

use comfy_table::presets::ASCII_MARKDOWN;
use gmpcr_eval::Spread;

/// A titled table; empty cells stay empty.
pub struct Table {
    title: String,
    inner: comfy_table::Table,
}

impl Table {
    pub fn new(title: impl Into<String>, header: impl IntoIterator<Item = impl ToString>) -> Self {
        let mut inner = comfy_table::Table::new();
        inner.load_style(ASCII_MARKDOWN);
        inner.set_header(header.into_iter().map(|cell| cell.to_string()));
        Self {
            title: title.into(),
            inner,
        }
    }

    pub fn row(&mut self, cells: impl IntoIterator<Item = impl ToString>) {
        self.inner
            .add_row(cells.into_iter().map(|cell| cell.to_string()));
    }

    /// Appends the table to a text, unless it has no rows.
    pub fn append_to(&self, text: &mut String) {
        if self.inner.is_empty() {
            return;
        }
        text.push_str(&format!("\n### {}\n\n{}\n", self.title, self.inner));
    }
}

/// Percent with one digit, and the standard deviation where there were several runs.
pub fn percent(ratio: Option<Spread>) -> String {
    match ratio {
        None => "–".to_owned(),
        Some(Spread { mean, count: 1, .. }) => format!("{:.1}", 100.0 * mean),
        Some(Spread { mean, std_dev, .. }) => {
            format!("{:.1} ± {:.1}", 100.0 * mean, 100.0 * std_dev)
        }
    }
}

/// The mean in units of `1 / factor`, with this many digits.
pub fn number(value: Option<Spread>, factor: f64, digits: usize) -> String {
    value.map_or("–".to_owned(), |spread| {
        format!("{:.digits$}", factor * spread.mean)
    })
}
