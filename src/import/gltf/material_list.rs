//! The materials of a scene, and what its meshes have to know of them.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use serde::Deserialize;
use std::collections::{BTreeSet, HashMap};

use super::container::Document;
use super::material;
use super::mesh::PrimitiveMaterial;
use super::schema::SundogMaterial;
use super::shader_graph;
use super::shapes::mesh_name;
use super::textures::Images;
use crate::import::{ImportError, ImportOptions};
use crate::scene::graph::{Graph, TangentKind};
use crate::scene::{
    Anisotropy, Aov, CoatNormal, Diagnostics, Effect, MaterialId, MetallicRoughness, Verdict,
};

/// The materials that the scene's meshes use, in file order, and the images that these use.
pub(super) struct Materials<'a> {
    pub(super) list: Vec<MetallicRoughness>,
    /// What is rendered instead, where a node tree is known.
    pub(super) graphs: Vec<Option<Graph>>,
    /// What they tell passes of the scene's own.
    pub(super) aovs: Vec<Option<Graph>>,
    /// Which of them are holdouts.
    pub(super) holdouts: Vec<bool>,
    pub(super) by_primitive: HashMap<MaterialKey, PrimitiveMaterial>,
    pub(super) images: Images<'a>,
}

/// A glTF material index (or none), and whether what it is of is drawn without light.
pub(super) type MaterialKey = (Option<usize>, bool);

/// The material of a primitive, which stands at a place of the file. Points and lines without normals show their colour
/// (specification 3.9.6), but for strands.
pub(super) fn key(document: &Document, pointer: &str, primitive: &Primitive) -> MaterialKey {
    let surfaces = [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan];
    let is_surface = matches!(primitive.mode, Checked::Valid(mode) if surfaces.contains(&mode));
    let strands = || {
        let extension = document.extension(pointer, "SUNDOG_mesh");
        extension.is_some_and(|extension| extension.get("strands").is_some())
    };
    let normals = Checked::Valid(Semantic::Normals);
    let lit = primitive.attributes.contains_key(&normals) || strands();
    (primitive.material.map(|m| m.value()), !is_surface && !lit)
}

