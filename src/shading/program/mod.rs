//! Shader graphs as flat programs, evaluated at hits.
//!
//! A program is a list of operations, each of which fills its own register from constants and from registers before it. A
//! socket of a shader knows which of them it needs, and they run when it is asked for: an image that nobody asks for is
//! not read. What is constant has no operations.

mod aovs;
mod call;
mod compile;
mod emission;
mod leaves;
mod projection;
mod shader;
mod shaders;
mod volume;

pub use aovs::Aovs;
pub use call::{Call, Height};
pub use compile::{Known, Source, compile, displacement};
pub use emission::{Covered, Emission, Shining};
pub use shader::parameters;
pub use shaders::{CoatRoots, LayerRoots, Shader, Weighted};
pub use volume::{AsksAbout, VolumeProgram};

use super::texture::PreparedTexture;
use crate::math::{average, luminance};
use crate::scene::graph::function::{DisplacementSpace, PlaceInput, Space, Transformed};
use crate::scene::graph::{
    Blend, Function, ImageProjection, Lane, MathOperation, NormalSpace, TangentKind,
};
use glam::{Vec2, Vec3, Vec4};

/// How the rays go that ask how open a place is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Openness {
    /// So many.
    pub samples: u8,
    /// They see the object alone.
    pub only_local: bool,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// The ray's own object.
    pub is_own: bool,
    /// In lengths of the direction.
    pub distance: f32,
    /// The smooth normal on the side that the ray comes from, in Blender's axes.
    pub normal: Vec3,
}

/// What shaders of hair ask about a place: of a strand, or of a mesh that they are on. Directions are in the world, in glTF's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strand {
    /// It is one.
    pub is_strand: bool,
    /// Along the strand, toward its tip, unit length. On meshes from the triangle's first corner to its second, as Cycles' derivative by
    /// u. Both the other way round seen from within.
    pub tangent: Vec3,
    /// On meshes from the first corner to the third, likewise: what the Hair BSDF follows there. 0 on strands.
    pub second: Vec3,
    /// Sine of the angle across flat strands, −1 to 1: Cycles' v of ribbons. 0 on round ones and on meshes.
    pub across: f32,
    /// Radius, metres; 0 on meshes.
    pub radius: f32,
    /// The strand's own number, 0 to 1: Cycles' random value of curves. 0 on meshes.
    pub random: f32,
    /// The curve's normal, which the greater axis of elliptic sections follows; 0 where there is none, and on meshes.
    pub normal: Vec3,
    /// For rays of the camera half the size of a pixel over the radius: below 1 a pixel has but a part of the width. 1 for all other
    /// rays, and on meshes.
    pub coverage: f32,
    /// Any number that differs from place to place, for estimates by random numbers: of the bits of where it was hit.
    pub seed: u32,
}

impl Strand {
    /// Of no surface.
    pub const NONE: Self = Self {
        is_strand: false,
        tangent: Vec3::X,
        second: Vec3::Y,
        across: 0.0,
        radius: 0.0,
        random: 0.0,
        normal: Vec3::ZERO,
        coverage: 1.0,
        seed: 0,
    };
}

