//! The materials that a stage's meshes show.

use std::collections::{BTreeSet, HashMap, HashSet};

use openusd::sdf::Path;

use super::network::Network;
use super::source::{Source, View};
use super::textures::Images;
use super::{materialx_surfaces, preview};
use crate::import::ImportOptions;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::{emission, principled};
use crate::scene::graph::{Graph, Input, Node, NodeKind};
use crate::scene::{Diagnostics, Material, MaterialLabel, Verdict};

/// An image with tiles: the set of coordinates that it lies by, and the tiles that it has.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    pub set: u32,
    pub numbers: Vec<u32>,
    /// How the file calls it.
    pub called: String,
}

/// What a material wants of the meshes that have it.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    /// Texture coordinates, by their primvars' names.
    pub uvs: Vec<String>,
    /// What stands for those that a mesh does not have, where the material says so.
    pub uv_fallbacks: HashMap<String, [f32; 2]>,
    /// Images with tiles that lie by coordinates as they are.
    pub tiles: Vec<Tiles>,
    /// Other primvars.
    pub attributes: Vec<String>,
    /// What stands for those that a mesh does not have.
    pub fallbacks: Vec<[f32; 4]>,
    /// The display colour.
    pub colors: bool,
    /// The set of texture coordinates that tangents follow.
    pub tangents: Option<usize>,
}

/// Where the display colour of a prim stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Colored {
    /// Nowhere.
    Plain,
    /// On its mesh.
    Vertex,
    /// On each instance of it.
    Object,
}

/// Materials and what they want.
pub(super) struct Materials<'a> {
    source: &'a Source,
    pub list: Vec<Material>,
    needs: Vec<Needs>,
    labels: Vec<MaterialLabel>,
    /// By their paths; of what has none, by where it has colours.
    known: HashMap<Result<String, Colored>, usize>,
    /// Those without a known surface.
    without: HashSet<Path>,
    pub images: Images,
}

impl<'a> Materials<'a> {
    pub(super) fn new(source: &'a Source, options: &ImportOptions) -> Self {
        Self {
            source,
            list: Vec::new(),
            needs: Vec::new(),
            labels: Vec::new(),
            known: HashMap::new(),
            without: HashSet::new(),
            images: Images::new(options.image_bytes),
        }
    }

    /// The number of the first material of some paths that has a known surface, or of that for what has none.
    pub(super) fn of(
        &mut self,
        paths: &[Path],
        has_colors: Colored,
        diagnostics: &mut Diagnostics,
    ) -> usize {
        let mut told = Diagnostics::default();
        for path in paths {
            let key = Ok(path.to_string());
            if let Some(known) = self.known.get(&key) {
                return *known;
            }
            // What has none is told once.
            if self.without.contains(path) {
                continue;
            }
            let mut own = Diagnostics::default();
            if let Some((material, needs)) = self.load(path, &mut own) {
                diagnostics.append(own);
                let name = material.name.as_str().into();
                let label = MaterialLabel {
                    name: Some(name),
                    index: 0.0,
                };
                return self.add(key, material, needs, label);
            }
            self.without.insert(path.clone());
            told.append(own);
        }
        diagnostics.append(told);
        let key = Err(has_colors);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let (material, needs) = self.bare(has_colors);
        self.add(key, material, needs, MaterialLabel::default())
    }

    fn add(
        &mut self,
        key: Result<String, Colored>,
        material: Material,
        needs: Needs,
        label: MaterialLabel,
    ) -> usize {
        self.list.push(material);
        self.needs.push(needs);
        self.labels.push(label);
        self.known.insert(key, self.list.len() - 1);
        self.list.len() - 1
    }

    /// A material that does nothing but shine with a radiance.
    pub(super) fn shining(&mut self, name: &str, radiance: [f32; 3]) -> usize {
        let mut graph = Graph::default();
        let shining = Node::new(NodeKind::Emission).with(emission::COLOR, radiance);
        graph.surface = Some(graph.add(shining));
        let material = Material {
            name: name.into(),
            graph,
            double_sided: false,
            medium: None,
            priority: None,
        };
        let key = Ok(format!("light {}", self.list.len()));
        self.add(key, material, Needs::default(), MaterialLabel::default())
    }

    /// The material of volumes.
    pub(super) fn filling(&mut self) -> usize {
        let key = Ok("volume".into());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let material = super::volumes::filling();
        self.add(key, material, Needs::default(), MaterialLabel::default())
    }

    /// Whether a material shows the colours of objects.
    pub(super) fn is_of_objects(&self, material: usize) -> bool {
        self.known.get(&Err(Colored::Object)) == Some(&material)
    }

    pub(super) fn needs(&self, material: usize) -> &Needs {
        &self.needs[material]
    }

    pub(super) fn label(&self, material: usize) -> MaterialLabel {
        self.labels[material].clone()
    }

    /// Names of all primvars that a material asks for.
    pub(super) fn primvars(&self, material: usize) -> BTreeSet<String> {
        let needs = &self.needs[material];
        let mut names: BTreeSet<String> =
            needs.uvs.iter().chain(&needs.attributes).cloned().collect();
        if needs.colors {
            names.extend(["displayColor".into(), "displayOpacity".into()]);
        }
        names
    }

    /// Whether a primvar is asked for as texture coordinates, and nothing stands for it.
    pub(super) fn is_open_uv(&self, materials: &[usize], name: &str) -> bool {
        let mut needs = materials.iter().map(|m| &self.needs[*m]);
        needs.any(|needs| {
            needs.uvs.iter().any(|uv| uv == name) && !needs.uv_fallbacks.contains_key(name)
        })
    }

