//! The enum of all kinds of lights.

use super::LightHit;
use super::area::Area;
use super::emissive::{EmissiveRectangle, EmissiveTriangle};
use super::environment::Environment;
use super::estimate::{Angle, Front, LightBounds};
use super::lamp::{Lamp, LampSample};
use super::light_sampler::Pmf;
use super::sun::Sun;
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
}

/// A point that is lit, with the probabilities of the lights there ([`super::LightSet::context`]).
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Where.
    pub point: Vec3,
    /// Side that receives; `None` where both do.
    pub normal: Option<Vec3>,
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
            pmf: Pmf::NONE,
            groups: Groups {
                sum: 1.0,
                count: 1.0,
                finite: 0.0,
            },
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
        }
    }

    /// Radiance over density; MIS is left to the caller.
    #[inline]
    pub fn contribution(&self) -> Vec3 {
        self.arriving / self.divisor
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
            Self::Triangle(triangle) => triangle.sample_li(at.point, u),
            Self::Rectangle(rectangle) => rectangle.sample_li(at.point, u),
            Self::Sun(sun) => {
                let d = sun.sample(u);
                Some(LightSample {
                    wi: d.wi,
                    arriving: sun.arriving(),
                    divisor: 1.0,
                    pdf: d.pdf,
                    delta: sun.is_delta(),
                    target: None,
                })
            }
            Self::Environment(environment) => {
                let d = environment.sample(u);
                let radiance = environment.emitted(d.wi);
                Some(LightSample::with_density(d.wi, radiance, d.pdf, None))
            }
        }
    }

    /// What a ray from `origin` finds of the light, as it shines on `at`. Emissive triangles are surfaces: the ray meets them
    /// among these, and what they emit is theirs to say.
    #[inline]
    pub fn le(&self, at: &LightSampleContext, origin: Vec3, wi: Vec3) -> Option<LightHit> {
        match self {
            Self::Lamp(lamp) => lamp.le(at.point, origin, wi),
            Self::Area(area) => area.le(origin, wi),
            Self::Triangle(_) | Self::Rectangle(_) => None,
            Self::Sun(sun) => sun.le(wi),
            Self::Environment(environment) => Some(environment.le(wi)),
        }
    }

    /// Density per solid angle with which [`Self::sample_li`] finds a point `on` it ([`LightHit::on`]) in a direction.
    #[inline]
    pub fn pdf_li(&self, at: &LightSampleContext, wi: Vec3, on: Vec3) -> f32 {
        match self {
            Self::Lamp(lamp) => lamp.pdf_li(at.point, at.normal, wi, on),
            Self::Area(area) => area.pdf_li(at.point, on),
            Self::Triangle(triangle) => triangle.pdf_li(at.point, on),
            Self::Rectangle(rectangle) => rectangle.pdf_li(at.point, on),
            Self::Sun(sun) => sun.pdf_li(),
            Self::Environment(environment) => environment.pdf_li(on),
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
        }
    }

    /// Luminance of the irradiance by a light at infinity, on a surface that faces it.
    pub(super) fn irradiance(&self) -> f32 {
        match self {
            Self::Sun(sun) => luminance(sun.irradiance),
            Self::Environment(environment) => std::f32::consts::PI * luminance(environment.mean()),
            Self::Lamp(_) | Self::Area(_) | Self::Triangle(_) | Self::Rectangle(_) => 0.0,
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
        }
    }
}