/// What programs ask about the point that they are evaluated at.
pub trait Place {
    /// Texture coordinates of a set; (0, 0) where the mesh has none.
    fn uv(&self, set: u32) -> Vec2;
    /// Vertex colour; white where there is none.
    fn color(&self) -> Vec4;
    /// The normal outside of one in some space, at a strength; 0 where there is none.
    fn mapped_normal(&self, space: NormalSpace, normal: Vec3, strength: f32) -> Vec3;
    /// What a node asks about the place.
    fn input(&self, input: PlaceInput) -> Vec4;
    /// The normal in the object's space by which a box of images is seen: that of the hit, also where a Bump steps.
    fn box_normal(&self) -> Vec3 {
        self.input(PlaceInput::ObjectNormal).truncate()
    }
    /// A vector of one space in another.
    fn transformed(&self, v: Vec3, what: Transformed, from: Space, to: Space) -> Vec3;
    /// A normal outside, in Blender's axes and on the viewer's side; of 0 the surface's own.
    fn facing(&self, outside: Vec3) -> Vec3;
    /// The other way round, as a unit vector.
    fn outside(&self, facing: Vec3) -> Vec3;
    /// The same as long as it is.
    fn turned(&self, facing: Vec3) -> Vec3 {
        self.outside(facing) * facing.length()
    }
    /// The ways across the surface to its neighbours, so many pixels apart, in Blender's axes.
    fn steps(&self, pixels: f32) -> [Vec3; 2];
    /// A number of the neighbours at these steps.
    fn of_neighbours(&self, steps: [Vec3; 2], number: impl FnMut(&Self) -> f32) -> [f32; 2]
    where
        Self: Sized;
    /// The same point before it was displaced, by an attribute of the vertices; as in Cycles from 5.0 on, with the normals of flat
    /// faces, or as before.
    fn undisplaced(&self, attribute: u32, is_of_5: bool) -> Self
    where
        Self: Sized;
    /// The share of rays to the side of a normal in the world (Blender's axes) that meet nothing within a distance.
    fn openness(&self, normal: Vec3, distance: f32, rays: Openness) -> f32;
    /// The mean normal of the object within a radius, on the viewer's side, in Blender's axes.
    fn beveled(&self, radius: f32, samples: u8) -> Vec3;
    /// What a ray meets that goes from a place in a direction, so many lengths of that; all in Blender's axes. It sees its object
    /// alone, or all.
    fn met(&self, ray: (Vec3, Vec3, f32), only_local: bool) -> Option<Met>;
    /// Whether it lies on an edge of its triangle, of a width in metres or in pixels.
    fn is_on_edge(&self, width: f32, pixels: bool) -> bool;
    /// A direction along the surface; one of texture coordinates is turned by x and y in tangent space. 0 where there is none.
    fn tangent(&self, _kind: TangentKind, _direction: Vec2) -> Vec3 {
        Vec3::ZERO
    }
    /// What shaders of hair ask.
    fn strand(&self) -> Strand {
        Strand::NONE
    }
}

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operand {
    /// It is known.
    Constant(Vec4),
    /// Numbers of a register.
    Register(u32, Lane),
}

/// What fills a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation {
    /// A texture, by its number.
    Image(u32),
    /// The opacity of a texture, of which nobody takes more.
    Alpha(u32),
    /// A texture, by its number, at coordinates.
    ImageAt {
        /// Which.
        texture: u32,
        /// How it lies in their space.
        projection: ImageProjection,
        /// Where.
        at: Operand,
    },
    /// The texture of the square in which coordinates lie.
    TiledImage {
        /// The number of the list of squares.
        tiles: u32,
        /// How they lie in the space of the coordinates.
        projection: ImageProjection,
        /// Where.
        at: Operand,
    },
    /// What a node computes of its sockets alone: a call, by its number.
    Compute(u32),
    /// What a node asks about the place: a call, by its number.
    Call(u32),
    /// A normal on the viewer's side, in Blender's axes, as one outside.
    Outside(Operand),
    /// The same, for what takes vectors of any length.
    Turned(Operand),
    /// A normal outside as one on the viewer's side, in Blender's axes.
    Facing(Operand),
    /// The vertices' colour.
    VertexColor,
    /// Arithmetic of numbers.
    Math {
        /// Which.
        operation: MathOperation,
        /// Brought to 0..=1.
        clamp: bool,
        /// The first.
        a: Operand,
        /// The second.
        b: Operand,
    },
    /// A blend of colours.
    Mix {
        /// Which.
        blend: Blend,
        /// How much of it.
        factor: Operand,
        /// Below.
        a: Operand,
        /// Above.
        b: Operand,
    },
    /// A normal map.
    NormalMap {
        /// In which axes.
        space: NormalSpace,
        /// Its texel.
        color: Operand,
        /// Its strength.
        strength: Operand,
    },
    /// A direction along the surface.
    Tangent {
        /// What it follows.
        kind: TangentKind,
        /// A direction in tangent space, 0 to 1 for -1 to 1.
        direction: Operand,
    },
}

/// A value that is asked for, with the operations that it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Where it is.
    pub operand: Operand,
    /// A bit for each block of operations.
    needs: u64,
}

impl Root {
    /// A colour that is known.
    pub fn constant(&self) -> Option<Vec3> {
        match self.operand {
            Operand::Constant(value) => Some(value.truncate()),
            Operand::Register(..) => None,
        }
    }
}

/// A flat list of operations.
#[derive(Clone, Debug, Default)]
pub struct Program {
    operations: Vec<Operation>,
    textures: Vec<PreparedTexture>,
    /// Lists of UDIM's squares: their numbers, and those of their textures.
    tiled: Vec<Vec<(u32, u32)>>,
    calls: Vec<Call>,
    /// A block has 2 to the power of this many operations: there are 64 blocks at most.
    shift: u32,
}

