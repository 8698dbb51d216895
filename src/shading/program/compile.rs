//! From graphs to programs.

use super::aovs::aovs;
use super::emission::{emission_of, shining};
use super::leaves::opacity;
use super::shader::{roots_of, shader};
use super::{
    Call, Emission, Height, Operand, Operation, Program, Programs, Root, Shining, Weighted,
};
use crate::math::average;
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::function::bump;
use crate::scene::graph::node::{image_texture, math, mix, normal_map, separate, tangent};
use crate::scene::graph::{
    self, Blend, Facts, Function, Graph, Input, Lane, Link, MathOperation, NodeKind, Range,
    SocketKind,
};
use crate::scene::{ImageUse, Texture};
use crate::shading::texture::PreparedTexture;
use glam::{Vec3, Vec4};

/// Gives textures their rasters; those without an image are white.
pub trait Source {
    /// A texture ready to be read.
    fn texture(&mut self, texture: &Texture, usage: ImageUse) -> Option<PreparedTexture>;
}

/// What is known when a material is prepared.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Whether some vertices have colours.
    pub vertex_colors: bool,
    /// The space of the scene's colours.
    pub space: WorkingSpace,
}

impl Facts for Known {
    fn image(&mut self, _: &Texture, _: ImageUse, _: [bool; 4]) -> Range {
        Range::UNKNOWN
    }

    fn colors(&self) -> Range {
        if self.vertex_colors {
            Range::UNKNOWN
        } else {
            Range::WHITE
        }
    }
}

pub(super) const ONE: Operand = Operand::Constant(Vec4::ONE);
pub(super) const ZERO: Operand = Operand::Constant(Vec4::ZERO);

/// Whether an operand is a number, or a colour of it.
fn is(operand: Operand, number: f32) -> bool {
    matches!(operand, Operand::Constant(value) if value.truncate() == Vec3::splat(number))
}

/// One program on its way.
pub(super) struct Compiler<'a, S> {
    pub(super) graph: &'a Graph,
    source: &'a mut S,
    program: Program,
    /// The register or constant of each node that has one.
    results: Vec<Option<Operand>>,
    /// Of heights within heights.
    depth: u32,
    /// So many heights have been compiled.
    heights: &'a mut u32,
}

/// Heights within heights that are seen: each level multiplies the work by three.
const DEEPEST: u32 = 4;
/// Heights of one material.
const MOST_HEIGHTS: u32 = 4096;

impl<'a, S: Source> Compiler<'a, S> {
    pub(super) fn new(graph: &'a Graph, source: &'a mut S, heights: &'a mut u32) -> Self {
        Self {
            graph,
            source,
            program: Program::default(),
            results: vec![None; graph.nodes.len()],
            depth: 0,
            heights,
        }
    }

    /// Whether an operand is the opacity of an image of integers: 0 to 1.
    fn is_share(&self, operand: Operand) -> bool {
        let Operand::Register(at, Lane::One(3)) = operand else {
            return false;
        };
        match self.program.operations[at as usize] {
            Operation::Image(texture) => self.program.textures[texture as usize].ends_at_one(),
            _ => false,
        }
    }

    pub(super) fn emit(&mut self, operation: Operation) -> u32 {
        self.program.operations.push(operation);
        self.program.operations.len() as u32 - 1
    }

    /// Emits what an input needs that is not there yet, in the order of the nodes.
    pub(super) fn operand(&mut self, input: Input) -> Operand {
        let link = match input {
            Input::Link(link) => link,
            Input::Value(value) => return Operand::Constant(Vec3::from(value).extend(1.0)),
            Input::None => return ZERO,
        };
        if self.results[link.node as usize].is_some() {
            return self.of(link);
        }
        let needed = self.before(link);
        for (at, _) in needed.into_iter().enumerate().filter(|(_, needed)| *needed) {
            if self.results[at].is_none() {
                let result = self.node(at);
                self.results[at] = Some(result);
            }
        }
        self.of(link)
    }

    /// Which nodes run before a link is read. The height of a bump has a program of its own.
    fn before(&self, link: Link) -> Vec<bool> {
        let nodes = &self.graph.nodes;
        let mut needed = vec![false; nodes.len()];
        needed[link.node as usize] = true;
        for at in (0..=link.node as usize)
            .rev()
            .filter(|at| self.results[*at].is_none())
        {
            if !needed[at] {
                continue;
            }
            let node = &nodes[at];
            let raised = matches!(node.kind, NodeKind::Function(Function::Bump { .. }));
            for (socket, input) in node.inputs.iter().enumerate() {
                if let (Input::Link(link), false) = (input, raised && socket == bump::HEIGHT) {
                    needed[link.node as usize] = true;
                }
            }
        }
        needed
    }

