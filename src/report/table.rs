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
mod tests {
    use crate::report::{Axis, Cell, Column, Plot, Point, Series, Table};

    #[test]
    fn points_keep_all_digits() {
        let plot = Plot {
            x: Axis::log("time", "s"),
            y: Axis::log("error", "%"),
            series: vec![Series::new(
                "cornell, \"seed\" 1",
                vec![
                    Point::new(0.1, 1.0 / 3.0).labelled("1 sample"),
                    Point::new(2.0, f64::NAN).spread(0.5, f64::INFINITY),
                ],
            )],
            ..Plot::default()
        };
        assert_eq!(
            plot.csv(),
            "series,time (s),error (%),low,high,label\r\n\
             \"cornell, \"\"seed\"\" 1\",0.1,0.3333333333333333,,,1 sample\r\n\
             \"cornell, \"\"seed\"\" 1\",2,NaN,0.5,inf,\r\n"
        );
    }

    #[test]
    fn tables_keep_all_digits() {
        let table = Table {
            columns: vec![Column::new("measure"), Column::new("value")],
            rows: vec![vec![Cell::text("a\nb"), Cell::number(1.0 / 3.0)]],
            ..Table::default()
        };
        assert_eq!(
            table.csv(),
            "measure,value\r\n\"a\nb\",0.3333333333333333\r\n"
        );
    }

    #[test]
    fn columns_stand_below_their_names() {
        let cells = |a: &str, b: &str| vec![Cell::text(a), Cell::shown(1.0, b)];
        let shown = Table {
            columns: vec![Column::new("effect"), Column::new("costs")],
            rows: vec![cells("lamps", "1 s"), cells("a long\nname", "-20 ms")],
            ..Table::default()
        };
        assert_eq!(
            shown.text(),
            "effect         costs\nlamps            1 s\na long\\nname  -20 ms\n"
        );
    }
}
