//! The outer layers of a glTF file: GLB chunks, JSON, URIs, buffers.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use ::gltf::json;
use base64::Engine as _;
use serde::Deserialize as _;
use serde_json::{Map, Value};

use super::schema::{Graph, NodeJson};
use super::{draco, meshopt, words};
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::import::error::{read_bytes, read_file};
use crate::nodes::CyclesVersion;
use crate::scene::Grid;
use crate::scene::graph::ShaderRules;

/// What is said of files of other formats.
const READ: &str =
    "glTF (.gltf, .glb) and USD (.usd, .usda, .usdc, .usdz) are read, export it as one of these";

/// A parsed file: its JSON in three readings, and its buffers.
pub(super) struct Document {
    /// The file's name for messages.
    pub file: String,
    folder: PathBuf,
    /// Files that are not in the folder may be read too.
    allow_outside: bool,
    /// Meshes, accessors, materials, textures and images, by the `gltf` crate's schema.
    pub core: json::Root,
    /// Cameras, lights and scenes, in the f64 precision that JSON has and that crate lacks.
    pub graph: Graph,
    /// How many nodes there are; [`Self::node`] reads one.
    pub nodes: usize,
    /// Everything, for extensions.
    pub value: Value,
    /// What the geometry of the file may take.
    pub budget: Budget,
    bytes: Vec<u8>,
    buffers: Vec<Buffer>,
    /// The buffer views with compressed data, once they are needed.
    unpacked: Vec<OnceLock<Result<Vec<u8>, String>>>,
    /// Grids of files that were read, by their names.
    pub grids: Mutex<HashMap<(PathBuf, String), Arc<Grid>>>,
    /// What they may take.
    pub grid_budget: Budget,
}

enum Buffer {
    /// Part of the file (GLB's binary chunk).
    Inside(Range<usize>),
    /// Decoded, or a file of its own, which several buffers may share.
    Loaded(Arc<Vec<u8>>),
    /// Not there; an error only if something needs it.
    Missing(String),
}

impl Document {
    /// Reads the file and all buffers that it names.
    pub(super) fn open(path: &Path, allow_outside: bool) -> Result<Self, ImportError> {
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
        let mut value: Value = serde_json::from_slice(text).map_err(|e| {
            let begun = text.trim_ascii_start().starts_with(b"{");
            let plain = || match begun {
                true => format!("it is neither GLB nor JSON ({e})"),
                false => format!("it is neither GLB nor JSON, and no USD: {READ}"),
            };
            not_gltf(words::mistaken(&bytes).map_or_else(plain, str::to_owned))
        })?;
        tidy(&mut value);
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
        let least = value.pointer("/asset/minVersion").and_then(Value::as_str);
        if let Some(least) = least.filter(|v| *v != "2.0" && *v != "2") {
            return Err(not_gltf(format!(
                "it asks for glTF {least} at least, and 2.0 is what is read; export it again as glTF 2.0"
            )));
        }
        let (graph, nodes, core) = readings(&value)
            .map_err(|e| not_gltf(format!("its JSON does not follow the format ({e})")))?;
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let mut document = Self {
            file,
            folder,
            allow_outside,
            core,
            graph,
            nodes,
            value,
            budget: Budget::for_geometry(0, 0),
            bytes,
            buffers: Vec::new(),
            unpacked: Vec::new(),
            grids: Mutex::default(),
            grid_budget: Budget::for_grids(None),
        };
        document.load_buffers(binary)?;
        let views = document.core.buffer_views.len();
        document.unpacked.resize_with(views, OnceLock::new);
        document.budget = Budget::for_geometry(document.input_bytes(), document.packed_bytes());
        Ok(document)
    }

    /// Puts other JSON in the place of the file's own, of which the buffers are the same. An error leaves it as it was.
    pub(super) fn replace(&mut self, mut value: Value) -> Result<(), String> {
        tidy(&mut value);
        (self.graph, self.nodes, self.core) = readings(&value)?;
        self.value = value;
        Ok(())
    }

