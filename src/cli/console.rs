//! Where words leave the program: the standard output and the standard error.

use serde::Serialize;
use std::io::{IsTerminal, Write};

/// Writes to the standard output; false if nobody reads it any more. A reader that has gone away
/// (`sundog info x | head`) is no error.
pub fn output(text: &str) -> bool {
    let mut stdout = std::io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    !written.is_err_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Writes a line to the standard error.
pub fn message(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Writes one JSON object as one line to the standard output; false if nobody reads it any more.
pub fn json_line(value: &impl Serialize) -> bool {
    match serde_json::to_string(value) {
        Ok(line) => output(&format!("{line}\n")),
        Err(error) => {
            message(&format!("sundog: cannot write JSON: {error}"));
            true
        }
    }
}

/// Writes a value as readable JSON to the standard output.
pub fn json_document(value: &impl Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => {
            output(&format!("{text}\n"));
        }
        Err(error) => message(&format!("sundog: cannot write JSON: {error}")),
    }
}

/// Whether somebody watches the standard error.
pub fn watched() -> bool {
    std::io::stderr().is_terminal()
}

/// `1234567` as `1 234 567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut result = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            result.push(' ');
        }
        result.push(digit);
    }
    result
}

/// Bytes in the unit that gives a short number.
pub fn bytes(number: u64) -> String {
    let mut value = number as f64;
    let mut unit = "B";
    for next in ["KiB", "MiB", "GiB", "TiB"] {
        if value < 1024.0 {
            break;
        }
        value /= 1024.0;
        unit = next;
    }
    if unit == "B" {
        format!("{number} B")
    } else {
        format!("{value:.1} {unit}")
    }
}

/// `75.3` as `1:15`, `4000` as `1:06:40`, below a minute as `5.3 s`.
pub fn clock(seconds: f64) -> String {
    if seconds < 60.0 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1 000");
        assert_eq!(grouped(1_234_567), "1 234 567");
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1024), "1.0 KiB");
        assert_eq!(bytes(3 * 1024 * 1024 / 2), "1.5 MiB");
        assert_eq!(clock(5.34), "5.3 s");
        assert_eq!(clock(75.3), "1:15");
        assert_eq!(clock(4000.0), "1:06:40");
    }
}
