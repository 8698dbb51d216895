//! Where words, strings and statements of a text layer end.

/// The end of what starts with some marks, at the next such marks.
pub(super) fn quoted(text: &[u8], start: usize, marks: &[u8], escapes: bool) -> usize {
    let mut at = start + marks.len();
    while at < text.len() {
        if escapes && text[at] == b'\\' {
            at += 2;
        } else if text[at..].starts_with(marks) {
            return at + marks.len();
        } else {
            at += 1;
        }
    }
    text.len()
}

/// The marks that a string or an asset path at this place begins with.
pub(super) fn marks(rest: &[u8]) -> &[u8] {
    let mark = rest[0];
    if rest.starts_with(&[mark; 3]) {
        &rest[..3]
    } else {
        &rest[..1]
    }
}

/// The end of an asset path. Between three marks there may be three of them behind a stroke.
pub(super) fn asset_end(text: &[u8], start: usize) -> usize {
    let marks = marks(&text[start..]);
    let mut end = quoted(text, start, marks, false);
    while marks.len() == 3 && end < text.len() && text[..end - 3].ends_with(b"\\") {
        end = quoted(text, end - 3, marks, false);
    }
    end
}

pub(super) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':') || byte >= 0x80
}

/// The end of a word, or of what takes its place.
pub(super) fn word_end(text: &[u8], start: usize) -> usize {
    let length = text[start..].iter().position(|b| !is_word(*b));
    length.map_or(text.len(), |length| start + length)
}

/// The end of a number.
pub(super) fn number_end(text: &[u8], start: usize) -> usize {
    let mut at = start;
    while let Some(byte) = text.get(at) {
        let signed =
            matches!(byte, b'+' | b'-') && at > start && matches!(text[at - 1], b'e' | b'E');
        if byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'E') || signed {
            at += 1;
        } else {
            break;
        }
    }
    at
}

/// The end of a comment, a string, a path or a place in a scene that begins here; `None` where none does.
pub(super) fn opaque_end(text: &[u8], at: usize) -> Option<usize> {
    let rest = &text[at..];
    let line = || at + rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
    match rest.first()? {
        b'"' | b'\'' => Some(quoted(text, at, marks(rest), true)),
        b'@' => Some(asset_end(text, at)),
        b'#' => Some(line()),
        b'/' if rest.starts_with(b"//") => Some(line()),
        b'/' if rest.starts_with(b"/*") => Some(quoted(text, at, b"*/", false)),
        b'<' => Some(
            at + rest
                .iter()
                .position(|b| *b == b'>')
                .map_or(1, |end| end + 1),
        ),
        _ => None,
    }
}

fn is_comment(rest: &[u8]) -> bool {
    rest.starts_with(b"#") || rest.starts_with(b"//") || rest.starts_with(b"/*")
}

/// The next place that is neither white nor a comment. Ends of lines count as white if `lines` says so.
pub(super) fn skip_white(text: &[u8], start: usize, lines: bool) -> usize {
    let mut at = start;
    while let Some(byte) = text.get(at) {
        if is_comment(&text[at..]) {
            at = opaque_end(text, at).unwrap_or(at + 1);
        } else if byte.is_ascii_whitespace() && (lines || !matches!(byte, b'\n' | b'\r')) {
            at += 1;
        } else {
            break;
        }
    }
    at.min(text.len())
}

/// The end of what a bracket at this place opens.
pub(super) fn closed(text: &[u8], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0usize);
    while at < text.len() {
        if let Some(end) = opaque_end(text, at) {
            at = end;
            continue;
        }
        match text[at] {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        at += 1;
        if depth == 0 {
            break;
        }
    }
    at.min(text.len())
}

/// The end of a value: a group, a string, a path with a place in it, a number or words.
pub(super) fn value_end(text: &[u8], start: usize) -> usize {
    match text.get(start) {
        None => text.len(),
        Some(b'(' | b'[' | b'{') => closed(text, start),
        Some(b'@') => {
            let end = opaque_end(text, start).unwrap_or(start + 1);
            let next = skip_white(text, end, false);
            match text.get(next) {
                Some(b'<') => opaque_end(text, next).unwrap_or(end),
                _ => end,
            }
        }
        Some(b'"' | b'\'' | b'<') => opaque_end(text, start).unwrap_or(start + 1),
        Some(_) => {
            let ends = |byte: &u8| byte.is_ascii_whitespace() || b",;)]}({[".contains(byte);
            let length = text[start..].iter().position(ends);
            length.map_or(text.len(), |length| start + length.max(1))
        }
    }
}

/// Bytes before a statement's value, at most: more are none, and each word of a text could be followed to its end.
const LONGEST_NAME: usize = 512;

/// A statement: where it ends, and where its value begins if it has one.
pub(super) fn statement(text: &[u8], start: usize) -> (usize, Option<usize>) {
    let mut at = start;
    let mut value = None;
    while at < text.len() && at < start + LONGEST_NAME {
        match text[at] {
            b'=' => {
                let mut begins = skip_white(text, at + 1, true);
                // "= prepend [...]".
                for operation in [b"add".as_slice(), b"append", b"prepend", b"delete"] {
                    let rest = &text[begins..];
                    let spaced = rest.get(operation.len()).is_some_and(|b| !is_word(*b));
                    if rest.starts_with(operation) && spaced {
                        begins = skip_white(text, begins + operation.len(), true);
                        break;
                    }
                }
                value = Some(begins);
                at = value_end(text, begins);
                break;
            }
            b'(' | b')' | b'{' | b'}' | b';' | b',' | b'\n' => break,
            // "int []".
            b'[' if text.get(skip_white(text, at + 1, false)) != Some(&b']') => break,
            _ => at = opaque_end(text, at).unwrap_or(at + 1),
        }
    }
    // What is said of it.
    let next = skip_white(text, at, true);
    if text.get(next) == Some(&b'(') {
        at = closed(text, next);
    }
    (at.clamp(start + 1, text.len().max(start + 1)), value)
}

/// The number of the line that a place is in.
pub(super) fn line(text: &[u8], at: usize) -> usize {
    let before = &text[..at.min(text.len())];
    1 + before.iter().filter(|b| **b == b'\n').count()
}

/// The beginning of a statement, for messages.
pub(super) fn shown(text: &[u8], start: usize) -> String {
    let rest = &text[start.min(text.len())..];
    let ends = |b: &u8| matches!(b, b'=' | b'\n' | b'\r' | b'(' | b'{');
    let end = rest.iter().position(ends).unwrap_or(rest.len());
    let words = String::from_utf8_lossy(&rest[..end]);
    words.trim().chars().take(60).collect()
}

/// A name in letters that the parser knows; others get others.
pub(super) fn encoded(name: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for byte in name {
        if byte.is_ascii() {
            out.push(*byte);
        } else {
            out.extend(format!("_x{byte:02x}").as_bytes());
        }
    }
    out
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/lexis.rs"]
mod tests;
