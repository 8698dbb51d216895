//! Text layers, put into the words that the parser knows: it lacks some that USD's own reads.

use std::borrow::Cow;

/// Types of before USD 0.8, and those without a meaning here.
const TYPES: [(&str, &str); 30] = [
    ("Vec2i", "int2"),
    ("Vec2h", "half2"),
    ("Vec2f", "float2"),
    ("Vec2d", "double2"),
    ("Vec3i", "int3"),
    ("Vec3h", "half3"),
    ("Vec3f", "float3"),
    ("Vec3d", "double3"),
    ("Vec4i", "int4"),
    ("Vec4h", "half4"),
    ("Vec4f", "float4"),
    ("Vec4d", "double4"),
    ("Point", "point3d"),
    ("PointFloat", "point3f"),
    ("Normal", "normal3d"),
    ("NormalFloat", "normal3f"),
    ("Vector", "vector3d"),
    ("VectorFloat", "vector3f"),
    ("Color", "color3d"),
    ("ColorFloat", "color3f"),
    ("Quath", "quath"),
    ("Quatf", "quatf"),
    ("Quatd", "quatd"),
    ("Matrix2d", "matrix2d"),
    ("Matrix3d", "matrix3d"),
    ("Matrix4d", "matrix4d"),
    ("Frame", "frame4d"),
    ("Transform", "matrix4d"),
    ("opaque", "token"),
    ("pathExpression", "string"),
];

/// Bytes after which a number may begin.
fn is_between(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b'(' | b'[' | b',' | b'=' | b':' | b'{')
}

/// The end of what starts with some marks, at the next such marks.
fn quoted(text: &[u8], start: usize, marks: &[u8], escapes: bool) -> usize {
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

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':')
}

/// The layer's own fields, without its prims: all up to the bracket that closes them.
pub(super) fn head(text: &[u8]) -> Option<&[u8]> {
    let mut at = text.iter().position(|b| *b == b'\n')?;
    let mut depth = 0usize;
    while at < text.len() {
        let rest = &text[at..];
        match text[at] {
            mark @ (b'"' | b'\'') => {
                let marks = if rest.starts_with(&[mark; 3]) { 3 } else { 1 };
                at = quoted(text, at, &rest[..marks], true);
                continue;
            }
            b'@' => {
                let marks = if rest.starts_with(b"@@@") { 3 } else { 1 };
                at = quoted(text, at, &rest[..marks], false);
                continue;
            }
            b'#' => {
                at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
                continue;
            }
            b'(' => depth += 1,
            b')' => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    return text.get(..=at);
                }
            }
            // A prim, and no field stood before it.
            byte if depth == 0 && !byte.is_ascii_whitespace() => return text.get(..at),
            _ => {}
        }
        at += 1;
    }
    None
}

/// Whether the way up from a path ends: of what is no path, the parser's parents may be the same again and again.
fn has_a_root(path: &[u8]) -> bool {
    let strange = |byte: &u8| byte.is_ascii_whitespace() || b"\"'()<@;".contains(byte);
    if path.iter().any(strange) {
        return false;
    }
    let path = std::str::from_utf8(path).ok();
    let mut at = path.and_then(|path| openusd::sdf::Path::new(path).ok());
    while let Some(here) = at {
        at = here.parent();
        if at
            .as_ref()
            .is_some_and(|up| up.as_str().len() >= here.as_str().len())
        {
            return false;
        }
    }
    true
}

