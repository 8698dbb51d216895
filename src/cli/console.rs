//! Where words leave the program: the standard output and the standard error. Names come from files and may hold anything:
//! what would command the terminal, or turn the order of letters about, is shown as what it is.

pub use crate::math::words::{bytes, clock, grouped};
use crate::report::is_unseen;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::OnceLock;

/// Why the standard output did not take what was written to it.
static LOST: OnceLock<String> = OnceLock::new();

/// Writes to the standard output; false if nobody reads it any more. A reader that has gone away
/// (`sundog info x | head`) is no error; what else goes wrong is told by [`lost`].
pub fn output(text: &str) -> bool {
    let text = escaped(text, is_unseen_in_lines, by_rust);
    let mut stdout = std::io::stdout().lock();
    let written = stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush());
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => return false,
        Err(error) => {
            LOST.get_or_init(|| match error.kind() {
                ErrorKind::StorageFull => "the disk is full".into(),
                ErrorKind::QuotaExceeded => "the disk quota is used up".into(),
                _ => error.to_string(),
            });
        }
        Ok(()) => {}
    }
    true
}

/// Why something that was written to the standard output has not got there, if that is so.
pub fn lost() -> Option<&'static str> {
    LOST.get().map(String::as_str)
}

/// Writes a line to the standard error.
pub fn message(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", one_line(text));
}

/// Writes a warning to the standard error.
pub fn warn(text: &str) {
    message(&format!("sundog: warning: {text}"));
}

/// Writes lines to the standard error.
pub fn page(text: &str) {
    text.lines().for_each(message);
}

/// A text in which nothing breaks a line or commands the terminal.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_unseen, by_rust)
}

/// What would command the terminal where lines may end.
fn is_unseen_in_lines(symbol: char) -> bool {
    is_unseen(symbol) && symbol != '\n'
}

/// A symbol as `\n` or `\u{1b}`.
fn by_rust(result: &mut String, symbol: char) {
    result.extend(symbol.escape_default());
}

/// A symbol as JSON writes it, by its units of UTF-16.
fn by_json(result: &mut String, symbol: char) {
    for unit in symbol.encode_utf16(&mut [0; 2]) {
        let _ = write!(result, "\\u{unit:04x}");
    }
}

/// A text with some symbols written in another way.
fn escaped(
    text: &str,
    is_escaped: impl Fn(char) -> bool,
    write: impl Fn(&mut String, char),
) -> Cow<'_, str> {
    if !text.chars().any(&is_escaped) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len() + 16);
    for symbol in text.chars() {
        if is_escaped(symbol) {
            write(&mut result, symbol);
        } else {
            result.push(symbol);
        }
    }
    result.into()
}

/// JSON with what it allows in texts and a terminal obeys (the controls from U+007F on) escaped its own way.
fn escaped_json(text: &str) -> Cow<'_, str> {
    escaped(text, is_unseen_in_lines, by_json)
}

/// Empties the line that the terminal's cursor is in. Asks for no lock: another thread may hold it for ever.
pub fn empty_line() {
    let _ = rustix::io::write(std::io::stderr(), b"\r\x1b[2K");
}

/// Writes one JSON object as one line to the standard output; false if nobody reads it any more.
pub fn json_line(value: &impl Serialize) -> bool {
    match serde_json::to_string(value) {
        Ok(line) => output(&format!("{}\n", escaped_json(&line))),
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
            output(&format!("{}\n", escaped_json(&text)));
        }
        Err(error) => message(&format!("sundog: cannot write JSON: {error}")),
    }
}

/// Whether somebody watches the standard error.
pub fn watched() -> bool {
    std::io::stderr().is_terminal()
}

#[cfg(test)]
#[path = "../../tests/unit/cli/console.rs"]
mod tests;
