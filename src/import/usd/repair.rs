//! Text layers that the parser refuses: what it cannot read is left out and named, so that the rest can be.

use std::borrow::Cow;

use openusd::usda::parser::Parser;

use super::lexis::{is_word, line, opaque_end, shown, statement, word_end};
use super::text::LeftOut;

/// Statements that are left out of a layer, at most.
const MOST_LEFT_OUT: usize = 64;
/// Bytes that are parsed for it, at most.
const MOST_PARSED: usize = 1 << 28;

/// The text without what the parser cannot read. An error is where it ends to be understood.
pub(super) fn repaired(
    text: Cow<'_, [u8]>,
    left_out: &mut Vec<LeftOut>,
) -> Result<Vec<u8>, String> {
    let mut text = text.into_owned();
    let mut parsed = 0;
    for _ in 0..=MOST_LEFT_OUT {
        let place = match std::str::from_utf8(&text) {
            Ok(words) => error(words),
            Err(fault) => Some(fault.valid_up_to()),
        };
        let Some(place) = place else {
            return Ok(text);
        };
        parsed += text.len();
        let Some((start, end)) = enclosing(&text, place).filter(|_| parsed < MOST_PARSED) else {
            return Err(not_understood(&text, place));
        };
        left_out.push(LeftOut {
            line: line(&text, start),
            what: shown(&text, start),
        });
        // Lines keep their numbers.
        for byte in &mut text[start..end] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    let place = std::str::from_utf8(&text).ok().and_then(error);
    match place {
        Some(place) => Err(not_understood(&text, place)),
        None => Ok(text),
    }
}

fn not_understood(text: &[u8], place: usize) -> String {
    let start = text[..place.min(text.len())]
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |before| before + 1);
    let rest = &text[start..];
    let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
    let words = String::from_utf8_lossy(&rest[..end.unwrap_or(rest.len())]);
    let words: String = words.trim().chars().take(60).collect();
    format!(
        "its line {} is not understood: \"{words}\"",
        line(text, place)
    )
}

/// Where the parser stops, if it does.
fn error(text: &str) -> Option<usize> {
    let mut parser = Parser::new(text);
    parser.parse().err()?;
    let Some(told) = parser.last_error_highlight() else {
        return Some(0);
    };
    let before = text.split_inclusive('\n').take(told.line.saturating_sub(1));
    let start: usize = before.map(str::len).sum();
    let on_line = text[start..].chars().take(told.column.saturating_sub(1));
    Some(start + on_line.map(char::len_utf8).sum::<usize>())
}

/// A bracket that is open.
struct Open {
    /// Statements stand in it.
    statements: bool,
    /// Where the last of them ends.
    until: usize,
}

/// The innermost statement that a place is in. Prims are none: what stands in them would be lost with them.
fn enclosing(text: &[u8], place: usize) -> Option<(usize, usize)> {
    let mut open = vec![Open {
        statements: true,
        until: 0,
    }];
    let mut found = None;
    let mut work = 0;
    let (mut at, mut last) = (0, b'\n');
    while at < text.len() && at <= place {
        if let Some(end) = opaque_end(text, at) {
            if !matches!(text[at], b'#' | b'/') {
                last = text[at];
            }
            // A comment among fields is a statement, but one that is always understood.
            at = end;
            continue;
        }
        let byte = text[at];
        match byte {
            b'{' | b'(' | b'[' => {
                let value = matches!(last, b'=' | b',' | b'(' | b'[' | b':');
                open.push(Open {
                    statements: byte != b'[' && !value,
                    until: 0,
                });
            }
            b'}' | b')' | b']' if open.len() > 1 => {
                open.pop();
            }
            b if is_word(b) => {
                let stop = word_end(text, at);
                let word = &text[at..stop];
                let prim = matches!(word, b"def" | b"over" | b"class" | b"variantSet");
                let inner = open.last_mut().filter(|o| o.statements && at >= o.until);
                if let Some(inner) = inner.filter(|_| !prim) {
                    // The type and the name of a prim stand behind its word.
                    let named = text[stop..].trim_ascii_start().first() == Some(&b'"');
                    let (end, _) = statement(text, at);
                    // Of what stands in what stands in what, each is followed to its end.
                    work += end - at;
                    if work > MOST_PARSED {
                        return None;
                    }
                    inner.until = end;
                    if (at..end).contains(&place) && !(named && last == b'd') {
                        found = Some((at, end));
                    }
                }
                last = if prim { b'd' } else { b'a' };
                at = stop;
                continue;
            }
            _ => {}
        }
        if !byte.is_ascii_whitespace() {
            last = byte;
        }
        at += 1;
    }
    found
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/repair.rs"]
mod tests;
