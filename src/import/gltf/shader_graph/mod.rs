//! Blender's node trees as the add-on writes them (`SUNDOG_shader_graph`; docs/gltf-extensions.md).

mod function;
mod json;
mod luminaire;
mod shader;
mod sky;
mod texture;

use super::container::Document;
use super::scene_extension::working_space;
use super::textures::Images;
use crate::import::ImportError;
use crate::nodes::CyclesVersion;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::{PlaceInput, bump};
use crate::scene::graph::{
    AovOutput, Function, Graph, Input, Link, Node, NodeKind, SocketKind, node,
};
use crate::scene::{Aov, Diagnostics, Interpolation, Subject, Verdict};
use json::{AovJson, NodeJson, Reference, ShaderGraphJson, SocketJson};
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};

/// Why a graph is not taken: in words, as the end of a sentence.
struct Refusal(String);

impl Refusal {
    fn of(node: &NodeJson, what: &str) -> Self {
        Self(format!("{} ({what})", node.kind))
    }
}

/// More nodes than this are no material.
const MOST_NODES: usize = 200_000;

/// A graph on its way.
struct Reader<'a, 'i, 'd> {
    source: &'a ShaderGraphJson,
    graph: Graph,
    /// What the outputs in use give.
    made: HashMap<Reference, Input>,
    images: &'a mut Images<'i>,
    diagnostics: &'d mut Diagnostics,
    owner: &'a str,
    /// What the scene's own colour space is called.
    linear_names: [&'a str; 3],
    /// What Cycles it is to be as.
    version: CyclesVersion,
    /// The number of the attribute with the places of vertices before they were displaced, or with their normals, if some node asks.
    before: Option<u32>,
}

/// A graph, and what it needs of meshes.
pub(super) struct Loaded {
    pub graph: Graph,
    /// The set of texture coordinates along which its tangents lie.
    pub tangents: Option<u32>,
    /// It asks for the attribute with the places or normals of vertices before they were displaced, after all others.
    pub asks_before: bool,
    /// Where the camera sees it, the picture is empty.
    pub holdout: bool,
    /// By name, what is told to passes of the scene's own.
    aovs: Vec<(String, Option<Link>)>,
}

