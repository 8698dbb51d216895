//! Operations that are calls of nodes' functions.

use super::{Evaluation, Openness, Operand, Place, Program, Root};
use crate::scene::graph::function::{
    DisplacementSpace, PlaceInput, RayPart, Space, Transformed, bump,
};
use crate::scene::graph::{Function, SocketKind, TangentKind};
use crate::shading::fresnel;
use glam::{Vec2, Vec3, Vec4};

/// More inputs no node has.
const MOST_INPUTS: usize = 16;

/// A node's function with what stands in its sockets.
#[derive(Clone, Debug)]
pub struct Call {
    /// What it computes.
    pub function: Function,
    /// Where its inputs come from, and what they are taken as.
    pub inputs: Vec<(Operand, SocketKind)>,
    /// Of a Bump: what is evaluated at its neighbours too.
    pub height: Option<Box<Height>>,
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
    /// What it asks about the place, with what is behind its bump.
    pub fn place_inputs(&self) -> Vec<PlaceInput> {
        let mut inputs = match self.function {
            Function::Place(input) => vec![input],
            Function::LightFalloff { .. } => vec![PlaceInput::RayLength],
            Function::Fresnel | Function::LayerFresnel | Function::LayerFacing => {
                vec![PlaceInput::Incoming]
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
    #[inline(never)]
    pub(super) fn call(&self, call: &Call) -> Vec4 {
        let mut inputs = [Vec4::ZERO; MOST_INPUTS];
        for (input, (operand, kind)) in inputs.iter_mut().zip(&call.inputs) {
            *input = match kind {
                SocketKind::Float => Vec4::splat(self.read_number(*operand)),
                _ => self.read_color(*operand).extend(1.0),
            };
        }
        let inputs = &inputs[..call.inputs.len()];
        if let Some(result) = call.function.evaluate(inputs) {
            return result;
        }
        let place = self.place;
        match &call.function {
            Function::Place(input) => place.input(*input),
            Function::VectorTransform { what, from, to } => place
                .transformed(inputs[0].truncate(), *what, *from, *to)
                .extend(1.0),
            Function::LightFalloff { power } => {
                let length = place.input(PlaceInput::RayLength).x;
                Vec4::splat(falloff(*power, length, inputs[0].x, inputs[1].x))
            }
            Function::Fresnel | Function::LayerFresnel | Function::LayerFacing => {
                Vec4::splat(self.by_angle(&call.function, inputs))
            }
            Function::Bump {
                invert,
                object_space,
                undisplaced,
                ..
            } => call.height().map_or(Vec4::ZERO, |height| {
                let sign = if *invert { -1.0 } else { 1.0 };
                let before = undisplaced.map(|attribute| place.undisplaced(attribute));
                let place = before.as_ref().unwrap_or(place);
                bump(place, inputs, height, (sign, *object_space)).extend(1.0)
            }),
            Function::Displacement { object_space } => {
                let [height, middle, scale] = [0, 1, 2].map(|socket: usize| inputs[socket].x);
                let normal = place.facing(inputs[3].truncate());
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
                let by = (inputs[0].truncate() - inputs[1].x) * inputs[2].x;
                moved(place, by, *space).extend(1.0)
            }
            Function::AmbientOcclusion {
                samples,
                inside,
                only_local,
            } => {
                let normal = place.facing(inputs[2].truncate());
                let rays = Openness {
                    samples: *samples,
                    only_local: *only_local,
                };
                let side = if *inside { -normal } else { normal };
                let open = place.openness(side, inputs[1].x, rays);
                (inputs[0].truncate() * open).extend(open)
            }
            Function::Bevel { samples } => {
                let normal = place.facing(inputs[1].truncate());
                let own = place.facing(Vec3::ZERO);
                let beveled = place.beveled(inputs[0].x, *samples);
                (normal + beveled - own).normalize_or(own).extend(1.0)
            }
            Function::Raycast { only_local, part } => {
                let [from, direction] = [0, 1].map(|socket: usize| inputs[socket].truncate());
                let length = inputs[2].x;
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
                Vec4::splat(f32::from(place.is_on_edge(inputs[0].x, *pixels)))
            }
            _ => Vec4::ZERO,
        }
    }

    /// Fresnel and Layer Weight.
    fn by_angle(&self, function: &Function, inputs: &[Vec4]) -> f32 {
        let place = self.place;
        let normal = place.facing(inputs[1].truncate());
        let cos = place.input(PlaceInput::Incoming).truncate().dot(normal);
        let behind = place.input(PlaceInput::Backfacing).x != 0.0;
        let number = inputs[0].x;
        match function {
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
    inputs: &[Vec4],
    height: &Height,
    (sign, object_space): (f32, bool),
) -> Vec3 {
    let mut normal = place.facing(inputs[bump::NORMAL].truncate());
    let width = inputs[bump::FILTER_WIDTH].x;
    let mut steps = place.steps(width.abs());
    let at = |place: &P| height.program.at(place, |at| at.number(&height.root));
    let here = if height.is_known_here {
        inputs[bump::HEIGHT].x
    } else {
        at(place)
    };
    let rises = steps.map(|step| at(&place.neighbour(step)) - here);
    if object_space {
        let own = |v, what| place.transformed(v, what, Space::World, Space::Object);
        normal = own(normal, Transformed::Normal);
        steps = steps.map(|step| own(step, Transformed::Vector));
    }
    let [to_x, to_y] = steps;
    let (across_x, across_y) = (to_y.cross(normal), normal.cross(to_x));
    let det = to_x.dot(across_x);
    let gradient = across_x * rises[0] + across_y * rises[1];
    let distance = inputs[bump::DISTANCE].x * sign;
    let strength = inputs[bump::STRENGTH].x.max(0.0);
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