    /// What is shown where no material is bound: the display colour, or grey.
    fn bare(&self, has_colors: Colored) -> (Material, Needs) {
        let version = super::blender_version(self.source);
        let mut network = Network::bare();
        let color = if has_colors == Colored::Vertex {
            Input::Link(network.graph.add(Node::new(NodeKind::ColorAttribute)))
        } else if has_colors == Colored::Object {
            Input::Link(network.place(PlaceInput::ObjectColor))
        } else if version.is_some() {
            Input::float(0.8)
        } else {
            // Hydra's own fallback.
            Input::float(0.5)
        };
        let plain = version.is_some_and(|version| version.major < 5);
        let node = preview::principled()
            .with(principled::BASE_COLOR, color)
            .with(principled::ROUGHNESS, if plain { 1.0 } else { 0.5 })
            .with(
                principled::SPECULAR_IOR_LEVEL,
                if plain { 0.0 } else { 0.5 },
            );
        let shader = network.graph.add(node);
        let alpha = match color {
            Input::Link(_) if has_colors == Colored::Object => {
                Input::Link(network.place(PlaceInput::ObjectAlpha))
            }
            Input::Link(link) => Input::Link(crate::scene::graph::Link { output: 1, ..link }),
            _ => Input::float(1.0),
        };
        network.graph.surface = Some(preview::seen_through(&mut network.graph, shader, alpha));
        let needs = Needs {
            colors: has_colors == Colored::Vertex,
            ..Needs::default()
        };
        let material = Material {
            name: "(no material)".into(),
            graph: network.graph,
            double_sided: true,
            medium: None,
            priority: None,
        };
        (material, needs)
    }

    fn load(&mut self, path: &Path, diagnostics: &mut Diagnostics) -> Option<(Material, Needs)> {
        let prim = self.source.view(path);
        let name = prim.name();
        if prim.kind() != "Material" {
            diagnostics.report(
                "usd-binding",
                Verdict::Lost,
                "bindings to materials that do not exist",
                path.to_string(),
                "rendered as without a material",
            );
            return None;
        }
        let mut reasons = Vec::new();
        for output in ["outputs:mtlx:surface", "outputs:surface"] {
            if !prim.has(output) {
                continue;
            }
            let mut told = Diagnostics::default();
            let mut network = Network::new(self.source, &mut self.images, &mut told, &name);
            let Some((shader, _)) = network.shader(&prim, output) else {
                continue;
            };
            let shader = self.source.view(&shader);
            let surface = materialx_surfaces::any(&mut network, &shader, 0);
            let complete = network.complete;
            let (mut graph, needs) = (network.graph, network.needs);
            // A network that is not known in all its parts is worse than another of the same material.
            if output == "outputs:mtlx:surface" && !complete && prim.has("outputs:surface") {
                reasons.push(told);
                continue;
            }
            let Some(surface) = surface else {
                reasons.push(told);
                continue;
            };
            if !reasons.is_empty() {
                lose(
                    diagnostics,
                    "MaterialX networks with nodes that are not read",
                    &name,
                    "the material's UsdPreviewSurface is rendered instead",
                );
            }
            for told in reasons.drain(..) {
                diagnostics.append(told);
            }
            diagnostics.append(told);
            graph.surface = Some(surface);
            graph.prune();
            if prim.has("outputs:volume") && network_connected(self.source, &prim, "outputs:volume")
            {
                lose(
                    diagnostics,
                    "volumes of materials",
                    &name,
                    "only the surface is rendered",
                );
            }
            if displaces(self.source, &prim, &shader) {
                lose(
                    diagnostics,
                    "displacement of materials",
                    &name,
                    "the surface stays where it is",
                );
            }
            let material = Material {
                name,
                graph,
                double_sided: true,
                medium: None,
                priority: None,
            };
            return Some((material, needs));
        }
        reasons
            .into_iter()
            .for_each(|told| diagnostics.append(told));
        let other = prim.names.iter().find(|n| n.ends_with(":surface"));
        let what = match other {
            Some(name) => format!("materials that no known shader is connected to ({name})"),
            None => "materials without a surface".into(),
        };
        lose(diagnostics, what, &name, "rendered as without a material");
        None
    }
}

/// Whether a material moves its surface: by the surface's own shader, or by one for that alone.
fn displaces(source: &Source, material: &View, surface: &View) -> bool {
    let mut shaders = vec![surface.path().clone()];
    for output in ["outputs:mtlx:displacement", "outputs:displacement"] {
        let connections = material.prim.attribute(output).connections();
        let connections = source
            .told(material.path(), connections)
            .filter(|_| material.has(output));
        let ends = connections.into_iter().flatten();
        shaders.extend(ends.filter_map(|end| Some(end.split_property()?.0)));
    }
    shaders.iter().any(|shader| {
        let shader = source.view(shader);
        let name = "inputs:displacement";
        if !shader.has(name) {
            // What is no shader leads to one.
            return shader.kind() != "Shader";
        }
        network_connected(source, &shader, name)
            || shader
                .value(name)
                .as_ref()
                .and_then(super::value::floats)
                .is_some_and(|(_, numbers)| numbers.iter().any(|v| *v != 0.0))
    })
}

fn network_connected(source: &Source, prim: &View, name: &str) -> bool {
    let connections = prim.prim.attribute(name).connections();
    source
        .told(prim.path(), connections)
        .is_some_and(|c| !c.is_empty())
}

pub(super) fn lose(
    diagnostics: &mut Diagnostics,
    what: impl Into<String>,
    material: &str,
    instead: &str,
) {
    diagnostics.report(
        "usd-material",
        Verdict::Lost,
        what,
        crate::scene::Subject::Material(material.into()),
        instead,
    );
}