    /// What an input of a node gives, as its socket takes it; what is behind it is emitted first. Normals stand outside in
    /// glTF's axes, vectors of them on the viewer's side in Blender's. Functions take both: see [`Self::takes_vector`].
    pub(super) fn input(&mut self, at: usize, socket: usize) -> Operand {
        let node = &self.graph.nodes[at];
        let operand = self.operand(node.inputs[socket]);
        let Some(link) = node.inputs[socket].link() else {
            return operand;
        };
        let takes_normal = node.kind.sockets()[socket].kind == SocketKind::Normal;
        let gives_normal = self.graph.gives(link).0 == SocketKind::Normal;
        let operation = match (gives_normal, takes_normal) {
            (true, false) => Operation::Facing(operand),
            (false, true) if self.takes_vector(at) => return operand,
            // One of 0 is the surface's own: Cycles' constant ones do not count.
            (false, true) if is_displacement(&node.kind) => Operation::Turned(operand),
            (false, true) => Operation::Outside(operand),
            _ => return operand,
        };
        Operand::Register(self.emit(operation), Lane::Xyz)
    }

    /// Whether a function's normal is a vector, as long as it is: one of 0 is not the surface's own normal, but 0.
    fn takes_vector(&self, at: usize) -> bool {
        let node = &self.graph.nodes[at];
        if !matches!(node.kind, NodeKind::Function(_)) || is_displacement(&node.kind) {
            return false;
        }
        let mut sockets = node.kind.sockets().iter().zip(&node.inputs);
        let gives = |link: Link| self.graph.gives(link).0 != SocketKind::Normal;
        sockets.any(|(s, input)| s.kind == SocketKind::Normal && input.link().is_some_and(gives))
    }

    /// What an operand is as a number, brought to 0 to 1 on request.
    pub(super) fn number(&mut self, operand: Operand, clamp: bool) -> Operand {
        let at = self.emit(Operation::Math {
            operation: MathOperation::Add,
            clamp,
            a: operand,
            b: ZERO,
        });
        Operand::Register(at, Lane::One(0))
    }

    fn of(&self, link: Link) -> Operand {
        let (_, lane) = self.graph.gives(link);
        match (self.results[link.node as usize].unwrap_or(ZERO), lane) {
            (Operand::Constant(value), Lane::One(i)) => {
                Operand::Constant(Vec4::splat(value[usize::from(i)]))
            }
            (Operand::Constant(value), Lane::Rgb | Lane::Xyz) => Operand::Constant(value),
            (Operand::Constant(value), Lane::Mean) => {
                Operand::Constant(Vec4::splat(average(value.truncate())))
            }
            // A number stands in all places.
            (one @ Operand::Register(_, Lane::One(_) | Lane::Mean), _) => one,
            (Operand::Register(at, Lane::Rgb | Lane::Xyz), lane) => Operand::Register(at, lane),
        }
    }

