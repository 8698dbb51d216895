//! glTF 2.0 (`.glb`, `.gltf`).

mod accessor;
mod camera;
mod container;
mod deform;
mod draco;
mod extensions;
mod lights;
mod material;
mod mesh;
mod meshopt;
mod named;
mod scene_extension;
mod schema;
mod tangents;
mod textures;
mod world;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use glam::{DAffine3, DMat4, DQuat, DVec3};
use rayon::prelude::*;
use serde_json::Value;

use self::container::Document;
use self::deform::Pose;
use self::lights::OpenUnits;
use self::mesh::{Attributes, PrimitiveMaterial};
use self::schema::{InstancingJson, NodeJson};
use self::textures::Images;
use super::budget::Budget;
use super::{ImportError, ImportOptions, Imported};
use crate::scene::validate::Dropped;
use crate::scene::{
    Camera, Diagnostics, Effect, Instance, Light, MaterialId, Mesh, MeshId, Scene, Subject,
    Verdict, Visibility,
};

pub(super) use self::named::named_files;

/// More placed copies than this would be an accident: each takes memory in the renderer.
const MOST_INSTANCES: usize = 1 << 26;

/// Reads a file; the result has not been through [`crate::scene::validate::clean`] yet.
pub(super) fn load(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let document = Document::open(path, options.allow_outside)?;
    extensions::check_required(&document)?;
    let mut diagnostics = Diagnostics::default();

    let mut walk = Walk {
        document: &document,
        options,
        budget: &document.budget,
        diagnostics: &mut diagnostics,
        reached: vec![false; document.nodes],
        joints: document.joints(),
        worlds: HashMap::new(),
        placed: Vec::new(),
        lights: Vec::new(),
        open_units: Vec::new(),
        cameras: Vec::new(),
        scene: None,
    };
    walk.run()?;
    let Walk {
        worlds,
        scene: scene_index,
        mut placed,
        lights,
        open_units,
        cameras,
        ..
    } = walk;

    report_whole_file(&document, &mut diagnostics);
    let shapes: BTreeSet<Shaped> = placed.iter().map(|p| p.mesh).collect();
    let used_meshes: BTreeSet<usize> = shapes.iter().map(|s| s.mesh).collect();
    let poses = poses(
        &document,
        &shapes,
        &mut placed,
        &worlds,
        &document.budget,
        &mut diagnostics,
    )?;
    let mut materials = Materials::load(&document, &used_meshes, options, &mut diagnostics)?;
    let images = materials
        .images
        .decode(&mut materials.list, &mut diagnostics);

    let meshes = load_meshes(
        &document,
        &poses,
        &materials.by_primitive,
        &document.budget,
        &mut diagnostics,
    )?;
    let mut scene = Scene {
        generator: document.core.asset.generator.clone(),
        materials: materials.list,
        images,
        lights,
        cameras,
        ..Scene::default()
    };
    let mut ids: HashMap<Shaped, Vec<MeshId>> = HashMap::new();
    for (index, primitives) in meshes {
        let list = ids.entry(index).or_default();
        for mesh in primitives {
            list.push(MeshId(
                u32::try_from(scene.meshes.len()).unwrap_or(u32::MAX),
            ));
            scene.meshes.push(mesh);
        }
    }
    for place in placed {
        for &mesh in ids.get(&place.mesh).into_iter().flatten() {
            if scene.instances.len() >= MOST_INSTANCES {
                return Err(ImportError::malformed(
                    &document.file,
                    "scene",
                    format!("it places more than {MOST_INSTANCES} meshes"),
                ));
            }
            scene.instances.push(Instance {
                name: place.name.clone(),
                mesh,
                world_from_object: place.world_from_object,
                visibility: place.visibility,
                holdout: place.holdout,
            });
        }
    }
    lights::choose_units(&open_units, &mut scene, &mut diagnostics);
    let extension = scene_index.and_then(|i| document.graph.scenes[i].extensions.sundog.as_ref());
    if let Some(extension) = extension {
        let place = (path, options.allow_outside);
        scene_extension::apply(extension, place, &mut scene, &mut diagnostics);
    }
    if let Some(world) = extension.and_then(|s| s.world.as_ref())
        && !options.without_world
    {
        world::load(&document, world, &mut scene, &mut diagnostics)?;
    }
    Ok(Imported { scene, diagnostics })
}