/// The text with numbers, types, versions and samples of paths that the parser knows. An error is why it must not be parsed.
pub(super) fn readable(text: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let mut out: Vec<u8> = Vec::new();
    // What has been copied so far.
    let mut copied = 0;
    let mut replace = |from: usize, to: usize, by: &[u8]| {
        out.extend(&text[copied..from]);
        out.extend(by);
        copied = to;
    };
    // The version says which features there may be, and only the parser's own is read.
    let mut at = 0;
    if text.starts_with(b"#usda 1.") {
        let end = text
            .iter()
            .position(|b| matches!(b, b'\n' | b'\r'))
            .unwrap_or(text.len());
        replace(0, end, b"#usda 1.0");
        at = end;
    }
    // The last byte that means something, and the word before the place.
    let mut last = b'\n';
    let mut word: &[u8] = b"";
    while at < text.len() {
        let byte = text[at];
        let rest = &text[at..];
        let start = at;
        match byte {
            b'"' | b'\'' => {
                let marks: &[u8] = if rest.starts_with(&[byte; 3]) {
                    &rest[..3]
                } else {
                    &rest[..1]
                };
                at = quoted(text, at, marks, true);
            }
            b'#' => {
                at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
                continue;
            }
            b'/' if rest.starts_with(b"/*") => {
                at = quoted(text, at, b"*/", false);
                continue;
            }
            b'<' => {
                let end = rest.iter().position(|b| *b == b'>');
                if end.is_some_and(|end| !has_a_root(&rest[1..end])) {
                    return Err("it names a path that is none".into());
                }
                at += end.map_or(1, |end| end + 1);
            }
            b'@' => {
                let marks: &[u8] = if rest.starts_with(b"@@@") {
                    b"@@@"
                } else {
                    b"@"
                };
                at = quoted(text, at, marks, false);
                let inside = text.get(start + marks.len()..at.saturating_sub(marks.len()));
                // A sample of a path, or a field of the layer: the parser reads them as words only.
                let plain =
                    inside.filter(|path| !path.iter().any(|b| matches!(b, b'"' | b'\\' | b'\n')));
                if let Some(path) = plain
                    && (last == b':' || (last == b'=' && word == b"colorConfiguration"))
                {
                    replace(start, at, &[b"\"", path, b"\""].concat());
                }
            }
            b'.' if rest.get(1).is_some_and(u8::is_ascii_digit)
                && is_between(text[start.saturating_sub(1)]) =>
            {
                replace(at, at, b"0");
                at = number_end(text, at);
            }
            b'0'..=b'9' => {
                at = number_end(text, at);
                // "1." and "1.e5".
                let digits = text[start..at]
                    .iter()
                    .take_while(|b| b.is_ascii_digit())
                    .count();
                let dot = start + digits;
                if text.get(dot) == Some(&b'.')
                    && !text.get(dot + 1).is_some_and(u8::is_ascii_digit)
                {
                    replace(dot + 1, dot + 1, b"0");
                }
            }
            b if (is_word(b) && b != b':') || b >= 0x80 => {
                while at < text.len() && (is_word(text[at]) || text[at] >= 0x80) {
                    at += 1;
                }
                let found = &text[start..at];
                if let Some(new) = renamed(found, word, &text[at..]) {
                    replace(start, at, new.as_bytes());
                }
                word = found;
                last = b'a';
                continue;
            }
            _ => at += 1,
        }
        if !byte.is_ascii_whitespace() {
            last = byte;
            if !matches!(byte, b'=') {
                word = b"";
            }
        }
    }
    if copied == 0 && out.is_empty() {
        return Ok(text.into());
    }
    out.extend(&text[copied..]);
    Ok(out.into())
}

/// The new name of a type, where a word stands in a type's place: before a name, and not after `def`.
fn renamed(found: &[u8], before: &[u8], after: &[u8]) -> Option<&'static str> {
    if matches!(before, b"def" | b"over" | b"class") {
        return None;
    }
    let next = after.iter().find(|b| !matches!(b, b' ' | b'\t'))?;
    if !(next.is_ascii_alphabetic() || matches!(next, b'_' | b'[')) {
        return None;
    }
    let known = TYPES.iter().find(|(old, _)| old.as_bytes() == found);
    known.map(|(_, new)| *new)
}

/// The end of a number.
fn number_end(text: &[u8], start: usize) -> usize {
    let mut at = start;
    while let Some(byte) = text.get(at) {
        let signed =
            matches!(byte, b'+' | b'-') && matches!(text[at - 1], b'e' | b'E') && at > start;
        if byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'E') || signed {
            at += 1;
        } else {
            break;
        }
    }
    at
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/text.rs"]
mod tests;
