//! Sun lights: parallel, or from a disc at infinity.

use super::{Direction, LightHit};
use crate::math::float::UNIT_ROUNDOFF;
use crate::math::warp;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// A sun.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    /// Towards the middle of the disc, unit length.
    pub toward: Vec3,
    /// Irradiance on a surface that faces it, W/m².
    pub irradiance: Vec3,
    /// 1 − cos of the disc's angular radius; 0 for exactly parallel light.
    pub one_minus_cos: f32,
}

impl Sun {
    /// Whether a surface of this normal, of unit length, sees nothing of it.
    pub fn is_behind(&self, normal: Vec3) -> bool {
        let height = self.toward.dot(normal);
        // sin² = (1 − cos)(1 + cos).
        height <= 0.0 && height <= -(self.one_minus_cos * (2.0 - self.one_minus_cos)).sqrt()
    }

    /// From irradiance and angular diameter in radians (up to π: a hemisphere).
    pub fn new(toward: Vec3, irradiance: Vec3, angle: f32) -> Self {
        let half = (0.5 * angle).clamp(0.0, std::f32::consts::FRAC_PI_2);
        // 1 − cos h = 2 sin²(h/2), without cancellation.
        let s = (0.5 * half).sin();
        let disc = Self {
            toward,
            irradiance,
            one_minus_cos: 2.0 * s * s,
        };
        // Unit vectors are rounded to u: no direction can tell a smaller disc from a point.
        if half < UNIT_ROUNDOFF || !disc.radiance().is_finite() {
            return Self {
                one_minus_cos: 0.0,
                ..disc
            };
        }
        disc
    }

    /// Whether it is exactly parallel.
    pub fn is_delta(&self) -> bool {
        self.one_minus_cos == 0.0
    }

    /// Radiance of the disc: ∫ L cosθ over the cap is L·π sin²h.
    #[inline]
    pub fn radiance(&self) -> Vec3 {
        let sin2 = self.one_minus_cos * (2.0 - self.one_minus_cos);
        self.irradiance / (PI * sin2)
    }

    /// Radiance over density of [`Self::sample`], without the disc's size in it: its square can leave f32's range.
    #[inline]
    pub fn arriving(&self) -> Vec3 {
        if self.is_delta() {
            self.irradiance
        } else {
            self.irradiance * (2.0 / (2.0 - self.one_minus_cos))
        }
    }

    /// Uniform direction in the disc.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Direction {
        if self.is_delta() {
            return Direction {
                wi: self.toward,
                pdf: 0.0,
            };
        }
        Direction {
            wi: warp::cone_about(self.toward, u, self.one_minus_cos),
            pdf: warp::cone_pdf(self.one_minus_cos),
        }
    }

    /// Whether a direction meets the disc. 1 − cos from the chord: |a − b|² = 2(1 − cos).
    #[inline]
    pub fn contains(&self, wi: Vec3) -> bool {
        !self.is_delta() && 0.5 * (wi - self.toward).length_squared() <= self.one_minus_cos
    }

    /// What a ray finds in its disc.
    #[inline]
    pub fn le(&self, wi: Vec3) -> Option<LightHit> {
        self.contains(wi).then(|| LightHit {
            distance: f32::INFINITY,
            radiance: self.radiance(),
            on: Vec3::ZERO,
        })
    }

    /// Density of [`Self::sample`] inside the disc.
    #[inline]
    pub fn pdf_li(&self) -> f32 {
        if self.is_delta() {
            0.0
        } else {
            warp::cone_pdf(self.one_minus_cos)
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/sun.rs"]
mod tests;