/// A mesh in one shape: meshes with a skin or with weights of their node's own cannot be shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Shaped {
    mesh: usize,
    by_node: Option<usize>,
}

/// A mesh that a node of the scene places.
struct Placed {
    name: String,
    mesh: Shaped,
    world_from_object: DAffine3,
    visibility: Visibility,
    holdout: bool,
}

/// Nodes with one parent that are still to be visited.
struct Siblings {
    nodes: std::vec::IntoIter<usize>,
    parent: DAffine3,
    hidden: bool,
}

/// The walk over the nodes of the scene.
struct Walk<'a> {
    document: &'a Document,
    options: &'a ImportOptions,
    budget: &'a Budget,
    diagnostics: &'a mut Diagnostics,
    /// The nodes that were reached.
    reached: Vec<bool>,
    /// The nodes that some skin hangs on.
    joints: std::collections::HashSet<usize>,
    /// Where these stand, if they were reached.
    worlds: HashMap<usize, DAffine3>,
    placed: Vec<Placed>,
    lights: Vec<Light>,
    open_units: Vec<OpenUnits>,
    cameras: Vec<Camera>,
    /// Number of the scene that is walked.
    scene: Option<usize>,
}

impl Walk<'_> {
    fn run(&mut self) -> Result<(), ImportError> {
        // Siblings that are still to be visited, of each generation; not a place for each of them, as there may be millions.
        let mut stack = vec![Siblings {
            nodes: self.roots()?.into_iter(),
            parent: DAffine3::IDENTITY,
            hidden: false,
        }];
        while let Some(siblings) = stack.last_mut() {
            let Some(index) = siblings.nodes.next() else {
                stack.pop();
                continue;
            };
            let (parent, hidden) = (siblings.parent, siblings.hidden);
            let Some(node) = self.document.node(index) else {
                return Err(self.malformed(
                    "scene",
                    format!("it uses node {index}, which does not exist"),
                ));
            };
            let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
            // The format demands a forest; anything else would be walked forever, or for very long.
            if std::mem::replace(&mut self.reached[index], true) {
                return Err(self.malformed(
                    format!("node \"{name}\""),
                    "it has two parents or is its own ancestor",
                ));
            }
            let world = parent * local_transform(&node, &name, self.diagnostics);
            if self.joints.contains(&index) {
                self.worlds.insert(index, world);
            }
            // Hidden nodes are walked too, as joints of skins may be among them.
            let hidden = hidden
                || node
                    .extensions
                    .visibility
                    .as_ref()
                    .is_some_and(|v| !v.visible);
            if !hidden {
                self.visit(index, &node, &name, world)?;
            }
            // The last of its siblings needs no place any more: a chain takes no more memory than its end.
            if stack.last().is_some_and(|s| s.nodes.len() == 0) {
                stack.pop();
            }
            if !node.children.is_empty() {
                stack.push(Siblings {
                    nodes: node.children.into_iter(),
                    parent: world,
                    hidden,
                });
            }
        }
        Ok(())
    }

    fn malformed(&self, object: impl Into<String>, problem: impl Into<String>) -> ImportError {
        ImportError::malformed(&self.document.file, object, problem)
    }

    /// The root nodes of the scene that was asked for.
    fn roots(&mut self) -> Result<Vec<usize>, ImportError> {
        let graph = &self.document.graph;
        let index = match &self.options.scene {
            Some(wanted) => {
                let by_name = graph
                    .scenes
                    .iter()
                    .position(|s| s.name.as_deref() == Some(wanted));
                let found = by_name.or_else(|| {
                    wanted
                        .parse()
                        .ok()
                        .filter(|&i: &usize| i < graph.scenes.len())
                });
                found.ok_or_else(|| {
                    let name = |(i, s): (usize, &schema::SceneJson)| {
                        s.name.clone().unwrap_or_else(|| i.to_string())
                    };
                    let there: Vec<String> = graph.scenes.iter().enumerate().map(name).collect();
                    self.malformed(
                        format!("scene \"{wanted}\""),
                        format!("there is no such scene; there are: {}", there.join(", ")),
                    )
                })?
            }
            None => graph.scene.unwrap_or(0),
        };
        match graph.scenes.get(index) {
            Some(scene) => {
                self.scene = Some(index);
                extensions::report_others(
                    self.document,
                    &format!("/scenes/{index}"),
                    scene.name.as_deref().unwrap_or("scene"),
                    &["SUNDOG_scene"],
                    self.diagnostics,
                );
                Ok(scene.nodes.clone())
            }
            None if graph.scene.is_some() => {
                Err(self.malformed("scene", format!("the default scene {index} does not exist")))
            }
            // A file without scenes is a library of parts; everything that has no parent is shown.
            None => {
                let count = self.document.nodes;
                let mut is_child = vec![false; count];
                for node in (0..count).filter_map(|i| self.document.node(i)) {
                    for child in node.children {
                        if let Some(flag) = is_child.get_mut(child) {
                            *flag = true;
                        }
                    }
                }
                if count > 0 {
                    self.diagnostics.report(
                        "no-scene",
                        Verdict::Exact,
                        "file without a scene",
                        &self.document.file,
                        "all its nodes are rendered",
                    );
                }
                Ok((0..count).filter(|&i| !is_child[i]).collect())
            }
        }
    }

    fn visit(
        &mut self,
        index: usize,
        node: &NodeJson,
        name: &str,
        world: DAffine3,
    ) -> Result<(), ImportError> {
        let document = self.document;
        extensions::report_others(
            document,
            &format!("/nodes/{index}"),
            &format!("node \"{name}\""),
            &[
                "KHR_lights_punctual",
                "EXT_mesh_gpu_instancing",
                "KHR_node_visibility",
                "SUNDOG_light",
                "SUNDOG_object",
            ],
            self.diagnostics,
        );
        if let Some(mesh) = node.mesh {
            let copies = match &node.extensions.instancing {
                Some(instancing) => self.copies(instancing, name)?,
                None => vec![DAffine3::IDENTITY],
            };
            let (visibility, holdout) = self.object(node, name);
            let by_node = (node.skin.is_some() || node.weights.is_some()).then_some(index);
            for copy in copies {
                let mesh = Shaped { mesh, by_node };
                self.placed.push(Placed {
                    name: name.into(),
                    mesh,
                    world_from_object: world * copy,
                    visibility,
                    holdout,
                });
            }
            if node.skin.is_some() {
                self.diagnostics.report(
                    "skin",
                    Verdict::Exact,
                    "skinned mesh",
                    name,
                    "posed as its joints stand in the file",
                );
            }
        }
        if let Some(reference) = &node.extensions.light {
            let light = document.graph.lights.get(reference.light).ok_or_else(|| {
                self.malformed(
                    format!("node \"{name}\""),
                    format!("it uses light {}, which does not exist", reference.light),
                )
            })?;
            extensions::report_others(
                document,
                &format!("/extensions/KHR_lights_punctual/lights/{}", reference.light),
                &format!("light \"{}\"", light.name.as_deref().unwrap_or(name)),
                &["SUNDOG_light"],
                self.diagnostics,
            );
            let open = OpenUnits::of(self.lights.len(), light, self.options);
            let light = lights::load_light(
                document,
                light,
                name.into(),
                world,
                self.options,
                self.diagnostics,
            );
            self.open_units.extend(light.as_ref().and(open));
            self.lights.extend(light);
        }
        if let Some(area) = &node.extensions.area {
            let light = lights::load_area(area, name, world, self.diagnostics);
            self.lights.extend(light);
        }
        if let Some(camera) = node.camera {
            let source = document.graph.cameras.get(camera).ok_or_else(|| {
                self.malformed(
                    format!("node \"{name}\""),
                    format!("it uses camera {camera}, which does not exist"),
                )
            })?;
            extensions::report_others(
                document,
                &format!("/cameras/{camera}"),
                &format!("camera \"{}\"", source.name.as_deref().unwrap_or(name)),
                &["SUNDOG_camera"],
                self.diagnostics,
            );
            let camera = camera::load_camera(source, node, name, world, self.diagnostics);
            let camera = camera.ok_or_else(|| {
                self.malformed(
                    format!("camera \"{name}\""),
                    "it is neither perspective nor orthographic",
                )
            })?;
            self.cameras.push(camera);
        }
        Ok(())
    }

    /// Ray visibility and holdout of a node with a mesh.
    fn object(&mut self, node: &NodeJson, name: &str) -> (Visibility, bool) {
        let Some(object) = &node.extensions.object else {
            return (Visibility::ALL, false);
        };
        for property in object.unknown.keys() {
            extensions::report_property(self.diagnostics, "SUNDOG_object", property, name);
        }
        if object.shadow_catcher {
            self.diagnostics.report_effect(
                Effect::ShadowCatcher,
                "shadow-catcher",
                Verdict::Lost,
                "shadow catchers",
                Subject::Object(name.into()),
                "rendered as any object",
            );
        }
        let visibility = object.visibility.visibility(|kind| {
            extensions::report_property(
                self.diagnostics,
                "SUNDOG_object",
                &format!("visibility.{kind}"),
                name,
            );
        });
        (visibility, object.holdout)
    }

    /// The placements of EXT_mesh_gpu_instancing.
    fn copies(
        &mut self,
        instancing: &InstancingJson,
        name: &str,
    ) -> Result<Vec<DAffine3>, ImportError> {
        let attributes = &instancing.attributes;
        let document = self.document;
        let broken = |problem: String| {
            ImportError::malformed(
                &document.file,
                format!("instances of node \"{name}\""),
                problem,
            )
        };
        let mut count = None;
        let mut same = |length: usize| match *count.get_or_insert(length) {
            first if first == length => Ok(()),
            first => Err(broken(format!(
                "its attributes have {first} and {length} elements"
            ))),
        };
        let translations = match attributes.translation {
            Some(index) => accessor::read::<3>(document, index, self.budget).map_err(broken)?,
            None => Vec::new(),
        };
        let rotations = match attributes.rotation {
            Some(index) => accessor::read::<4>(document, index, self.budget).map_err(broken)?,
            None => Vec::new(),
        };
        let scales = match attributes.scale {
            Some(index) => accessor::read::<3>(document, index, self.budget).map_err(broken)?,
            None => Vec::new(),
        };
        if attributes.translation.is_some() {
            same(translations.len())?;
        }
        if attributes.rotation.is_some() {
            same(rotations.len())?;
        }
        if attributes.scale.is_some() {
            same(scales.len())?;
        }
        let count = count.unwrap_or(1);
        self.budget
            .take(
                count as u64,
                size_of::<Placed>() + size_of::<Instance>() + name.len() * 2,
            )
            .map_err(broken)?;
        let turns: Vec<_> = rotations.into_iter().map(rotation).collect();
        if turns.iter().any(|(_, unit)| !unit) {
            report_rotation(name, self.diagnostics);
        }
        Ok((0..count)
            .map(|i| {
                DAffine3::from_scale_rotation_translation(
                    scales.get(i).map_or(DVec3::ONE, |&s| DVec3::from(s)),
                    turns.get(i).map_or(DQuat::IDENTITY, |&(turn, _)| turn),
                    translations.get(i).map_or(DVec3::ZERO, |&t| DVec3::from(t)),
                )
            })
            .collect())
    }
}

