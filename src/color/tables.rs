//! Tables of colours that OpenColorIO would read for ever, found before it opens them.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// A table of 129³ colours as text has 64 MiB.
const LARGEST: u64 = 1 << 28;
/// How much of a file is looked at for the word that CineSpace tables begin with.
const START: u64 = 4096;

/// What is wrong with the table at a path that is a regular file of so many bytes.
pub(super) fn fault(path: &Path, length: u64) -> Option<String> {
    if length > LARGEST {
        return Some(format!("it has {} MiB", length >> 20));
    }
    let endless = File::open(path).and_then(has_endless_metadata);
    // What cannot be read OpenColorIO tells by itself.
    endless.ok()?.then(endless_words)
}

/// The first table of an archive with which something is wrong, and what. Those that no archive is OpenColorIO tells of.
pub(super) fn fault_in_archive(path: &Path) -> Option<(String, String)> {
    let mut archive = zip::ZipArchive::new(File::open(path).ok()?).ok()?;
    (0..archive.len()).find_map(|index| {
        let entry = archive.by_index(index).ok()?;
        let name = entry.name().to_owned();
        if entry.size() > LARGEST {
            return Some((name, format!("it has {} MiB", entry.size() >> 20)));
        }
        let endless = has_endless_metadata(entry.take(LARGEST)).ok()?;
        endless.then(|| (name, endless_words()))
    })
}

fn endless_words() -> String {
    "its metadata have no end".to_owned()
}

/// Whether a table is one of CineSpace whose metadata begin and do not end: OpenColorIO 2.6 asks for their next line beyond the
/// end of the file, and keeps each (FileFormatCSP.cpp). The table's extension does not count: all formats are tried.
fn has_endless_metadata(mut from: impl Read) -> io::Result<bool> {
    let mut text = Vec::new();
    from.by_ref().take(START).read_to_end(&mut text)?;
    if !text.to_ascii_uppercase().windows(6).any(|w| w == b"CSPLUT") {
        return Ok(false);
    }
    from.read_to_end(&mut text)?;
    text.make_ascii_uppercase();
    let mut lines = text
        .split(|&byte| byte == b'\n')
        .map(<[u8]>::trim_ascii_start);
    let begins = lines
        .by_ref()
        .any(|line| line.starts_with(b"BEGIN METADATA"));
    Ok(begins && !lines.any(|line| line.starts_with(b"END METADATA")))
}

#[cfg(test)]
#[path = "../../tests/unit/color/tables.rs"]
mod tests;
