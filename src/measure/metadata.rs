//! What files say about their pictures.

use super::MeasureError;
use crate::math::primaries::{Primaries, WorkingSpace};
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

/// What the light in a file is numbers of.
#[derive(Clone, Debug, PartialEq)]
pub enum LightSpace {
    /// One that a scene may have.
    Known(WorkingSpace),
    /// The file doesn't say.
    Unsaid,
    /// Another one, by its name or its primaries.
    Other(String),
}

/// What an EXR file says of the space of its light: by `colorInteropID`, as Blender 5.0 and later write it, else by
/// `chromaticities`. Other files do not say.
///
/// # Errors
/// The file cannot be read.
pub fn working_space(path: &Path) -> Result<LightSpace, MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let mut file = BufReader::new(File::open(path).map_err(|e| unreadable(e.to_string()))?);
    let mut magic = [0; 4];
    if file.read_exact(&mut magic).is_err() || magic != *b"\x76\x2f\x31\x01" {
        return Ok(LightSpace::Unsaid);
    }
    file.seek(SeekFrom::Start(0))
        .map_err(|error| unreadable(error.to_string()))?;
    let headers = exr::meta::MetaData::read_from_buffered(&mut file, false)
        .map_err(|error| unreadable(error.to_string()))?
        .headers;
    let id = headers.iter().find_map(|header| {
        let shared = &header.shared_attributes.other;
        let mut all = header.own_attributes.other.iter().chain(shared);
        all.find_map(|(name, value)| match value {
            exr::prelude::AttributeValue::Text(text) if name.eq("colorInteropID") => {
                Some(text.to_string())
            }
            _ => None,
        })
    });
    if let Some(id) = id {
        let known = WorkingSpace::ALL
            .into_iter()
            .find(|space| space.interop_id() == id);
        return Ok(known.map_or(LightSpace::Other(id), LightSpace::Known));
    }
    let primaries = headers
        .iter()
        .find_map(|header| header.shared_attributes.chromaticities);
    Ok(match primaries {
        None => LightSpace::Unsaid,
        Some(said) => {
            let pair = |v: exr::prelude::Vec2<f32>| [f64::from(v.0), f64::from(v.1)];
            let said = Primaries {
                red: pair(said.red),
                green: pair(said.green),
                blue: pair(said.blue),
                white: pair(said.white),
            };
            let known = WorkingSpace::with_primaries(&said);
            known.map_or_else(|| LightSpace::Other(format!("{said:?}")), LightSpace::Known)
        }
    })
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

    fn one_pixel() -> film::Picture {
        film::Picture {
            width: 1,
            height: 1,
            layers: vec![film::Layer {
                name: "Combined".into(),
                channels: ["R", "G", "B"].map(String::from).to_vec(),
                data: vec![0.5; 3],
            }],
        }
    }

    #[test]
    fn an_exr_file_says_what_its_light_is_numbers_of() {
        let folder = tempfile::tempdir().unwrap();
        let picture = one_pixel();
        for space in WorkingSpace::ALL {
            let path = folder.path().join("a.exr");
            let options = output::exr::ExrOptions {
                space,
                ..Default::default()
            };
            output::exr::write(&path, &picture, &options, &Vec::new()).unwrap();
            assert_eq!(working_space(&path).unwrap(), LightSpace::Known(space));
            let read = exr::meta::MetaData::read_from_file(&path, false).unwrap();
            let said = read.headers[0].shared_attributes.chromaticities.unwrap();
            let red = space.primaries().red;
            assert_eq!([said.red.0, said.red.1], red.map(|v| v as f32));
        }
    }

    #[test]
    fn texts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
        let written = vec![("sundog/samples".to_owned(), "64 Käse".to_owned())];
        let picture = one_pixel();
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