/// Registers of most programs, on the stack.
const FEW: usize = 12;
/// Those of larger ones: each is set to 0 first, so that there are two sizes.
const SOME: usize = 28;
const MANY: usize = 64;

impl Program {
    /// Whether everything is known.
    pub fn is_constant(&self) -> bool {
        self.operations.is_empty()
    }

    /// How many operations there are.
    pub fn len(&self) -> usize {
        self.operations.len()
    }

    /// Whether there are no operations.
    pub fn is_empty(&self) -> bool {
        self.operations.is_empty()
    }

    /// Whether it has a normal map.
    pub fn has_normal_map(&self) -> bool {
        let is = |o: &Operation| matches!(o, Operation::NormalMap { .. });
        self.operations.iter().any(is) || self.heights().any(Self::has_normal_map)
    }

    /// The programs of its bumps' heights.
    fn heights(&self) -> impl Iterator<Item = &Program> {
        let heights = self.calls.iter().filter_map(Call::height);
        heights.map(|height| &height.program)
    }

    /// Whether some of its calls are Bumps.
    fn has_bumps(&self) -> bool {
        self.heights().next().is_some()
    }

    /// Whether it reads a tangent of some kind.
    pub fn reads_tangent(&self, kind: TangentKind) -> bool {
        let is = |o: &Operation| matches!(o, Operation::Tangent { kind: of, .. } if *of == kind);
        let calls = |call: &Call| {
            matches!(
                call.function,
                Function::Place(PlaceInput::UvTangent)
                    | Function::VectorDisplacement(DisplacementSpace::Tangent)
            )
        };
        self.operations.iter().any(is)
            || (kind == TangentKind::Uv && self.calls.iter().any(calls))
            || self.heights().any(|height| height.reads_tangent(kind))
    }

    /// The textures that it reads.
    pub fn textures(&self) -> &[PreparedTexture] {
        &self.textures
    }

    /// Whether it does more than glTF's materials call for.
    pub fn computes(&self) -> bool {
        let more = |operation: &Operation| {
            matches!(
                operation,
                Operation::ImageAt { .. }
                    | Operation::TiledImage { .. }
                    | Operation::Outside(_)
                    | Operation::Turned(_)
            )
        };
        !self.calls.is_empty() || self.operations.iter().any(more)
    }

    /// What its nodes ask about the place, those behind bumps included.
    pub fn place_inputs(&self) -> Vec<PlaceInput> {
        let of_operation = |operation: &Operation| match *operation {
            Operation::ImageAt {
                projection: ImageProjection::Box { .. },
                ..
            }
            | Operation::TiledImage {
                projection: ImageProjection::Box { .. },
                ..
            } => [Some(PlaceInput::ObjectNormal), None],
            Operation::NormalMap {
                space: NormalSpace::Object | NormalSpace::Tangent | NormalSpace::Spread,
                ..
            } => [Some(PlaceInput::Object), None],
            Operation::NormalMap {
                space: NormalSpace::Before(number),
                ..
            } => [
                Some(PlaceInput::Object),
                Some(PlaceInput::Attribute(number)),
            ],
            _ => [None; 2],
        };
        let of_calls = self.calls.iter().flat_map(Call::place_inputs);
        let of_operations = self.operations.iter().flat_map(of_operation).flatten();
        of_calls.chain(of_operations).collect()
    }

    /// Whether its nodes ask the scene by rays.
    pub fn traces(&self) -> bool {
        let asks = |call: &Call| {
            matches!(
                call.function,
                Function::AmbientOcclusion { .. }
                    | Function::Bevel { .. }
                    | Function::Raycast { .. }
            )
        };
        self.calls.iter().any(asks) || self.heights().any(Self::traces)
    }

    /// Whether some of its Bumps are widened.
    pub fn is_widened(&self) -> bool {
        let is = |call: &Call| matches!(call.function, Function::Bump { widened: true, .. });
        self.calls.iter().any(is) || self.heights().any(Self::is_widened)
    }

    /// How many sets of texture coordinates it reads.
    pub fn uv_sets(&self) -> usize {
        let textures = self.textures.iter().map(|t| t.uv_set as usize + 1);
        let inputs = self.place_inputs().into_iter().map(|input| match input {
            PlaceInput::Uv(set) => set as usize + 1,
            _ => 0,
        });
        let heights = self.heights().map(Self::uv_sets);
        textures.chain(inputs).chain(heights).fold(0, usize::max)
    }

