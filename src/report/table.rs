//! Tables of numbers as CSV (RFC 4180) and as lines of text.

use super::{Cell, Plot, Table};
use std::fmt::Write as _;

impl Plot {
    /// All points, a line each, as numbers: also those that the plot cannot show.
    pub fn csv(&self) -> String {
        let mut text = line([
            "series".to_owned(),
            self.x.title(),
            self.y.title(),
            "low".to_owned(),
            "high".to_owned(),
            "label".to_owned(),
        ]);
        let optional =
            |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        for series in &self.series {
            for point in &series.points {
                text += &line([
                    series.name.clone(),
                    point.x.to_string(),
                    point.y.to_string(),
                    optional(point.low),
                    optional(point.high),
                    point.label.clone(),
                ]);
            }
        }
        text
    }
}

impl Table {
    /// The cells, numbers in full.
    pub fn csv(&self) -> String {
        let mut text = line(self.columns.iter().map(|column| column.name.clone()));
        for row in &self.rows {
            text += &line(row.iter().map(|cell| match cell.value {
                Some(value) => value.to_string(),
                None => cell.text.clone(),
            }));
        }
        text
    }

    /// Columns below their names, words to the left, numbers to the right.
    pub fn text(&self) -> String {
        let heads = self.columns.iter().map(|column| column.name.clone());
        let mut lines: Vec<Vec<String>> = vec![heads.collect()];
        // A name that breaks the line would break the table.
        let words = |cell: &Cell| cell.text.replace('\n', "\\n");
        lines.extend(self.rows.iter().map(|row| row.iter().map(words).collect()));
        let width = |column: usize| {
            let cells = lines.iter().filter_map(|line| line.get(column));
            cells.map(|text| text.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let numeric = self.numeric_columns();
        let mut result = String::new();
        for line in &lines {
            let mut text = String::new();
            for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
                let gap = if column == 0 { "" } else { "  " };
                let _ = if numeric[column] {
                    write!(text, "{gap}{cell:>width$}")
                } else {
                    write!(text, "{gap}{cell:<width$}")
                };
            }
            result += text.trim_end();
            result += "\n";
        }
        result
    }

    /// Which columns hold numbers.
    pub(super) fn numeric_columns(&self) -> Vec<bool> {
        let is_number = |column: usize| {
            let mut cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.any(|cell| cell.value.is_some())
        };
        (0..self.columns.len()).map(is_number).collect()
    }
}

fn line(fields: impl IntoIterator<Item = String>) -> String {
    let fields: Vec<_> = fields.into_iter().map(|field| quoted(&field)).collect();
    fields.join(",") + "\r\n"
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
#[path = "../../tests/unit/report/table.rs"]
mod tests;
