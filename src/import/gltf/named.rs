//! The files that a glTF file names, without reading them.

use super::container::strip_scheme;
use serde_json::Value;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Where the files would be that a scene needs beside its own: buffers, images, whatever stands under a key `uri` or `image`. None for a
/// file that cannot be read.
pub(in crate::import) fn named_files(path: &Path) -> Vec<PathBuf> {
    let Some(value) = json(path) else {
        return Vec::new();
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut files = Vec::new();
    walk(&value, &mut |uri| {
        if strip_scheme(uri, "data:").is_none() {
            // As the file is looked for: decoded, or as it stands.
            let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
            files.push(folder.join(name.as_ref()));
            if name != uri {
                files.push(folder.join(uri));
            }
        }
    });
    files
}

/// The JSON alone: what follows it in a GLB may be large.
fn json(path: &Path) -> Option<Value> {
    if !path.is_file() {
        return None;
    }
    let mut file = File::open(path).ok()?;
    let mut bytes = Vec::new();
    file.by_ref().take(20).read_to_end(&mut bytes).ok()?;
    if bytes.starts_with(b"glTF") {
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?);
        bytes.clear();
        file.take(length.into()).read_to_end(&mut bytes).ok()?;
    } else {
        file.read_to_end(&mut bytes).ok()?;
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    serde_json::from_slice(text).ok()
}

fn walk(value: &Value, tell: &mut impl FnMut(&str)) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| walk(item, tell)),
        Value::Object(fields) => {
            for (key, field) in fields {
                match field {
                    // (`image`: of the world, in our own extension.)
                    Value::String(uri) if key == "uri" || key == "image" => tell(uri),
                    _ => walk(field, tell),
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/gltf/named.rs"]
mod tests;
