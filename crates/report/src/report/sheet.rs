//! Tables that the text for a terminal and the page of HTML share.

use comfy_table::{Table, presets};
use std::fmt;

/// Rows under their header.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

/// A table with its introduction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Section {
    pub about: String,
    pub sheet: Sheet,
}

impl Sheet {
    pub fn new<T: AsRef<str>>(header: &[T]) -> Self {
        let header = header.iter().map(|name| name.as_ref().to_owned()).collect();
        Self { header, rows: Vec::new() }
    }

    pub fn add_row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// This table with an introduction.
    pub fn about(self, about: impl Into<String>) -> Section {
        Section { about: about.into(), sheet: self }
    }
}

impl Section {
    /// Introduction and table as text that ends with a newline; empty where there are no rows.
    pub fn text(&self) -> String {
        if self.sheet.rows.is_empty() {
            return String::new();
        }
        format!("{}\n{}\n", self.about, self.sheet)
    }
}

impl fmt::Display for Sheet {
    /// Writes the table without lines and colours on any terminal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        table.force_no_tty();
        table.set_header(&self.header);
        table.add_rows(&self.rows);
        write!(f, "{table}")
    }
}
