//! KHR_draco_mesh_compression, through the crate `draco-core`.

use std::collections::BTreeMap;

use ::gltf::json;
use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex,
};
use json::accessor::ComponentType;
use json::mesh::{Mode, Primitive, Semantic};
use json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use super::accessor::{self, Unpacked};
use super::container::Document;
use crate::import::budget::Budget;
use crate::import::guard::guarded;

/// The extension's object on a primitive.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extension {
    buffer_view: usize,
    /// The stream's own number of each attribute.
    #[serde(default)]
    attributes: BTreeMap<String, u32>,
}

/// What came out of a primitive's stream.
pub(super) struct Decoded {
    /// Three for each triangle.
    pub corners: Vec<u32>,
    pub attributes: BTreeMap<Checked<Semantic>, Unpacked>,
}

/// Memory of the decoder for a triangle: its corners, their opposites, and the same for one attribute with seams.
const BYTES_PER_FACE: usize = 160;

/// The buffer view of a primitive's stream, if it has one.
pub(super) fn buffer_view(extension: &Value) -> Option<usize> {
    let index = extension.get("bufferView")?.as_u64()?;
    usize::try_from(index).ok()
}

/// Decodes a primitive's stream. What accessors say is asked before memory is taken, and holds afterwards.
pub(super) fn decode(
    document: &Document,
    extension: &Value,
    primitive: &Primitive,
    budget: &Budget,
) -> Result<Decoded, String> {
    let extension = Extension::deserialize(extension)
        .map_err(|e| format!("its KHR_draco_mesh_compression cannot be read ({e})"))?;
    let (stream, _) = document.view(extension.buffer_view)?;
    let wanted = wanted(document, &extension, primitive)?;
    let points = match wanted.first() {
        Some(first) => first.shape.count,
        None => return Err("its Draco data hold none of its attributes".into()),
    };
    if let Some(other) = wanted.iter().find(|w| w.shape.count != points) {
        return Err(format!(
            "its attributes have {points} and {} elements",
            other.shape.count
        ));
    }
    let faces = faces(document, primitive)?;
    // Where nothing says how many triangles there are, each takes a bit at least.
    let most_faces = faces.unwrap_or(stream.len().saturating_mul(8)) as u64;
    budget.take(faces.unwrap_or(0) as u64, BYTES_PER_FACE)?;
    for attribute in &wanted {
        // As decoded, as quantised inside the decoder, and as laid out for reading.
        let element = accessor::components(attribute.shape.kind) * 4;
        budget.take(points as u64, 3 * element)?;
    }
    let limits = DecodeLimits::default()
        .with_max_faces(most_faces)
        .with_max_points(points as u64)
        .with_max_decoded_bytes(budget.left());
    guarded(|| {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new()
            .decode(&mut buffer, &mut mesh)
            .map_err(|e| match e.kind() {
                ErrorKind::LimitExceeded => {
                    "its Draco data hold more triangles or vertices than its accessors say".into()
                }
                _ => format!("its Draco data are damaged ({})", e.message()),
            })?;
        if let Some(faces) = faces
            && mesh.num_faces() != faces
        {
            return Err(format!(
                "its Draco data hold {} triangles, but its accessor says {faces}",
                mesh.num_faces()
            ));
        }
        if mesh.num_points() != points {
            return Err(format!(
                "its Draco data hold {} vertices, but its accessors say {points}",
                mesh.num_points()
            ));
        }
        let mut attributes = BTreeMap::new();
        for attribute in wanted {
            let source = mesh
                .attribute_by_unique_id(attribute.id)
                .ok_or_else(|| format!("its Draco data have no attribute {}", attribute.id))?;
            attributes.insert(attribute.semantic, lay_out(source, points)?);
        }
        let faces = mesh.faces().iter();
        Ok(Decoded {
            corners: faces.flatten().map(|corner| corner.0).collect(),
            attributes,
        })
    })
}

/// An attribute that the stream should hold.
struct Wanted {
    semantic: Checked<Semantic>,
    id: u32,
    shape: accessor::Shape,
}

/// The attributes of the stream that are of use.
fn wanted(
    document: &Document,
    extension: &Extension,
    primitive: &Primitive,
) -> Result<Vec<Wanted>, String> {
    let mut wanted = Vec::new();
    for (semantic, index) in &primitive.attributes {
        // Those that are an application's own nobody reads.
        let Checked::Valid(known) = semantic else {
            continue;
        };
        if let Some(&id) = extension.attributes.get(&known.to_string()) {
            wanted.push(Wanted {
                semantic: semantic.clone(),
                id,
                shape: accessor::shape(document, index.value())?,
            });
        }
    }
    Ok(wanted)
}

/// How many triangles the accessor of the indices promises.
fn faces(document: &Document, primitive: &Primitive) -> Result<Option<usize>, String> {
    match (&primitive.indices, &primitive.mode) {
        (Some(indices), Checked::Valid(Mode::Triangles)) => {
            Ok(Some(accessor::shape(document, indices.value())?.count / 3))
        }
        // A strip's indices are counted otherwise than the stream's triangles.
        _ => Ok(None),
    }
}

/// The values point by point, in a type that accessors have.
fn lay_out(attribute: &PointAttribute, points: usize) -> Result<Unpacked, String> {
    let components = usize::from(attribute.num_components());
    let width = attribute.data_type().byte_length();
    let component = match attribute.data_type() {
        DataType::Int8 => Some(ComponentType::I8),
        DataType::Uint8 | DataType::Bool => Some(ComponentType::U8),
        DataType::Int16 => Some(ComponentType::I16),
        DataType::Uint16 => Some(ComponentType::U16),
        DataType::Uint32 => Some(ComponentType::U32),
        DataType::Float32 => Some(ComponentType::F32),
        // Types that no accessor has become floats.
        _ => None,
    };
    let data = attribute.buffer().data();
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(0);
    let size = components * width;
    let short = || "its Draco data are damaged (values are missing)".to_string();
    let narrow = |bytes: &[u8]| -> f32 {
        match (attribute.data_type(), bytes) {
            (DataType::Int32, &[a, b, c, d]) => i32::from_le_bytes([a, b, c, d]) as f32,
            (DataType::Int64, &[a, b, c, d, e, f, g, h]) => {
                i64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32
            }
            (DataType::Uint64, &[a, b, c, d, e, f, g, h]) => {
                u64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32
            }
            (DataType::Float64, &[a, b, c, d, e, f, g, h]) => {
                f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32
            }
            _ => 0.0,
        }
    };
    let mut bytes = Vec::with_capacity(points * components * component.map_or(4, |_| width));
    for point in 0..points {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride).ok_or_else(short)?;
        let element = start
            .checked_add(size)
            .and_then(|end| data.get(start..end))
            .ok_or_else(short)?;
        if component.is_some() {
            bytes.extend_from_slice(element);
        } else {
            for scalar in element.chunks_exact(width.max(1)) {
                bytes.extend(narrow(scalar).to_le_bytes());
            }
        }
    }
    Ok(Unpacked {
        component: component.unwrap_or(ComponentType::F32),
        components,
        bytes,
    })
}
