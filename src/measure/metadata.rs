//! What files say about their pictures.

use super::MeasureError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// The texts that stand in an EXR or PNG file besides its pixels, by name. Other files have none.
///
/// # Errors
/// The file cannot be read.
pub fn metadata(path: &Path) -> Result<BTreeMap<String, String>, MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let mut file = BufReader::new(File::open(path).map_err(|e| unreadable(e.to_string()))?);
    let mut magic = Vec::new();
    file.by_ref()
        .take(4)
        .read_to_end(&mut magic)
        .and_then(|_| file.seek(SeekFrom::Start(0)))
        .map_err(|error| unreadable(error.to_string()))?;
    match magic.as_slice() {
        b"\x76\x2f\x31\x01" => of_exr(file).map_err(unreadable),
        b"\x89PNG" => of_png(file).map_err(unreadable),
        _ => Ok(BTreeMap::new()),
    }
}

fn of_exr(mut file: BufReader<File>) -> Result<BTreeMap<String, String>, String> {
    use exr::prelude::AttributeValue;
    let headers = exr::meta::MetaData::read_from_buffered(&mut file, false)
        .map_err(|error| error.to_string())?
        .headers;
    let mut texts = BTreeMap::new();
    for header in headers {
        let attributes = &header.own_attributes;
        let known = attributes
            .software_name
            .iter()
            .map(|text| ("software", text));
        for (name, text) in known {
            texts.insert(name.to_owned(), text.to_string());
        }
        let shared = &header.shared_attributes.other;
        for (name, value) in attributes.other.iter().chain(shared) {
            let value = match value {
                // As they are written (see `output::exr`): bytes that are UTF-8.
                AttributeValue::Text(text) => {
                    let bytes: Vec<u8> = text.bytes().to_vec();
                    String::from_utf8_lossy(&bytes).into_owned()
                }
                AttributeValue::F32(value) => value.to_string(),
                AttributeValue::F64(value) => value.to_string(),
                AttributeValue::I32(value) => value.to_string(),
                _ => continue,
            };
            texts.insert(name.to_string(), value);
        }
    }
    Ok(texts)
}

fn of_png(file: BufReader<File>) -> Result<BTreeMap<String, String>, String> {
    let mut reader = png::Decoder::new(file)
        .read_info()
        .map_err(|error| error.to_string())?;
    // Texts may stand after the pixels.
    reader.finish().map_err(|error| error.to_string())?;
    let info = reader.info();
    let mut texts = BTreeMap::new();
    for chunk in &info.uncompressed_latin1_text {
        texts.insert(chunk.keyword.clone(), chunk.text.clone());
    }
    for chunk in &info.compressed_latin1_text {
        texts.insert(
            chunk.keyword.clone(),
            chunk.get_text().map_err(|e| e.to_string())?,
        );
    }
    for chunk in &info.utf8_text {
        texts.insert(
            chunk.keyword.clone(),
            chunk.get_text().map_err(|e| e.to_string())?,
        );
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film;
    use crate::output::{self, png::Codes};

    #[test]
    fn texts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
        let written = vec![("sundog/samples".to_owned(), "64 Käse".to_owned())];
        let picture = film::Picture {
            width: 1,
            height: 1,
            layers: vec![film::Layer {
                name: "Combined".into(),
                channels: ["R", "G", "B"].map(String::from).to_vec(),
                data: vec![0.0; 3],
            }],
        };
        output::exr::write(&exr, &picture, &Default::default(), &written).unwrap();
        output::png::write(&png, 1, 1, Codes::Eight(&[0; 3]), &written).unwrap();
        for path in [exr, png] {
            assert_eq!(metadata(&path).unwrap()["sundog/samples"], "64 Käse");
        }
        let other = folder.path().join("a.txt");
        std::fs::write(&other, "x").unwrap();
        assert!(metadata(&other).unwrap().is_empty());
        assert!(metadata(&folder.path().join("none")).is_err());
    }
}
