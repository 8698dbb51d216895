//! The outer layers of a glTF file: GLB chunks, JSON, URIs, buffers.

use std::ops::Range;
use std::path::{Path, PathBuf};

use ::gltf::json;
use base64::Engine as _;
use serde_json::{Map, Value};

use super::schema::Graph;
use crate::import::ImportError;
use crate::import::error::{read_bytes, read_file};

/// A parsed file: its JSON in three readings, and its buffers.
pub(super) struct Document {
    /// The file's name for messages.
    pub file: String,
    folder: PathBuf,
    /// Meshes, accessors, materials, textures and images, by the `gltf` crate's schema.
    pub core: json::Root,
    /// Nodes, cameras, lights and scenes, in the f64 precision that JSON has and that crate lacks.
    pub graph: Graph,
    /// Everything, for extensions.
    pub value: Value,
    bytes: Vec<u8>,
    buffers: Vec<Buffer>,
}

enum Buffer {
    /// Part of the file (GLB's binary chunk).
    Inside(Range<usize>),
    Loaded(Vec<u8>),
    /// Not there; an error only if something needs it.
    Missing(String),
}

impl Document {
    /// Reads the file and all buffers that it names.
    pub(super) fn open(path: &Path) -> Result<Self, ImportError> {
        let bytes = read_file(path)?;
        let file = path.display().to_string();
        let not_gltf = |reason: String| ImportError::NotGltf {
            file: file.clone(),
            reason,
        };
        let (json_range, binary) = if bytes.starts_with(b"glTF") {
            split_glb(&bytes).map_err(not_gltf)?
        } else {
            (0..bytes.len(), None)
        };
        let text = bytes.get(json_range).unwrap_or_default();
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        if text.iter().all(u8::is_ascii_whitespace) {
            return Err(not_gltf("it is empty".into()));
        }
        let mut value: Value = serde_json::from_slice(text)
            .map_err(|e| not_gltf(format!("it is neither GLB nor JSON ({e})")))?;
        drop_nulls(&mut value);
        let version = value.pointer("/asset/version").and_then(Value::as_str);
        match version {
            Some(v) if v == "2" || v.starts_with("2.") => {}
            Some(v) => {
                return Err(not_gltf(format!(
                    "its version is {v}; export it again as glTF 2.0"
                )));
            }
            None => return Err(not_gltf("it has no asset.version".into())),
        }
        let graph = Graph::parse(&value)
            .map_err(|e| not_gltf(format!("its JSON does not follow the format ({e})")))?;
        let core = core_json(&value);
        let core: json::Root = serde_json::from_value(core)
            .map_err(|e| not_gltf(format!("its JSON does not follow the format ({e})")))?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let mut document = Self {
            file,
            folder,
            core,
            graph,
            value,
            bytes,
            buffers: Vec::new(),
        };
        document.load_buffers(binary)?;
        Ok(document)
    }

    fn load_buffers(&mut self, binary: Option<Range<usize>>) -> Result<(), ImportError> {
        let mut buffers = Vec::with_capacity(self.core.buffers.len());
        for (index, buffer) in self.core.buffers.iter().enumerate() {
            let object = format!("buffer {index}");
            let said = buffer.byte_length.0;
            let loaded = match (&buffer.uri, &binary) {
                (Some(uri), _) => match self.resolve(uri, &object)? {
                    Resolved::Data(data) => Buffer::Loaded(data),
                },
                (None, Some(range)) if index == 0 => Buffer::Inside(range.clone()),
                (None, _) => Buffer::Missing(format!("buffer {index} has no data in the file")),
            };
            let found = match &loaded {
                Buffer::Inside(range) => range.len() as u64,
                Buffer::Loaded(data) => data.len() as u64,
                Buffer::Missing(_) => said,
            };
            if found < said {
                return Err(ImportError::malformed(
                    &self.file,
                    object,
                    format!("it should have {said} bytes but has {found}: the file is cut off"),
                ));
            }
            buffers.push(loaded);
        }
        self.buffers = buffers;
        Ok(())
    }

