//! What nodes compute of numbers alone.

use super::Function;
use crate::math::luminance;
use crate::nodes::color::{bright_contrast, gamma, hue_saturation, invert};
use crate::nodes::curve::Curves;
use crate::nodes::math::Math;
use crate::nodes::mix::BlendMode;
use crate::nodes::radial_tiling::radial_tiling;
use crate::nodes::range::{RangeKind, between};
use crate::nodes::vector::Mapping;
use crate::nodes::whole::whole;
use glam::{Vec3, Vec4};

fn clamped(value: f32, clamp: bool) -> f32 {
    if clamp { value.clamp(0.0, 1.0) } else { value }
}

/// The Math node.
#[inline(never)]
fn math<S: Sockets + ?Sized>(operation: Math, clamp: bool, inputs: &S) -> Vec4 {
    let third = if operation.takes_three() {
        inputs.number(2)
    } else {
        0.0
    };
    let result = operation.of(inputs.number(0), inputs.number(1), third);
    Vec4::splat(clamped(result, clamp))
}

/// The Map Range node for numbers.
#[inline(never)]
fn map_range<S: Sockets + ?Sized>(kind: RangeKind, clamp: bool, inputs: &S) -> Vec4 {
    let number = |socket: usize| inputs.number(socket);
    let steps = match kind {
        RangeKind::Stepped => number(5),
        _ => 0.0,
    };
    let (from, to) = ((number(1), number(2)), (number(3), number(4)));
    Vec4::splat(kind.of(number(0), from, to, steps, clamp))
}

/// The Mix node for colours; its factor and its result can be clamped.
#[inline(never)]
fn mixed<S: Sockets + ?Sized>(blend: BlendMode, clamps: [bool; 2], inputs: &S) -> Vec4 {
    let factor = clamped(inputs.number(0), clamps[0]);
    let mixed = blend.of(factor, inputs.vector(1), inputs.vector(2));
    if clamps[1] {
        mixed.clamp(Vec3::ZERO, Vec3::ONE)
    } else {
        mixed
    }
    .extend(1.0)
}

/// The node Hue/Saturation/Value.
#[inline(never)]
fn hue_saturated<S: Sockets + ?Sized>(inputs: &S) -> Vec4 {
    let [hue, saturation, value, factor] = [0, 1, 2, 3].map(|socket| inputs.number(socket));
    hue_saturation(hue, saturation, value, factor, inputs.vector(4)).extend(1.0)
}

/// The nodes RGB Curves and Vector Curves.
#[inline(never)]
fn curved<S: Sockets + ?Sized>(curves: &Curves, inputs: &S) -> Vec4 {
    let (factor, given) = (inputs.number(0), inputs.vector(1));
    (given * (1.0 - factor) + curves.of(given) * factor).extend(1.0)
}

/// What stands in the sockets of a node.
pub trait Sockets {
    /// The number of a socket for numbers; the first one of another.
    fn number(&self, socket: usize) -> f32;
    /// The vector or the colour of a socket; a number stands in all places.
    fn vector(&self, socket: usize) -> Vec3;
}

impl Sockets for [Vec4] {
    fn number(&self, socket: usize) -> f32 {
        self[socket].x
    }

    fn vector(&self, socket: usize) -> Vec3 {
        self[socket].truncate()
    }
}

impl Function {
    /// The result, from what stands in the sockets; a number stands in all places. `None` where it depends on the place
    /// that is shaded.
    pub fn evaluate(&self, inputs: &[Vec4]) -> Option<Vec4> {
        (!self.depends_on_place()).then(|| self.of_numbers(inputs))
    }

    /// Whether it gives what stands in its first socket, by what is known of the others.
    pub fn gives_its_first(&self, known: impl Fn(usize) -> Option<Vec3>) -> bool {
        use crate::nodes::vector::Mapping::{Point, Texture, Vector};
        let neutral = [Vec3::ZERO, Vec3::ZERO, Vec3::ONE];
        matches!(self, Self::Mapping(Point | Texture | Vector))
            && (1..)
                .zip(neutral)
                .all(|(socket, value)| known(socket) == Some(value))
    }

    /// Whether what is known of its sockets makes nothing of all that varies: of a Mapping that scales points by 0 Cycles leaves out the
    /// location too (ConstantFolder::fold_mapping).
    pub fn is_annulled(&self, known: &[Option<Vec4>]) -> bool {
        let scale = matches!(self, Self::Mapping(Mapping::Point)).then(|| known[3]);
        scale.flatten().is_some_and(|s| s.truncate() == Vec3::ZERO)
    }

    /// Whether it asks for the place that is shaded.
    pub fn depends_on_place(&self) -> bool {
        matches!(
            self,
            Self::Place(_)
                | Self::LightFalloff { .. }
                | Self::VectorTransform { .. }
                | Self::Fresnel
                | Self::LayerFresnel
                | Self::LayerFacing
                | Self::Bump { .. }
                | Self::Displacement { .. }
                | Self::VectorDisplacement(_)
                | Self::AmbientOcclusion { .. }
                | Self::Bevel { .. }
                | Self::Raycast { .. }
                | Self::Wireframe { .. }
        )
    }