/// Reads the graph of a material, if it has one that is evaluated; what is not has a verdict, and the flat material counts.
pub(super) fn load(
    document: &Document,
    (index, name): (usize, &str),
    images: &mut Images,
    version: Option<CyclesVersion>,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Loaded>, ImportError> {
    let pointer = format!("/materials/{index}");
    let Some(value) = document.extension(&pointer, "SUNDOG_shader_graph") else {
        return Ok(None);
    };
    let owner = Owner {
        words: format!("material \"{name}\""),
        subject: Subject::Material(name.to_owned()),
        instead: "the material's flat version is rendered instead",
        version,
    };
    read(document, value, &owner, images, diagnostics)
}

/// Reads the node tree of the world; what is not evaluated has a verdict, and its colour counts.
pub(super) fn load_world(
    document: &Document,
    value: &Value,
    images: &mut Images,
    version: Option<CyclesVersion>,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Graph>, ImportError> {
    let owner = Owner {
        words: "world".to_owned(),
        subject: "the world".into(),
        instead: "its colour is used instead",
        version,
    };
    let loaded = read(document, value, &owner, images, diagnostics)?;
    Ok(loaded.map(|loaded| loaded.graph))
}

/// Reads the node tree of a light; what is not evaluated has a verdict, and the light shines without.
pub(super) fn load_light(
    document: &Document,
    (value, name): (&Value, &str),
    images: &mut Images,
    version: Option<CyclesVersion>,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Graph>, ImportError> {
    let owner = Owner {
        words: format!("light \"{name}\""),
        subject: name.into(),
        instead: "it shines without",
        version,
    };
    let loaded = read(document, value, &owner, images, diagnostics)?;
    Ok(loaded.map(|loaded| loaded.graph))
}

/// Reads the node tree of what fills a mesh or all space; what is not evaluated has a verdict, and is not there.
pub(super) fn load_volume(
    document: &Document,
    (value, material): (&Value, Option<&str>),
    images: &mut Images,
    version: Option<CyclesVersion>,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Graph>, ImportError> {
    let owner = Owner {
        words: material.map_or("world".to_owned(), |name| format!("material \"{name}\"")),
        subject: material.map_or_else(
            || "the world".into(),
            |name| Subject::Material(name.to_owned()),
        ),
        instead: "its volume is left out",
        version,
    };
    let loaded = read(document, value, &owner, images, diagnostics)?;
    let graph = loaded.map(|loaded| loaded.graph);
    Ok(graph.filter(|graph| graph.volume.is_some()))
}

/// What a material or the world tells passes of the scene's own; what is not evaluated has a verdict, and is 0 there.
pub(super) fn load_aovs(
    document: &Document,
    (value, teller): (&Value, Option<&str>),
    known: &[Aov],
    images: &mut Images,
    version: Option<CyclesVersion>,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Loaded>, ImportError> {
    let owner = Owner {
        words: teller.map_or("world".to_owned(), |name| format!("material \"{name}\"")),
        subject: teller.map_or_else(
            || "the world".into(),
            |name| Subject::Material(name.to_owned()),
        ),
        instead: "its AOVs are 0",
        version,
    };
    let loaded = read(document, value, &owner, images, diagnostics)?;
    Ok(loaded.map(|mut loaded| {
        loaded.graph.aovs = std::mem::take(&mut loaded.aovs)
            .into_iter()
            .filter_map(|(name, value)| {
                let at = known.iter().position(|aov| aov.name == name)?;
                Some(AovOutput {
                    first: Aov::floats(&known[..at]) as u32,
                    is_color: known[at].is_color,
                    value,
                })
            })
            .collect();
        loaded.graph.prune();
        loaded
    }))
}

/// Whose graph it is.
struct Owner {
    words: String,
    subject: Subject,
    instead: &'static str,
    /// What Cycles it is to be as, if not that of its Blender.
    version: Option<CyclesVersion>,
}

fn read(
    document: &Document,
    value: &Value,
    owner: &Owner,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Loaded>, ImportError> {
    let source = ShaderGraphJson::deserialize(value).map_err(|problem| {
        let told = format!("its SUNDOG_shader_graph cannot be read: {problem}");
        ImportError::malformed(&document.file, owner.words.clone(), told)
    })?;
    let mut reader = Reader {
        source: &source,
        graph: Graph::default(),
        made: HashMap::new(),
        images,
        diagnostics,
        owner: &owner.words,
        linear_names: [
            working_space(document).name(),
            "scene_linear",
            "Working Space",
        ],
        version: owner.version.unwrap_or_else(|| source.version()),
        before: None,
    };
    match reader.read() {
        Ok(tangents) => {
            let asks_before = reader.before.is_some();
            let holdout = reader.is_holdout();
            let value = |aov: &AovJson| reader.made.get(&aov.value).and_then(|input| input.link());
            let aovs = source.aovs.iter();
            let aovs: Vec<_> = aovs.map(|aov| (aov.name.clone(), value(aov))).collect();
            let mut graph = reader.graph;
            if aovs.is_empty() {
                graph.prune();
            }
            Ok(Some(Loaded {
                graph,
                tangents,
                asks_before,
                holdout,
                aovs,
            }))
        }
        Err(Stop::Broken(error)) => Err(error),
        Err(Stop::Refused(Refusal(what))) => {
            diagnostics.report(
                "shader-graph",
                Verdict::Approximated,
                format!("node tree with {what}"),
                owner.subject.clone(),
                owner.instead,
            );
            Ok(None)
        }
    }
}

/// Why reading ends.
enum Stop {
    /// The file is broken.
    Broken(ImportError),
    /// Something in it is not evaluated.
    Refused(Refusal),
}

impl From<Refusal> for Stop {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl From<ImportError> for Stop {
    fn from(error: ImportError) -> Self {
        Self::Broken(error)
    }
}

impl Reader<'_, '_, '_> {
    /// Reads all that is in use; the set of texture coordinates along which tangents lie.
    fn read(&mut self) -> Result<Option<u32>, Stop> {
        let source = self.source;
        if source.nodes.len() > MOST_NODES {
            return Err(Refusal(format!("{} nodes", source.nodes.len())).into());
        }
        let (used, of_displacement) = self.used();
        // Displacement first: it comes before the surface.
        for (at, &displaces) in of_displacement.iter().enumerate() {
            if displaces {
                self.make_all(at, &used)?;
            }
        }
        self.displaced();
        for (at, &displaces) in of_displacement.iter().enumerate() {
            if !displaces {
                self.make_all(at, &used)?;
            }
        }
        if let Some(surface) = &source.surface {
            self.graph.surface = self.made.get(surface).and_then(|input| input.link());
        }
        if let Some(volume) = &source.volume {
            self.graph.volume = self.made.get(volume).and_then(|input| input.link());
        }
        self.tangents(&used)
    }

    /// Whether the surface is a Holdout, also behind mixes that show one side alone.
    pub(super) fn is_holdout(&self) -> bool {
        let mut surface = self.source.surface.as_ref();
        let mut before = self.source.nodes.len();
        while let Some(Reference { node: at, .. }) = surface {
            let Some(node) = self.source.nodes.get(*at).filter(|_| *at < before) else {
                return false;
            };
            match &*node.kind {
                "ShaderNodeHoldout" => return true,
                "ShaderNodeMixShader" => {}
                _ => return false,
            }
            let factor = node.inputs.get("Fac").or_else(|| node.inputs.get("Factor"));
            let side = match factor {
                Some(SocketJson::Number(factor)) if *factor <= 0.0 => "Shader",
                Some(SocketJson::Number(factor)) if *factor >= 1.0 => "Shader_001",
                _ => return false,
            };
            before = *at;
            surface = match node.inputs.get(side) {
                Some(SocketJson::Link(link)) => Some(link),
                _ => None,
            };
        }
        false
    }

    /// The set of texture coordinates along which tangents lie: meshes have those of one set.
    fn tangents(&self, used: &[BTreeSet<String>]) -> Result<Option<u32>, Stop> {
        let nodes = self.source.nodes.iter().zip(used);
        let with_tangents = nodes.filter(|(node, used)| {
            let takes_uv = node.text("direction_type") == Some("UV_MAP");
            let space = node.text("space");
            !used.is_empty()
                && match &*node.kind {
                    "ShaderNodeNormalMap" => true,
                    "ShaderNodeVectorDisplacement" => space == Some("TANGENT"),
                    "ShaderNodeTangent" => takes_uv,
                    _ => false,
                }
        });
        let sets: BTreeSet<u32> = with_tangents
            .filter_map(|(node, _)| Some(node.number("uv_set")? as u32))
            .collect();
        if sets.len() > 1 {
            return Err(Refusal("tangents of several UV maps".to_owned()).into());
        }
        Ok(sets.first().copied())
    }

    /// The outputs in use, by node, and the nodes that the displacement needs.
    fn used(&self) -> (Vec<BTreeSet<String>>, Vec<bool>) {
        let nodes = &self.source.nodes;
        let mut used = vec![BTreeSet::new(); nodes.len()];
        let mut of_displacement = vec![false; nodes.len()];
        for (root, displaces) in self
            .source
            .displacement
            .iter()
            .map(|root| (root, true))
            .chain(self.source.surface.iter().map(|root| (root, false)))
            .chain(self.source.volume.iter().map(|root| (root, false)))
            .chain(self.source.aovs.iter().map(|aov| (&aov.value, false)))
        {
            if let Some(outputs) = used.get_mut(root.node) {
                outputs.insert(root.output.clone());
                of_displacement[root.node] |= displaces;
            }
        }
        for at in (0..nodes.len()).rev() {
            if used[at].is_empty() {
                continue;
            }
            let displaces = of_displacement[at];
            for input in nodes[at].inputs.values() {
                // Links go to nodes before: what goes elsewhere is no link.
                if let SocketJson::Link(link) = input
                    && link.node < at
                {
                    used[link.node].insert(link.output.clone());
                    of_displacement[link.node] |= displaces;
                }
            }
        }
        (used, of_displacement)
    }

    fn make_all(&mut self, at: usize, used: &[BTreeSet<String>]) -> Result<(), Stop> {
        for output in &used[at] {
            let input = self.make(at, output, &used[at])?;
            let output = output.clone();
            self.made.insert(Reference { node: at, output }, input);
        }
        Ok(())
    }

    /// The normal that comes of the displacement (Cycles: a Bump of distance 1 whose height is how far it goes along the
    /// normal), where it is not for the vertices alone.
    fn displaced(&mut self) {
        let source = self.source;
        let Some(found) = source
            .displacement
            .as_ref()
            .and_then(|root| self.made.get(root))
        else {
            return;
        };
        let moved = *found;
        let (moves, bumps) = match source.displacement_method.as_deref() {
            Some("DISPLACEMENT") => (true, false),
            Some("BOTH") => (true, true),
            _ => (false, true),
        };
        if moves {
            self.graph.displacement = moved.link();
        }
        if !bumps || moved.link().is_none() {
            return;
        }
        let function = |function| Node::new(NodeKind::Function(function));
        let normal = self
            .graph
            .add(function(Function::Place(PlaceInput::Normal)));
        let height = function(Function::VectorMath(VectorMath::DotProduct));
        let height = self.graph.add(height.with(0, moved).with(1, normal));
        let output = 1;
        self.before = moves.then(|| self.source.attributes());
        let bump = function(Function::Bump {
            invert: false,
            object_space: moves,
            undisplaced: self.before,
            is_of_5: moves && self.version >= CyclesVersion::new(5, 0),
            widened: function::widens(self.version),
        });
        let bump = bump.with(bump::HEIGHT, Link { output, ..height });
        self.graph.normal = Some(self.graph.add(bump));
    }

    /// What an output gives that has a value for each vertex, or for each object.
    fn value(&mut self, node: &NodeJson, output: &str) -> Result<Option<Input>, Stop> {
        let Some(value) = node.properties.get("values").and_then(|v| v.get(output)) else {
            return Ok(None);
        };
        let attribute = value.get("attribute").and_then(Value::as_str);
        let object = value.get("object").and_then(Value::as_u64);
        let grid = value.get("grid").and_then(Value::as_u64);
        let input = match (attribute, object) {
            _ if let Some(number) = grid => PlaceInput::Grid {
                number: u32::try_from(number).unwrap_or(u32::MAX),
                interpolation: match value.get("interpolation").and_then(Value::as_str) {
                    Some("cubic") => Interpolation::Cubic,
                    Some("drawn") => Interpolation::Drawn,
                    _ => Interpolation::Linear,
                },
                otherwise: value
                    .get("otherwise")
                    .and_then(Value::as_f64)
                    .unwrap_or(0.0) as f32,
            },
            (Some(name), _) => shader::attribute(node, name)?,
            (_, Some(number)) => PlaceInput::ObjectValue(number as u32),
            _ => return Err(Refusal::of(node, output).into()),
        };
        let link = self
            .graph
            .add(Node::new(NodeKind::Function(Function::Place(input))));
        let output = match value.get("kind").and_then(Value::as_str) {
            Some("color") => node::COLOR,
            Some("alpha") => node::ALPHA,
            // The mean of a number that stands three times is the number.
            _ if output == "Fac" => node::FACTOR,
            _ => node::VECTOR,
        };
        Ok(Some(Link { output, ..link }.into()))
    }

    /// What an output gives.
    fn make(&mut self, at: usize, output: &str, used: &BTreeSet<String>) -> Result<Input, Stop> {
        let source = self.source;
        let node = &source.nodes[at];
        if let Some(input) = self.shader(at)? {
            return Ok(input);
        }
        if let Some(input) = self.value(node, output)? {
            return Ok(input);
        }
        let is_image = matches!(
            &*node.kind,
            "ShaderNodeTexImage" | "ShaderNodeTexEnvironment"
        );
        if is_image || matches!(&*node.kind, "ShaderNodeAttribute" | "ShaderNodeVertexColor") {
            // One node for both outputs.
            let of_other = self.made.get(&Reference {
                node: at,
                output: "Alpha".to_owned(),
            });
            let link = match of_other.and_then(|input| input.link()) {
                Some(link) => link,
                None if is_image => self.image(at, used.contains("Alpha"))?,
                None => self.attribute(at)?,
            };
            let output = match output {
                "Alpha" => node::ALPHA,
                "Vector" => node::VECTOR,
                "Fac" => node::FACTOR,
                _ => node::COLOR,
            };
            return Ok(Link { output, ..link }.into());
        }
        match &*node.kind {
            "ShaderNodeNormalMap" => return self.normal_map(at),
            "ShaderNodeTexSky" => return self.sky(at),
            "ShaderNodeTexIES" => return self.ies(at),
            "ShaderNodeLightFalloff" => return Ok(self.falloff(at, output)),
            _ => {}
        }
        match (&*node.kind, output) {
            ("ShaderNodeNormal", "Dot") => return self.normal_dot(at),
            ("ShaderNodeCameraData", "View Vector") => {
                let camera = Function::Place(PlaceInput::Camera);
                let camera = self.graph.add(Node::new(NodeKind::Function(camera)));
                return Ok(self
                    .vector_math(VectorMath::Normalize, &[camera.into()])
                    .into());
            }
            _ => {}
        }
        let found = function::of(node, (output, used), source.pass_index, self.version)?;
        let kind = NodeKind::Function(found.function);
        // Outputs that are computed together are those of one node.
        let mut others = used.iter().filter_map(|output| {
            let node = at;
            let output = output.clone();
            self.made.get(&Reference { node, output })?.link()
        });
        let same = others.find(|link| self.graph.node(*link).kind == kind);
        let link = match same {
            Some(link) => link,
            None => self.add(at, kind, found.aliases),
        };
        Ok(Link {
            output: found.output,
            ..link
        }
        .into())
    }

    /// A Normal node's product with its direction; both are made one long.
    fn normal_dot(&mut self, at: usize) -> Result<Input, Stop> {
        let node = &self.source.nodes[at];
        let numbers = node.properties.get("direction").and_then(Value::as_array);
        let number = |i: usize| Some(numbers?.get(i)?.as_f64()? as f32);
        let (Some(x), Some(y), Some(z)) = (number(0), number(1), number(2)) else {
            return Err(Refusal::of(node, "without a direction").into());
        };
        let direction = glam::Vec3::new(x, y, z).normalize_or_zero().to_array();
        let normal = self.input(node, "Normal", SocketKind::Vector);
        let normal = self.vector_math(
            VectorMath::Normalize,
            &[normal.unwrap_or(Input::Value([0.0; 3]))],
        );
        let both = [normal.into(), Input::Value(direction)];
        let product = self.vector_math(VectorMath::DotProduct, &both);
        // The number is the second output.
        Ok(Link {
            output: 1,
            ..product
        }
        .into())
    }

    fn vector_math(&mut self, operation: VectorMath, inputs: &[Input]) -> Link {
        let mut node = Node::new(NodeKind::Function(Function::VectorMath(operation)));
        for (place, input) in inputs.iter().enumerate() {
            node.inputs[place] = *input;
        }
        self.graph.add(node)
    }

    /// Adds a node whose sockets are those of the tree's node, by their names.
    fn add(&mut self, at: usize, kind: NodeKind, aliases: &[(&str, &str)]) -> Link {
        let source = self.source;
        let mut node = Node::new(kind);
        for (place, socket) in node.kind.sockets().iter().enumerate() {
            let alias = aliases.iter().find(|(ours, _)| *ours == socket.name);
            let name = alias.map_or(socket.name, |(_, theirs)| theirs);
            let input = self.input(&source.nodes[at], name, socket.kind);
            if let Some(input) = input {
                node.inputs[place] = input;
            } else if socket.kind == SocketKind::Vector
                && socket.name == "Vector"
                && source.nodes[at].kind.starts_with("ShaderNodeTex")
            {
                node.inputs[place] = self.generated();
            }
        }
        self.graph.add(node)
    }

    /// What stands in a socket; `None` where nothing does. Versions call factors "Fac" or "Factor".
    fn input(&self, node: &NodeJson, name: &str, kind: SocketKind) -> Option<Input> {
        let other = match name {
            "Fac" => "Factor",
            "Factor" => "Fac",
            name => name,
        };
        let found = node.inputs.get(name).or_else(|| node.inputs.get(other))?;
        match found {
            SocketJson::Link(link) => self.made.get(link).copied(),
            _ if kind == SocketKind::Shader => None,
            SocketJson::Number(value) => Some(Input::float(*value)),
            SocketJson::Switch(on) => Some(Input::float(f32::from(*on))),
            SocketJson::Numbers(values) => match **values {
                [x, y, z, ..] => Some(Input::Value([x, y, z])),
                [x, y] => Some(Input::Value([x, y, 0.0])),
                [x] => Some(Input::float(x)),
                [] => None,
            },
        }
    }

    /// "Generated" coordinates, which textures take where nothing is linked.
    fn generated(&mut self) -> Input {
        let kind = NodeKind::Function(Function::Place(PlaceInput::Generated));
        self.graph.add(Node::new(kind)).into()
    }
}

#[cfg(test)]
#[path = "../../../../tests/unit/import/gltf/shader_graph/mod.rs"]
mod tests;
