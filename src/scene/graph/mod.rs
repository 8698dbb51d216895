//! Shader graphs: what a material is, independent of the file format.
//!
//! A node's inputs come from nodes before it, so that one pass in the order of the list does whatever is to be done
//! to all of them, and there are no cycles. Whoever builds a graph with links that go elsewhere has them cut by
//! [`super::validate`].

mod clean;
mod emission;
mod fold;
pub mod function;
mod label;
pub mod node;
mod range;
mod shaders;
mod summary;

pub use clean::Faults;
pub use fold::fold;
use function::{DisplacementSpace, PlaceInput};

pub use function::{Function, ProceduralTexture};
pub use node::{
    Blend, Distribution, ImageProjection, Lane, Legal, MathOperation, NodeKind, NormalSpace,
    Socket, SocketKind, TangentKind,
};
pub use range::{Facts, Range, Unit};
pub use shaders::{
    HairColoring, HairFibre, HairModel, PhaseKind, ShaderRules, SimpleBsdf, Subsurface,
    VolumeShader, WalkMethod,
};
pub use summary::{Opacity, PrincipledSummary, Slot, SolidIndex, Summary};

use super::material::Texture;
use node::ONLY;

/// An output of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Its place in the list.
    pub node: u32,
    /// Which output.
    pub output: u8,
}

/// What stands in a socket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// Nothing: a missing shader, or the surface's own normal.
    None,
    /// A colour, or a number three times.
    Value([f32; 3]),
    /// What a node gives.
    Link(Link),
}

impl Input {
    /// A number.
    pub fn float(value: f32) -> Self {
        Self::Value([value; 3])
    }

    /// The link, if there is one.
    pub fn link(self) -> Option<Link> {
        match self {
            Self::Link(link) => Some(link),
            _ => None,
        }
    }
}

impl From<Link> for Input {
    fn from(link: Link) -> Self {
        Self::Link(link)
    }
}

impl From<f32> for Input {
    fn from(value: f32) -> Self {
        Self::float(value)
    }
}

impl From<[f32; 3]> for Input {
    fn from(value: [f32; 3]) -> Self {
        Self::Value(value)
    }
}

/// A node with what stands in its sockets, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it is.
    pub kind: NodeKind,
    /// One for each of its sockets.
    pub inputs: Vec<Input>,
}

impl Node {
    /// With Blender's defaults in all sockets.
    pub fn new(kind: NodeKind) -> Self {
        let default = |socket: &Socket| match socket.kind {
            SocketKind::Normal | SocketKind::Coordinates | SocketKind::Shader => Input::None,
            SocketKind::Float | SocketKind::Color | SocketKind::Vector => {
                Input::Value(socket.default)
            }
        };
        let inputs = kind.sockets().iter().map(default).collect();
        Self { kind, inputs }
    }

    /// With something in a socket.
    #[must_use]
    pub fn with(mut self, socket: usize, input: impl Into<Input>) -> Self {
        self.inputs[socket] = input.into();
        self
    }

    /// The sockets for how far its facets' spread differs along the tangent and across it, and for that tangent.
    pub fn anisotropy_sockets(&self) -> Option<(usize, usize)> {
        match self.kind {
            NodeKind::PrincipledBsdf { .. } => {
                Some((node::principled::ANISOTROPIC, node::principled::TANGENT))
            }
            NodeKind::GlossyBsdf { .. } => Some((node::glossy::ANISOTROPY, node::glossy::TANGENT)),
            NodeKind::Bsdf(SimpleBsdf::Glass { .. }) => {
                Some((node::glass::ANISOTROPY, node::glass::TANGENT))
            }
            NodeKind::Bsdf(SimpleBsdf::Metallic { .. }) => {
                Some((node::metallic::ANISOTROPY, node::metallic::TANGENT))
            }
            _ => None,
        }
    }

