//! The enum of all kinds of lights.

use super::LightHit;
use super::area::Area;
use super::computed::ComputedLight;
use super::emissive::{EmissiveRectangle, EmissiveTriangle};
use super::environment::Environment;
use super::estimate::{Angle, Ball, Front, LightBounds};
use super::lamp::{Lamp, LampSample};
use super::light_sampler::Pmf;
use super::program::LookingRay;
use super::sun::Sun;
use super::two_bounds::Receiver;
use crate::math::luminance;
use glam::{Mat3, Vec2, Vec3};

/// A light. Large ones are boxed: a scene may have millions of triangles.
#[derive(Debug)]
pub enum Light {
    /// A point or a spot: a point, a sphere, or a disc that faces what it shines on.
    Lamp(Box<Lamp>),
    /// A rectangle, parallelogram or ellipse that shines to one side.
    Area(Box<Area>),
    /// A triangle of a mesh.
    Triangle(EmissiveTriangle),
    /// Two triangles of a mesh that are a rectangle.
    Rectangle(Box<EmissiveRectangle>),
    /// Parallel light, or a disc at infinity.
    Sun(Sun),
    /// Light from all around.
    Environment(Box<Environment>),
    /// A lamp, an area light or a sun whose strength a node tree computes.
    Computed(Box<ComputedLight>),
}

/// A point that is lit, with the probabilities of the lights there ([`super::LightSet::context`]).
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Where.
    pub point: Vec3,
    /// Side that receives; `None` where both do.
    pub normal: Option<Vec3>,
    /// Surfaces that have scattered the path to it, for lights whose node trees ask.
    pub bounces: u32,
    /// When the path is on its way, 0 to 1.
    pub time: f32,
    /// The set of receivers that it is in ([`super::LightSet::receiver`]).
    pub receiver: u8,
    /// Bits of kinds that a ray which goes through a surface is of beside that, as in Cycles: diffuse from what lets light through
    /// diffusely, glossy from all else.
    pub also: u32,
    /// The normal of the surface, and whether light from below it counts as well; `None` in a medium.
    pub facing: Option<(Vec3, bool)>,
    /// Light that falls on it is clamped.
    pub clamps: bool,
    pub(super) pmf: Pmf,
    pub(super) groups: Groups,
}

/// Estimated irradiance at a point by the finite lights and those at infinity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups {
    pub sum: f32,
    pub count: f32,
    pub finite: f32,
}

impl LightSampleContext {
    /// For a single light, or where no light is looked for.
    pub fn new(point: Vec3, normal: Option<Vec3>) -> Self {
        Self {
            point,
            normal,
            bounces: 0,
            time: 0.0,
            receiver: 0,
            also: 0,
            facing: None,
            clamps: true,
            pmf: Pmf::NONE,
            groups: Groups {
                sum: 1.0,
                count: 1.0,
                finite: 0.0,
            },
        }
    }

    /// The same at a time between 0 and 1.
    #[must_use]
    pub fn at_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// As Cycles' Light Tree sees it.
    #[inline]
    pub(super) fn receiver_in_tree(&self) -> Receiver {
        Receiver {
            point: self.point,
            normal: self.facing.map(|(normal, _)| normal),
            both: self.facing.is_none_or(|(_, both)| both),
        }
    }

    /// Where, and which side.
    #[inline]
    pub(super) fn place(&self) -> (Vec3, Option<Vec3>) {
        (self.point, self.normal)
    }
}

/// Light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Towards the light, unit length.
    pub wi: Vec3,
    /// What arrives, but for the divisor. Apart, as the quotient can leave f32's range where it is not asked for.
    arriving: Vec3,
    divisor: f32,
    /// Density per solid angle; 0 if `delta`.
    pub pdf: f32,
    /// No BSDF sample can find it.
    pub delta: bool,
    /// Where on the light; `None` at infinity. Already moved off the light's surface.
    pub target: Option<Vec3>,
    /// It counts so many times, whatever is clamped of it.
    pub counts: f32,
}

impl LightSample {
    /// With a density by which radiance is divided.
    #[inline]
    pub(super) fn with_density(wi: Vec3, radiance: Vec3, pdf: f32, target: Option<Vec3>) -> Self {
        Self {
            wi,
            arriving: radiance,
            divisor: pdf,
            pdf,
            delta: false,
            target,
            counts: 1.0,
        }
    }

