//! Operations that are calls of nodes' functions.

use super::{Evaluation, Openness, Operand, Place, Program, Root};
use crate::math::{average, luminance};
use crate::scene::graph::function::{
    DisplacementSpace, PlaceInput, RayPart, Sockets, Space, Transformed, bump,
};
use crate::scene::graph::{Function, Lane, SocketKind, TangentKind};
use crate::shading::fresnel;
use glam::{Vec2, Vec3, Vec4};

/// What a socket takes of four numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// One of them.
    One,
    /// A vector or a colour.
    Vector,
    /// The luminance of a colour, as a number.
    Luminance,
    /// The mean of a vector, as a number.
    Mean,
}

/// Where what stands in a socket is found.
#[derive(Clone, Copy, Debug)]
struct Taken {
    /// The first number that is taken, of all registers' or of all constants' numbers: no lane has to be chosen at a hit.
    at: u32,
    is_constant: bool,
    part: Part,
}

impl Taken {
    /// That of sockets which a function does not have.
    const NOTHING: Self = Self {
        at: 0,
        is_constant: true,
        part: Part::One,
    };
}

/// The sockets of the node that has most, which is Brick.
const MOST_SOCKETS: usize = 10;

/// A node's function with what stands in its sockets.
#[derive(Clone, Debug)]
pub struct Call {
    /// What it computes.
    pub function: Function,
    /// As many for each function: no socket has to be looked for at a hit.
    taken: [Taken; MOST_SOCKETS],
    constants: Vec<Vec4>,
    /// Of a Bump: what is evaluated at its neighbours too.
    pub height: Option<Box<Height>>,
    /// Its normal is a vector on the viewer's side in Blender's axes, of any length: one of 0 is not the surface's own.
    pub takes_vector: bool,
}

/// The sockets of a call: what is known, and registers.
struct Filled<'a> {
    taken: &'a [Taken; MOST_SOCKETS],
    /// Registers and constants.
    files: [&'a [Vec4]; 2],
}

impl Filled<'_> {
    #[inline(always)]
    fn at(&self, socket: usize) -> (Taken, &[Vec4]) {
        let taken = self.taken[socket];
        (taken, self.files[usize::from(taken.is_constant)])
    }

    /// A number that is made of three.
    #[inline(always)]
    fn reduced(part: Part, value: Vec3) -> f32 {
        match part {
            Part::Mean => average(value),
            _ => luminance(value),
        }
    }
}

impl Sockets for Filled<'_> {
    #[inline(always)]
    fn number(&self, socket: usize) -> f32 {
        let (taken, file) = self.at(socket);
        match taken.part {
            Part::One | Part::Vector => bytemuck::cast_slice::<Vec4, f32>(file)[taken.at as usize],
            part => Self::reduced(part, file[taken.at as usize / 4].truncate()),
        }
    }

    #[inline(always)]
    fn vector(&self, socket: usize) -> Vec3 {
        let (taken, file) = self.at(socket);
        match taken.part {
            Part::Vector => file[taken.at as usize / 4].truncate(),
            _ => Vec3::splat(self.number(socket)),
        }
    }
}

/// The height that a Bump asks for.
#[derive(Clone, Debug)]
pub struct Height {
    /// Its operations.
    pub program: Program,
    /// Where the height is.
    pub root: Root,
    /// Whether the Bump's own input is the height at the place itself, so that only its neighbours are left.
    pub is_known_here: bool,
}

