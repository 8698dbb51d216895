//! Tables on the terminal, and numbers as people say them.

use crate::cli::console;
use crate::film::error::ErrorEstimate;
use crate::render::Expected;
use crate::report::{Cell, Table};

/// Smaller numbers are told as 0.
const MOST_DECIMALS: i32 = 9;

/// Columns below their names, words to the left, numbers to the right.
pub fn table(table: &Table) -> String {
    let heads = table.columns.iter().map(|column| column.name.clone());
    let mut lines: Vec<Vec<String>> = vec![heads.collect()];
    for row in &table.rows {
        let words = row
            .iter()
            .map(|cell| console::one_line(&cell.text).into_owned());
        lines.push(words.collect());
    }
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|text| text.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..table.columns.len()).map(width).collect();
    let is_number =
        |row: &Vec<Cell>, column: usize| row.get(column).is_some_and(|c| c.value.is_some());
    let numbers = |column: usize| table.rows.iter().any(|row| is_number(row, column));
    let numbers: Vec<bool> = (0..widths.len()).map(numbers).collect();
    let mut result = String::new();
    for line in &lines {
        let mut text = String::new();
        for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
            let gap = if column == 0 { "" } else { "  " };
            if numbers[column] {
                text.push_str(&format!("{gap}{cell:>width$}"));
            } else {
                text.push_str(&format!("{gap}{cell:<width$}"));
            }
        }
        result.push_str(text.trim_end());
        result.push('\n');
    }
    result
}

/// `2.4 %`: two digits, more where there are more before the point.
pub fn percent(share: f64) -> String {
    format!("{} %", in_percent(share, 2))
}

/// `2.10 % (1.93 to 2.42 %)`: three digits.
pub fn error(error: &ErrorEstimate) -> String {
    let [error, low, high] = [error.error, error.low, error.high].map(|e| in_percent(e, 3));
    format!("{error} % ({low} to {high} %)")
}

/// So many digits, as many decimals as that takes.
fn in_percent(share: f64, digits: i32) -> String {
    let percent = 100.0 * share;
    let decimals = if percent == 0.0 {
        0
    } else {
        (digits - 1 - percent.abs().log10().floor() as i32).clamp(0, MOST_DECIMALS) as usize
    };
    format!("{percent:.decimals$}")
}

/// `45 s (38 s to 53 s)`.
pub fn interval(value: Expected, show: impl Fn(f64) -> String) -> String {
    let [expected, low, high] = [value.expected, value.low, value.high].map(show);
    format!("{expected} ({low} to {high})")
}

/// `40 ms`, `4.2 s`, `1:15`: a length of time, of two digits where it is short.
pub fn time(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "for ever".into();
    }
    if seconds.abs() < 0.0995 {
        return format!("{:.0} ms", 1000.0 * seconds);
    }
    if seconds < 0.0 {
        return format!("-{}", time(-seconds));
    }
    match seconds {
        s if s < 0.995 => format!("{s:.2} s"),
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 59.5 => format!("{s:.0} s"),
        s => console::clock(s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Column;

    #[test]
    fn numbers_as_people_say_them() {
        assert_eq!(percent(0.0237), "2.4 %");
        assert_eq!(percent(0.237), "24 %");
        assert_eq!(percent(0.000_237), "0.024 %");
        assert_eq!(percent(2.0), "200 %");
        assert_eq!(percent(0.0), "0 %");
        let told = ErrorEstimate {
            error: 0.0214,
            low: 0.019_32,
            high: 0.1,
        };
        assert_eq!(error(&told), "2.14 % (1.93 to 10.0 %)");
        assert_eq!(time(0.012), "12 ms");
        assert_eq!(time(-0.5), "-0.50 s");
        assert_eq!(time(4.23), "4.2 s");
        assert_eq!(time(42.3), "42 s");
        assert_eq!(time(75.3), "1:15");
        assert_eq!(time(f64::INFINITY), "for ever");
    }

    #[test]
    fn columns_stand_below_their_names() {
        let cells = |a: &str, b: &str| vec![Cell::text(a), Cell::shown(1.0, b)];
        let shown = table(&Table {
            columns: vec![Column::new("effect"), Column::new("costs")],
            rows: vec![cells("lamps", "1 s"), cells("a long name", "-20 ms")],
            ..Table::default()
        });
        assert_eq!(
            shown,
            "effect        costs\nlamps           1 s\na long name  -20 ms\n"
        );
    }
}
