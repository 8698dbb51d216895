//! Text layers, put into the words that the parser knows: it lacks some that USD's own reads.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::lexis::{
    asset_end, closed, encoded, is_word, line, marks, number_end, opaque_end, quoted, shown,
    skip_white, statement, word_end,
};

/// Types of before USD 0.8, and those without a meaning here.
const TYPES: [(&str, &str); 34] = [
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
    ("PointIndex", "int"),
    ("EdgeIndex", "int"),
    ("FaceIndex", "int"),
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
    ("group", "token"),
    ("pathExpression", "string"),
];
/// Types that the parser knows: their stems, and what may follow those.
const STEMS: [(&str, &[&str]); 19] = [
    ("int", &["", "2", "3", "4", "64"]),
    ("uint", &["", "64"]),
    ("half", &["", "2", "3", "4"]),
    ("float", &["", "2", "3", "4"]),
    ("double", &["", "2", "3", "4"]),
    ("point3", &["h", "f", "d"]),
    ("normal3", &["h", "f", "d"]),
    ("vector3", &["h", "f", "d"]),
    ("color3", &["h", "f", "d"]),
    ("color4", &["h", "f", "d"]),
    ("texCoord2", &["h", "f", "d"]),
    ("texCoord3", &["h", "f", "d"]),
    ("quat", &["h", "f", "d"]),
    ("matrix2", &["d"]),
    ("matrix3", &["d"]),
    ("matrix4", &["d"]),
    ("frame4", &["d"]),
    ("time", &["code"]),
    (
        "",
        &["bool", "uchar", "string", "token", "asset", "dictionary"],
    ),
];
/// Words that stand before a type, or in its place.
const KEYWORDS: [&str; 18] = [
    "add",
    "append",
    "class",
    "config",
    "custom",
    "def",
    "delete",
    "over",
    "prepend",
    "rel",
    "reorder",
    "uniform",
    "variantSet",
    "varying",
    "post",
    "pre",
    "loop",
    "bezier",
];
/// Fields of prims that lists may be edited of.
const LISTED: [&str; 7] = [
    "apiSchemas",
    "clipSets",
    "inherits",
    "payload",
    "references",
    "specializes",
    "variantSets",
];
/// Fields whose values are paths of files to the parser.
const FILES: [&str; 3] = ["payload", "references", "subLayers"];

/// Something that a layer says and that is not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LeftOut {
    pub line: usize,
    /// How it begins.
    pub what: String,
}

/// A text that the parser knows.
#[derive(Debug)]
pub(super) struct Readable<'a> {
    pub text: Cow<'a, [u8]>,
    pub left_out: Vec<LeftOut>,
    /// It has sublayers, or prims that inherit or specialize others.
    pub arcs: bool,
}

/// Bytes after which a number may begin.
fn is_between(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b'(' | b'[' | b',' | b'=' | b':' | b'{')
}

fn is_known(name: &[u8]) -> bool {
    STEMS.iter().any(|(stem, ends)| {
        let end = name.strip_prefix(stem.as_bytes());
        end.is_some_and(|end| ends.iter().any(|e| e.as_bytes() == end))
    })
}

fn is_one_of(found: &[u8], words: &[&str]) -> bool {
    words.iter().any(|word| word.as_bytes() == found)
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

/// What a bracket that is open holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inside {
    /// Statements of a prim, or variants.
    Body,
    /// Fields of a layer, a prim or a property.
    Fields,
    /// A dictionary, samples over time, or a spline.
    Map,
    /// Values.
    Values,
}