impl Call {
    /// A function of operands and what its sockets take them as.
    pub fn new(
        function: Function,
        inputs: Vec<(Operand, SocketKind)>,
        height: Option<Box<Height>>,
    ) -> Self {
        let mut constants = Vec::new();
        debug_assert!(inputs.len() <= MOST_SOCKETS, "{function:?}");
        let mut taken = [Taken::NOTHING; MOST_SOCKETS];
        let found = inputs.into_iter().map(|(operand, kind)| {
            let is_number = kind == SocketKind::Float;
            match operand {
                Operand::Constant(value) => {
                    constants.push(value);
                    Taken {
                        at: 4 * (constants.len() as u32 - 1),
                        is_constant: true,
                        part: if is_number { Part::One } else { Part::Vector },
                    }
                }
                Operand::Register(register, lane) => {
                    let (lane, part) = match lane {
                        Lane::One(lane) => (u32::from(lane), Part::One),
                        Lane::Rgb if is_number => (0, Part::Luminance),
                        Lane::Xyz if is_number => (0, Part::Mean),
                        Lane::Mean => (0, Part::Mean),
                        Lane::Rgb | Lane::Xyz => (0, Part::Vector),
                    };
                    Taken {
                        at: 4 * register + lane,
                        is_constant: false,
                        part,
                    }
                }
            }
        });
        for (taken, found) in taken.iter_mut().zip(found) {
            *taken = found;
        }
        Self {
            function,
            taken,
            constants,
            height,
            takes_vector: false,
        }
    }

    /// The registers that it reads, each as a vector where it is read as one.
    pub(super) fn operands(&self) -> impl Iterator<Item = Operand> {
        let registers = self.taken.iter().filter(|taken| !taken.is_constant);
        registers.map(|taken| {
            let lane = match taken.part {
                Part::One => Lane::One((taken.at % 4) as u8),
                _ => Lane::Rgb,
            };
            Operand::Register(taken.at / 4, lane)
        })
    }

    /// The normal in a socket, in Blender's axes and on the viewer's side.
    fn normal(&self, inputs: &Filled, socket: usize, place: &impl Place) -> Vec3 {
        let normal = inputs.vector(socket);
        if self.takes_vector {
            normal
        } else {
            place.facing(normal)
        }
    }

    fn filled<'a>(&'a self, registers: &'a [Vec4]) -> Filled<'a> {
        Filled {
            taken: &self.taken,
            files: [registers, &self.constants],
        }
    }

    /// The result of what depends on its sockets alone.
    #[inline]
    pub(super) fn of_numbers(&self, registers: &[Vec4]) -> Vec4 {
        self.function.of_numbers(&self.filled(registers))
    }

    /// What it asks about the place, with what is behind its bump.
    pub fn place_inputs(&self) -> Vec<PlaceInput> {
        let mut inputs = match self.function {
            Function::Place(input) => vec![input],
            Function::LightFalloff { .. } => vec![PlaceInput::RayLength],
            Function::Fresnel | Function::LayerFresnel | Function::LayerFacing => {
                vec![PlaceInput::Incoming]
            }
            Function::VectorTransform { from, to, .. } if [from, to].contains(&Space::Camera) => {
                vec![PlaceInput::Position, PlaceInput::Camera]
            }
            Function::VectorTransform { .. }
            | Function::Displacement { .. }
            | Function::VectorDisplacement(_)
            | Function::AmbientOcclusion { .. }
            | Function::Bevel { .. }
            | Function::Raycast { .. }
            | Function::Wireframe { .. } => vec![PlaceInput::Position],
            Function::Bump {
                undisplaced: Some(number),
                ..
            } => vec![PlaceInput::Attribute(number)],
            _ => Vec::new(),
        };
        if let Some(height) = &self.height {
            inputs.push(PlaceInput::Position);
            inputs.extend(height.program.place_inputs());
        }
        inputs
    }

    /// What its bump asks for.
    pub fn height(&self) -> Option<&Height> {
        self.height.as_deref()
    }
}

/// Layer Weight's and Fresnel's index, seen from one side.
fn index(ior: f32, from_behind: bool) -> f32 {
    let ior = ior.max(1e-5);
    if from_behind { 1.0 / ior } else { ior }
}

/// A strength by the length of the ray to the light, as Cycles' Light Falloff; light from infinity does not fall off.
fn falloff(power: i32, length: f32, strength: f32, smooth: f32) -> f32 {
    if length == f32::MAX {
        return strength;
    }
    let square = length * length;
    let smoothed = if smooth > 0.0 {
        square / (smooth + square)
    } else {
        1.0
    };
    strength * length.powi(power) * smoothed
}