    /// Of a lamp, whose radiance is divided by its density already.
    #[inline]
    fn of_lamp(from: Vec3, s: LampSample) -> Self {
        Self {
            wi: s.direction.wi,
            arriving: s.arriving,
            divisor: 1.0,
            pdf: s.direction.pdf,
            delta: s.delta,
            target: Some(from + s.direction.wi * s.distance),
            counts: 1.0,
        }
    }

    /// What a factor leaves of it.
    #[must_use]
    pub(super) fn times(self, factor: Vec3) -> Self {
        Self {
            arriving: self.arriving * factor,
            ..self
        }
    }

    /// Radiance over density; MIS is left to the caller.
    #[inline]
    pub fn contribution(&self) -> Vec3 {
        self.arriving / self.divisor
    }

    /// The same, of a light that was chosen with a probability, and would be with another one where the density is asked for.
    #[inline]
    pub(super) fn chosen_elsewhere(self, probability: f32, here: f32) -> Option<Self> {
        let divisor = self.divisor * probability;
        (divisor > 0.0).then_some(Self {
            divisor,
            pdf: self.pdf * here,
            ..self
        })
    }

    /// The same, counting so many times.
    #[inline]
    pub(super) fn counting(self, counts: f32) -> Self {
        Self { counts, ..self }
    }

    /// The same, of a light that was chosen with a probability. `None` where the density is 0 by underflow.
    #[inline]
    pub(super) fn chosen(self, probability: f32) -> Option<Self> {
        let divisor = self.divisor * probability;
        (divisor > 0.0).then_some(Self {
            divisor,
            pdf: self.pdf * probability,
            ..self
        })
    }
}

impl Light {
    /// Draws a direction from which the light arrives; `None` where it does not.
    #[inline]
    pub fn sample_li(&self, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        match self {
            Self::Lamp(lamp) => {
                let s = lamp.sample(at.point, at.normal, u)?;
                Some(LightSample::of_lamp(at.point, s))
            }
            Self::Area(area) => Some(LightSample::of_lamp(at.point, area.sample(at.point, u)?)),
            Self::Triangle(triangle) => triangle.sample_li(at, u),
            Self::Rectangle(rectangle) => rectangle.sample_li(at, u),
            Self::Sun(sun) => {
                let d = sun.sample(u);
                Some(LightSample {
                    wi: d.wi,
                    arriving: sun.arriving(),
                    divisor: 1.0,
                    pdf: d.pdf,
                    delta: sun.is_delta(),
                    target: None,
                    counts: 1.0,
                })
            }
            Self::Environment(environment) => {
                let (d, radiance) = environment.sample_li(at, u)?;
                Some(LightSample::with_density(d.wi, radiance, d.pdf, None))
            }
            Self::Computed(light) => light.sample_li(at, u),
        }
    }

    /// What a ray from `origin` finds of the light, as it shines on `at`; `ray` says who looks. Emissive triangles are surfaces: the
    /// ray meets them among these, and what they emit is theirs to say.
    #[inline]
    pub fn le(
        &self,
        at: &LightSampleContext,
        (origin, wi): (Vec3, Vec3),
        ray: LookingRay,
    ) -> Option<LightHit> {
        match self {
            Self::Lamp(lamp) => lamp.le(at.point, origin, wi),
            Self::Area(area) => area.le(origin, wi),
            Self::Triangle(_) | Self::Rectangle(_) => None,
            Self::Sun(sun) => sun.le(wi),
            Self::Environment(environment) => Some(environment.le(wi, ray)),
            Self::Computed(light) => light.le(at, (origin, wi), ray),
        }
    }

    /// Density per solid angle with which [`Self::sample_li`] finds a point `on` it ([`LightHit::on`]) in a direction.
    #[inline]
    pub fn pdf_li(&self, at: &LightSampleContext, wi: Vec3, on: Vec3) -> f32 {
        match self {
            Self::Lamp(lamp) => lamp.pdf_li(at.point, at.normal, wi, on),
            Self::Area(area) => area.pdf_li(at.point, on),
            Self::Triangle(triangle) => triangle.pdf_li(at, on),
            Self::Rectangle(rectangle) => rectangle.pdf_li(at, on),
            Self::Sun(sun) => sun.pdf_li(),
            Self::Environment(environment) => environment.pdf_from(at, wi, on),
            Self::Computed(light) => light.plain().pdf_li(at, wi, on),
        }
    }

