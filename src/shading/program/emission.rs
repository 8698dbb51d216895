//! What graphs emit: of each shader by its share, below a Principled BSDF's sheen and coat.

use super::compile::{Compiler, root};
use super::shader::layers;
use super::{Lane, LayerRoots, Operand, Program, Root, Source};
use crate::scene::graph::node::{emission, principled};
use crate::scene::graph::{Blend, Graph, Input, NodeKind, SocketKind};
use glam::Vec4;

/// What shines below layers that keep a part of the light.
#[derive(Clone, Debug)]
pub struct Covered {
    /// The light without them.
    pub light: Root,
    /// The normal map of the shader, if it has one.
    pub normal: Option<Root>,
    /// What lies over it.
    pub layers: Box<LayerRoots>,
}

impl Covered {
    fn roots(&mut self) -> impl Iterator<Item = &mut Root> {
        let own = [&mut self.light].into_iter().chain(&mut self.normal);
        own.chain(self.layers.roots())
    }
}

/// What is emitted, as values of a program.
#[derive(Clone, Debug)]
pub struct Shining {
    /// Emitted radiance of what nothing covers, as far as it does not pass straight on.
    pub open: Root,
    /// The rest.
    pub covered: Vec<Covered>,
}

impl Shining {
    pub(super) fn roots(&mut self) -> impl Iterator<Item = &mut Root> {
        let covered = self.covered.iter_mut().flat_map(Covered::roots);
        covered.chain([&mut self.open])
    }
}

/// Operations of what is emitted.
#[derive(Clone, Debug)]
pub struct Emission {
    /// All of them.
    pub program: Program,
    /// What they make.
    pub shining: Shining,
}

impl Emission {
    /// The emitted radiance, if it is the same everywhere.
    pub fn constant(&self) -> Option<glam::Vec3> {
        let Shining { open, covered } = &self.shining;
        open.constant().filter(|_| covered.is_empty())
    }
}

impl<S: Source> Compiler<'_, S> {
    /// [`Compiler::input`] where it is read as a colour whatever the socket takes: of a colour that is linked to a number's socket the luminance
    /// counts, and of a vector the mean.
    pub(super) fn color_input(&mut self, at: usize, socket: usize) -> Operand {
        let operand = self.input(at, socket);
        let takes_number = self.graph.nodes[at].kind.sockets()[socket].kind == SocketKind::Float;
        match operand {
            Operand::Register(_, Lane::Rgb | Lane::Xyz) if takes_number => {
                self.number(operand, false)
            }
            operand => operand,
        }
    }
}

pub(super) fn emission_of(graph: &Graph, source: &mut impl Source) -> Emission {
    let mut heights = 0;
    let mut compiler = Compiler::new(graph, source, &mut heights);
    let mut shining = shining(&mut compiler);
    let mut roots: Vec<&mut Root> = shining.roots().collect();
    let program = compiler.finish(&mut roots);
    Emission { program, shining }
}

/// Emits what shines into a program.
pub(super) fn shining<S: Source>(compiler: &mut Compiler<'_, S>) -> Shining {
    let graph = compiler.graph;
    let mut open = Operand::Constant(Vec4::W);
    let mut covered = Vec::new();
    for (at, weight) in compiler.body() {
        let node = &graph.nodes[at];
        let is_principled = matches!(node.kind, NodeKind::PrincipledBsdf { .. });
        let (color, strength) = match node.kind {
            _ if is_principled => (principled::EMISSION_COLOR, principled::EMISSION_STRENGTH),
            NodeKind::Emission => (emission::COLOR, emission::STRENGTH),
            _ => continue,
        };
        let is_black = |socket: usize| node.inputs[socket] == Input::float(0.0);
        if is_black(color) || is_black(strength) {
            continue;
        }
        let color = compiler.input(at, color);
        let strength = compiler.color_input(at, strength);
        let light = compiler.blend(Blend::Multiply, color, strength);
        let part = compiler.blend(Blend::Multiply, light, weight);
        let layers = is_principled.then(|| layers(compiler, at));
        match layers.flatten() {
            Some(layers) => covered.push(Covered {
                light: root(part),
                normal: (node.inputs[principled::NORMAL] != Input::None)
                    .then(|| root(compiler.input(at, principled::NORMAL))),
                layers,
            }),
            None => open = compiler.blend(Blend::Add, open, part),
        }
    }
    Shining {
        open: root(open),
        covered,
    }
}