    fn node(&mut self, at: usize) -> Operand {
        let operation = match &self.graph.nodes[at].kind {
            NodeKind::ImageTexture {
                texture,
                usage,
                projection,
            } => {
                let Some(texture) = self.source.texture(texture, *usage) else {
                    return ONE;
                };
                self.program.textures.push(texture);
                let texture = self.program.textures.len() as u32 - 1;
                match self.graph.nodes[at].inputs[image_texture::VECTOR] {
                    Input::None => Operation::Image(texture),
                    _ => Operation::ImageAt {
                        texture,
                        projection: *projection,
                        at: self.input(at, image_texture::VECTOR),
                    },
                }
            }
            NodeKind::TiledImage {
                numbers,
                textures,
                usage,
                projection,
            } => {
                let mut tiles = Vec::with_capacity(numbers.len());
                for (number, texture) in numbers.iter().zip(textures) {
                    if let Some(texture) = self.source.texture(texture, *usage) {
                        tiles.push((*number, self.program.textures.len() as u32));
                        self.program.textures.push(texture);
                    }
                }
                self.program.tiled.push(tiles);
                Operation::TiledImage {
                    tiles: self.program.tiled.len() as u32 - 1,
                    projection: *projection,
                    at: self.input(at, image_texture::VECTOR),
                }
            }
            NodeKind::Function(function) => return self.call(at, function),
            NodeKind::ColorAttribute => Operation::VertexColor,
            // Its outputs are the numbers of what it takes.
            NodeKind::SeparateColor => return self.input(at, separate::COLOR),
            NodeKind::Math { operation, clamp } => {
                let (a, b) = (self.input(at, math::A), self.input(at, math::B));
                if *operation == MathOperation::Multiply && is(a, 1.0) && self.is_share(b) {
                    return b;
                }
                Operation::Math {
                    operation: *operation,
                    clamp: *clamp,
                    a,
                    b,
                }
            }
            NodeKind::MixColor { blend } => Operation::Mix {
                blend: *blend,
                factor: self.input(at, mix::FACTOR),
                a: self.input(at, mix::A),
                b: self.input(at, mix::B),
            },
            NodeKind::NormalMap { space } => Operation::NormalMap {
                space: *space,
                color: self.input(at, normal_map::COLOR),
                strength: self.input(at, normal_map::STRENGTH),
            },
            NodeKind::Tangent { kind } => Operation::Tangent {
                kind: *kind,
                direction: self.input(at, tangent::DIRECTION),
            },
            NodeKind::PrincipledBsdf { .. }
            | NodeKind::DiffuseBsdf { .. }
            | NodeKind::GlossyBsdf { .. }
            | NodeKind::Bsdf(_)
            | NodeKind::TransparentBsdf
            | NodeKind::Holdout
            | NodeKind::Emission
            | NodeKind::MixShader
            | NodeKind::AddShader
            | NodeKind::Volume(_) => return ZERO,
        };
        Operand::Register(self.emit(operation), Lane::Rgb)
    }

    /// A node's function.
    fn call(&mut self, at: usize, function: &Function) -> Operand {
        let sockets = function.sockets();
        let mut inputs = Vec::with_capacity(sockets.len());
        let raised = matches!(function, Function::Bump { .. });
        for (place, socket) in sockets.iter().enumerate() {
            let operand = match raised && place == bump::HEIGHT {
                true => ZERO,
                false => self.input(at, place),
            };
            inputs.push((operand, socket.kind));
        }
        if let Some(same) = unmapped(function, &inputs) {
            return same;
        }
        let mut height = None;
        if raised {
            let input = self.graph.nodes[at].inputs[bump::HEIGHT];
            height = self.height(input);
            let Some(height) = &mut height else {
                // What is as high everywhere is not raised.
                let normal = inputs[bump::NORMAL].0;
                if self.takes_vector(at) {
                    return Operand::Register(self.emit(Operation::Turned(normal)), Lane::Xyz);
                }
                return normal;
            };
            let is_displaced = matches!(
                function,
                Function::Bump {
                    undisplaced: Some(_),
                    ..
                }
            );
            if !is_displaced && !height.program.has_bumps() {
                // Here it is what this program may have computed for other sockets already.
                inputs[bump::HEIGHT].0 = self.operand(input);
                height.is_known_here = true;
            }
        }
        let mut call = Call::new(function.clone(), inputs, height);
        call.takes_vector = self.takes_vector(at);
        self.program.calls.push(call);
        let call = self.program.calls.len() as u32 - 1;
        let operation = match function.depends_on_place() {
            true => Operation::Call(call),
            false => Operation::Compute(call),
        };
        let lane = match function.outputs() {
            [(_, lane @ Lane::One(_))] => *lane,
            _ => Lane::Rgb,
        };
        Operand::Register(self.emit(operation), lane)
    }

    /// The program of a height; `None` where nothing varies, or where heights of heights go too deep.
    fn height(&mut self, input: Input) -> Option<Box<Height>> {
        if self.depth >= DEEPEST || *self.heights >= MOST_HEIGHTS {
            return None;
        }
        input.link()?;
        *self.heights += 1;
        let mut compiler = Compiler {
            graph: self.graph,
            source: &mut *self.source,
            program: Program::default(),
            results: vec![None; self.graph.nodes.len()],
            depth: self.depth + 1,
            heights: &mut *self.heights,
        };
        let operand = compiler.operand(input);
        let mut root = root(operand);
        let program = compiler.finish(&mut [&mut root]);
        (!program.is_constant()).then(|| {
            Box::new(Height {
                program,
                root,
                is_known_here: false,
            })
        })
    }