impl<P: Place> Evaluation<'_, P> {
    /// The result of what depends on the place.
    #[inline]
    pub(super) fn call(&self, call: &Call) -> Vec4 {
        match &call.function {
            Function::Place(input) => self.place.input(*input),
            _ => self.ask(call),
        }
    }

    #[inline(never)]
    fn ask(&self, call: &Call) -> Vec4 {
        let inputs = &call.filled(self.registers);
        let place = self.place;
        match &call.function {
            Function::VectorTransform { what, from, to } => place
                .transformed(inputs.vector(0), *what, *from, *to)
                .extend(1.0),
            Function::LightFalloff { power } => {
                let length = place.input(PlaceInput::RayLength).x;
                Vec4::splat(falloff(*power, length, inputs.number(0), inputs.number(1)))
            }
            Function::Fresnel | Function::LayerFresnel | Function::LayerFacing => {
                Vec4::splat(self.by_angle(call, inputs))
            }
            Function::Bump {
                invert,
                object_space,
                undisplaced,
                is_of_5,
                ..
            } => call.height().map_or(Vec4::ZERO, |height| {
                let sign = if *invert { -1.0 } else { 1.0 };
                let before = undisplaced.map(|attribute| place.undisplaced(attribute, *is_of_5));
                let place = before.as_ref().unwrap_or(place);
                let normal = call.normal(inputs, bump::NORMAL, place);
                bump(place, (inputs, normal), height, (sign, *object_space)).extend(1.0)
            }),
            Function::Displacement { object_space } => {
                let [height, middle, scale] = [0, 1, 2].map(|socket| inputs.number(socket));
                let normal = call.normal(inputs, 3, place);
                let raised = (height - middle) * scale;
                if *object_space {
                    let own =
                        place.transformed(normal, Transformed::Normal, Space::World, Space::Object);
                    place.transformed(
                        own * raised,
                        Transformed::Vector,
                        Space::Object,
                        Space::World,
                    )
                } else {
                    normal * raised
                }
                .extend(1.0)
            }
            Function::VectorDisplacement(space) => {
                let by = (inputs.vector(0) - inputs.number(1)) * inputs.number(2);
                moved(place, by, *space).extend(1.0)
            }
            Function::AmbientOcclusion {
                samples,
                inside,
                only_local,
            } => {
                let mut normal = call.normal(inputs, 2, place);
                if call.takes_vector {
                    // Rays that go nowhere meet nothing.
                    let Some(unit) = normal.try_normalize() else {
                        return inputs.vector(0).extend(1.0);
                    };
                    normal = unit;
                }
                let rays = Openness {
                    samples: *samples,
                    only_local: *only_local,
                };
                let side = if *inside { -normal } else { normal };
                let open = place.openness(side, inputs.number(1), rays);
                (inputs.vector(0) * open).extend(open)
            }
            Function::Bevel { samples } => {
                let normal = call.normal(inputs, 1, place);
                let own = place.facing(Vec3::ZERO);
                let beveled = place.beveled(inputs.number(0), *samples);
                (normal + beveled - own).normalize_or(own).extend(1.0)
            }
            Function::Raycast { only_local, part } => {
                let [from, direction] = [0, 1].map(|socket| inputs.vector(socket));
                let length = inputs.number(2);
                let met = place.met((from, direction, length), *only_local);
                match (part, met) {
                    (RayPart::Hit, None) => Vec4::new(0.0, 0.0, length, 1.0),
                    (RayPart::Hit, Some(met)) => {
                        Vec4::new(1.0, f32::from(met.is_own), met.distance, 1.0)
                    }
                    (_, None) => Vec3::ZERO.extend(1.0),
                    (RayPart::Position, Some(met)) => (from + direction * met.distance).extend(1.0),
                    (RayPart::Normal, Some(met)) => met.normal.extend(1.0),
                }
            }
            Function::Wireframe { pixels } => {
                Vec4::splat(f32::from(place.is_on_edge(inputs.number(0), *pixels)))
            }
            _ => Vec4::ZERO,
        }
    }

    /// Fresnel and Layer Weight.
    fn by_angle(&self, call: &Call, inputs: &Filled) -> f32 {
        let place = self.place;
        let normal = call.normal(inputs, 1, place);
        let cos = place.input(PlaceInput::Incoming).truncate().dot(normal);
        let behind = place.input(PlaceInput::Backfacing).x != 0.0;
        let number = inputs.number(0);
        match call.function {
            Function::Fresnel => fresnel::of_cosine(cos.abs(), index(number, behind)).reflectance,
            Function::LayerFresnel => {
                let ior = index(1.0 - number, !behind);
                fresnel::of_cosine(cos.abs(), ior).reflectance
            }
            _ => {
                let blend = number.clamp(0.0, 1.0 - 1e-5);
                let power = if blend < 0.5 {
                    2.0 * blend
                } else {
                    0.5 / (1.0 - blend)
                };
                1.0 - cos.abs().powf(power)
            }
        }
    }
}