fn bounds_of_lamp(lamp: &Lamp) -> LightBounds {
    LightBounds {
        min: lamp.center - lamp.radius,
        max: lamp.center + lamp.radius,
        intensity: luminance(lamp.intensity),
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
        intensity: luminance(area.intensity()),
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
mod tests {
    use super::*;
    use crate::light::emissive::tests::square;
    use crate::math::warp;
    use crate::math::warp::grid;
    use glam::{DAffine3, DMat3};
    use std::f32::consts::PI;

    /// Every kind, but points and parallel light, which no ray finds.
    fn lights() -> Vec<Light> {
        let lamp = Lamp {
            center: Vec3::new(0.2, 0.1, 3.0),
            radius: 0.5,
            soft_falloff: false,
            intensity: Vec3::new(10.0, 5.0, 2.0),
            cone: None,
        };
        let disc = Lamp {
            soft_falloff: true,
            ..lamp
        };
        let place = DAffine3::from_translation(glam::DVec3::new(0.0, 0.3, 2.0));
        let area = |ellipse, spread| {
            let area = Area::new(&place, [1.5, 1.0], ellipse, Vec3::ONE, false, spread);
            Light::Area(Box::new(area.unwrap()))
        };
        let texels: Vec<Vec3> = (0..32).map(|i| Vec3::splat(1.0 + (i % 7) as f32)).collect();
        let image = Environment::image(8, 4, texels, Vec3::ONE, &DMat3::from_rotation_x(0.4));
        let mut lights = vec![
            Light::Lamp(Box::new(lamp)),
            Light::Lamp(Box::new(disc)),
            area(false, PI),
            area(true, PI),
            area(true, 1.0),
            Light::Sun(Sun::new(
                Vec3::new(0.3, 0.2, 1.0).normalize(),
                Vec3::ONE,
                0.6,
            )),
            Light::Environment(Box::new(Environment::constant(Vec3::ONE))),
            Light::Environment(Box::new(image)),
        ];
        lights.extend(square(Vec3::new(0.0, 0.0, 2.0), 1.0, false));
        lights.extend(square(Vec3::new(0.0, 0.0, 2.0), 1.0, true));
        lights
    }

    /// Below all of them, and seen by all.
    const AT: Vec3 = Vec3::new(0.1, -0.2, 0.25);

    /// Samples have the radiance and the density that a ray along them finds.
    #[test]
    fn rays_find_what_is_sampled() {
        for light in lights() {
            let at = LightSampleContext::new(AT, Some(Vec3::Z));
            let (mut drawn, mut found) = (0, 0);
            for u in grid(64) {
                let Some(s) = light.sample_li(&at, u) else {
                    continue;
                };
                assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0 && !s.delta);
                drawn += 1;
                let (radiance, on) = match light.le(&at, AT, s.wi) {
                    Some(hit) => {
                        if let Some(target) = s.target {
                            let distance = (target - AT).length();
                            assert!((hit.distance / distance - 1.0).abs() < 1e-3, "{light:?}");
                        }
                        (hit.radiance, hit.on)
                    }
                    // Only the geometry finds surfaces. Each of these emits 3 everywhere.
                    None if light.of_surface().is_some() => (Vec3::splat(3.0), s.target.unwrap()),
                    None => continue,
                };
                let pdf = light.pdf_li(&at, s.wi, on);
                // Neighbours in an image differ, and rounding may name the other one.
                found += u32::from((pdf / s.pdf - 1.0).abs() < 2e-3);
                let by_radiance = radiance / pdf;
                let off = (s.contribution() - by_radiance).abs().max_element();
                assert!(
                    off <= 5e-3 * by_radiance.max_element() || (pdf / s.pdf - 1.0).abs() > 2e-3,
                    "{light:?}: {} {by_radiance}",
                    s.contribution()
                );
            }
            assert!(drawn > 1000, "{light:?}: {drawn}");
            assert!(found * 100 >= drawn * 98, "{light:?}: {found} of {drawn}");
        }
    }

    /// The irradiance by the light's samples is the one by uniform directions, and densities integrate to the share of the
    /// numbers that give samples.
    #[test]
    fn samples_and_uniform_directions_find_the_same_light() {
        let n = 700;
        let all = f64::from(n * n);
        for light in lights() {
            let at = LightSampleContext::new(AT, None);
            let cosine = |wi: Vec3| f64::from(wi.z.max(0.0));
            let (mut sampled, mut drawn) = (0.0, 0.0);
            for s in grid(n).filter_map(|u| light.sample_li(&at, u)) {
                sampled += f64::from(s.contribution().x) * cosine(s.wi);
                drawn += 1.0;
            }
            let (mut uniform, mut density) = (0.0, 0.0);
            for wi in grid(n).map(warp::sphere) {
                let (radiance, on) = match light.le(&at, AT, wi) {
                    Some(hit) => (hit.radiance, hit.on),
                    None => match on_square(&light, wi) {
                        Some(on) => (Vec3::splat(3.0), on),
                        None => continue,
                    },
                };
                let solid_angle = 4.0 * std::f64::consts::PI;
                uniform += f64::from(radiance.x) * cosine(wi) * solid_angle;
                density += f64::from(light.pdf_li(&at, wi, on)) * solid_angle;
            }
            assert!(
                (sampled / uniform - 1.0).abs() < 1e-2,
                "{light:?}: {} {}",
                sampled / all,
                uniform / all
            );
            assert!(
                ((density - drawn) / all).abs() < 1e-2,
                "{light:?}: {} {}",
                density / all,
                drawn / all
            );
        }
    }

    /// Where a ray meets a light of `square`.
    fn on_square(light: &Light, wi: Vec3) -> Option<Vec3> {
        let bounds = light.of_surface().and_then(|_| light.bounds())?;
        let on = AT + wi * ((bounds.max.z - AT.z) / wi.z);
        let corner = bounds.min.truncate();
        let d = (on.truncate() - corner) / (bounds.max.truncate() - corner);
        let inside = d.cmpge(Vec2::ZERO).all() && d.cmple(Vec2::ONE).all();
        let inside = inside && (matches!(light, Light::Rectangle(_)) || d.y <= d.x);
        (wi.z > 0.0 && inside).then_some(on)
    }

    /// A scene may have millions of them.
    #[test]
    fn lights_are_small() {
        assert!(size_of::<Light>() <= 56, "{}", size_of::<Light>());
    }
}
