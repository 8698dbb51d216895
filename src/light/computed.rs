//! Lamps and suns whose strength a node tree computes.

use super::LightHit;
use super::estimate::LightBounds;
use super::kinds::{Light, LightSample, LightSampleContext};
use super::program::{LightProgram, LookingRay, ShinePoint};
use crate::math::luminance;
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::PI;

/// A light times what its tree gives.
#[derive(Debug)]
pub struct ComputedLight {
    light: Light,
    program: Box<dyn LightProgram>,
    axes: LightAxes,
    /// The luminance of the tree's mean, for the choice between lights.
    mean: f32,
    /// How strongly its tree shines, guessed as Cycles does.
    pub(super) guess: Vec3,
}

/// Where a light stands, and where its texture coordinates lie.
#[derive(Clone, Copy, Debug)]
pub struct LightAxes {
    /// From the world's directions (glTF's axes) to the light's own, which are Blender's.
    pub light_from_world: Mat3,
    /// Its middle, relative to the world's origin.
    pub location: Vec3,
    /// Its extents along its own axes, of an area light; of a spot or a sun half of its angle, twice.
    pub size: Vec2,
}

/// Directions by which the mean of a tree is taken.
const LOOKS: u32 = 12;
/// No light is chosen less often than one of this share of its own strength.
const LEAST: f32 = 0.01;

impl ComputedLight {
    /// A light with the program of its tree.
    pub fn new(light: Light, program: Box<dyn LightProgram>, axes: LightAxes) -> Self {
        let mut made = Self {
            light,
            program,
            axes,
            mean: 1.0,
            guess: Vec3::ONE,
        };
        made.mean = made.estimate().max(LEAST);
        made
    }

    /// The light without its tree.
    pub fn plain(&self) -> &Light {
        &self.light
    }

    /// The mean factor of points a metre away all around.
    fn estimate(&self) -> f32 {
        let middle = |i: u32| (i as f32 + 0.5) / LOOKS as f32;
        let places = (0..LOOKS * LOOKS).map(|i| Vec2::new(middle(i % LOOKS), middle(i / LOOKS)));
        let (mut sum, mut count) = (0f32, 0u32);
        for u in places {
            let from = self.axes.location - crate::math::warp::sphere(u);
            let at = LightSampleContext::new(from, None);
            let inner = Vec2::new(u.y, u.x);
            if let Some(sample) = self.light.sample_li(&at, inner) {
                let factor = self.factor((from, 0), &sample);
                sum += luminance(factor.abs());
                count += 1;
            }
        }
        let mean = sum / count.max(1) as f32;
        if mean.is_finite() { mean } else { 1.0 }
    }

    /// For a light sample, from where the path has come to after so many bounces.
    fn factor(&self, (from, bounces): (Vec3, u32), sample: &LightSample) -> Vec3 {
        let distance = sample
            .target
            .map_or(f32::MAX, |target| (target - from).length());
        let ray = LookingRay::sampling(bounces);
        self.program
            .emitted(&self.point((from, sample.wi), distance, ray))
    }

    /// What the tree sees of a point that is met along a direction, as Cycles tells it.
    fn point(&self, (from, wi): (Vec3, Vec3), distance: f32, ray: LookingRay) -> ShinePoint {
        let at_infinity = distance == f32::MAX;
        let position = if at_infinity {
            -wi
        } else {
            from + wi * distance
        };
        let (normal, uv) = match &self.light {
            Light::Lamp(lamp) => {
                let from_middle = (position - lamp.center).try_normalize();
                let sphere = lamp.radius > 0.0 && !lamp.soft_falloff;
                let normal = from_middle.filter(|_| sphere).unwrap_or(-wi);
                let uv = if lamp.cone.is_some() {
                    self.on_cone(-wi)
                } else {
                    on_sphere(self.axes.light_from_world * normal)
                };
                (normal, uv)
            }
            Light::Area(area) => (area.normal(), self.on_area(position)),
            _ => (-wi, self.on_sun(wi)),
        };
        ShinePoint {
            position,
            normal,
            incoming: -wi,
            uv,
            distance,
            ray,
        }
    }

    /// The picture of a spot fills its cone.
    fn on_cone(&self, out: Vec3) -> Vec2 {
        let local = (self.axes.light_from_world * out).normalize_or_zero();
        let scale = 0.5 / (self.axes.size.x.tan() * -local.z);
        Vec2::new(local.x * scale + 0.5, local.y * scale + 0.5)
    }

    fn on_area(&self, position: Vec3) -> Vec2 {
        let local = self.axes.light_from_world * (position - self.axes.location);
        let at = (local.truncate() / self.axes.size).clamp(Vec2::splat(-0.5), Vec2::splat(0.5));
        at + 0.5
    }

    fn on_sun(&self, wi: Vec3) -> Vec2 {
        let half = self.axes.size.x;
        if half <= 0.0 {
            return Vec2::splat(0.5);
        }
        let local = (self.axes.light_from_world * wi).normalize_or_zero();
        // The disc's radius is the chord of half of its angle.
        let across = local.truncate();
        let chord = (local - Vec3::Z).length();
        let along = across.try_normalize().unwrap_or(Vec2::ZERO);
        along * (0.25 * chord / (0.5 * half).sin()) + 0.5
    }

    /// As [`Light::sample_li`].
    #[cold]
    pub fn sample_li(&self, at: &LightSampleContext, u: Vec2) -> Option<LightSample> {
        let sample = self.light.sample_li(at, u)?;
        let factor = self.factor((at.point, at.bounces), &sample);
        Some(sample.times(factor))
    }

    /// As [`Light::le`].
    #[cold]
    pub fn le(
        &self,
        at: &LightSampleContext,
        (origin, wi): (Vec3, Vec3),
        ray: LookingRay,
    ) -> Option<LightHit> {
        let hit = self.light.le(at, (origin, wi), ray)?;
        let distance = if hit.distance.is_finite() {
            hit.distance
        } else {
            f32::MAX
        };
        let factor = self
            .program
            .emitted(&self.point((origin, wi), distance, ray));
        Some(LightHit {
            radiance: hit.radiance * factor,
            ..hit
        })
    }

    /// As [`Light::bounds`].
    pub fn bounds(&self) -> Option<LightBounds> {
        let bounds = self.light.bounds()?;
        Some(LightBounds {
            intensity: bounds.intensity * self.mean,
            ..bounds
        })
    }

    /// As [`Light::irradiance`].
    pub(super) fn irradiance(&self) -> f32 {
        self.light.irradiance() * self.mean
    }
}

/// Around and up a sphere, as Cycles maps it.
fn on_sphere(d: Vec3) -> Vec2 {
    let Some(n) = d.try_normalize() else {
        return Vec2::ZERO;
    };
    let around = if n.truncate() == Vec2::ZERO {
        0.0
    } else {
        0.5 - n.x.atan2(n.y) / (2.0 * PI)
    };
    Vec2::new(around, 1.0 - n.z.clamp(-1.0, 1.0).acos() / PI)
}