/// A displacement in the world, of a vector in some space.
fn moved(place: &impl Place, by: Vec3, space: DisplacementSpace) -> Vec3 {
    let own = match space {
        DisplacementSpace::World => return by,
        DisplacementSpace::Object => by,
        DisplacementSpace::Tangent => {
            let to_object = |v: Vec3, what| {
                let own = place.transformed(v, what, Space::World, Space::Object);
                own.normalize_or_zero()
            };
            let [tangent, bitangent] = [Vec2::X, Vec2::Y].map(|direction| {
                let outside = place.tangent(TangentKind::Uv, direction);
                // Its axes are glTF's.
                let world = Vec3::new(outside.x, -outside.z, outside.y);
                to_object(world, Transformed::Vector)
            });
            let normal = to_object(place.facing(Vec3::ZERO), Transformed::Normal);
            let across = normal.cross(tangent).normalize_or_zero();
            let across = across * across.dot(bitangent).signum();
            tangent * by.x + normal * by.y + across * by.z
        }
    };
    place.transformed(own, Transformed::Vector, Space::Object, Space::World)
}

/// The normal of a surface that is raised by a height, outside (Blender's Bump node; Mikkelsen, *Bump Mapping
/// Unparametrized Surfaces on the GPU*, 2010).
fn bump<P: Place>(
    place: &P,
    (inputs, mut normal): (&Filled, Vec3),
    height: &Height,
    (sign, object_space): (f32, bool),
) -> Vec3 {
    let width = inputs.number(bump::FILTER_WIDTH);
    let mut steps = place.steps(width.abs());
    let at = |place: &P| height.program.at(place, |at| at.number(&height.root));
    let here = if height.is_known_here {
        inputs.number(bump::HEIGHT)
    } else {
        at(place)
    };
    let rises = place.of_neighbours(steps, |place| at(place) - here);
    if object_space {
        let own = |v, what| place.transformed(v, what, Space::World, Space::Object);
        normal = own(normal, Transformed::Normal);
        steps = steps.map(|step| own(step, Transformed::Vector));
    }
    let [to_x, to_y] = steps;
    let (across_x, across_y) = (to_y.cross(normal), normal.cross(to_x));
    let det = to_x.dot(across_x);
    let gradient = across_x * rises[0] + across_y * rises[1];
    let distance = inputs.number(bump::DISTANCE) * sign;
    let strength = inputs.number(bump::STRENGTH).max(0.0);
    let raised = normal * det.abs() - gradient * (distance * det.signum());
    // Steps of a negative width turn the normal round, as in Cycles.
    let raised = (raised * width.signum()).try_normalize().unwrap_or(normal);
    let result = raised * strength + normal * (1.0 - strength);
    let mut result = result.try_normalize().unwrap_or(normal);
    if object_space {
        result = place.transformed(result, Transformed::Normal, Space::Object, Space::World);
    }
    place.outside(result)
}