/// A unit quaternion from glTF's (x, y, z, w); the identity if it has no direction. Says whether it had the length 1.
fn rotation(xyzw: [f64; 4]) -> (DQuat, bool) {
    let length = DQuat::from_array(xyzw).length();
    // Stored in 8 bits each of the four is off by up to half of 1/127, and the length by √4 of that.
    let unit = (length - 1.0).abs() <= 1.0 / 127.0;
    // Not-a-numbers pass, so that `scene::validate` finds them.
    if length == 0.0 {
        (DQuat::IDENTITY, unit)
    } else {
        (DQuat::from_array(xyzw.map(|c| c / length)), unit)
    }
}

fn report_rotation(name: &str, diagnostics: &mut Diagnostics) {
    diagnostics.report(
        "rotation-length",
        Verdict::Approximated,
        "rotation by a quaternion that is not of length 1",
        name,
        "made that long; one of length 0 does not turn",
    );
}

fn local_transform(node: &NodeJson, name: &str, diagnostics: &mut Diagnostics) -> DAffine3 {
    match &node.matrix {
        Some(columns) => matrix(columns, name, diagnostics),
        None => DAffine3::from_scale_rotation_translation(
            node.scale.map_or(DVec3::ONE, DVec3::from),
            node.rotation.map_or(DQuat::IDENTITY, |xyzw| {
                let (rotation, unit) = rotation(xyzw);
                if !unit {
                    report_rotation(name, diagnostics);
                }
                rotation
            }),
            node.translation.map_or(DVec3::ZERO, DVec3::from),
        ),
    }
}