    /// What is known of it for its estimate; `None` at infinity.
    pub fn bounds(&self) -> Option<LightBounds> {
        match self {
            Self::Lamp(lamp) => Some(bounds_of_lamp(lamp)),
            Self::Area(area) => Some(bounds_of_area(area)),
            Self::Triangle(triangle) => Some(triangle.bounds()),
            Self::Rectangle(rectangle) => Some(rectangle.bounds()),
            Self::Sun(_) | Self::Environment(_) => None,
            Self::Computed(light) => light.bounds(),
        }
    }

    /// Whether a surface of this normal, of unit length, sees nothing of it, as Cycles' Light Tree has it; a sky is all around.
    /// `ball`: about a finite light.
    pub(super) fn is_behind(&self, ball: Option<&Ball>, (from, normal): (Vec3, Vec3)) -> bool {
        match self {
            Self::Area(area) => area.is_behind(from, normal),
            Self::Sun(sun) => sun.is_behind(normal),
            Self::Computed(light) => light.plain().is_behind(ball, (from, normal)),
            _ => ball.is_some_and(|ball| ball.is_behind(from, normal)),
        }
    }

    /// Area of the surface of an object that emits; `None` of what is none.
    pub(super) fn surface_area(&self) -> Option<f32> {
        match self {
            Self::Triangle(triangle) => Some(triangle.area()),
            Self::Rectangle(rectangle) => Some(rectangle.area()),
            _ => None,
        }
    }

    /// Luminance of the irradiance, of less than nothing its size, by a light at infinity, on a surface that faces it.
    pub(super) fn irradiance(&self) -> f32 {
        match self {
            Self::Sun(sun) => luminance(sun.irradiance.abs()),
            Self::Environment(environment) => {
                std::f32::consts::PI * luminance(environment.mean().abs())
            }
            Self::Lamp(_) | Self::Area(_) | Self::Triangle(_) | Self::Rectangle(_) => 0.0,
            Self::Computed(light) => light.irradiance(),
        }
    }

    /// Whether a ray can find it other than among surfaces.
    pub(super) fn is_sized(&self) -> bool {
        match self {
            Self::Lamp(lamp) => lamp.radius > 0.0,
            Self::Area(area) => !area.is_parallel(),
            Self::Triangle(_) | Self::Rectangle(_) => false,
            Self::Sun(sun) => !sun.is_delta(),
            Self::Environment(_) => true,
            Self::Computed(light) => light.plain().is_sized(),
        }
    }

    /// The light without its node tree.
    pub(super) fn plain(&self) -> &Self {
        match self {
            Self::Computed(light) => light.plain(),
            _ => self,
        }
    }
}

fn bounds_of_lamp(lamp: &Lamp) -> LightBounds {
    LightBounds {
        min: lamp.center - lamp.radius,
        max: lamp.center + lamp.radius,
        intensity: luminance(lamp.intensity.abs()),
        axis: lamp.cone.as_ref().map_or(Vec3::Z, |c| c.axis),
        // A spot with a scaled transform is an ellipse: only round ones are bounded by their cone. From
        // inside its sphere a spot is a point light.
        normals: lamp
            .cone
            .as_ref()
            .filter(|c| is_rigid(&c.light_from_world))
            .map_or(Angle::ALL, |c| Angle {
                sin: (c.one_minus_cos * (2.0 - c.one_minus_cos)).max(0.0).sqrt(),
                cos: 1.0 - c.one_minus_cos,
            }),
        cos_emission: 1.0,
        two_sided: false,
        front: None,
    }
}

fn bounds_of_area(area: &Area) -> LightBounds {
    let (min, max) = area.bounds();
    LightBounds {
        min,
        max,
        intensity: luminance(area.intensity().abs()),
        axis: area.normal(),
        normals: Angle::ZERO,
        cos_emission: area.cos_spread(),
        two_sided: false,
        front: Some(Front {
            normal: area.normal(),
            offset: area.normal().dot(area.center()),
        }),
    }
}

fn is_rigid(m: &Mat3) -> bool {
    let (x, y, z) = (m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    let same = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.max(b);
    same(x, y)
        && same(y, z)
        && m.x_axis.dot(m.y_axis).abs() <= 1e-5 * x * y
        && m.y_axis.dot(m.z_axis).abs() <= 1e-5 * y * z
}

#[cfg(test)]
#[path = "../../tests/unit/light/kinds.rs"]
mod tests;