    /// All bytes that the scene's data come from.
    pub(super) fn input_bytes(&self) -> usize {
        let loaded = |b: &Buffer| {
            if let Buffer::Loaded(data) = b {
                data.len()
            } else {
                0
            }
        };
        self.bytes.len() + self.buffers.iter().map(loaded).sum::<usize>()
    }

    /// The bytes of a buffer view, with its stride.
    pub(super) fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), String> {
        let view = self
            .core
            .buffer_views
            .get(index)
            .ok_or_else(|| format!("there is no buffer view {index}"))?;
        let data: &[u8] = match self.buffers.get(view.buffer.value()) {
            Some(Buffer::Inside(range)) => self.bytes.get(range.clone()).unwrap_or_default(),
            Some(Buffer::Loaded(data)) => data,
            Some(Buffer::Missing(reason)) => return Err(reason.clone()),
            None => return Err(format!("there is no buffer {}", view.buffer.value())),
        };
        let start = view.byte_offset.map_or(0, |o| o.0);
        let end = start.checked_add(view.byte_length.0);
        let slice = end
            .and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?))
            .and_then(|range| data.get(range))
            .ok_or_else(|| {
                format!(
                    "buffer view {index} reaches beyond the end of its buffer ({} bytes)",
                    data.len()
                )
            })?;
        Ok((slice, view.byte_stride.map(|s| s.0)))
    }

    /// The bytes behind a URI: `data:` or a file beside the scene.
    pub(super) fn resolve(&self, uri: &str, object: &str) -> Result<Resolved, ImportError> {
        if let Some(rest) = strip_scheme(uri, "data:") {
            return decode_data_uri(rest)
                .map(Resolved::Data)
                .map_err(|problem| ImportError::malformed(&self.file, object, problem));
        }
        if let Some((scheme, _)) = uri.split_once(':')
            && scheme.len() > 1
            && scheme
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.'))
        {
            return Err(ImportError::malformed(
                &self.file,
                object,
                format!(
                    "its address \"{}\" is not a file beside the scene: download it and export again",
                    shorten(uri)
                ),
            ));
        }
        let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
        // Some exporters forget to encode: a file that is there under the literal name counts too.
        let mut path = self.folder.join(name.as_ref());
        if !path.exists() && self.folder.join(uri).exists() {
            path = self.folder.join(uri);
        }
        read_bytes(&path)
            .map(Resolved::Data)
            .map_err(|reason| ImportError::MissingPart {
                file: self.file.clone(),
                object: object.into(),
                needed: path.display().to_string(),
                reason,
            })
    }

    /// Whether Blender's own exporter wrote the file, and if so its major version.
    pub(super) fn blender_version(&self) -> Option<u32> {
        let rest = self
            .core
            .asset
            .generator
            .as_deref()?
            .strip_prefix("Khronos glTF Blender I/O v")?;
        rest.split('.').next()?.parse().ok()
    }

    /// An extension object of the JSON object at a pointer such as `/materials/3`.
    pub(super) fn extension(&self, pointer: &str, name: &str) -> Option<&Value> {
        self.value.pointer(pointer)?.get("extensions")?.get(name)
    }
}

/// What a URI led to.
pub(super) enum Resolved {
    /// The bytes.
    Data(Vec<u8>),
}

pub(super) fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme)
        .then(|| &uri[scheme.len()..])
}

/// At most 60 characters of a text from the file, for messages.
fn shorten(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

fn decode_data_uri(rest: &str) -> Result<Vec<u8>, String> {
    let (header, payload) = rest.split_once(',').ok_or("its data URI has no comma")?;
    let raw: Vec<u8> = percent_encoding::percent_decode_str(payload).collect();
    if !header.to_ascii_lowercase().ends_with(";base64") {
        return Ok(raw);
    }
    let compact: Vec<u8> = raw
        .into_iter()
        .filter(|b| !b.is_ascii_whitespace())
        .collect();
    let engine = base64::engine::GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        base64::engine::GeneralPurposeConfig::new()
            .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent),
    );
    engine
        .decode(compact)
        .map_err(|e| format!("its base64 data are damaged ({e})"))
}

