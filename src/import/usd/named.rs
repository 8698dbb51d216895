//! The files that a stage names, without composing it: in all of its layers, in all variants.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::crate_file;

/// Layers that are looked into, at most.
const MOST_LAYERS: usize = 10_000;
/// Longer words are no paths.
const LONGEST: usize = 4096;

/// Where the files would be that a stage needs beside its own: layers, images, whatever its layers name as an asset. What
/// stands in a package is part of the package.
pub(in crate::import) fn named_files(path: &Path) -> Vec<PathBuf> {
    let mut seen = HashSet::new();
    let mut files = Vec::new();
    let mut open = vec![path.to_path_buf()];
    while let Some(layer) = open.pop() {
        let real = layer.canonicalize().unwrap_or_else(|_| layer.clone());
        if seen.len() >= MOST_LAYERS || !seen.insert(real) {
            continue;
        }
        let folder = layer.parent().unwrap_or(Path::new(""));
        for name in names(&layer) {
            // "part.usdz[texture.png]" is in the package.
            let name = name.split('[').next().unwrap_or_default();
            for file in places(folder, name) {
                if super::is_usd(&file) {
                    open.push(file.clone());
                }
                files.push(file);
            }
        }
    }
    files
}

/// The files that a name may mean: that of its own, and of many where it has a place for numbers.
fn places(folder: &Path, name: &str) -> Vec<PathBuf> {
    let whole = folder.join(name);
    let (before, after) = match name.split_once("<UDIM>") {
        Some(parts) => parts,
        // Value clips have a number sign for each digit.
        None => match (name.find('#'), name.rfind('#')) {
            (Some(first), Some(last)) => (&name[..first], &name[last + 1..]),
            // As it is looked for when it is not beside the layer.
            _ => return vec![whole, PathBuf::from(name)],
        },
    };
    let (inside, start) = before.rsplit_once('/').unwrap_or(("", before));
    let inside = folder.join(inside);
    let entries = std::fs::read_dir(&inside).into_iter().flatten().flatten();
    entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|file| file.starts_with(start) && file.ends_with(after))
        .map(|file| inside.join(file))
        .collect()
}

/// Words of a layer that may be names of files.
fn names(layer: &Path) -> Vec<String> {
    let mut bytes = Vec::new();
    let read = std::fs::metadata(layer)
        .ok()
        .filter(std::fs::Metadata::is_file)
        .and_then(|_| std::fs::File::open(layer).ok())
        .and_then(|mut file| file.read_to_end(&mut bytes).ok());
    if read.is_none() || bytes.starts_with(b"PK") {
        return Vec::new();
    }
    let words = if bytes.starts_with(b"PXR-USDC") {
        crate_file::words(&bytes).unwrap_or_default()
    } else {
        between_marks(&bytes)
    };
    words
        .into_iter()
        .filter(|word| (1..LONGEST).contains(&word.len()) && word.contains(['.', '/']))
        .collect()
}

/// What stands between the marks of paths in a text. What only looks so does no harm.
fn between_marks(text: &[u8]) -> Vec<String> {
    let parts = text.split(|byte| matches!(byte, b'@' | b'\n' | b'"' | b'\''));
    let words = parts.filter(|part| part.len() < LONGEST);
    words
        .filter_map(|part| Some(std::str::from_utf8(part).ok()?.to_owned()))
        .collect()
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/named.rs"]
mod tests;
