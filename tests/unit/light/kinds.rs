use super::*;
use crate::light::computed::LightAxes;
use crate::light::emissive::tests::square;
use crate::light::environment::{Disc, SkyTable};
use crate::light::program::{LightProgram, ShinePoint};
use crate::math::warp;
use crate::math::warp::grid;
use glam::{DAffine3, DMat3};
use std::f32::consts::PI;

/// A sky with a sun, and a lamp's pattern: brighter upwards and nearer by.
#[derive(Debug)]
struct Pattern {
    sun: Vec3,
}

impl LightProgram for Pattern {
    fn emitted(&self, at: &ShinePoint) -> Vec3 {
        let is_sun = at.distance == f32::MAX && at.position.dot(self.sun) > 0.98f32.sqrt();
        let bright = if is_sun { 40.0 } else { 0.0 };
        let near = 1.0 / (1.0 + at.distance.min(100.0));
        Vec3::new(1.2 + at.incoming.z + bright, 1.0, 0.5) * (1.0 + near)
    }
}

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
    let sun = Vec3::new(0.5, 0.1, 0.8).normalize();
    let pattern = || Box::new(Pattern { sun });
    let disc = Disc {
        shines: true,
        share: None,
        toward: sun,
        one_minus_cos: 1.0 - 0.98f32.sqrt(),
    };
    let sought = Disc {
        shines: false,
        share: Some(0.8),
        ..disc
    };
    let skies = [
        (None, false),
        (None, true),
        (Some(disc), false),
        (Some(sought), true),
    ];
    for (disc, as_cycles) in skies {
        let columns = 128;
        let table = SkyTable { columns, as_cycles };
        let around = Environment::computed(pattern(), table, Vec3::ONE, disc);
        lights.push(Light::Environment(Box::new(around)));
    }
    let axes = LightAxes {
        light_from_world: glam::Mat3::IDENTITY,
        location: lamp.center,
        size: Vec2::ONE,
    };
    let patterned = |light| {
        let computed = ComputedLight::new(light, pattern(), axes);
        Light::Computed(Box::new(computed))
    };
    lights.push(patterned(Light::Lamp(Box::new(lamp))));
    lights.push(patterned(area(false, PI)));
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
            let (radiance, on) = match light.le(&at, (AT, s.wi), LookingRay::sampling(0)) {
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
            let (radiance, on) = match light.le(&at, (AT, wi), LookingRay::sampling(0)) {
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