/// The affine part of a matrix by columns.
fn matrix(columns: &[f64; 16], name: &str, diagnostics: &mut Diagnostics) -> DAffine3 {
    let last = [columns[3], columns[7], columns[11], columns[15] - 1.0];
    // What products in f32 leave of zeros and a one.
    if last
        .iter()
        .any(|c| c.abs() > 16.0 * f64::from(f32::EPSILON))
    {
        diagnostics.report(
            "matrix-row",
            Verdict::Approximated,
            "matrix whose last row is not 0, 0, 0, 1",
            name,
            "the row is taken as that: glTF places objects without perspective",
        );
    }
    DAffine3::from_mat4(DMat4::from_cols_array(columns))
}

/// The materials that the scene's meshes use, in file order, and the images that these use.
struct Materials<'a> {
    list: Vec<crate::scene::Material>,
    /// By glTF material index (or none).
    by_primitive: HashMap<Option<usize>, PrimitiveMaterial>,
    images: Images<'a>,
}

impl<'a> Materials<'a> {
    fn load(
        document: &'a Document,
        used_meshes: &BTreeSet<usize>,
        options: &ImportOptions,
        diagnostics: &mut Diagnostics,
    ) -> Result<Self, ImportError> {
        let mut used: BTreeSet<Option<usize>> = BTreeSet::new();
        let mut bare: Option<String> = None;
        for &index in used_meshes {
            let Some(mesh) = document.core.meshes.get(index) else {
                continue;
            };
            for primitive in &mesh.primitives {
                used.insert(primitive.material.map(|m| m.value()));
                if primitive.material.is_none() {
                    bare.get_or_insert_with(|| mesh_name(document, index));
                }
            }
        }
        let mut images = Images::new(document);
        let mut list = Vec::new();
        let mut by_primitive = HashMap::new();
        for index in used {
            let material = match index {
                Some(index) => Some(material::load_material(
                    document,
                    index,
                    options,
                    &mut images,
                    diagnostics,
                )?),
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
            let normal_map_uv_set = material
                .as_ref()
                .and_then(|m| m.normal_texture.as_ref())
                .map(|n| n.texture.uv_set);
            let uv_set = material.as_ref().and_then(|m| {
                let textures = [
                    &m.base_color_texture,
                    &m.metallic_roughness_texture,
                    &m.emission_texture,
                    &m.specular_texture,
                    &m.specular_color_texture,
                    &m.transmission_texture,
                ];
                textures.into_iter().flatten().map(|t| t.uv_set).max()
            });
            let brightest = brightest(document, material.as_ref());
            let id = material.map(|material| {
                list.push(material);
                MaterialId((list.len() - 1) as u32)
            });
            by_primitive.insert(
                index,
                PrimitiveMaterial {
                    id,
                    normal_map_uv_set,
                    uv_set,
                    brightest,
                },
            );
        }
        Ok(Self {
            list,
            by_primitive,
            images,
        })
    }
}

/// The vertex colours with which a material's base colour is 1. `None` where they may be brighter: what is unlit shines anyway,
/// and the add-on writes what Cycles shows.
fn brightest(document: &Document, material: Option<&crate::scene::Material>) -> Option<[f32; 3]> {
    let generator = document.core.asset.generator.as_deref();
    if material.is_some_and(|m| m.unlit)
        || generator.is_some_and(|g| g.starts_with("Sundog add-on for Blender"))
    {
        return None;
    }
    let base = material.map_or([1.0; 3], |m| m.base_color);
    Some(base.map(|c| if c < 1.0 { 1.0 / c.max(0.0) } else { 1.0 }))
}

fn mesh_name(document: &Document, index: usize) -> String {
    let name = document.core.meshes.get(index).and_then(|m| m.name.clone());
    name.unwrap_or_else(|| format!("mesh {index}"))
}

/// The pose of each shape. Skinned meshes are placed anew: only their joints say where they are.
fn poses(
    document: &Document,
    shapes: &BTreeSet<Shaped>,
    placed: &mut [Placed],
    worlds: &HashMap<usize, DAffine3>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<BTreeMap<Shaped, Pose>, ImportError> {
    let mut poses = BTreeMap::new();
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
                let world = |joint: usize| worlds.get(&joint).copied();
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

/// Reads the meshes, several at a time; the order is the file's.
fn load_meshes(
    document: &Document,
    shapes: &BTreeMap<Shaped, Pose>,
    materials: &HashMap<Option<usize>, PrimitiveMaterial>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Vec<(Shaped, Vec<Mesh>)>, ImportError> {
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
        for (mesh, triangles) in &primitives {
            dropped.add(&mesh.name, *triangles);
        }
        meshes.push((
            shape,
            primitives.into_iter().map(|(mesh, _)| mesh).collect(),
        ));
    }
    dropped.report_bad_indices(diagnostics);
    Ok(meshes)
}

fn load_mesh(
    document: &Document,
    index: usize,
    pose: &Pose,
    materials: &HashMap<Option<usize>, PrimitiveMaterial>,
    budget: &Budget,
    diagnostics: &mut Diagnostics,
) -> Result<Vec<(Mesh, usize)>, ImportError> {
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
            &["KHR_draco_mesh_compression"],
            diagnostics,
        );
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
        let attributes = Attributes { primitive, decoded };
        let material = primitive.material.map(|m| m.value());
        let none = PrimitiveMaterial {
            id: None,
            normal_map_uv_set: None,
            uv_set: None,
            brightest: Some([1.0; 3]),
        };
        let material = materials.get(&material).copied().unwrap_or(none);
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

/// What concerns the file as a whole.
fn report_whole_file(document: &Document, diagnostics: &mut Diagnostics) {
    extensions::report_others(
        document,
        "",
        "the file",
        &["KHR_lights_punctual"],
        diagnostics,
    );
    if let Some(Value::Array(animations)) = document.value.get("animations") {
        for (index, animation) in animations.iter().enumerate() {
            let name = animation
                .get("name")
                .and_then(Value::as_str)
                .map(str::to_owned);
            diagnostics.report_effect(
                Effect::MotionBlur,
                "animation",
                Verdict::Lost,
                "animations",
                name.unwrap_or_else(|| format!("animation {index}")),
                "the scene stands still, as its nodes are placed in the file",
            );
        }
    }
}
