//! Operations that are calls of nodes' functions.

use super::{Evaluation, Operand, Place, Program, Root};
use crate::scene::graph::function::{PlaceInput, bump};
use crate::scene::graph::{Function, SocketKind};
use crate::shading::fresnel;
use glam::{Vec3, Vec4};

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
            Function::VectorTransform { .. } => vec![PlaceInput::Position],
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
            } => call.height().map_or(Vec4::ZERO, |height| {
                let sign = if *invert { -1.0 } else { 1.0 };
                self.bump(inputs, height, sign, *object_space).extend(1.0)
            }),
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
            Function::Fresnel => fresnel::dielectric(cos.abs(), index(number, behind)).reflectance,
            Function::LayerFresnel => {
                let ior = index(1.0 - number, !behind);
                fresnel::dielectric(cos.abs(), ior).reflectance
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

    /// The normal of a surface that is raised by a height, outside (Blender's Bump node; Mikkelsen, *Bump Mapping
    /// Unparametrized Surfaces on the GPU*, 2010).
    fn bump(&self, inputs: &[Vec4], height: &Height, sign: f32, object_space: bool) -> Vec3 {
        let place = self.place;
        let normal = place.facing(inputs[bump::NORMAL].truncate());
        let [to_x, to_y] = place.steps(inputs[bump::FILTER_WIDTH].x);
        let at = |place: &P| height.program.at(place, |at| at.number(&height.root));
        let here = at(place);
        let rises = [to_x, to_y].map(|step| at(&place.neighbour(step)) - here);
        let (across_x, across_y) = (to_y.cross(normal), normal.cross(to_x));
        let det = to_x.dot(across_x);
        let gradient = across_x * rises[0] + across_y * rises[1];
        let mut distance = inputs[bump::DISTANCE].x * sign;
        if object_space {
            distance *= place.object_scale();
        }
        let strength = inputs[bump::STRENGTH].x.max(0.0);
        let raised = normal * det.abs() - gradient * (distance * det.signum());
        let raised = raised.try_normalize().unwrap_or(normal);
        let result = raised * strength + normal * (1.0 - strength);
        place.outside(result.try_normalize().unwrap_or(normal))
    }
}
