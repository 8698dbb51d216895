//! Point and spot lights: spheres or discs of uniform radiance, or points.

use super::{Direction, LightHit};
use crate::math::{Frame, sqr, warp};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::PI;

/// A lamp in world space (relative to the scene's origin).
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    /// Centre.
    pub center: Vec3,
    /// Radius; 0 is a point.
    pub radius: f32,
    /// A disc that faces what it shines on instead of a sphere (Blender's "Soft Falloff").
    pub soft_falloff: bool,
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
    /// 1 − cos of half the opening angle: the cosine itself cannot tell narrow cones apart.
    pub one_minus_cos: f32,
    /// 1 / (`one_minus_cos` · blend); infinite for a hard edge.
    pub steepness: f32,
}

impl Cone {
    /// The share of the intensity that leaves along `out` (from the light, unit length): a
    /// smoothstep in the cosine, as Blender's spot blend is defined.
    #[inline]
    pub fn attenuation(&self, out: Vec3) -> f32 {
        let local = self.light_from_world * out;
        let length = local.length();
        // 1 − cosθ = sin²θ/(1 + cosθ), which does not cancel near the axis.
        let one_minus_cos = if local.z < 0.0 {
            (sqr(local.x) + sqr(local.y)) / (length * (length - local.z))
        } else {
            1.0 + local.z / length
        };
        let inside = self.one_minus_cos - one_minus_cos;
        if inside <= 0.0 {
            return 0.0;
        }
        if self.steepness.is_infinite() {
            1.0
        } else {
            warp::smoothstep(inside * self.steepness)
        }
    }
}

/// What arrives from a lamp along one direction.
#[derive(Clone, Copy, Debug)]
pub struct LampSample {
    /// Where it comes from.
    pub direction: Direction,
    /// Radiance over density, for a point its intensity over the squared distance: in a form that stays in f32's
    /// range where the one or the other does not.
    pub arriving: Vec3,
    /// Distance to the lamp's surface along the direction.
    pub distance: f32,
    /// A point: no other technique finds it.
    pub delta: bool,
}

impl Lamp {
    /// The same radiance on the whole sphere: intensity over the disc that one sees. Not finite for a lamp so small
    /// that it has to be taken for a point.
    #[inline]
    pub fn radiance(&self) -> Vec3 {
        self.intensity / (PI * sqr(self.radius))
    }

    #[inline]
    fn toward(&self, out: Vec3) -> f32 {
        self.cone.as_ref().map_or(1.0, |c| c.attenuation(out))
    }

    /// Samples what is seen of it uniformly in solid angle; a disc uniformly in area. `normal`: of the lit side, where
    /// only one is.
    #[inline]
    pub fn sample(&self, from: Vec3, normal: Option<Vec3>, u: Vec2) -> Option<LampSample> {
        let to_center = self.center - from;
        let d2 = to_center.length_squared();
        let distance = d2.sqrt();
        if distance == 0.0 {
            return None;
        }
        let axis = to_center / distance;
        if self.radius == 0.0 {
            return Some(LampSample {
                direction: Direction { wi: axis, pdf: 0.0 },
                arriving: self.intensity * (self.toward(-axis) / d2),
                distance,
                delta: true,
            });
        }
        let (wi, pdf, arriving, distance) = if self.soft_falloff {
            let on = warp::disk(u) * self.radius;
            let t = (d2 + on.length_squared()).sqrt();
            let wi = Frame::from_normal(axis).to_world(Vec3::new(on.x, on.y, distance)) / t;
            // I/πr² over t³/(d·πr²).
            let arriving = self.intensity * (self.toward(-wi) * distance / (sqr(t) * t));
            (wi, self.disc_pdf(t, distance), arriving, t)
        } else if d2 > sqr(self.radius) {
            let sin2 = sqr(self.radius) / d2;
            let one_minus_cos = warp::one_minus_cos_from_sin2(sin2);
            let wi = warp::cone_about(axis, u, one_minus_cos);
            // I/πr² over 1/2π(1 − cos), with 1 − cos = (r²/d²)/(1 + cos).
            let share = 2.0 / (d2 * (1.0 + (1.0 - sin2).max(0.0).sqrt()));
            (
                wi,
                warp::cone_pdf(one_minus_cos),
                self.intensity * (self.toward(-wi) * share),
                self.hit(from, wi).unwrap_or(distance),
            )
        } else {
            // Inside it shines from all around; a spot is a point light there, as in Cycles.
            let wi = match normal {
                Some(n) => Frame::from_normal(n).to_world(warp::cosine_hemisphere(u)),
                None => warp::sphere(u),
            };
            let pdf = Self::inner_pdf(normal, wi);
            (wi, pdf, self.radiance() / pdf, self.hit(from, wi)?)
        };
        (pdf > 0.0).then_some(LampSample {
            direction: Direction { wi, pdf },
            arriving,
            distance,
            delta: false,
        })
    }

