//! Meshes in the shapes in which the scene places them: posed, read, several at a time.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DAffine3;
use rayon::prelude::*;
use serde::Deserialize;

use super::container::Document;
use super::deform::Pose;
use super::material_list::{MaterialKey, key};
use super::mesh::{Attributes, Loaded, PrimitiveMaterial, VerticesSource};
use super::placement::{local_transform, matrix};
use super::schema::SundogMesh;
use super::strands::StrandsSource;
use super::walk::{Placed, Shaped};
use super::{draco, extensions, grids, mesh};
use crate::import::ImportError;
use crate::import::budget::Budget;
use crate::scene::validate::Dropped;
use crate::scene::{Diagnostics, Verdict};

pub(super) fn mesh_name(document: &Document, index: usize) -> String {
    let name = document.core.meshes.get(index).and_then(|m| m.name.clone());
    name.unwrap_or_else(|| format!("mesh {index}"))
}

/// The pose of each shape. Skinned meshes are placed anew: only their joints say where they are.
pub(super) fn poses(
    document: &Document,
    shapes: &BTreeSet<Shaped>,
    placed: &mut [Placed],
    worlds: &HashMap<usize, DAffine3>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<BTreeMap<Shaped, Pose>, ImportError> {
    let mut poses = BTreeMap::new();
    let mut parents = HashMap::new();
    let mut origins: HashMap<Shaped, DAffine3> = HashMap::new();
    for &shape in shapes {
        let mesh_weights = document
            .core
            .meshes
            .get(shape.mesh)
            .and_then(|m| m.weights.as_ref());
        let mut pose = Pose {
            weights: mesh_weights
                .into_iter()
                .flatten()
                .copied()
                .map(f64::from)
                .collect(),
            joints: Vec::new(),
        };
        if let Some(index) = shape.by_node
            && let Some(node) = document.node(index)
        {
            if let Some(weights) = &node.weights {
                pose.weights.clone_from(weights);
            }
            if let Some(skin) = node.skin {
                let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
                let broken = |problem: String| {
                    ImportError::malformed(&document.file, format!("node \"{name}\""), problem)
                };
                let skin =
                    document.graph.skins.get(skin).ok_or_else(|| {
                        broken(format!("it uses skin {skin}, which does not exist"))
                    })?;
                let absent = skin.joints.iter().find(|j| !worlds.contains_key(*j));
                if absent.is_some() {
                    diagnostics.report(
                        "skin-joints",
                        Verdict::Approximated,
                        "skin with joints that are not in the scene",
                        &name,
                        "posed as those stand in the file",
                    );
                    if parents.is_empty() {
                        parents = parents_of(document);
                    }
                }
                let world = |joint: usize| {
                    let placed = worlds.get(&joint).copied();
                    placed.or_else(|| stands(document, joint, &parents))
                };
                // Vertices are f32: they are kept small by measuring from the first joint.
                let first = skin
                    .joints
                    .first()
                    .and_then(|&j| world(j))
                    .unwrap_or(DAffine3::IDENTITY);
                let origin = DAffine3::from_translation(first.translation);
                let affine = |columns: &[f64; 16]| matrix(columns, &name, diagnostics);
                pose.joints = Pose::joints(document, skin, world, origin.inverse(), budget, affine)
                    .map_err(broken)?;
                origins.insert(shape, origin);
            }
        }
        poses.insert(shape, pose);
    }
    for place in placed {
        if let Some(&origin) = origins.get(&place.mesh) {
            place.world_from_object = origin;
        }
    }
    Ok(poses)
}

/// The node that each node stands below.
fn parents_of(document: &Document) -> HashMap<usize, usize> {
    let mut parents = HashMap::new();
    for index in 0..document.nodes {
        let children = document.node(index).map(|node| node.children);
        for child in children.into_iter().flatten() {
            parents.insert(child, index);
        }
    }
    parents
}

/// Where a node stands that is not in the scene.
fn stands(document: &Document, index: usize, parents: &HashMap<usize, usize>) -> Option<DAffine3> {
    let mut world = DAffine3::IDENTITY;
    let mut at = Some(index);
    // A circle of parents is no longer than there are any.
    for _ in 0..=parents.len() + 1 {
        let Some(index) = at else {
            return Some(world);
        };
        let node = document.node(index)?;
        world = local_transform(&node, "", &mut Diagnostics::default()) * world;
        at = parents.get(&index).copied();
    }
    None
}

/// Reads the meshes, several at a time; the order is the file's.
pub(super) fn load_meshes(
    document: &Document,
    shapes: &BTreeMap<Shaped, Pose>,
    materials: &HashMap<MaterialKey, PrimitiveMaterial>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Vec<(Shaped, Vec<Loaded>)>, ImportError> {
    let loaded: Vec<Result<_, ImportError>> = shapes
        .par_iter()
        .map(|(&shape, pose)| {
            let mut messages = Diagnostics::default();
            let meshes = load_mesh(document, shape.mesh, pose, materials, budget, &mut messages)?;
            Ok((shape, meshes, messages))
        })
        .collect();
    let mut meshes = Vec::with_capacity(loaded.len());
    let mut dropped = Dropped::default();
    for result in loaded {
        let (shape, primitives, messages) = result?;
        diagnostics.append(messages);
        for primitive in &primitives {
            dropped.add(&primitive.mesh.name, primitive.dropped);
        }
        meshes.push((shape, primitives));
    }
    dropped.report_bad_indices(diagnostics);
    Ok(meshes)
}

fn load_mesh(
    document: &Document,
    index: usize,
    pose: &Pose,
    materials: &HashMap<MaterialKey, PrimitiveMaterial>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Vec<Loaded>, ImportError> {
    let name = mesh_name(document, index);
    let object = format!("mesh \"{name}\"");
    let broken = |problem: String| ImportError::malformed(&document.file, &object, problem);
    let Some(mesh) = document.core.meshes.get(index) else {
        return Err(broken("a node uses it, but it does not exist".into()));
    };
    extensions::report_others(
        document,
        &format!("/meshes/{index}"),
        &object,
        &[],
        diagnostics,
    );
    let mut result = Vec::with_capacity(mesh.primitives.len());
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let pointer = format!("/meshes/{index}/primitives/{number}");
        extensions::report_others(
            document,
            &pointer,
            &object,
            &[
                "KHR_draco_mesh_compression",
                "KHR_materials_variants",
                "SUNDOG_mesh",
            ],
            diagnostics,
        );
        let (mut motion, mut grids, mut strands) = (Vec::new(), None, None);
        let mut absent_uvs = Vec::new();
        let (texture_space, generated, vertices) = match document.extension(&pointer, "SUNDOG_mesh")
        {
            None => (None, None, None),
            Some(extension) => {
                let extension = SundogMesh::deserialize(extension)
                    .map_err(|e| broken(format!("its SUNDOG_mesh cannot be read: {e}")))?;
                let unknown = &extension.unknown;
                extensions::report_properties("SUNDOG_mesh", unknown, &object, diagnostics);
                let named = |name: &Option<String>| {
                    let place = format!("{pointer}/attributes/{}", name.as_ref()?);
                    usize::try_from(document.value.pointer(&place)?.as_u64()?).ok()
                };
                let vertices = named(&extension.vertices).zip(u32::try_from(index).ok());
                let vertices = vertices.map(|(numbers, whole)| VerticesSource {
                    numbers,
                    normals: named(&extension.vertex_normals),
                    whole,
                });
                let told = (&*extension.grids, extension.density_by_object);
                absent_uvs = extension.absent_uvs;
                grids = grids::load(document, told, &object, budget, diagnostics)?;
                if let Some(json) = &extension.strands {
                    let radius = named(&Some(json.radius.clone()));
                    let radius =
                        radius.ok_or_else(|| broken("its strands have no radius".into()))?;
                    strands = Some(StrandsSource::new(json, radius));
                }
                for step in extension.motion {
                    let position = named(&Some(step.position));
                    let position = position
                        .ok_or_else(|| broken("a step of its motion has no positions".into()))?;
                    motion.push((position, named(&step.normal)));
                }
                (
                    extension.texture_space,
                    named(&extension.generated),
                    vertices,
                )
            }
        };
        let stream = document.extension(&pointer, "KHR_draco_mesh_compression");
        let decoded = match stream.map(|s| draco::decode(document, s, primitive, budget)) {
            Some(Ok(decoded)) => Some(decoded),
            Some(Err(problem)) if has_plain_copy(document, primitive) => {
                diagnostics.report(
                    "compression-fallback",
                    Verdict::Exact,
                    format!("mesh of which {problem}"),
                    &object,
                    "the file's uncompressed copy of it is used",
                );
                None
            }
            Some(Err(problem)) => return Err(broken(problem)),
            None => None,
        };
        let own = (0..mesh::MOST_ATTRIBUTES).map_while(|number| {
            let place = format!("{pointer}/attributes/_SUNDOG_{number}");
            let index = document.value.pointer(&place)?.as_u64()?;
            usize::try_from(index).ok()
        });
        let own = own.collect();
        let attributes = Attributes {
            primitive,
            decoded,
            own,
            texture_space,
            generated,
            vertices,
            motion,
            grids,
            strands,
        };
        let material = key(document, &pointer, primitive);
        let none = PrimitiveMaterial {
            id: None,
            tangents: None,
            radial: false,
            uv_set: None,
            attributes: 0,
            asks_before: false,
            brightest: Some([1.0; 3]),
        };
        let mut material = materials.get(&material).copied().unwrap_or(none);
        // Of a map that is not there there are no tangents.
        material.tangents = material
            .tangents
            .filter(|(set, _)| !absent_uvs.contains(set));
        let loaded = mesh::load_primitive(
            document,
            &name,
            &attributes,
            material,
            pose,
            budget,
            diagnostics,
        );
        result.extend(loaded.map_err(broken)?);
    }
    Ok(result)
}

/// Whether a Draco primitive also has its data uncompressed.
fn has_plain_copy(document: &Document, primitive: &::gltf::json::mesh::Primitive) -> bool {
    let positions =
        ::gltf::json::validation::Checked::Valid(::gltf::json::mesh::Semantic::Positions);
    let accessor = primitive
        .attributes
        .get(&positions)
        .and_then(|i| document.core.accessors.get(i.value()));
    accessor.is_some_and(|a| a.buffer_view.is_some() || a.sparse.is_some())
}

#[cfg(test)]
#[path = "../../../tests/unit/import/gltf/shapes.rs"]
mod tests;
