//! What files say about their pictures.

use super::MeasureError;
use crate::math::primaries::{Primaries, WorkingSpace};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// A file whose first bytes say what it is.
enum Kind {
    Exr(BufReader<File>),
    Png(BufReader<File>),
    Other,
}

fn open(path: &Path) -> std::io::Result<Kind> {
    let mut file = BufReader::new(File::open(path)?);
    let mut magic = Vec::new();
    file.by_ref().take(4).read_to_end(&mut magic)?;
    file.rewind()?;
    Ok(match magic.as_slice() {
        b"\x76\x2f\x31\x01" => Kind::Exr(file),
        b"\x89PNG" => Kind::Png(file),
        _ => Kind::Other,
    })
}

fn unreadable(path: &Path, reason: &impl std::fmt::Display) -> MeasureError {
    MeasureError::Unreadable {
        path: path.display().to_string(),
        reason: reason.to_string(),
    }
}

/// The texts that stand in an EXR or PNG file besides its pixels, by name. Other files have none.
///
/// # Errors
/// The file cannot be read.
pub fn metadata(path: &Path) -> Result<BTreeMap<String, String>, MeasureError> {
    let texts = match open(path).map_err(|error| unreadable(path, &error))? {
        Kind::Exr(file) => of_exr(file).map_err(|error| error.to_string()),
        Kind::Png(file) => of_png(file).map_err(|error| error.to_string()),
        Kind::Other => Ok(BTreeMap::new()),
    };
    texts.map_err(|reason| unreadable(path, &reason))
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
    let Kind::Exr(file) = open(path).map_err(|error| unreadable(path, &error))? else {
        return Ok(LightSpace::Unsaid);
    };
    let headers = headers(file).map_err(|error| unreadable(path, &error))?;
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

fn headers(mut file: BufReader<File>) -> exr::error::Result<exr::meta::Headers> {
    Ok(exr::meta::MetaData::read_from_buffered(&mut file, false)?.headers)
}

fn of_exr(file: BufReader<File>) -> exr::error::Result<BTreeMap<String, String>> {
    use exr::prelude::AttributeValue;
    let mut texts = BTreeMap::new();
    for header in headers(file)? {
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

fn of_png(file: BufReader<File>) -> Result<BTreeMap<String, String>, png::DecodingError> {
    let mut reader = png::Decoder::new(file).read_info()?;
    // Texts may stand after the pixels.
    reader.finish()?;
    let info = reader.info();
    let mut texts = BTreeMap::new();
    for chunk in &info.uncompressed_latin1_text {
        texts.insert(chunk.keyword.clone(), chunk.text.clone());
    }
    for chunk in &info.compressed_latin1_text {
        texts.insert(chunk.keyword.clone(), chunk.get_text()?);
    }
    for chunk in &info.utf8_text {
        texts.insert(chunk.keyword.clone(), chunk.get_text()?);
    }
    Ok(texts)
}