    /// Radiance at a point along a direction that meets it. From inside a spot is a point light, as in Cycles.
    #[inline]
    fn emitted(&self, from: Vec3, wi: Vec3) -> Vec3 {
        let inside =
            !self.soft_falloff && (self.center - from).length_squared() <= sqr(self.radius);
        self.radiance() * if inside { 1.0 } else { self.toward(-wi) }
    }

    /// Density per solid angle of points on a disc: distance to the point, and to the disc.
    #[inline]
    fn disc_pdf(&self, t: f32, distance: f32) -> f32 {
        sqr(t) * t / (distance * PI * sqr(self.radius))
    }

    #[inline]
    fn inner_pdf(normal: Option<Vec3>, wi: Vec3) -> f32 {
        normal.map_or(0.25 / PI, |n| warp::cosine_hemisphere_pdf(n.dot(wi)))
    }

    /// What a ray from the lit point `from` hits of it beyond `origin`, which the ray has reached already: the distance from there, and
    /// the radiance that `from` sees. A disc faces `from`, and a sphere that the ray has entered before is not met a second time.
    #[inline]
    pub fn le(&self, from: Vec3, origin: Vec3, wi: Vec3) -> Option<LightHit> {
        let (distance, on) = if self.soft_falloff {
            let to_center = self.center - from;
            let along = to_center.length();
            let axis = to_center.try_normalize()?;
            let cos = axis.dot(wi);
            // The tangent of the angle from the part of the direction beside the axis, which does not cancel.
            if cos <= 0.0 || (wi - axis * cos).length() * along > self.radius * cos {
                return None;
            }
            let t = along / cos;
            let left = t - (origin - from).dot(wi);
            if left <= 0.0 {
                return None;
            }
            (left, Vec3::new(t, along, 0.0))
        } else {
            let is_inside =
                |point: Vec3| (self.center - point).length_squared() <= sqr(self.radius);
            if is_inside(origin) && !is_inside(from) {
                return None;
            }
            (self.hit(origin, wi)?, Vec3::ZERO)
        };
        Some(LightHit {
            distance,
            radiance: self.emitted(from, wi),
            on,
        })
    }

    /// Density with which [`Self::sample`] finds what a ray has hit.
    #[inline]
    pub fn pdf_li(&self, from: Vec3, normal: Option<Vec3>, wi: Vec3, on: Vec3) -> f32 {
        if self.soft_falloff {
            return self.disc_pdf(on.x, on.y);
        }
        let d2 = (self.center - from).length_squared();
        if d2 > sqr(self.radius) {
            warp::cone_pdf(warp::one_minus_cos_from_sin2(sqr(self.radius) / d2))
        } else {
            Self::inner_pdf(normal, wi)
        }
    }

    /// Distance to the sphere along a unit direction. The discriminant comes from the
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
        let (near, far) = if b > 0.0 { (c / q, q) } else { (q, c / q) };
        // From inside the near one is behind.
        let t = if near > 0.0 { near } else { far };
        (t > 0.0).then_some(t)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/lamp.rs"]
mod tests;