/// A layer's text that is being put into other words.
struct Reader<'a> {
    text: &'a [u8],
    out: Vec<u8>,
    /// What has been copied so far.
    copied: usize,
    at: usize,
    open: Vec<Inside>,
    /// The last byte that means something, and the word before the place.
    last: u8,
    word: &'a [u8],
    /// Where the statement begins, if words stand before its type.
    begins: usize,
    /// The type of the statement, and where the word after it ends.
    kind: &'a [u8],
    whole: bool,
    name_end: usize,
    /// The field that is being said.
    field: &'a [u8],
    /// A set of variants is being opened.
    variants: bool,
    /// Names with letters that the parser does not know.
    strange: BTreeSet<&'a [u8]>,
    left_out: Vec<LeftOut>,
    /// A place, and the number of its line.
    counted: (usize, usize),
    arcs: bool,
}

/// The text in words that the parser knows, and what had to be left out. An error is why it must not be parsed.
pub(super) fn readable(text: &[u8]) -> Result<Readable<'_>, String> {
    let mut reader = Reader {
        text,
        out: Vec::new(),
        copied: 0,
        at: 0,
        open: Vec::new(),
        last: b'\n',
        word: b"",
        begins: 0,
        kind: b"",
        whole: false,
        name_end: 0,
        field: b"",
        variants: false,
        strange: strange_names(text),
        left_out: Vec::new(),
        counted: (0, 1),
        arcs: false,
    };
    // The version says which features there may be, and only the parser's own is read.
    if text.starts_with(b"#usda") {
        let end = text
            .iter()
            .position(|b| matches!(b, b'\n' | b'\r'))
            .unwrap_or(text.len());
        let version = text[5..end].trim_ascii();
        if version.starts_with(b"1.") {
            reader.replace(0, end, b"#usda 1.0");
        }
        reader.at = end;
    }
    while reader.at < text.len() {
        reader.step()?;
    }
    let text = if reader.copied == 0 && reader.out.is_empty() {
        text.into()
    } else {
        reader.out.extend(&text[reader.copied..]);
        reader.out.into()
    };
    Ok(Readable {
        text,
        left_out: reader.left_out,
        arcs: reader.arcs,
    })
}

impl<'a> Reader<'a> {
    fn replace(&mut self, from: usize, to: usize, by: &[u8]) {
        self.out.extend(&self.text[self.copied..from]);
        self.out.extend(by);
        self.copied = to;
    }

    /// Names what is left out at a place behind all others that were.
    fn tell(&mut self, at: usize, what: String) {
        let (before, number) = self.counted;
        // Lines are counted once: there may be very many of both.
        let number = number + line(&self.text[before..], at - before) - 1;
        self.counted = (at, number);
        self.left_out.push(LeftOut { line: number, what });
    }

    /// Leaves out what stands from one place to another, and names it.
    fn leave_out(&mut self, from: usize, to: usize) {
        let what = shown(self.text, from);
        self.tell(from, what);
        self.replace(from, to, b"");
        self.at = to;
        self.kind = b"";
        self.last = b';';
    }

    fn inside(&self) -> Inside {
        self.open.last().copied().unwrap_or(Inside::Body)
    }

    /// Takes what stands at the place.
    fn step(&mut self) -> Result<(), String> {
        let (text, start) = (self.text, self.at);
        let byte = text[start];
        let rest = &text[start..];
        match byte {
            b'"' | b'\'' => self.string()?,
            b'#' => {
                self.at = opaque_end(text, start).unwrap_or(start + 1);
                return Ok(());
            }
            b'/' if rest.starts_with(b"//") => {
                self.at = opaque_end(text, start).unwrap_or(start + 2);
                self.replace(start, self.at, b"");
                return Ok(());
            }
            b'/' if rest.starts_with(b"/*") => {
                self.at = quoted(text, start, b"*/", false);
                return Ok(());
            }
            b'<' => self.place()?,
            b'@' => self.file(),
            b'.' if rest.get(1).is_some_and(u8::is_ascii_digit)
                && is_between(text[start.saturating_sub(1)]) =>
            {
                self.replace(start, start, b"0");
                self.at = number_end(text, start);
            }
            b'0'..=b'9' => self.number(),
            b if is_word(b) && b != b':' => {
                self.word();
                return Ok(());
            }
            _ => {
                self.bracket(byte);
                self.at += 1;
            }
        }
        if !byte.is_ascii_whitespace() {
            self.last = byte;
            if !matches!(byte, b'=') {
                self.word = b"";
            }
        }
        Ok(())
    }