    fn load_buffers(&mut self, binary: Option<Range<usize>>) -> Result<(), ImportError> {
        let mut buffers = Vec::with_capacity(self.core.buffers.len());
        // A file that many buffers name is read once.
        let mut files: HashMap<PathBuf, Arc<Vec<u8>>> = HashMap::new();
        for (index, buffer) in self.core.buffers.iter().enumerate() {
            let object = format!("buffer {index}");
            let said = buffer.byte_length.0;
            let json = self.value.pointer(&format!("/buffers/{index}"));
            let loaded = match (&buffer.uri, &binary) {
                // Its views are compressed, and the compressed data are what is read.
                _ if json.is_some_and(meshopt::is_fallback) => {
                    Buffer::Missing(format!("buffer {index} is a fallback, which is not read"))
                }
                (Some(uri), _) => match self.locate(uri, &object)? {
                    Located::Data(data) => Buffer::Loaded(Arc::new(data)),
                    Located::File(path) => Buffer::Loaded(match files.get(&path) {
                        Some(data) => data.clone(),
                        None => {
                            let data = Arc::new(self.read(&path, &object)?);
                            files.insert(path, data.clone());
                            data
                        }
                    }),
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

    /// All bytes that the scene's data come from, those of a file that is named often once.
    pub(super) fn input_bytes(&self) -> usize {
        let mut loaded: Vec<_> = self
            .buffers
            .iter()
            .filter_map(|b| match b {
                Buffer::Loaded(data) => Some((Arc::as_ptr(data), data.len())),
                _ => None,
            })
            .collect();
        loaded.sort_unstable();
        loaded.dedup();
        self.bytes.len() + loaded.iter().map(|(_, n)| n).sum::<usize>()
    }

    /// Where the bytes of a buffer view lie: the address and length tell two views of the same bytes to be one.
    pub(super) fn place(&self, index: usize) -> Result<(usize, usize), String> {
        let (bytes, _) = self.view(index)?;
        Ok((bytes.as_ptr() as usize, bytes.len()))
    }

    /// Bytes of compressed geometry, by what the file says: views that several use count once.
    fn packed_bytes(&self) -> u64 {
        let views = (0..self.core.buffer_views.len())
            .filter_map(|view| Some(self.packed_view(view)?.ok()?.byte_length));
        let primitives = self.value.get("meshes").and_then(Value::as_array);
        let streams: BTreeSet<usize> = primitives
            .into_iter()
            .flatten()
            .filter_map(|mesh| mesh.get("primitives")?.as_array())
            .flatten()
            .filter_map(|p| {
                draco::buffer_view(p.get("extensions")?.get("KHR_draco_mesh_compression")?)
            })
            .collect();
        let streams = streams
            .into_iter()
            .filter_map(|view| Some(self.core.buffer_views.get(view)?.byte_length.0));
        views.chain(streams).fold(0, u64::saturating_add)
    }

    /// What a buffer view says of its compressed data; `None` if they are not compressed.
    fn packed_view(&self, index: usize) -> Option<Result<meshopt::Packed, String>> {
        meshopt::of_view(self.value.get("bufferViews")?.get(index)?)
    }

    /// The bytes of a buffer view, decoded if they are compressed, with its stride.
    pub(super) fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), String> {
        let view = self
            .core
            .buffer_views
            .get(index)
            .ok_or_else(|| format!("there is no buffer view {index}"))?;
        let stride = view.byte_stride.map(|s| s.0);
        let object = format!("buffer view {index}");
        if let (Some(packed), Some(slot)) = (self.packed_view(index), self.unpacked.get(index)) {
            let unpacked = slot.get_or_init(|| {
                let packed = packed.map_err(|problem| format!("{object}: {problem}"))?;
                let (start, length) = (packed.byte_offset, packed.byte_length);
                let source = self.slice(packed.buffer, start, length, &object)?;
                meshopt::decode(&packed, source, &self.budget)
                    .map_err(|problem| format!("{object}: {problem}"))
            });
            return unpacked
                .as_ref()
                .map(|data| (data.as_slice(), stride))
                .map_err(Clone::clone);
        }
        let start = view.byte_offset.map_or(0, |o| o.0);
        let slice = self.slice(view.buffer.value(), start, view.byte_length.0, &object)?;
        Ok((slice, stride))
    }

    /// Part of a buffer, for what messages call `object`.
    fn slice(&self, buffer: usize, start: u64, length: u64, object: &str) -> Result<&[u8], String> {
        let data: &[u8] = match self.buffers.get(buffer) {
            Some(Buffer::Inside(range)) => self.bytes.get(range.clone()).unwrap_or_default(),
            Some(Buffer::Loaded(data)) => data,
            Some(Buffer::Missing(reason)) => return Err(reason.clone()),
            None => return Err(format!("there is no buffer {buffer}")),
        };
        start
            .checked_add(length)
            .and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?))
            .and_then(|range| data.get(range))
            .ok_or_else(|| {
                format!(
                    "{object} reaches beyond the end of its buffer ({} bytes)",
                    data.len()
                )
            })
    }

    /// The bytes behind a URI: `data:` or a file beside the scene.
    pub(super) fn resolve(&self, uri: &str, object: &str) -> Result<Vec<u8>, ImportError> {
        match self.locate(uri, object)? {
            Located::Data(data) => Ok(data),
            Located::File(path) => self.read(&path, object),
        }
    }

    /// A file that [`Self::locate`] found.
    pub(super) fn read(&self, path: &Path, object: &str) -> Result<Vec<u8>, ImportError> {
        let missing = |reason: String| ImportError::MissingPart {
            file: self.file.clone(),
            object: object.into(),
            needed: path.display().to_string(),
            reason,
        };
        let bytes = read_bytes(path).map_err(|reason| match in_another_case(path) {
            Some(there) => missing(format!(
                "{reason}, but there is \"{there}\": capitals and small letters count"
            )),
            None => missing(reason),
        })?;
        match words::mistaken(&bytes) {
            Some(reason) => Err(missing(reason.to_owned())),
            None => Ok(bytes),
        }
    }

    /// What a URI leads to: `data:` or a file in the scene's folder.
    pub(super) fn locate(&self, uri: &str, object: &str) -> Result<Located, ImportError> {
        if let Some(rest) = strip_scheme(uri, "data:") {
            return decode_data_uri(rest)
                .map(Located::Data)
                .map_err(|problem| ImportError::malformed(&self.file, object, problem));
        }
        if let Some((scheme, _)) = uri.split_once(':')
            && scheme.len() > 1
            && scheme
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.'))
        {
            return Err(ImportError::Remote {
                file: self.file.clone(),
                object: object.into(),
                address: shorten(uri),
            });
        }
        let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
        // Some exporters forget to encode: a file that is there under the literal name counts too.
        let inside = |name: &str| {
            let path = inside(&self.folder, Path::new(name), self.allow_outside);
            path.map_err(|needed| ImportError::Outside {
                file: self.file.clone(),
                object: object.into(),
                needed: needed.display().to_string(),
            })
        };
        let path = inside(&name)?;
        if !path.exists() && self.folder.join(uri).exists() {
            return Ok(Located::File(inside(uri)?));
        }
        Ok(Located::File(path))
    }

    /// A node, read anew from the JSON.
    pub(super) fn node(&self, index: usize) -> Option<NodeJson> {
        NodeJson::deserialize(self.value.get("nodes")?.get(index)?).ok()
    }

    /// The nodes that skins hang on.
    pub(super) fn joints(&self) -> HashSet<usize> {
        let skins = self.graph.skins.iter();
        skins.flat_map(|skin| skin.joints.iter().copied()).collect()
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

    /// The rules of shaders in the Blender whose version Sundog's add-on ran in; of other files those of before.
    pub(super) fn shader_rules(&self, wanted: Option<CyclesVersion>) -> ShaderRules {
        let generator = self.core.asset.generator.as_deref();
        let told = generator.and_then(|g| g.strip_prefix("Sundog add-on for Blender "));
        let version = wanted.or_else(|| told?.parse().ok());
        version.map_or(ShaderRules::default(), ShaderRules::of)
    }

    /// Whether the file was made of what Cycles renders: by Blender's exporter or by Sundog's add-on.
    pub(super) fn is_as_cycles_shows(&self) -> bool {
        let generator = self.core.asset.generator.as_deref().unwrap_or_default();
        self.blender_version().is_some() || generator.starts_with("Sundog add-on for Blender")
    }

    /// An extension object of the JSON object at a pointer such as `/materials/3`.
    pub(super) fn extension(&self, pointer: &str, name: &str) -> Option<&Value> {
        self.value.pointer(pointer)?.get("extensions")?.get(name)
    }
}

/// What a URI leads to.
pub(super) enum Located {
    /// The bytes that stand in it.
    Data(Vec<u8>),
    /// A file, by one name however it is written, if it is there.
    File(PathBuf),
}

/// A file that a scene in a folder names; the error is a file that does not lie in that folder, by its name or by where
/// symbolic links lead. One that is not there may be returned.
pub(in crate::import) fn inside(
    folder: &Path,
    name: &Path,
    allow_outside: bool,
) -> Result<PathBuf, PathBuf> {
    let path = folder.join(name);
    let real = path.canonicalize();
    if allow_outside {
        return Ok(real.unwrap_or(path));
    }
    // By its name, so that nobody is told what there is elsewhere.
    let mut depth = 0usize;
    for part in name.components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            _ => return Err(path),
        }
    }
    let Ok(real) = real else {
        return Ok(path);
    };
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    if here.canonicalize().is_ok_and(|here| real.starts_with(here)) {
        Ok(real)
    } else {
        Err(path)
    }
}

