//! The walk over a scene's nodes: what they place, and where.

use std::collections::HashMap;

use glam::{DAffine3, DQuat, DVec3};

use super::container::Document;
use super::lights::{OpenUnits, PORTAL};
use super::placement::{local_transform, matrix, report_rotation, rotation};
use super::schema::{self, InstancingJson, NodeJson};
use super::{accessor, camera, cube_light, extensions, ies_lights, lights};
use crate::import::budget::Budget;
use crate::import::{ImportError, ImportOptions};
use crate::scene::{Camera, Diagnostics, Instance, Light, ObjectInfo, Portal, Verdict, Visibility};

/// A mesh in one shape: meshes with a skin or with weights of their node's own cannot be shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Shaped {
    pub(super) mesh: usize,
    pub(super) by_node: Option<usize>,
}

/// A mesh that a node of the scene places.
pub(super) struct Placed {
    pub(super) name: String,
    pub(super) mesh: Shaped,
    pub(super) world_from_object: DAffine3,
    pub(super) motion: Vec<DAffine3>,
    pub(super) visibility: Visibility,
    pub(super) holdout: bool,
    pub(super) info: ObjectInfo,
}

/// Nodes with one parent that are still to be visited.
struct Siblings {
    nodes: std::vec::IntoIter<usize>,
    parent: DAffine3,
    hidden: bool,
}

/// The walk over the nodes of the scene.
pub(super) struct Walk<'a> {
    pub(super) document: &'a Document,
    pub(super) options: &'a ImportOptions,
    pub(super) budget: &'a Budget,
    pub(super) diagnostics: &'a mut Diagnostics,
    /// The nodes that were reached.
    pub(super) reached: Vec<bool>,
    /// The nodes that some skin hangs on.
    pub(super) joints: std::collections::HashSet<usize>,
    /// Where these stand, if they were reached.
    pub(super) worlds: HashMap<usize, DAffine3>,
    pub(super) placed: Vec<Placed>,
    pub(super) lights: Vec<Light>,
    pub(super) portals: Vec<Portal>,
    pub(super) open_units: Vec<OpenUnits>,
    /// Node trees of lights, by the lights' numbers.
    pub(super) light_graphs: Vec<(usize, serde_json::Value)>,
    pub(super) cameras: Vec<Camera>,
    /// Number of the scene that is walked.
    pub(super) scene: Option<usize>,
}

impl Walk<'_> {
    pub(super) fn run(&mut self) -> Result<(), ImportError> {
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
                    &["SUNDOG_scene", cube_light::NAME],
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
                ies_lights::NAME,
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
            let info = node.extensions.object.as_ref().map(|object| object.info());
            let motion = self.motion(node, name);
            let by_node = (node.skin.is_some() || node.weights.is_some()).then_some(index);
            for copy in copies {
                let mesh = Shaped { mesh, by_node };
                self.placed.push(Placed {
                    name: name.into(),
                    mesh,
                    world_from_object: world * copy,
                    motion: motion.clone(),
                    visibility,
                    holdout,
                    info: info.clone().unwrap_or_default(),
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
            let source = document.graph.lights.get(reference.light).ok_or_else(|| {
                self.malformed(
                    format!("node \"{name}\""),
                    format!("it uses light {}, which does not exist", reference.light),
                )
            })?;
            extensions::report_others(
                document,
                &format!("/extensions/KHR_lights_punctual/lights/{}", reference.light),
                &format!("light \"{}\"", source.name.as_deref().unwrap_or(name)),
                &["SUNDOG_light"],
                self.diagnostics,
            );
            let open = OpenUnits::of(self.lights.len(), source, self.options);
            let light = lights::load_light(
                document,
                source,
                name.into(),
                world,
                self.options,
                self.diagnostics,
            );
            self.open_units.extend(light.as_ref().and(open));
            if let (Some(sundog), Some(_)) = (&source.extensions.sundog, &light) {
                let graph = sundog.shader_graph.as_ref();
                let number = self.lights.len();
                self.light_graphs
                    .extend(graph.map(|graph| (number, graph.clone())));
            }
            self.lights.extend(light);
        }
        if let Some(json) = &node.extensions.ies {
            let place = (name, world);
            let lamp = ies_lights::load(document, json, place, self.diagnostics)?;
            self.lights.extend(lamp);
        }
        if let Some(area) = &node.extensions.area
            && area.kind.as_deref() == Some(PORTAL)
        {
            let portal = lights::load_portal(area, name, world, self.diagnostics);
            self.portals.extend(portal);
        } else if let Some(area) = &node.extensions.area {
            let light = lights::load_area(area, name, world, self.diagnostics);
            if let (Some(graph), Some(_)) = (&area.shader_graph, &light) {
                self.light_graphs.push((self.lights.len(), graph.clone()));
            }
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

    /// Where an object is at steps of time. Copies have no motions of their own.
    fn motion(&mut self, node: &NodeJson, name: &str) -> Vec<DAffine3> {
        let object = node.extensions.object.as_ref();
        let alone = object.filter(|_| node.extensions.instancing.is_none());
        let steps = alone.into_iter().flat_map(|object| &object.motion);
        steps.map(|m| matrix(m, name, self.diagnostics)).collect()
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