/// Byte ranges of the JSON chunk and, where there is one, of the binary chunk (specification 4.4).
///
/// Ours rather than the `gltf` crate's: that one subtracts without a check on short headers.
fn split_glb(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), String> {
    let word = |at: usize| -> Result<u32, String> {
        match bytes.get(at..at + 4) {
            Some(&[a, b, c, d]) => Ok(u32::from_le_bytes([a, b, c, d])),
            _ => Err("it is cut off in a GLB header".into()),
        }
    };
    let version = word(4)?;
    if version != 2 {
        return Err(format!(
            "its GLB version is {version}; export it again as glTF 2.0"
        ));
    }
    let total = word(8)? as usize;
    if total > bytes.len() {
        return Err(format!(
            "it should have {total} bytes but has {}: it is cut off",
            bytes.len()
        ));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= total {
        let length = word(at)? as usize;
        let kind = word(at + 4)?;
        let end = at + 8 + length;
        if end > total {
            return Err("a GLB chunk reaches beyond the end of the file: it is cut off".into());
        }
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(at + 8..end),
            BINARY_CHUNK if binary.is_none() => binary = Some(at + 8..end),
            // "Client implementations MUST ignore chunks with unknown types."
            _ => {}
        }
        at = end.next_multiple_of(4);
    }
    Ok((json.ok_or("it has no JSON chunk")?, binary))
}

const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;

/// The part of the JSON that goes through the `gltf` crate's schema.
///
/// Left out: what [`Graph`] reads in f64, and `extras`, which the crate refuses unless they are
/// objects although the format allows any value.
fn core_json(value: &Value) -> Value {
    let mut core = Map::new();
    for key in [
        "asset",
        "accessors",
        "buffers",
        "bufferViews",
        "images",
        "materials",
        "meshes",
        "samplers",
        "textures",
    ] {
        if let Some(part) = value.get(key) {
            core.insert(key.into(), without_extras(part));
        }
    }
    Value::Object(core)
}

/// Some exporters write `null` for what they leave out.
fn drop_nulls(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(drop_nulls),
        Value::Object(fields) => {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(drop_nulls);
        }
        _ => {}
    }
}

fn without_extras(value: &Value) -> Value {
    match value {
        Value::Array(items) => Value::Array(items.iter().map(without_extras).collect()),
        Value::Object(fields) => Value::Object(
            fields
                .iter()
                .filter(|(k, _)| *k != "extras")
                .map(|(k, v)| (k.clone(), without_extras(v)))
                .collect(),
        ),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris_are_decoded_with_and_without_base64() {
        assert_eq!(
            decode_data_uri("application/octet-stream;base64,AAEC").unwrap(),
            [0, 1, 2]
        );
        assert_eq!(
            decode_data_uri("application/octet-stream;base64,AAECAw").unwrap(),
            [0, 1, 2, 3]
        );
        assert_eq!(decode_data_uri("text/plain,a%20b").unwrap(), b"a b");
        assert!(decode_data_uri("no comma").is_err());
        assert!(decode_data_uri(";base64,@@@").is_err());
    }

    #[test]
    fn glb_headers_of_every_length_are_refused_without_panic() {
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        for length in [0u32, 1, 11, 12, 13, 19, 20, 24, u32::MAX] {
            glb.truncate(8);
            glb.extend(length.to_le_bytes());
            glb.extend(b"\xff\xff\xff\xffJSON");
            for cut in 0..=glb.len() {
                assert!(split_glb(&glb[..cut]).is_err());
            }
        }
    }
}