    fn bracket(&mut self, byte: u8) {
        let values = matches!(self.last, b'=' | b',' | b'(' | b'[' | b':' | b'-' | b'+');
        match byte {
            b'{' if self.last == b'=' && self.variants => {
                self.variants = false;
                self.open.push(Inside::Body);
            }
            b'{' if matches!(self.last, b'=' | b':' | b';') && self.inside() != Inside::Body => {
                self.open.push(Inside::Map);
            }
            b'{' if self.last == b'=' => self.open.push(Inside::Map),
            b'{' => {
                self.kind = b"";
                self.open.push(Inside::Body);
            }
            b'(' if values && self.inside() != Inside::Fields => self.open.push(Inside::Values),
            b'(' if values && self.last == b'=' => self.open.push(Inside::Values),
            b'(' => self.open.push(Inside::Fields),
            b'[' => self.open.push(Inside::Values),
            b'}' | b']' | b')' => {
                self.open.pop();
            }
            _ => {}
        }
    }

    fn string(&mut self) -> Result<(), String> {
        let (text, start) = (self.text, self.at);
        let marks = marks(&text[start..]);
        self.at = quoted(text, start, marks, true).min(text.len());
        let end = self.at;
        let inside = text.get(start + marks.len()..end.saturating_sub(marks.len()));
        let Some(inside) = inside else {
            return Ok(());
        };
        // In paths they stand about the names of variants, and the composition would look for such without an end.
        let names = self.inside() == Inside::Body && !matches!(self.last, b'=' | b'[' | b',');
        if names && inside.iter().any(|b| matches!(b, b'{' | b'}')) {
            return Err(format!(
                "line {}: a name has a bracket in it",
                line(text, start)
            ));
        }
        let value = matches!(self.last, b'=' | b'[' | b',') && self.inside() != Inside::Fields;
        let plain = !inside.iter().any(|b| matches!(b, b'@' | b'\\' | b'\n'));
        if value && self.kind == b"asset" && plain {
            self.replace(start, end, &[b"@", inside, b"@"].concat());
        } else if value && self.strange.contains(inside) {
            self.replace(start, end, &[marks, &encoded(inside), marks].concat());
        } else if marks.len() == 3 && inside.contains(&b'\\') {
            // The parser ends at the first three marks, whatever stands before them.
            let escaped = [b'\\', marks[0]];
            let other: &[u8] = if marks[0] == b'"' { b"'" } else { b"\"" };
            let mut from = start + marks.len();
            while let Some(place) = text[from..end - 3].windows(2).position(|w| w == escaped) {
                self.replace(from + place, from + place + 2, other);
                from += place + 2;
            }
        }
        Ok(())
    }

    fn place(&mut self) -> Result<(), String> {
        let (text, start) = (self.text, self.at);
        let rest = &text[start..];
        let end = rest.iter().position(|b| *b == b'>');
        self.at = start + end.map_or(1, |end| end + 1);
        let Some(end) = end else {
            return Ok(());
        };
        let path = &rest[1..end];
        if !has_a_root(path) {
            return Err(format!(
                "line {}: it names a path that is none",
                line(text, start)
            ));
        }
        // Connections, as they were written before they were called so.
        if self.last == b'='
            && self.inside() == Inside::Body
            && !self.kind.is_empty()
            && self.word != b"connect"
        {
            self.replace(self.name_end, self.name_end, b".connect");
        }
        if path.iter().any(|b| *b >= 0x80)
            && let Some(dot) = path.iter().position(|b| *b == b'.')
            && self.strange.contains(&path[dot + 1..])
        {
            let name = encoded(&path[dot + 1..]);
            self.replace(start + dot + 2, start + end, &name);
        }
        Ok(())
    }

