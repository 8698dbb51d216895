//! Primitives become triangle meshes.

use ::gltf::json;
use json::accessor::{ComponentType, Type};
use json::mesh::{Mode, Semantic};
use json::validation::Checked;

use super::accessor::{self, Source};
use super::container::Document;
use super::deform::{self, Pose};
use super::draco::Decoded;

use super::radial;
use super::schema::{SundogMaterial, TextureSpaceJson};
use super::strands::StrandsSource;
use super::strokes::Stroke;
use crate::import::budget::Budget;
use crate::scene::tangents;
use crate::scene::{
    Diagnostics, Effect, Grids, MaterialId, MaterialLabel, Mesh, MeshStep, Part, TextureSpace,
    Verdict,
};
use serde::Deserialize;
use std::sync::Arc;

/// What a primitive needs to know of its material.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitiveMaterial {
    pub id: Option<MaterialId>,
    /// The UV set that tangents follow, if a normal map or anisotropy needs them.
    pub tangents: Option<(u32, Effect)>,
    /// It needs radial tangents.
    pub radial: bool,
    /// The highest UV set of its other textures.
    pub uv_set: Option<u32>,
    /// So many attributes of its own does its node tree ask for.
    pub attributes: usize,
    /// The last of them is where its vertices were before they were displaced, or their normals then.
    pub asks_before: bool,
    /// Vertex colours above this would make the surface send out more light than arrives; `None` if they may.
    pub brightest: Option<[f32; 3]>,
}

/// A primitive and where its values are.
pub(super) struct Attributes<'a> {
    pub primitive: &'a json::mesh::Primitive,
    /// What came out of its compressed stream, if it has one.
    pub decoded: Option<Decoded>,
    /// Accessors of "_SUNDOG_0", "_SUNDOG_1" …
    pub own: Vec<usize>,
    /// The box of its generated coordinates.
    pub texture_space: Option<TextureSpaceJson>,
    /// The accessor of these coordinates, where they are given.
    pub generated: Option<usize>,
    /// What tells its vertices apart, where they may be displaced.
    pub vertices: Option<VerticesSource>,
    /// The accessors of its vertices' positions, and of their normals, at steps of time.
    pub motion: Vec<(usize, Option<usize>)>,
    /// Grids of what fills it.
    pub grids: Option<Arc<Grids>>,
    /// It is drawn as strands or points.
    pub strands: Option<StrandsSource>,
}

/// Where the vertices of a mesh that may be displaced are named.
pub(super) struct VerticesSource {
    /// The accessor of their numbers.
    pub numbers: usize,
    /// The accessor of their normals, if the mesh is flat and says them.
    pub normals: Option<usize>,
    /// The number of the mesh.
    pub whole: u32,
}

impl Attributes<'_> {
    /// An attribute's accessor, with its values if they were compressed.
    pub(super) fn get(&self, semantic: Semantic) -> Option<Source<'_>> {
        let semantic = Checked::Valid(semantic);
        let index = self.primitive.attributes.get(&semantic)?.value();
        let decoded = self.decoded.as_ref();
        Some(Source {
            index,
            unpacked: decoded.and_then(|d| d.attributes.get(&semantic)),
        })
    }
}

/// More attributes of their own than this no node tree refers to.
pub(super) const MOST_ATTRIBUTES: usize = 64;

/// More texture coordinate sets than this no material of ours refers to.
const UV_SETS: u32 = 8;

/// A primitive that was read.
pub(super) struct Loaded {
    pub mesh: Mesh,
    /// Triangles that were left out because their corners do not exist.
    pub dropped: usize,
    /// It has no surface yet.
    pub stroke: Option<Stroke>,
}