    /// Evaluates at a place what is asked for.
    #[inline]
    pub fn at<P: Place, T>(&self, place: &P, ask: impl FnOnce(&mut Evaluation<'_, P>) -> T) -> T {
        if self.operations.len() > FEW {
            return self.at_many(place, ask);
        }
        let mut few = [Vec4::ZERO; FEW];
        ask(&mut Evaluation {
            program: self,
            place,
            done: 0,
            registers: &mut few,
        })
    }

    /// The same where what was `computed` at this place is known; it starts with nothing.
    pub fn again<P: Place, T>(
        &self,
        place: &P,
        computed: &mut Computed,
        ask: impl FnOnce(&mut Evaluation<'_, P>) -> T,
    ) -> T {
        let Computed { done, some, all } = computed;
        let count = self.operations.len();
        let registers = if count <= SOME {
            &mut some[..]
        } else {
            all.resize(count, Vec4::ZERO);
            &mut all[..]
        };
        let mut evaluation = Evaluation {
            program: self,
            place,
            done: *done,
            registers,
        };
        let answer = ask(&mut evaluation);
        *done = evaluation.done;
        answer
    }

    /// The same for larger programs.
    #[cold]
    #[inline(never)]
    fn at_many<P: Place, T>(&self, place: &P, ask: impl FnOnce(&mut Evaluation<'_, P>) -> T) -> T {
        let (mut some, mut many, mut all);
        let registers = if self.operations.len() <= SOME {
            some = [Vec4::ZERO; SOME];
            &mut some[..]
        } else if self.operations.len() <= MANY {
            many = [Vec4::ZERO; MANY];
            &mut many[..]
        } else {
            all = vec![Vec4::ZERO; self.operations.len()];
            &mut all[..]
        };
        ask(&mut Evaluation {
            program: self,
            place,
            done: 0,
            registers,
        })
    }
}

/// What a program has computed at a place, for whoever asks there again.
#[derive(Default)]
pub struct Computed {
    /// Blocks that have run.
    done: u64,
    some: [Vec4; SOME],
    /// In place of `some`, for larger programs.
    all: Vec<Vec4>,
}

/// A program at a place.
pub struct Evaluation<'a, P> {
    program: &'a Program,
    place: &'a P,
    /// Blocks that have run.
    done: u64,
    registers: &'a mut [Vec4],
}

impl<P: Place> Evaluation<'_, P> {
    /// Where.
    pub fn place(&self) -> &P {
        self.place
    }

    /// A colour or a direction.
    #[inline]
    pub fn color(&mut self, root: &Root) -> Vec3 {
        self.run(root.needs);
        self.read_color(root.operand)
    }

    /// A number.
    #[inline]
    pub fn number(&mut self, root: &Root) -> f32 {
        self.run(root.needs);
        self.read_number(root.operand)
    }

    #[inline]
    fn read_color(&self, operand: Operand) -> Vec3 {
        match operand {
            Operand::Constant(value) => value.truncate(),
            Operand::Register(at, Lane::Rgb | Lane::Xyz) => self.registers[at as usize].truncate(),
            Operand::Register(at, Lane::Mean) => Vec3::splat(self.mean(at)),
            Operand::Register(at, Lane::One(i)) => {
                Vec3::splat(self.registers[at as usize][usize::from(i)])
            }
        }
    }

    #[inline]
    fn read_number(&self, operand: Operand) -> f32 {
        match operand {
            Operand::Constant(value) => value.x,
            Operand::Register(at, Lane::One(i)) => self.registers[at as usize][usize::from(i)],
            Operand::Register(at, Lane::Rgb) => luminance(self.registers[at as usize].truncate()),
            Operand::Register(at, Lane::Xyz | Lane::Mean) => self.mean(at),
        }
    }

    #[inline]
    fn mean(&self, at: u32) -> f32 {
        average(self.registers[at as usize].truncate())
    }

    #[inline]
    fn run(&mut self, needs: u64) {
        let mut missing = needs & !self.done;
        self.done |= needs;
        while missing != 0 {
            let first = (missing.trailing_zeros() as usize) << self.program.shift;
            missing &= missing - 1;
            let last = (first + (1 << self.program.shift)).min(self.program.operations.len());
            for at in first..last {
                // Cut-outs ask for little else, many times for each path.
                let value = match self.program.operations[at] {
                    Operation::Math {
                        operation,
                        clamp,
                        a,
                        b,
                    } => self.math(operation, clamp, a, b),
                    Operation::Compute(call) => {
                        self.program.calls[call as usize].of_numbers(self.registers)
                    }
                    _ => self.operate(at),
                };
                self.registers[at] = value;
            }
        }
    }

    #[inline(always)]
    fn math(&self, operation: MathOperation, clamp: bool, a: Operand, b: Operand) -> Vec4 {
        let result = operation.of(self.read_number(a), self.read_number(b));
        Vec4::splat(if clamp {
            result.clamp(0.0, 1.0)
        } else {
            result
        })
    }

    #[inline(never)]
    fn operate(&self, at: usize) -> Vec4 {
        match self.program.operations[at] {
            Operation::Image(number) => {
                let texture = &self.program.textures[number as usize];
                texture.read(self.place.uv(texture.uv_set))
            }
            Operation::Alpha(number) => {
                let texture = &self.program.textures[number as usize];
                Vec4::splat(texture.read_alpha(self.place.uv(texture.uv_set)))
            }
            Operation::ImageAt {
                texture,
                projection,
                at,
            } => {
                let texture = &self.program.textures[texture as usize];
                projection::read(projection, self.read_color(at), self.place, |uv| {
                    texture.read_upwards(uv)
                })
            }
            Operation::TiledImage {
                tiles,
                projection,
                at,
            } => {
                let tiles = &self.program.tiled[tiles as usize];
                projection::read(projection, self.read_color(at), self.place, |uv| {
                    projection::tile(tiles, uv).map_or(projection::MISSING, |(texture, uv)| {
                        self.program.textures[texture as usize].read_upwards(uv)
                    })
                })
            }
            Operation::Compute(call) => {
                self.program.calls[call as usize].of_numbers(self.registers)
            }
            Operation::Call(call) => self.call(&self.program.calls[call as usize]),
            Operation::Outside(normal) => self.place.outside(self.read_color(normal)).extend(1.0),
            Operation::Turned(normal) => self.place.turned(self.read_color(normal)).extend(1.0),
            Operation::Facing(normal) => self.place.facing(self.read_color(normal)).extend(1.0),
            Operation::VertexColor => self.place.color(),
            Operation::Math {
                operation,
                clamp,
                a,
                b,
            } => self.math(operation, clamp, a, b),
            Operation::Mix {
                blend,
                factor,
                a,
                b,
            } => {
                let (a, b) = (self.read_color(a), self.read_color(b));
                blend.of(self.read_number(factor), a, b).extend(1.0)
            }
            Operation::NormalMap {
                space,
                color,
                strength,
            } => {
                let normal = self.read_color(color) * 2.0 - 1.0;
                let strength = self.read_number(strength);
                let mapped = self.place.mapped_normal(space, normal, strength);
                mapped.extend(1.0)
            }
            Operation::Tangent { kind, direction } => {
                let direction = self.read_color(direction) * 2.0 - 1.0;
                self.place.tangent(kind, direction.truncate()).extend(1.0)
            }
        }
    }
}

/// The colour of what is reflected: files of floats may hold negative ones, which count as 0, as in Cycles. What is not a
/// number stays so, and is counted where it arises.
#[inline]
pub fn reflected(color: Vec3) -> Vec3 {
    Vec3::select(color.cmplt(Vec3::ZERO), Vec3::ZERO, color)
}

/// The light that passes straight on, and the share that does not.
#[derive(Clone, Debug)]
pub struct Opacity {
    /// Its operations.
    pub program: Program,
    /// What passes straight on, as a colour.
    pub transmittance: Root,
    /// The share of the rest.
    pub rest: Root,
    /// What portals take of it, as a colour, if there are any.
    pub portal: Option<Root>,
    /// The share of the whole that holdouts empty, if there are any.
    pub holdout: Option<Root>,
}

/// A material's programs.
#[derive(Clone, Debug)]
pub struct Programs {
    /// Operations of what scatters.
    pub surface: Program,
    /// What scatters: the shaders that are not transparent.
    pub shaders: Vec<Weighted>,
    /// Where light passes straight on.
    pub opacity: Option<Opacity>,
    /// What is emitted.
    pub emission: Emission,
    /// The same as values of `surface`, where that computes some of it anyway: for hits that ask for both.
    pub shining: Option<Shining>,
    /// The normal outside in the place of the surface's own, if it has one.
    pub normal: Option<(Program, Root)>,
    /// What is told to passes of the scene's own, if anything is.
    pub aovs: Option<Box<Aovs>>,
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/program/mod.rs"]
mod tests;