    /// The socket for the thickness of a film on it.
    pub fn film_socket(&self) -> Option<usize> {
        match self.kind {
            NodeKind::PrincipledBsdf { .. } => Some(node::principled::THIN_FILM_THICKNESS),
            NodeKind::Bsdf(SimpleBsdf::Glass { .. } | SimpleBsdf::Refraction { .. }) => {
                Some(node::glass::THIN_FILM_THICKNESS)
            }
            NodeKind::Bsdf(SimpleBsdf::Metallic { .. }) => {
                Some(node::metallic::THIN_FILM_THICKNESS)
            }
            _ => None,
        }
    }

    /// Whether it is a shader with anisotropy.
    pub fn is_anisotropic(&self) -> bool {
        let sockets = self.anisotropy_sockets();
        sockets.is_some_and(|(of, _)| self.inputs[of] != Input::float(0.0))
    }

    /// Whether it is a shader with anisotropy and without a tangent of its own: in Blender that is the radial one.
    pub fn is_anisotropic_about_z(&self) -> bool {
        let sockets = self.anisotropy_sockets();
        self.is_anisotropic()
            && sockets.is_some_and(|(_, tangent)| self.inputs[tangent] == Input::None)
    }

    /// The images that it reads.
    pub fn textures(&self) -> &[Texture] {
        match &self.kind {
            NodeKind::ImageTexture { texture, .. } => std::slice::from_ref(texture),
            NodeKind::TiledImage { textures, .. } => textures,
            _ => &[],
        }
    }

    /// The image of an Image Texture that has one.
    pub fn texture(&self) -> Option<&Texture> {
        match &self.kind {
            NodeKind::ImageTexture { texture, .. } => Some(texture),
            _ => None,
        }
    }
}

/// Nodes, and which of them the Material Output takes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// Each after those that it takes something from.
    pub nodes: Vec<Node>,
    /// Shader of the surface.
    pub surface: Option<Link>,
    /// Shader of what is inside.
    pub volume: Option<Link>,
    /// Displacement of the surface.
    pub displacement: Option<Link>,
    /// Tangents of what its displacement has moved are computed anew: normal maps stand on the surface as it is then (Cycles from
    /// 5.1 on).
    pub renews_tangents: bool,
    /// The normal that takes the place of the surface's own: that of a displacement that is a bump.
    pub normal: Option<Link>,
    /// What it tells passes of the scene's own (Blender's AOV Output nodes).
    pub aovs: Vec<AovOutput>,
}

/// A value for a pass of the scene's own.
#[derive(Clone, Debug, PartialEq)]
pub struct AovOutput {
    /// Its first float among those of all of these passes.
    pub first: u32,
    /// A colour, or a number.
    pub is_color: bool,
    /// The value.
    pub value: Option<Link>,
}

impl Graph {
    /// Adds a node; its first output.
    pub fn add(&mut self, node: Node) -> Link {
        self.nodes.push(node);
        Link {
            node: self.nodes.len() as u32 - 1,
            output: ONLY,
        }
    }

    /// The node that a link comes from.
    pub fn node(&self, link: Link) -> &Node {
        &self.nodes[link.node as usize]
    }

    /// What the link gives: a number, a colour …
    pub fn gives(&self, link: Link) -> (SocketKind, Lane) {
        self.node(link).kind.outputs()[usize::from(link.output)]
    }

    fn roots(&mut self) -> Vec<&mut Option<Link>> {
        let aovs = self.aovs.iter_mut().map(|aov| &mut aov.value);
        let own = [
            &mut self.surface,
            &mut self.volume,
            &mut self.displacement,
            &mut self.normal,
        ];
        own.into_iter().chain(aovs).collect()
    }

    /// Takes over what another graph tells passes of the scene's own.
    pub fn take_aovs(&mut self, mut other: Self) {
        let shift = self.nodes.len() as u32;
        let inputs = other.nodes.iter_mut().flat_map(|node| &mut node.inputs);
        let links = inputs.filter_map(|input| match input {
            Input::Link(link) => Some(link),
            _ => None,
        });
        let roots = other.aovs.iter_mut().filter_map(|aov| aov.value.as_mut());
        links.chain(roots).for_each(|link| link.node += shift);
        self.nodes.append(&mut other.nodes);
        self.aovs.append(&mut other.aovs);
    }