    /// Arithmetic of numbers, done at once where both are known.
    pub(super) fn math(&mut self, operation: MathOperation, a: Operand, b: Operand) -> Operand {
        use MathOperation::{Add, Multiply};
        match (operation, a, b) {
            (_, Operand::Constant(a), Operand::Constant(b)) => {
                Operand::Constant(Vec4::splat(operation.of(a.x, b.x)))
            }
            (Multiply, _, other) if is(a, 1.0) => other,
            (Multiply, other, _) if is(b, 1.0) => other,
            (Add, _, other) if is(a, 0.0) => other,
            (Add, other, _) if is(b, 0.0) => other,
            _ => {
                let clamp = false;
                let at = self.emit(Operation::Math {
                    operation,
                    clamp,
                    a,
                    b,
                });
                Operand::Register(at, Lane::One(0))
            }
        }
    }

    /// Arithmetic of colours, done at once where both are known.
    pub(super) fn blend(&mut self, blend: Blend, a: Operand, b: Operand) -> Operand {
        match (blend, a, b) {
            (_, Operand::Constant(a), Operand::Constant(b)) => {
                let color = blend.of(1.0, a.truncate(), b.truncate());
                Operand::Constant(color.extend(1.0))
            }
            (Blend::Multiply, _, other) if is(a, 1.0) => other,
            (Blend::Multiply, other, _) if is(b, 1.0) => other,
            (Blend::Add, _, other) if is(a, 0.0) => other,
            (Blend::Add, other, _) if is(b, 0.0) => other,
            _ => {
                let factor = ONE;
                let at = self.emit(Operation::Mix {
                    blend,
                    factor,
                    a,
                    b,
                });
                Operand::Register(at, Lane::Rgb)
            }
        }
    }

    pub(super) fn finish(mut self, roots: &mut [&mut Root]) -> Program {
        let program = &mut self.program;
        while (program.operations.len() >> program.shift) >= 64 {
            program.shift += 1;
        }
        narrow(&mut program.operations, &program.calls, roots);
        let block = |operand: Operand| match operand {
            Operand::Constant(_) => 0u64,
            Operand::Register(at, _) => 1 << (at >> program.shift),
        };
        // What each block takes from others.
        let mut takes = [0u64; 64];
        for (at, operation) in program.operations.iter().enumerate() {
            let takes = &mut takes[at >> program.shift];
            operation.each_taken(&program.calls, |operand| *takes |= block(operand));
        }
        for root in roots {
            root.needs = block(root.operand);
            for at in (0..64).rev() {
                if root.needs >> at & 1 == 1 {
                    root.needs |= takes[at];
                }
            }
        }
        self.program
    }
}

/// The program of a graph's displacement, a vector in the world (Blender's axes); `None` where it has none.
pub fn displacement(graph: &Graph, source: &mut impl Source) -> Option<(Program, Root)> {
    Some(program_of(graph, graph.displacement?, source))
}

/// The program of one value.
fn program_of(graph: &Graph, link: Link, source: &mut impl Source) -> (Program, Root) {
    let mut heights = 0;
    let mut compiler = Compiler::new(graph, source, &mut heights);
    let mut root = root(compiler.operand(link.into()));
    let program = compiler.finish(&mut [&mut root]);
    (program, root)
}

impl Operation {
    /// Calls for each operand that it takes.
    fn each_taken(&self, calls: &[Call], mut take: impl FnMut(Operand)) {
        match *self {
            Self::Image(_) | Self::Alpha(_) | Self::VertexColor => {}
            Self::ImageAt { at, .. } | Self::TiledImage { at, .. } => take(at),
            Self::Math { a, b, .. } => [a, b].into_iter().for_each(take),
            Self::Mix { factor, a, b, .. } => [factor, a, b].into_iter().for_each(take),
            Self::NormalMap {
                color, strength, ..
            } => [color, strength].into_iter().for_each(take),
            Self::Tangent { direction, .. } => take(direction),
            Self::Outside(normal) | Self::Turned(normal) | Self::Facing(normal) => take(normal),
            Self::Call(number) | Self::Compute(number) => {
                calls[number as usize].operands().for_each(take);
            }
        }
    }
}