    /// The result of what depends on its sockets alone: what is common here, in functions of their own, so that none saves
    /// registers for all.
    #[inline]
    pub fn of_numbers<S: Sockets + ?Sized>(&self, inputs: &S) -> Vec4 {
        match self {
            Self::Texture(texture) => texture.evaluate(inputs),
            Self::Math { operation, clamp } => math(*operation, *clamp, inputs),
            Self::MixColor {
                blend,
                clamp,
                clamp_result,
            } => mixed(*blend, [*clamp, *clamp_result], inputs),
            Self::ColorRamp(table) => table.at(inputs.number(0)),
            Self::HueSaturation => hue_saturated(inputs),
            Self::Curves(curves) | Self::VectorCurves(curves) => curved(curves, inputs),
            Self::MapRange { kind, clamp } => map_range(*kind, *clamp, inputs),
            _ => self.of_others(inputs),
        }
    }

    #[inline(never)]
    fn of_others<S: Sockets + ?Sized>(&self, inputs: &S) -> Vec4 {
        let number = |socket: usize| inputs.number(socket);
        let vector = |socket: usize| inputs.vector(socket);
        let same = Vec4::splat;
        let full = |v: Vec3| v.extend(1.0);
        match self {
            Self::Sky(sky) => full(sky.of(vector(0))),
            Self::Ies(profile) => same(number(1) * profile.of(vector(0))),
            Self::VectorMath(operation) => {
                let (v, n) = operation.of(vector(0), vector(1), vector(2), number(3));
                v.extend(n)
            }
            Self::IntegerMath(operation) => {
                let [a, b, c] = [0, 1, 2].map(|socket| whole(number(socket)));
                same(operation.of(a, b, c) as f32)
            }
            Self::BooleanMath(operation) => {
                let [a, b] = [0, 1].map(|socket| whole(number(socket)) > 0);
                same(f32::from(operation.of(a, b)))
            }
            Self::VectorComponent => {
                let index = usize::try_from(whole(number(1))).unwrap_or(usize::MAX);
                let all = vector(0).to_array();
                same(all.get(index).copied().unwrap_or(0.0))
            }
            Self::MixFloat { clamp } => {
                let t = clamped(number(0), *clamp);
                same(number(1) * (1.0 - t) + number(2) * t)
            }
            Self::MixVector { clamp, .. } => {
                let t = vector(0);
                let t = if *clamp {
                    t.clamp(Vec3::ZERO, Vec3::ONE)
                } else {
                    t
                };
                full(vector(1) * (1.0 - t) + vector(2) * t)
            }
            Self::FloatCurve(curves) => {
                let (t, value) = (number(0), number(1));
                same(value * (1.0 - t) + curves.of(Vec3::splat(value)).x * t)
            }
            Self::MapRangeVector { kind, clamp } => {
                let all = [0, 1, 2, 3, 4, 5].map(vector);
                let one = |i: usize| {
                    let at = |socket: usize| all[socket][i];
                    kind.of_component(at(0), (at(1), at(2)), (at(3), at(4)), at(5), *clamp)
                };
                full(Vec3::new(one(0), one(1), one(2)))
            }
            Self::Clamp { sorted: true } => same(between(number(0), number(1), number(2))),
            Self::Clamp { sorted: false } => same(number(0).max(number(1)).min(number(2))),
            Self::CombineColor(model) => {
                full(model.combine(Vec3::new(number(0), number(1), number(2))))
            }
            Self::CombineXyz => full(Vec3::new(number(0), number(1), number(2))),
            Self::SeparateColor(model) => full(model.separate(vector(0))),
            Self::SeparateXyz => full(vector(0)),
            Self::BrightContrast => full(bright_contrast(vector(0), number(1), number(2))),
            Self::Gamma => full(gamma(vector(0), number(1))),
            Self::Invert => full(invert(number(0), vector(1))),
            Self::RgbToBw => same(luminance(vector(0))),
            Self::Mapping(mapping) => full(mapping.of(vector(0), vector(1), vector(2), vector(3))),
            Self::VectorRotate { axis, invert } => {
                use crate::nodes::vector::RotationAxis::EulerXyz;
                let angle = if *axis == EulerXyz {
                    vector(4)
                } else {
                    Vec3::splat(number(3))
                };
                full(axis.of(vector(0), vector(1), vector(2), angle, *invert))
            }
            Self::RadialTiling { normalize } => {
                let found = radial_tiling(*normalize, vector(0), number(1), number(2));
                full(found.coordinates.extend(0.0))
            }
            Self::RadialSegment => {
                let found = radial_tiling(false, vector(0), number(1), number(2));
                full(Vec3::new(found.id, found.width, found.rotation))
            }
            _ => {
                debug_assert!(false, "{self:?} depends on the place");
                Vec4::ZERO
            }
        }
    }
}