    fn file(&mut self) {
        let (text, start) = (self.text, self.at);
        let marks = marks(&text[start..]);
        self.at = asset_end(text, start);
        let inside = text.get(start + marks.len()..self.at.saturating_sub(marks.len()));
        if marks.len() == 3 && inside.is_some_and(|path| path.windows(3).any(|w| w == b"@@@")) {
            self.tell(start, "a path with \"@@@\" in it".into());
            self.replace(start, self.at, b"@@");
            return;
        }
        // A sample of a path, or a field: the parser reads them as words only.
        let of_field = match self.inside() {
            Inside::Fields => self.last == b'=',
            Inside::Values => {
                let outer = self.open.len().checked_sub(2).map(|at| self.open[at]);
                outer == Some(Inside::Fields)
            }
            _ => false,
        };
        let word = self.last == b':' || (of_field && !is_one_of(self.field, &FILES));
        let Some(path) = inside.filter(|_| word) else {
            return;
        };
        let strange = |b: &u8| matches!(b, b'\\' | b'\n');
        let mark: &[u8] = if path.contains(&b'"') { b"'" } else { b"\"" };
        if !path.iter().any(strange) && !path.contains(&mark[0]) {
            self.replace(start, self.at, &[mark, path, mark].concat());
        }
    }

    fn number(&mut self) {
        let (text, start) = (self.text, self.at);
        self.at = number_end(text, start);
        let number = &text[start..self.at];
        let digits = number.iter().take_while(|b| b.is_ascii_digit()).count();
        if digits == number.len() {
            // Samples over time are read without their type: whole numbers would be held, not interpolated.
            let floats = is_one_of(self.kind, &["half", "float", "double"]);
            if floats && self.inside() == Inside::Map {
                self.replace(self.at, self.at, b".0");
            }
            return;
        }
        // A fraction where whole numbers are.
        let value = self.inside() == Inside::Values || matches!(self.last, b'=' | b'-');
        if self.whole && value {
            let parsed = std::str::from_utf8(number).ok();
            let parsed = parsed.and_then(|number| number.parse::<f64>().ok());
            if let Some(value) = parsed.filter(|v| v.abs() < 1e18) {
                self.replace(start, self.at, (value as i64).to_string().as_bytes());
                return;
            }
        }
        // "1." and "1.e5".
        let dot = start + digits;
        if text.get(dot) == Some(&b'.') && !text.get(dot + 1).is_some_and(u8::is_ascii_digit) {
            self.replace(dot + 1, dot + 1, b"0");
        }
    }

    fn word(&mut self) {
        let (text, start) = (self.text, self.at);
        let end = word_end(text, start);
        self.at = end;
        let (found, before) = (&text[start..end], self.word);
        let next = skip_white(text, end, false);
        match self.inside() {
            Inside::Body | Inside::Map => self.word_of_statement(start, end, next, before),
            Inside::Fields => self.word_of_field(start, end, next),
            Inside::Values => {}
        }
        if self.at == end {
            if self.strange.contains(found) {
                self.replace(start, end, &encoded(found));
            }
            self.word = found;
            self.last = b'a';
        }
    }