impl Program {
    /// Whether a normal is a vector that is the same everywhere, where it stands outside when it is asked for.
    pub fn is_known_vector(&self, normal: &Root) -> bool {
        let mut known: Vec<bool> = Vec::with_capacity(self.operations.len());
        let is_known = |known: &[bool], operand: Operand| match operand {
            Operand::Constant(_) => true,
            Operand::Register(at, _) => known.get(at as usize).is_some_and(|&known| known),
        };
        for operation in &self.operations {
            let mut is_computed = matches!(
                operation,
                Operation::Math { .. } | Operation::Mix { .. } | Operation::Compute(_)
            );
            operation.each_taken(&self.calls, |taken| is_computed &= is_known(&known, taken));
            known.push(is_computed);
        }
        match normal.operand {
            Operand::Constant(_) => true,
            Operand::Register(at, _) => match self.operations[at as usize] {
                Operation::Outside(vector) => is_known(&known, vector),
                _ => false,
            },
        }
    }
}

/// The vector that a Mapping leaves as it is, as most do that nobody has touched.
fn unmapped(function: &Function, inputs: &[(Operand, SocketKind)]) -> Option<Operand> {
    let known = |socket: usize| match inputs[socket].0 {
        Operand::Constant(value) => Some(value.truncate()),
        Operand::Register(..) => None,
    };
    function.gives_its_first(known).then(|| match inputs[0].0 {
        // What is read of it as a number is the mean of a vector, not the luminance of a colour.
        Operand::Register(at, Lane::Rgb) => Operand::Register(at, Lane::Xyz),
        other => other,
    })
}

fn is_displacement(kind: &NodeKind) -> bool {
    matches!(kind, NodeKind::Function(Function::Displacement { .. }))
}

/// Where an image's opacity is all that is taken of it, its colours are not looked up.
fn narrow(operations: &mut [Operation], calls: &[Call], roots: &[&mut Root]) {
    let mut is_color = vec![false; operations.len()];
    let mut read = |operand: Operand| {
        if let Operand::Register(at, lane) = operand {
            is_color[at as usize] |= lane != Lane::One(3);
        }
    };
    for operation in operations.iter() {
        operation.each_taken(calls, &mut read);
    }
    roots.iter().for_each(|root| read(root.operand));
    for (operation, is_color) in operations.iter_mut().zip(is_color) {
        if let Operation::Image(number) = *operation
            && !is_color
        {
            *operation = Operation::Alpha(number);
        }
    }
}

/// Before [`Compiler::finish`] says what it needs.
pub(super) fn root(operand: Operand) -> Root {
    Root { operand, needs: 0 }
}

/// What a surface's program makes: its shaders, and perhaps what it emits.
type Made = (Program, Vec<Weighted>, Option<Shining>);

/// The program of what scatters. It makes what is emitted as well where both look at the same images or compute the same.
fn surface(
    graph: &Graph,
    space: WorkingSpace,
    source: &mut impl Source,
    emission: &Emission,
) -> Made {
    let apart = surface_with(graph, space, source, false);
    if apart.0.is_constant() || emission.program.is_constant() {
        return apart;
    }
    let together = surface_with(graph, space, source, true);
    let work = |program: &Program| program.calls.len() + program.textures.len();
    if work(&together.0) < work(&apart.0) + work(&emission.program) {
        together
    } else {
        apart
    }
}

fn surface_with(
    graph: &Graph,
    space: WorkingSpace,
    source: &mut impl Source,
    shines: bool,
) -> Made {
    let mut heights = 0;
    let mut compiler = Compiler::new(graph, source, &mut heights);
    let mut shaders: Vec<Weighted> = Vec::new();
    for (at, weight) in compiler.body() {
        if let Some(shader) = shader(&mut compiler, at, space) {
            shaders.push(Weighted {
                weight: root(weight),
                shader,
            });
        }
    }
    let mut shining = shines.then(|| shining(&mut compiler));
    let mut roots: Vec<&mut Root> = shaders.iter_mut().flat_map(roots_of).collect();
    roots.extend(shining.iter_mut().flat_map(Shining::roots));
    let program = compiler.finish(&mut roots);
    (program, shaders, shining)
}

/// Compiles a material's graph. It is folded first: what is known is no operation.
pub fn compile(graph: &Graph, mut known: Known, source: &mut impl Source) -> Programs {
    let mut folded = graph.clone();
    graph::fold(&mut folded, &mut known);
    let emission = emission_of(&folded, source);
    let (surface, shaders, shining) = surface(&folded, known.space, source, &emission);
    let opacity = opacity(&folded, source);
    let normal = folded.normal.map(|link| program_of(&folded, link, source));
    Programs {
        surface,
        shaders,
        opacity,
        emission,
        shining,
        normal: normal.filter(|(program, _)| !program.is_constant()),
        aovs: aovs(&folded, source),
    }
}