impl<'a> Materials<'a> {
    pub(super) fn load(
        document: &'a Document,
        used_meshes: &BTreeSet<usize>,
        known_aovs: &[Aov],
        options: &ImportOptions,
        diagnostics: &mut Diagnostics,
    ) -> Result<Self, ImportError> {
        let mut used: BTreeSet<MaterialKey> = BTreeSet::new();
        let mut bare: Option<String> = None;
        for &index in used_meshes {
            let Some(mesh) = document.core.meshes.get(index) else {
                continue;
            };
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                let pointer = format!("/meshes/{index}/primitives/{number}");
                used.insert(key(document, &pointer, primitive));
                if primitive.material.is_none() {
                    bare.get_or_insert_with(|| mesh_name(document, index));
                }
            }
        }
        let mut images = Images::new(document, options.image_bytes);
        let mut list = Vec::new();
        let mut graphs = Vec::new();
        let mut holdouts = Vec::new();
        let mut all_aovs = Vec::new();
        let mut by_primitive = HashMap::new();
        for at in used {
            let (index, drawn) = at;
            let mut material = match index {
                Some(index) => Some(material::load_material(
                    document,
                    index,
                    options,
                    &mut images,
                    diagnostics,
                )?),
                None if drawn => Some(MetallicRoughness {
                    name: "(points and lines)".into(),
                    ..MetallicRoughness::default()
                }),
                None => material::without_material(document).inspect(|_| {
                    diagnostics.report(
                        "no-material",
                        Verdict::Exact,
                        "mesh without a material in a file from Blender",
                        bare.clone().unwrap_or_default(),
                        "looks as in that version's Cycles; glTF itself would mean white metal",
                    );
                }),
            };
            if let (true, Some(m)) = (drawn, &mut material) {
                m.unlit = true;
            }
            let graph = match (index, &material) {
                (Some(index), Some(m)) => {
                    let which = (index, &*m.name);
                    shader_graph::load(document, which, &mut images, options.cycles, diagnostics)?
                }
                _ => None,
            };
            let extension = index.and_then(|index| {
                document.extension(&format!("/materials/{index}"), "SUNDOG_material")
            });
            let known = extension.and_then(|e| SundogMaterial::deserialize(e).ok());
            let filled = known
                .as_ref()
                .and_then(|e| e.volume.as_ref()?.graph.as_ref());
            if let (Some(value), Some(m)) = (filled, &mut material) {
                let volume = shader_graph::load_volume(
                    document,
                    (value, Some(&m.name)),
                    &mut images,
                    options.cycles,
                    diagnostics,
                )?;
                if let Some(medium) = &mut m.medium {
                    medium.varying = volume.map(Box::new);
                }
            }
            let told = known.and_then(|e| e.aovs);
            let aovs = match (&told, &material) {
                (Some(value), Some(m)) if !known_aovs.is_empty() => shader_graph::load_aovs(
                    document,
                    (value, Some(&m.name)),
                    known_aovs,
                    &mut images,
                    options.cycles,
                    diagnostics,
                )?,
                _ => None,
            };
            let both = || graph.iter().chain(&aovs);
            let attributes = both()
                .map(|loaded| loaded.graph.attributes())
                .fold(0, usize::max);
            let asks_before = graph.as_ref().is_some_and(|loaded| loaded.asks_before);
            let of_graph = both().find_map(|loaded| loaded.tangents);
            let tangents = of_graph
                .map(|set| (set, Effect::NormalMaps))
                .or_else(|| material.as_ref().and_then(tangents));
            let is_radial = |loaded: &shader_graph::Loaded| {
                let mut nodes = loaded.graph.nodes.iter();
                nodes.any(|node| node.is_anisotropic_about_z())
            };
            let radial = both().any(is_radial) || material.as_ref().is_some_and(|m| {
                let radial = TangentKind::Radial;
                matches!(m.anisotropy, Some(Anisotropy::Blender { tangent, .. }) if tangent == radial)
            });
            let uv_set = material
                .as_mut()
                .and_then(MetallicRoughness::highest_uv_set);
            let brightest = brightest(document, material.as_ref());
            let id = material.map(|material| {
                list.push(material);
                holdouts.push(graph.as_ref().is_some_and(|loaded| loaded.holdout));
                graphs.push(graph.map(|loaded| loaded.graph));
                all_aovs.push(aovs.map(|loaded| loaded.graph));
                MaterialId((list.len() - 1) as u32)
            });
            by_primitive.insert(
                at,
                PrimitiveMaterial {
                    id,
                    tangents,
                    radial,
                    uv_set,
                    attributes,
                    asks_before,
                    brightest,
                },
            );
        }
        Ok(Self {
            list,
            graphs,
            aovs: all_aovs,
            holdouts,
            by_primitive,
            images,
        })
    }
}

/// The set of texture coordinates that a material's tangents follow, and what needs them.
fn tangents(material: &MetallicRoughness) -> Option<(u32, Effect)> {
    if let Some(normal) = &material.normal_texture {
        return Some((normal.texture.uv_set, Effect::NormalMaps));
    }
    if let Some(coat) = &material.coat
        && let CoatNormal::Map(normal) = &coat.normal
    {
        return Some((normal.texture.uv_set, Effect::NormalMaps));
    }
    let set = match material.anisotropy.as_ref()? {
        Anisotropy::Gltf { texture, .. } => texture.as_ref().map_or(0, |t| t.uv_set),
        Anisotropy::Blender {
            tangent: TangentKind::Uv,
            uv_set,
            ..
        } => *uv_set,
        Anisotropy::Blender { .. } => return None,
    };
    Some((set, Effect::Anisotropy))
}

/// The vertex colours with which a material's base colour is 1. `None` where they may be brighter: what is unlit shines anyway,
/// and the add-on writes what Cycles shows.
fn brightest(document: &Document, material: Option<&MetallicRoughness>) -> Option<[f32; 3]> {
    let generator = document.core.asset.generator.as_deref();
    if material.is_some_and(|m| m.unlit)
        || generator.is_some_and(|g| g.starts_with("Sundog add-on for Blender"))
    {
        return None;
    }
    let base = material.map_or([1.0; 3], |m| m.base_color);
    Some(base.map(|c| if c < 1.0 { 1.0 / c.max(0.0) } else { 1.0 }))
}
