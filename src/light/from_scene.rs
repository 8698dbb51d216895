//! Lights made from a scene's descriptions of them.

use super::area::Area;
use super::environment::{Disc, Environment, SkyTable};
use super::kinds::Light;
use super::lamp::{Cone, Lamp};
use super::program::LightProgram;
use super::sun::Sun;
use super::texels::Texels;
use crate::math::luminance;
use crate::scene::{self, AreaShape, Image, LightKind, Pixels};
use glam::{DAffine3, DVec3, Mat3, Vec3};

/// Smaller lamps, in metres, are points: the square of a smaller angle leaves f32's normal range (1e-24 m² over the
/// square of 1e7 m is its end), and with it the density.
const POINT: f32 = 1e-12;

impl Light {
    /// From a lamp or sun, relative to an origin. `None` if nothing shines.
    pub fn from_scene(light: &scene::Light, origin: DVec3) -> Option<Self> {
        let color = Vec3::from(light.color);
        let place = DAffine3 {
            translation: light.world_from_light.translation - origin,
            ..light.world_from_light
        };
        let made = match light.kind {
            LightKind::Point {
                intensity,
                radius,
                soft_falloff,
            } => lamp(&place, color * intensity, (radius, soft_falloff), None),
            LightKind::Spot {
                intensity,
                radius,
                soft_falloff,
                half_angle,
                blend,
            } => {
                let cone = cone(&place, half_angle, blend);
                lamp(
                    &place,
                    color * intensity,
                    (radius, soft_falloff),
                    Some(cone),
                )
            }
            LightKind::Area {
                shape,
                size,
                power,
                normalize,
                spread,
            } => {
                let ellipse = shape == AreaShape::Ellipse;
                let area = Area::new(&place, size, ellipse, color * power, normalize, spread)?;
                Self::Area(Box::new(area))
            }
            LightKind::Sun { irradiance, angle } => {
                let toward = -direction(&light.world_from_light);
                Self::Sun(Sun::new(toward, color * irradiance, angle))
            }
        };
        let power = match made.bounds() {
            Some(bounds) => bounds.intensity,
            None => made.irradiance(),
        };
        if power <= 0.0 { None } else { Some(made) }
    }

    /// The same with what Cycles guesses of its tree's strength.
    #[must_use]
    pub fn guessed(mut self, guess: Vec3) -> Self {
        match &mut self {
            Self::Environment(environment) => environment.guess = guess,
            Self::Computed(light) => light.guess = guess,
            Self::Lamp(_)
            | Self::Area(_)
            | Self::Triangle(_)
            | Self::Rectangle(_)
            | Self::Sun(_) => {}
        }
        self
    }

    /// The light of an environment with the openings of a scene, relative to an origin.
    #[must_use]
    pub fn with_portals(self, portals: &[scene::Portal], origin: DVec3) -> Self {
        let Self::Environment(environment) = self else {
            return self;
        };
        let areas = portals.iter().filter_map(|portal| {
            let place = DAffine3 {
                translation: portal.world_from_portal.translation - origin,
                ..portal.world_from_portal
            };
            let ellipse = portal.shape == AreaShape::Ellipse;
            let full = std::f32::consts::PI;
            Area::new(&place, portal.size, ellipse, Vec3::ONE, false, full)
        });
        Self::Environment(Box::new(environment.with_portals(areas.collect())))
    }

    /// From an environment that a program computes. `None` if nothing shines.
    pub fn computed(
        environment: &scene::Environment,
        program: Box<dyn LightProgram>,
        table: SkyTable,
        disc: Option<Disc>,
    ) -> Option<Self> {
        let radiance = Vec3::from(environment.radiance);
        (luminance(radiance.abs()) > 0.0).then(|| {
            let prepared = Environment::computed(program, table, radiance, disc);
            Self::Environment(Box::new(prepared))
        })
    }

    /// From an environment, with its image. `None` if nothing shines.
    pub fn from_environment(environment: &scene::Environment, images: &[Image]) -> Option<Self> {
        let radiance = Vec3::from(environment.radiance);
        let image = environment.image.and_then(|i| images.get(i.0 as usize));
        (luminance(radiance.abs()) > 0.0).then(|| {
            let prepared = match image {
                Some(image) => Environment::image(
                    image.width as usize,
                    image.height as usize,
                    texels(image),
                    radiance,
                    &environment.rotation,
                ),
                None => Environment::constant(radiance),
            };
            Self::Environment(Box::new(prepared))
        })
    }
}

fn lamp(
    place: &DAffine3,
    intensity: Vec3,
    (radius, soft_falloff): (f32, bool),
    cone: Option<Cone>,
) -> Light {
    let lamp = Lamp {
        center: place.translation.as_vec3(),
        radius: if radius < POINT { 0.0 } else { radius },
        soft_falloff,
        intensity,
        cone,
    };
    // So small for its strength that f32 cannot hold the radiance: a point, as for all but mirrors it is.
    let is_point = !lamp.radiance().is_finite();
    Light::Lamp(Box::new(Lamp {
        radius: if is_point { 0.0 } else { radius },
        ..lamp
    }))
}

fn cone(place: &DAffine3, half_angle: f32, blend: f32) -> Cone {
    let inverse = place.matrix3.inverse();
    // 1 − cos x = 2 sin²(x/2): the cosine of less than 3e-4 is 1 in f32.
    let sin = (0.5 * f64::from(half_angle)).sin();
    let one_minus_cos = (2.0 * sin * sin) as f32;
    let width = one_minus_cos * blend;
    Cone {
        light_from_world: if inverse.is_finite() {
            inverse.as_mat3()
        } else {
            Mat3::IDENTITY
        },
        axis: direction(place),
        one_minus_cos,
        steepness: if width > 0.0 {
            1.0 / width
        } else {
            f32::INFINITY
        },
    }
}

/// Where a light looks.
fn direction(t: &DAffine3) -> Vec3 {
    (-t.matrix3.z_axis)
        .try_normalize()
        .unwrap_or(DVec3::NEG_Y)
        .as_vec3()
}

fn texels(image: &Image) -> Texels {
    let n = image.channels.max(1) as usize;
    if let (3, Pixels::F32(channels)) = (n, &image.pixels) {
        return channels.clone().into();
    }
    let count = image.width as usize * image.height as usize;
    let value = |i: usize| match &image.pixels {
        Pixels::U8(p) => f32::from(p[i]) / 255.0,
        Pixels::U16(p) => f32::from(p[i]) / 65535.0,
        Pixels::F32(p) => p[i],
    };
    (0..count)
        .map(|i| {
            let at = i * n;
            if n < 3 {
                Vec3::splat(value(at))
            } else {
                Vec3::new(value(at), value(at + 1), value(at + 2))
            }
        })
        .collect::<Vec<Vec3>>()
        .into()
}