/// A file beside one that is not there, of the same name but for capitals.
pub(in crate::import) fn in_another_case(path: &Path) -> Option<String> {
    if path.exists() {
        return None;
    }
    let wanted = path.file_name()?.to_str()?.to_lowercase();
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let mut names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.find(|name| name.to_lowercase() == wanted)
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

/// A place in the JSON, such as `meshes[3].primitives[0]`, with the name of the object where it has one.
fn named(value: &Value, path: &str) -> String {
    let name = path.split_once('[').and_then(|(list, rest)| {
        let index: usize = rest.split_once(']')?.0.parse().ok()?;
        value.get(list)?.get(index)?.get("name")?.as_str()
    });
    match name {
        Some(name) => format!("{path} of \"{}\"", shorten(name)),
        None => path.into(),
    }
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

/// The JSON as cameras, lights and scenes, as a number of nodes, and by the `gltf` crate's schema.
fn readings(value: &Value) -> Result<(Graph, usize, json::Root), String> {
    let graph = Graph::parse(value)?;
    let nodes = NodeJson::check_all(value)?;
    let core = core_json(value);
    check_indices(&core, "")?;
    let core = serde_path_to_error::deserialize(core).map_err(|e| {
        let object = named(value, &e.path().to_string());
        format!("{object}: {}", words::plain(e.inner()))
    })?;
    Ok((graph, nodes, core))
}

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

/// Makes JSON as its users read it: without `null`, which some exporters write for what they leave out, and with whole
/// numbers as such, however they are written: JSON has one kind of number, and some writers put `1.0`.
fn tidy(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(fields) => {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(tidy);
        }
        Value::Number(number) if number.is_f64() => {
            // Up to 2⁵³ a float is the number that was written. A negative zero is none.
            const WHOLE: f64 = 9_007_199_254_740_992.0;
            if let Some(n) = number.as_f64()
                && n.fract() == 0.0
                && n.abs() <= WHOLE
                && !(n == 0.0 && n.is_sign_negative())
            {
                *number = (n as i64).into();
            }
        }
        _ => {}
    }
}

/// Refuses indices and enumerations above 2³² − 1, of which the `gltf` crate would keep the lower 32 bits.
fn check_indices(value: &Value, within: &str) -> Result<(), String> {
    const NUMBERS: [&str; 15] = [
        "buffer",
        "bufferView",
        "componentType",
        "index",
        "indices",
        "magFilter",
        "material",
        "minFilter",
        "mode",
        "sampler",
        "source",
        "target",
        "texCoord",
        "wrapS",
        "wrapT",
    ];
    // Every value of these is an index.
    let all = matches!(within, "attributes" | "targets");
    match value {
        Value::Array(items) => items
            .iter()
            .try_for_each(|item| check_indices(item, within)),
        Value::Object(fields) => fields.iter().try_for_each(|(key, field)| {
            if (all || NUMBERS.contains(&key.as_str()))
                && field.as_u64().is_some_and(|n| n > u64::from(u32::MAX))
            {
                return Err(format!(
                    "\"{key}\" is {field}, but no number of an object is above {}",
                    u32::MAX
                ));
            }
            check_indices(field, if within == "targets" { within } else { key })
        }),
        _ => Ok(()),
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
#[path = "../../../tests/unit/import/gltf/container.rs"]
mod tests;