/// Reads one primitive; `None` if there is nothing to render (which a diagnostic tells).
pub(super) fn load_primitive(
    document: &Document,
    name: &str,
    attributes: &Attributes,
    material: PrimitiveMaterial,
    pose: &Pose,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Loaded>, String> {
    let primitive = attributes.primitive;
    let Checked::Valid(mode) = primitive.mode else {
        return Err("its primitive mode is none that glTF knows".into());
    };
    let shape = read_shape(document, name, attributes, pose, budget, diagnostics)?;
    let Some((positions, normals, mut tangents)) = shape else {
        return Ok(None);
    };
    let count =
        u32::try_from(positions.len()).map_err(|_| "it has more than 2³² vertices".to_string())?;
    let whole = |what: &str, length: usize| same_length(positions.len(), what, length);
    let attribute = |semantic| attributes.get(semantic);
    let mut uvs = Vec::new();
    for set in 0..UV_SETS {
        let Some(index) = attribute(Semantic::TexCoords(set)) else {
            break;
        };
        let coordinates = accessor::read_f32::<2>(document, index, budget)?;
        whole("texture coordinates", coordinates.len())?;
        uvs.push(coordinates);
    }
    let colors = match attribute(Semantic::Colors(0)) {
        Some(index) => {
            let colors = read_colors(document, index, budget)?;
            whole("vertex colours", colors.len())?;
            let colors = limited(colors, material, name, diagnostics);
            Some(colors)
        }
        None => None,
    };
    let mut own = own_attributes(document, attributes, (count, material.attributes), budget)?;
    let given = |index| Source {
        index,
        unpacked: None,
    };
    let generated = match attributes.generated {
        Some(index) => {
            let generated = accessor::read_f32::<3>(document, given(index), budget)?;
            whole("generated coordinates", generated.len())?;
            Some(generated)
        }
        None => None,
    };
    let motion = read_motion(document, attributes, positions.len(), budget)?;
    let mut part = None;
    if let Some(source) = &attributes.vertices {
        let vertices = accessor::read_f32::<3>(document, given(source.numbers), budget)?;
        whole("numbers of vertices", vertices.len())?;
        // What stands on the surface before it was displaced asks for an attribute after all others, which takes the place of these.
        let place = own.len() - usize::from(material.asks_before);
        own.truncate(place);
        own.push(vertices.iter().map(|[a, b, c]| [*a, *b, *c, 1.0]).collect());
        if let Some(index) = source.normals {
            let normals = accessor::read_f32::<3>(document, given(index), budget)?;
            whole("normals of vertices", normals.len())?;
            own.push(normals.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect());
        }
        part = Some(Part {
            whole: source.whole,
            vertices: place as u32,
            with_normals: source.normals.is_some(),
        });
    }
    if attribute(Semantic::Colors(1)).is_some() {
        diagnostics.report_effect(
            Effect::VertexColors,
            "more-vertex-colours",
            Verdict::Lost,
            "COLOR_1 and further vertex colours",
            name,
            "left out: glTF's materials use COLOR_0 only",
        );
    }

    let corners = read_corners(document, attributes, count, budget)?;
    let mut stroke = Stroke::new(mode, &corners, count).filter(|_| attributes.decoded.is_none());
    let (triangles, dropped) = match &stroke {
        Some(_) => (Vec::new(), 0),
        None => triangles(attributes, mode, (corners, count), budget)?,
    };
    if triangles.is_empty() && stroke.is_none() {
        let (verdict, feature) = match dropped {
            0 => (Verdict::Exact, "mesh without triangles"),
            _ => (Verdict::Lost, "mesh of corners that do not exist"),
        };
        diagnostics.report("empty-mesh", verdict, feature, name, "left out");
        return Ok(None);
    }

    if tangents.is_some() && material.tangents.is_none() {
        tangents = None;
    }
    let radial = material.radial.then(|| match &generated {
        Some(generated) => radial::of_generated(generated),
        None => radial::of_positions(&positions, attributes.texture_space),
    });
    let texture_space = attributes
        .texture_space
        .map_or_else(|| TextureSpace::around(&positions), Into::into);
    let mut mesh = Mesh {
        name: name.into(),
        positions,
        normals,
        tangents,
        tangent_set: None,
        radial,
        uvs,
        colors,
        attributes: own,
        texture_space,
        generated,
        motion,
        triangles,
        material: material.id,
        material_label: material_label(document, attributes.primitive),
        part,
        grids: attributes.grids.clone(),
        strands: None,
    };
    if let Some(strands) = attributes.strands {
        (mesh.tangents, mesh.radial) = (None, None);
        strands.draw(document, &mut mesh, stroke.take(), budget)?;
    } else if stroke.is_none() {
        drop_unused_vertices(&mut mesh);
        complete_for_material(&mut mesh, material, budget, diagnostics)?;
    } else {
        // Their surfaces have none.
        (mesh.tangents, mesh.radial, mesh.generated) = (None, None, None);
        mesh.motion.clear();
    }
    Ok(Some(Loaded {
        mesh,
        dropped,
        stroke,
    }))
}

/// Where its vertices are at steps of time.
fn read_motion(
    document: &Document,
    attributes: &Attributes,
    count: usize,
    budget: &Budget,
) -> Result<Vec<MeshStep>, String> {
    let read = |index, what: &str| {
        let unpacked = None;
        let values = accessor::read_f32::<3>(document, Source { index, unpacked }, budget)?;
        same_length(count, what, values.len())?;
        Ok::<_, String>(values)
    };
    let steps = attributes.motion.iter().map(|&(position, normal)| {
        Ok(MeshStep {
            positions: read(position, "positions of a step")?,
            normals: normal.map(|n| read(n, "normals of a step")).transpose()?,
        })
    });
    steps.collect()
}

/// What passes tell of a primitive's material. What the add-on calls "(no material)" is none.
fn material_label(document: &Document, primitive: &json::mesh::Primitive) -> MaterialLabel {
    let Some(number) = primitive.material.map(|m| m.value()) else {
        return MaterialLabel::default();
    };
    let source = document.core.materials.get(number);
    let name = source.and_then(|material| material.name.as_deref());
    let extension = document.extension(&format!("/materials/{number}"), "SUNDOG_material");
    // What it can't be read for is told where the material is read.
    let index = extension.and_then(|e| SundogMaterial::deserialize(e).ok()?.pass_index);
    MaterialLabel {
        name: name.filter(|name| *name != "(no material)").map(Into::into),
        index: index.unwrap_or(0.0),
    }
}

/// Positions, normals and tangents.
type Shape = (Vec<[f32; 3]>, Option<Vec<[f32; 3]>>, Option<Vec<[f32; 4]>>);

/// Reads where a primitive's vertices are, in its pose; `None` if nowhere.
fn read_shape(
    document: &Document,
    name: &str,
    attributes: &Attributes,
    pose: &Pose,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Shape>, String> {
    let attribute = |semantic| attributes.get(semantic);
    let Some(positions) = attribute(Semantic::Positions) else {
        diagnostics.report(
            "no-positions",
            Verdict::Lost,
            "mesh without positions",
            name,
            "left out",
        );
        return Ok(None);
    };
    let mut positions = accessor::read_f32::<3>(document, positions, budget)?;
    let count = positions.len();
    let mut normals = None;
    if let Some(source) = attribute(Semantic::Normals) {
        let read = accessor::read_f32::<3>(document, source, budget)?;
        same_length(count, "normals", read.len())?;
        normals = Some(read);
    }
    let mut tangents = None;
    // "When normals are not specified […] the provided tangents (if present) MUST be ignored."
    if let Some(source) = attribute(Semantic::Tangents).filter(|_| normals.is_some()) {
        let read = accessor::read_f32::<4>(document, source, budget)?;
        same_length(count, "tangents", read.len())?;
        tangents = Some(read);
    }
    let shape = deform::Shape {
        positions: &mut positions,
        normals: normals.as_mut(),
        tangents: tangents.as_mut(),
    };
    let odd = pose.apply(document, attributes, shape, budget)?;
    odd.report(name, diagnostics);
    Ok(Some((positions, normals, tangents)))
}

fn same_length(positions: usize, what: &str, length: usize) -> Result<(), String> {
    if length == positions {
        Ok(())
    } else {
        Err(format!("it has {positions} positions but {length} {what}"))
    }
}

/// Vertex colours that make no light of nothing.
fn limited(
    mut colors: Vec<[f32; 4]>,
    material: PrimitiveMaterial,
    name: &str,
    diagnostics: &mut Diagnostics,
) -> Vec<[f32; 4]> {
    if let Some(most) = material.brightest
        && limit_colors(&mut colors, most)
    {
        diagnostics.report_effect(
            Effect::VertexColors,
            "bright-vertex-colours",
            Verdict::Approximated,
            "vertex colours that make a surface brighter than white",
            name,
            "brought down to white: it would make light of nothing",
        );
    }
    colors
}

/// The corners of a primitive, in the order of the file.
fn read_corners(
    document: &Document,
    attributes: &Attributes,
    count: u32,
    budget: &Budget,
) -> Result<Vec<u32>, String> {
    Ok(match (&attributes.decoded, &attributes.primitive.indices) {
        (Some(decoded), _) => {
            budget.take(decoded.corners.len() as u64, 4)?;
            decoded.corners.clone()
        }
        (None, Some(index)) => accessor::read_indices(document, index.value(), budget)?,
        (None, None) => {
            budget.take(u64::from(count), 4)?;
            (0..count).collect()
        }
    })
}

/// The triangles of corners, and how many were left out because their corners do not exist.
fn triangles(
    attributes: &Attributes,
    mode: Mode,
    (corners, count): (Vec<u32>, u32),
    budget: &Budget,
) -> Result<(Vec<[u32; 3]>, usize), String> {
    // A compressed stream holds triangles, whatever the mode.
    let mode = if attributes.decoded.is_some() {
        Mode::Triangles
    } else {
        mode
    };
    budget.take(
        corners.len() as u64,
        if mode == Mode::Triangles { 4 } else { 12 },
    )?;
    let mut triangles = assemble(mode, &corners);
    drop(corners);
    let before = triangles.len();
    triangles.retain(|t| t.iter().all(|&i| i < count));
    let dropped = before - triangles.len();
    Ok((triangles, dropped))
}

/// Calculates tangents that the material needs and the file does not have, and says which texture coordinates are missing.
fn complete_for_material(
    mesh: &mut Mesh,
    material: PrimitiveMaterial,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<(), String> {
    let name = mesh.name.clone();
    if let Some((set, effect)) = material.tangents
        && mesh.tangents.is_none()
    {
        if mesh.uvs.len() > set as usize {
            // Corners come apart before they are welded again: three full vertices a triangle.
            budget.take(mesh.triangles.len() as u64 * 3, 60)?;
            tangents::compute(mesh, set as usize);
        } else if effect == Effect::Anisotropy {
            diagnostics.report_effect(
                effect,
                "anisotropy-without-uv",
                Verdict::Lost,
                format!("anisotropy on meshes without texture coordinate set {set}"),
                &name,
                "rendered with an isotropic highlight",
            );
        } else {
            diagnostics.report_effect(
                effect,
                "normal-map-without-uv",
                Verdict::Lost,
                format!("normal map on meshes without texture coordinate set {set}"),
                &name,
                "the plain normals are used",
            );
        }
    }
    if let Some(set) = material.uv_set
        && mesh.uvs.len() <= set as usize
    {
        diagnostics.report(
            "texture-without-uv",
            Verdict::Approximated,
            format!("texture on meshes without texture coordinate set {set}"),
            &name,
            "its texel at (0, 0) is shown everywhere, as viewers of glTF do",
        );
    }
    Ok(())
}

/// Attributes "_SUNDOG_0", "_SUNDOG_1" …, so many as the material's node tree asks for; those that are not there are black.
fn own_attributes(
    document: &Document,
    attributes: &Attributes,
    (count, wanted): (u32, usize),
    budget: &Budget,
) -> Result<Vec<Vec<[f32; 4]>>, String> {
    let one = |number: usize| {
        let source = attributes.own.get(number).map(|&index| Source {
            index,
            unpacked: None,
        });
        let Some(source) = source else {
            budget.take(u64::from(count), 16)?;
            return Ok(vec![[0.0, 0.0, 0.0, 1.0]; count as usize]);
        };
        let values: Vec<[f32; 4]> = match accessor::shape(document, source)?.kind {
            Type::Scalar => accessor::read_f32::<1>(document, source, budget)?
                .into_iter()
                .map(|[v]| [v, v, v, 1.0])
                .collect(),
            Type::Vec2 => accessor::read_f32::<2>(document, source, budget)?
                .into_iter()
                .map(|[x, y]| [x, y, 0.0, 1.0])
                .collect(),
            Type::Vec3 => accessor::read_f32::<3>(document, source, budget)?
                .into_iter()
                .map(|[x, y, z]| [x, y, z, 1.0])
                .collect(),
            _ => accessor::read_f32::<4>(document, source, budget)?,
        };
        if values.len() == count as usize {
            Ok(values)
        } else {
            let length = values.len();
            Err(format!(
                "it has {count} positions but {length} values of _SUNDOG_{number}"
            ))
        }
    };
    (0..wanted).map(one).collect()
}

/// RGB or RGBA; missing alpha is 1.
fn read_colors(
    document: &Document,
    index: Source,
    budget: &Budget,
) -> Result<Vec<[f32; 4]>, String> {
    let shape = accessor::shape(document, index)?;
    // Exporters forget `normalized` on integer colours, which then can mean nothing else.
    let scale = match (shape.normalized, shape.component) {
        (false, ComponentType::U8) => 1.0 / 255.0,
        (false, ComponentType::U16) => 1.0 / 65535.0,
        _ => 1.0,
    };
    if shape.kind == Type::Vec3 {
        let rgb = accessor::read_f32::<3>(document, index, budget)?;
        Ok(rgb
            .into_iter()
            .map(|[r, g, b]| [r * scale, g * scale, b * scale, 1.0])
            .collect())
    } else {
        let rgba = accessor::read_f32::<4>(document, index, budget)?;
        Ok(rgba.into_iter().map(|c| c.map(|v| v * scale)).collect())
    }
}

/// Brings colours down to the largest allowed; whether that changed more than rounding does.
fn limit_colors(colors: &mut [[f32; 4]], most: [f32; 3]) -> bool {
    let mut changed = false;
    for color in colors {
        for (value, most) in color.iter_mut().zip(most) {
            if *value > most {
                changed |= *value > most * (1.0 + 16.0 * f32::EPSILON);
                *value = most;
            }
        }
    }
    changed
}

/// Corners in drawing order become triangles, with the winding of specification 3.7.2.1.
fn assemble(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .filter_map(|(i, w)| match *w {
                [a, b, c] => Some(if i % 2 == 0 { [a, b, c] } else { [a, c, b] }),
                _ => None,
            })
            .collect(),
        Mode::TriangleFan => match corners.split_first() {
            Some((&hub, rim)) => rim
                .windows(2)
                .filter_map(|w| match *w {
                    [b, c] => Some([b, c, hub]),
                    _ => None,
                })
                .collect(),
            None => Vec::new(),
        },
        _ => corners
            .chunks_exact(3)
            .filter_map(|w| match *w {
                [a, b, c] => Some([a, b, c]),
                _ => None,
            })
            .collect(),
    }
}

/// Primitives may share one large vertex buffer of which each uses a part; each keeps only its own.
fn drop_unused_vertices(mesh: &mut Mesh) {
    let mut used = vec![false; mesh.positions.len()];
    for &corner in mesh.triangles.iter().flatten() {
        used[corner as usize] = true;
    }
    if used.iter().all(|&u| u) {
        return;
    }
    let mut next = 0;
    let place: Vec<u32> = used
        .iter()
        .map(|&u| {
            let here = next;
            next += u32::from(u);
            here
        })
        .collect();
    let kept: Vec<u32> = (0..)
        .zip(&used)
        .filter(|(_, used)| **used)
        .map(|(i, _)| i)
        .collect();
    mesh.take_vertices(&kept);
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = place[*corner as usize];
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/gltf/mesh.rs"]
mod tests;