    /// Which nodes some links need, themselves included.
    pub fn behind(&self, links: impl IntoIterator<Item = Link>) -> Vec<bool> {
        let mut needed = vec![false; self.nodes.len()];
        for link in links {
            needed[link.node as usize] = true;
        }
        for at in (0..self.nodes.len()).rev() {
            if needed[at] {
                for link in self.nodes[at].inputs.iter().filter_map(|i| i.link()) {
                    needed[link.node as usize] = true;
                }
            }
        }
        needed
    }

    /// Images that what stands in a socket needs.
    pub fn textures_behind(&self, input: Input) -> impl Iterator<Item = &Texture> {
        let needed = self.behind(input.link());
        let nodes = self.nodes.iter().zip(needed);
        let nodes = nodes.filter_map(|(node, needed)| needed.then_some(node));
        nodes.flat_map(Node::textures)
    }

    /// All images.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        self.nodes.iter().flat_map(Node::textures)
    }

    /// All images, to be changed.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut Texture> {
        self.nodes.iter_mut().flat_map(|node| match &mut node.kind {
            NodeKind::ImageTexture { texture, .. } => std::slice::from_mut(texture),
            NodeKind::TiledImage { textures, .. } => textures,
            _ => &mut [],
        })
    }

    /// How many sets of texture coordinates its nodes read.
    pub fn uv_sets(&self) -> usize {
        let asked = self.nodes.iter().filter_map(|node| match node.kind {
            NodeKind::Function(Function::Place(PlaceInput::Uv(set))) => Some(set),
            _ => None,
        });
        let sets = self.textures().map(|texture| texture.uv_set).chain(asked);
        sets.map(|set| set as usize + 1).max().unwrap_or(0)
    }

    /// How many attributes of vertices its nodes ask for.
    pub fn attributes(&self) -> usize {
        let of = |node: &Node| match node.kind {
            NodeKind::Function(
                Function::Place(PlaceInput::Attribute(number))
                | Function::Bump {
                    undisplaced: Some(number),
                    ..
                },
            )
            | NodeKind::NormalMap {
                space: NormalSpace::Before(number),
            } => number as usize + 1,
            _ => 0,
        };
        self.nodes.iter().map(of).fold(0, usize::max)
    }

    /// Whether a bump goes over its true displacement.
    pub fn bumps_displaced(&self) -> bool {
        self.nodes.iter().any(|node| {
            let Function::Bump { undisplaced, .. } = (match &node.kind {
                NodeKind::Function(function) => function,
                _ => return false,
            }) else {
                return false;
            };
            undisplaced.is_some()
        })
    }

    /// Whether some shader has another normal than the surface: by a map, a bump, or numbers.
    pub fn has_normal_map(&self) -> bool {
        let bends = |n: &Node| {
            let normal = |socket: &Socket| socket.kind == SocketKind::Normal;
            let shades = n.kind.outputs().first().map(|o| o.0) == Some(SocketKind::Shader);
            let mut sockets = n.kind.sockets().iter().zip(&n.inputs);
            shades && sockets.any(|(s, input)| normal(s) && input.link().is_some())
        };
        self.normal.is_some() || self.nodes.iter().any(bends)
    }

    /// Whether some shader's normal is another than the surface's: maps of strength 0 change nothing.
    pub fn bends_normals(&self) -> bool {
        let bends = |link: Link| {
            let node = self.node(link);
            !matches!(node.kind, NodeKind::NormalMap { .. })
                || node.inputs[node::normal_map::STRENGTH] != Input::float(0.0)
        };
        let is_bent = |n: &Node| {
            let shades = n.kind.outputs().first().map(|o| o.0) == Some(SocketKind::Shader);
            let sockets = n.kind.sockets().iter().zip(&n.inputs);
            let mut normals = sockets.filter(|(s, _)| s.kind == SocketKind::Normal);
            shades && normals.any(|(_, input)| input.link().is_some_and(bends))
        };
        self.normal.is_some() || self.nodes.iter().any(is_bent)
    }

    /// Whether a tangent of some kind is read: by a normal map, or for anisotropy.
    pub fn has_tangent(&self, kind: TangentKind) -> bool {
        self.nodes.iter().any(|n| match n.kind {
            NodeKind::NormalMap { .. }
            | NodeKind::Function(
                Function::Place(PlaceInput::UvTangent)
                | Function::VectorDisplacement(DisplacementSpace::Tangent),
            ) => kind == TangentKind::Uv,
            NodeKind::Tangent { kind: of } => kind == of,
            _ => kind == TangentKind::Radial && n.is_anisotropic_about_z(),
        })
    }

    /// The strengths of the normal maps; of one that varies, 1.
    pub fn normal_map_strengths(&self) -> impl Iterator<Item = f32> {
        let is_map = |n: &&Node| matches!(n.kind, NodeKind::NormalMap { .. });
        let maps = self.nodes.iter().filter(is_map);
        maps.map(|map| match map.inputs[node::normal_map::STRENGTH] {
            Input::Value([strength, ..]) => strength,
            _ => 1.0,
        })
    }

    /// Takes out nodes that nothing needs.
    pub fn prune(&mut self) {
        let roots: Vec<Link> = self.roots().into_iter().filter_map(|r| *r).collect();
        let needed = self.behind(roots);
        let mut next = 0;
        let places: Vec<u32> = needed
            .iter()
            .map(|&needed| {
                next += u32::from(needed);
                next.wrapping_sub(1)
            })
            .collect();
        let place = |link: &mut Link| link.node = places[link.node as usize];
        let mut needed = needed.into_iter();
        self.nodes.retain(|_| needed.next().unwrap_or(false));
        for node in &mut self.nodes {
            for input in &mut node.inputs {
                if let Input::Link(link) = input {
                    place(link);
                }
            }
        }
        self.roots().into_iter().flatten().for_each(place);
    }

    /// Patterns that are computed.
    pub fn procedural_textures(&self) -> impl Iterator<Item = &ProceduralTexture> {
        self.nodes.iter().filter_map(|node| match &node.kind {
            NodeKind::Function(Function::Texture(texture)) => Some(texture),
            _ => None,
        })
    }

    /// Puts 0.5 in the place of some patterns: about the mean of most.
    pub fn make_grey(&mut self, is_grey: impl Fn(&ProceduralTexture) -> bool) {
        let grey: Vec<bool> = self
            .nodes
            .iter()
            .map(|node| match &node.kind {
                NodeKind::Function(Function::Texture(texture)) => is_grey(texture),
                _ => false,
            })
            .collect();
        for input in self.nodes.iter_mut().flat_map(|node| &mut node.inputs) {
            if input.link().is_some_and(|link| grey[link.node as usize]) {
                *input = Input::float(0.5);
            }
        }
    }

    /// Makes images white where one socket reads them; others that read the same images keep them.
    pub fn whiten(&mut self, node: usize, socket: usize) {
        let Input::Link(link) = self.nodes[node].inputs[socket] else {
            return;
        };
        let shift = node as u32;
        // The nodes before it stand there twice: the second ones are for this socket alone.
        let mut copies: Vec<Node> = self.nodes[..node].to_vec();
        let white = |from: Link, nodes: &[Node]| match nodes[from.node as usize].kind {
            NodeKind::ImageTexture { .. } | NodeKind::TiledImage { .. } => Input::float(1.0),
            _ => Input::Link(Link {
                node: from.node + shift,
                ..from
            }),
        };
        for input in copies.iter_mut().flat_map(|copy| &mut copy.inputs) {
            if let Input::Link(from) = *input {
                *input = white(from, &self.nodes);
            }
        }
        let input = white(link, &self.nodes);
        let later = |link: &mut Link| {
            if link.node >= shift {
                link.node += shift;
            }
        };
        for input in self.nodes[node..].iter_mut().flat_map(|n| &mut n.inputs) {
            if let Input::Link(link) = input {
                later(link);
            }
        }
        self.roots().into_iter().flatten().for_each(later);
        self.nodes[node].inputs[socket] = input;
        self.nodes.splice(node..node, copies);
        self.prune();
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/scene/graph/mod.rs"]
mod tests;
