//! What is wrong with a file's JSON, in plain words.

use std::fmt::Display;

/// What stands in the place of the types that messages of `serde` expect.
const EXPECTED: [(&str, &str); 16] = [
    ("f32", "a number"),
    ("f64", "a number"),
    ("u8", "a whole number from 0 to 255"),
    ("u16", "a whole number from 0 to 65535"),
    ("u32", "a whole number of at least 0"),
    ("u64", "a whole number of at least 0"),
    ("usize", "a whole number of at least 0"),
    ("i32", "a whole number"),
    ("i64", "a whole number"),
    ("a boolean", "true or false"),
    ("a string", "a text"),
    ("a sequence", "a list"),
    ("a map", "an object"),
    ("an array of length", "a list of"),
    ("a tuple of size", "a list of"),
    ("struct", "an object"),
];

/// A message of `serde` as a sentence that needs no knowledge of programs.
pub(super) fn plain(error: &impl Display) -> String {
    let told = error.to_string();
    if let Some(rest) = told.strip_prefix("missing field `")
        && let Some((field, _)) = rest.split_once('`')
    {
        return format!("\"{field}\" is missing");
    }
    let Some((found, expected)) = told.rsplit_once(", expected ") else {
        return told;
    };
    let found = ["invalid type: ", "invalid value: "]
        .iter()
        .find_map(|head| found.strip_prefix(head))
        .map(in_words)
        .or_else(|| {
            let count = found.strip_prefix("invalid length ")?;
            Some(format!("a list of {count}"))
        });
    let Some(found) = found else {
        return told;
    };
    let known = EXPECTED.iter().find_map(|(name, words)| {
        let rest = expected.strip_prefix(name)?;
        Some(match *name {
            // The name of a type of the program says nothing.
            "struct" => (*words).to_owned(),
            _ => format!("{words}{}", rest.strip_suffix(" elements").unwrap_or(rest)),
        })
    });
    let expected = known.unwrap_or_else(|| expected.to_owned());
    format!("there is {found} where {expected} belongs")
}

/// What was found, by `serde`'s name for it.
fn in_words(found: &str) -> String {
    let of = |head: &str| {
        Some(
            found
                .strip_prefix(head)?
                .trim()
                .trim_matches('`')
                .to_owned(),
        )
    };
    if let Some(text) = of("string ") {
        format!("the text {text}")
    } else if let Some(number) = of("integer ").or_else(|| of("floating point ")) {
        format!("the number {number}")
    } else if let Some(value) = of("boolean ") {
        value
    } else {
        match found {
            "sequence" => "a list".to_owned(),
            "map" => "an object".to_owned(),
            "null" => "nothing".to_owned(),
            other => other.to_owned(),
        }
    }
}

/// Why bytes are no scene that somebody meant to have.
pub(super) fn mistaken(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.trim_ascii_start();
    let begins = |with: &[u8]| {
        let head = text.get(..with.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(with))
    };
    if begins(b"version https://git-lfs") {
        Some("it is a pointer of Git LFS and not the file itself: \"git lfs pull\" fetches that")
    } else if begins(b"<!doctype html") || begins(b"<html") {
        Some("it is a web page: the address that it was downloaded from is not that of the file")
    } else if bytes.starts_with(b"BLENDER") {
        Some("it is Blender's own file: export it as glTF or USD, or render it by the add-on")
    } else {
        None
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/gltf/words.rs"]
mod tests;
