//! Point and spot lights: spheres of uniform radiance, or points.

use super::Direction;
use crate::math::{sqr, warp};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::PI;

/// A lamp in world space (relative to the scene's origin).
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    /// Centre.
    pub center: Vec3,
    /// Radius; 0 is a point.
    pub radius: f32,
    /// Radiant intensity on the axis (all directions for a point light), W/sr.
    pub intensity: Vec3,
    /// Cone of a spot light.
    pub cone: Option<Cone>,
}

/// Blender's spot cone.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// World to light space; the light looks down -Z.
    pub light_from_world: Mat3,
    /// Axis in world space.
    pub axis: Vec3,
    /// Cosine of half the opening angle.
    pub cos_half_angle: f32,
    /// 1 / ((1 − cos half angle) · blend); infinite for a hard edge.
    pub steepness: f32,
}

impl Cone {
    /// The share of the intensity that leaves along `out` (from the light, unit length): a
    /// smoothstep in the cosine, as Blender's spot blend is defined.
    #[inline]
    pub fn attenuation(&self, out: Vec3) -> f32 {
        let local = self.light_from_world * out;
        let cos = -local.z / local.length();
        let above = cos - self.cos_half_angle;
        if above <= 0.0 {
            return 0.0;
        }
        if self.steepness.is_infinite() {
            1.0
        } else {
            warp::smoothstep(above * self.steepness)
        }
    }
}

/// What arrives from a lamp along one direction.
#[derive(Clone, Copy, Debug)]
pub struct LampSample {
    /// Where it comes from.
    pub direction: Direction,
    /// Radiance; for a point its intensity over the squared distance.
    pub radiance: Vec3,
    /// Distance to the lamp's surface along the direction.
    pub distance: f32,
    /// A point: no other technique finds it.
    pub delta: bool,
}

impl Lamp {
    /// The same radiance on the whole sphere: intensity over the disc that one sees.
    #[inline]
    fn radiance(&self) -> Vec3 {
        self.intensity / (PI * sqr(self.radius))
    }

    #[inline]
    fn toward(&self, out: Vec3) -> f32 {
        self.cone.as_ref().map_or(1.0, |c| c.attenuation(out))
    }

    /// Samples the visible cap uniformly in solid angle. `None` from inside the sphere: there the
    /// lamp is left to BSDF sampling.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<LampSample> {
        let to_center = self.center - from;
        let d2 = to_center.length_squared();
        let distance = d2.sqrt();
        if d2 <= sqr(self.radius) || distance == 0.0 {
            return None;
        }
        let axis = to_center / distance;
        if self.radius == 0.0 {
            let radiance = self.intensity * (self.toward(-axis) / d2);
            return Some(LampSample {
                direction: Direction { wi: axis, pdf: 0.0 },
                radiance,
                distance,
                delta: true,
            });
        }
        let sin2_max = sqr(self.radius) / d2;
        let one_minus_cos = warp::one_minus_cos_from_sin2(sin2_max);
        let wi = warp::cone_about(axis, u, one_minus_cos);
        let radiance = self.radiance() * self.toward(-wi);
        let distance = self.hit(from, wi).unwrap_or(distance);
        Some(LampSample {
            direction: Direction {
                wi,
                pdf: warp::cone_pdf(one_minus_cos),
            },
            radiance,
            distance,
            delta: false,
        })
    }

    /// Radiance towards the viewer along `wi` (from the viewer), given that the ray meets the sphere.
    #[inline]
    pub fn emitted(&self, wi: Vec3) -> Vec3 {
        self.radiance() * self.toward(-wi)
    }

    /// Density of [`Self::sample`] from a point, for any direction that meets the sphere.
    #[inline]
    pub fn pdf(&self, from: Vec3) -> f32 {
        let d2 = (self.center - from).length_squared();
        if self.radius == 0.0 || d2 <= sqr(self.radius) {
            return 0.0;
        }
        warp::cone_pdf(warp::one_minus_cos_from_sin2(sqr(self.radius) / d2))
    }

    /// Distance to the sphere from outside along a unit direction. The discriminant comes from the
    /// foot of the perpendicular, which does not cancel at large distances
    /// (Haines et al., *Precision Improvements for Ray/Sphere Intersection*, Ray Tracing Gems, ch. 7).
    #[inline]
    pub fn hit(&self, from: Vec3, wi: Vec3) -> Option<f32> {
        let f = from - self.center;
        let b = -f.dot(wi);
        let foot = f + wi * b;
        let discriminant = sqr(self.radius) - foot.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let c = f.length_squared() - sqr(self.radius);
        let q = b + discriminant.sqrt().copysign(b);
        let near = if b > 0.0 { c / q } else { q };
        (near > 0.0).then_some(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(radius: f32) -> Lamp {
        Lamp {
            center: Vec3::new(0.0, 0.0, 5.0),
            radius,
            intensity: Vec3::splat(10.0),
            cone: None,
        }
    }

    /// The irradiance on a surface that faces a lamp is I/d² for every radius.
    #[test]
    fn irradiance_does_not_depend_on_the_radius() {
        for radius in [0.0f32, 1e-6, 1e-3, 0.5, 2.0, 4.5] {
            let lamp = lamp(radius);
            let n = 64;
            let mut sum = 0f64;
            for i in 0..n * n {
                let u = Vec2::new(
                    ((i % n) as f32 + 0.5) / n as f32,
                    ((i / n) as f32 + 0.5) / n as f32,
                );
                let s = lamp.sample(Vec3::ZERO, u).unwrap();
                let weight = if s.delta { 1.0 } else { 1.0 / s.direction.pdf };
                sum += f64::from(s.radiance.x * s.direction.wi.z * weight);
            }
            let irradiance = sum / f64::from(n * n);
            assert!(
                (irradiance / 0.4 - 1.0).abs() < 1e-3,
                "{radius}: {irradiance}"
            );
        }
    }

    #[test]
    fn a_far_sphere_is_hit_at_the_right_distance() {
        for distance in [10f32, 1e3, 1e5, 1e7] {
            let lamp = Lamp {
                center: Vec3::new(0.0, 0.0, distance),
                radius: 1.0,
                ..lamp(1.0)
            };
            let hit = lamp.hit(Vec3::new(0.3, 0.2, 0.0), Vec3::Z).unwrap();
            let exact = f64::from(distance) - (1.0 - 0.13f64).sqrt();
            assert!(
                (f64::from(hit) - exact).abs()
                    < 2.0 * f64::from(f32::EPSILON) * f64::from(distance)
            );
            assert!(lamp.hit(Vec3::new(1.1, 0.0, 0.0), Vec3::Z).is_none());
        }
    }

    #[test]
    fn the_spot_blend_is_smooth_from_edge_to_plateau() {
        let half: f32 = 0.5;
        let cone = Cone {
            light_from_world: Mat3::IDENTITY,
            axis: Vec3::NEG_Z,
            cos_half_angle: half.cos(),
            steepness: 1.0 / ((1.0 - half.cos()) * 0.2),
        };
        let out = |angle: f32| Vec3::new(angle.sin(), 0.0, -angle.cos());
        assert_eq!(cone.attenuation(out(0.51)), 0.0);
        assert_eq!(cone.attenuation(out(0.1)), 1.0);
        let edge = cone.attenuation(out(0.48));
        assert!(edge > 0.0 && edge < 1.0);
        assert_eq!(
            Cone {
                steepness: f32::INFINITY,
                ..cone
            }
            .attenuation(out(0.49)),
            1.0
        );
    }
}