    /// A word where a type, the name after it, or a word before it may stand.
    fn word_of_statement(&mut self, start: usize, end: usize, next: usize, before: &[u8]) {
        let text = self.text;
        let found = &text[start..end];
        let sample = matches!(self.last, b':' | b'-') && self.inside() == Inside::Map;
        if self.last == b'.' || sample {
            return;
        }
        if is_one_of(found, &KEYWORDS) {
            if !is_one_of(before, &KEYWORDS) {
                self.begins = start;
            }
            self.kind = b"";
            self.whole = false;
            self.variants = found == b"variantSet";
            let follows = |word: &[u8]| {
                let after = text[next..].strip_prefix(word);
                after.is_some_and(|after| after.first().is_some_and(|b| !is_word(*b)))
            };
            let named = text.get(next).is_some_and(|b| is_word(*b));
            let idle = (found == b"config" && named)
                || (matches!(found, b"varying" | b"uniform") && follows(b"rel"));
            if idle && self.inside() == Inside::Body {
                self.replace(start, end, b"");
            }
            return;
        }
        let after = text.get(next).copied().unwrap_or_default();
        let typed = (is_word(after) && after != b':') || after == b'[';
        if matches!(before, b"def" | b"over" | b"class") || matches!(self.last, b'=' | b',') {
            self.kind = b"";
            return;
        }
        if !typed {
            // The name after a type, or words of no use here.
            self.name_end = end;
            if before != self.kind && self.last != b']' {
                self.kind = b"";
                self.whole = false;
            }
            return;
        }
        let array = after == b'[';
        let renamed = TYPES.iter().find(|(old, _)| old.as_bytes() == found);
        let new = match renamed {
            Some((_, new)) => new.as_bytes(),
            None if array && matches!(found, b"uint" | b"uint64") => b"int64",
            None => found,
        };
        if !is_known(new) {
            let (stop, value) = statement(text, start);
            if value.is_some() {
                let begins = if is_one_of(before, &KEYWORDS) {
                    self.begins.max(self.copied)
                } else {
                    start
                };
                self.leave_out(begins, stop);
            }
            return;
        }
        if new != found {
            self.replace(start, end, new);
        }
        self.kind = found;
        self.whole = new.starts_with(b"int") || new.starts_with(b"uint") || new == b"uchar";
    }

    /// A word where fields of a layer, a prim or a property stand.
    fn word_of_field(&mut self, start: usize, end: usize, next: usize) {
        let text = self.text;
        let found = &text[start..end];
        if self.last == b'=' {
            return;
        }
        let edits = is_one_of(found, &["add", "append", "prepend", "delete", "reorder"]);
        if edits && text.get(next).is_some_and(|b| is_word(*b)) {
            let name = &text[next..word_end(text, next)];
            if !is_one_of(name, &LISTED) {
                self.replace(start, end, b"");
            }
            return;
        }
        self.field = found;
        self.arcs |= is_one_of(found, &["inherits", "specializes", "subLayers"]);
        self.kind = b"";
        self.whole = false;
        if text.get(next) != Some(&b'=') {
            return;
        }
        let value = skip_white(text, next + 1, true);
        let first = |at: usize| text.get(at).copied().unwrap_or_default();
        let tuples = first(value) == b'('
            || (first(value) == b'[' && first(skip_white(text, value + 1, true)) == b'(');
        if first(value) == b')' {
            self.leave_out(start, next + 1);
            return;
        }
        if tuples && !is_one_of(found, &FILES) {
            self.leave_out(start, closed(text, value));
            return;
        }
        if found == b"active" {
            let stop = word_end(text, value);
            let new: &[u8] = match &text[value..stop] {
                b"1" | b"True" | b"TRUE" => b"true",
                b"0" | b"False" | b"FALSE" => b"false",
                _ => return,
            };
            self.replace(value, stop, new);
            self.at = stop;
            self.last = b'a';
        }
    }
}

/// Names of properties in which letters stand that the parser does not know.
fn strange_names(text: &[u8]) -> BTreeSet<&[u8]> {
    let mut names = BTreeSet::new();
    let mut at = 0;
    if text.is_ascii() {
        return names;
    }
    while at < text.len() {
        if let Some(end) = opaque_end(text, at) {
            at = end;
            continue;
        }
        let end = word_end(text, at).max(at + 1);
        let word = &text[at..end];
        if !word.is_ascii() {
            names.insert(word);
            // The name that materials know a primvar by.
            if let Some(primvar) = word.strip_prefix(b"primvars:") {
                names.insert(primvar);
            }
        }
        at = end;
    }
    names
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/text.rs"]
mod tests;
