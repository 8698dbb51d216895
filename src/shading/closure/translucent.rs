//! Diffuse transmission: what meets the surface leaves it on the other side, the same in all directions.

use super::{LobeSample, LobeValue};
use crate::math::{Frame, warp};
use crate::shading::normal;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A Lambertian lobe on the other side.
#[derive(Clone, Copy, Debug)]
pub struct Translucent {
    /// Albedo times the lobe's weight.
    pub color: Vec3,
    /// The lobe's own normal, on the viewer's side.
    pub normal: Vec3,
}

impl Translucent {
    /// Value and density for a direction beyond the surface.
    pub fn evaluate(&self, wi: Vec3) -> LobeValue {
        let cos = -wi.dot(self.normal);
        if cos <= 0.0 {
            return LobeValue::ZERO;
        }
        LobeValue {
            value: self.color * (cos * FRAC_1_PI),
            pdf: warp::cosine_hemisphere_pdf(cos),
        }
    }

    /// What that has too much of where Cycles samples a light: there the terminator of a bump is softened, which it is not where
    /// directions are drawn.
    pub fn evaluate_backs(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        if self.normal == smooth {
            return LobeValue::ZERO;
        }
        let shadowing = normal::bump_shadowing(smooth, self.normal, -wi);
        LobeValue {
            value: self.evaluate(wi).value * (shadowing - 1.0),
            pdf: 0.0,
        }
    }

    /// What Cycles samples of a light before the surface, where the lobe's own normal looks behind it. No direction that is drawn goes
    /// there. Light that the smooth normal does not see is lost (see [`crate::world::World::meets_own_surface`]).
    pub fn evaluate_before(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        if self.normal == smooth || smooth.dot(wi) <= 0.0 {
            return LobeValue::ZERO;
        }
        let shadowing = normal::bump_shadowing(smooth, self.normal, -wi);
        if shadowing == 0.0 {
            return LobeValue::ZERO;
        }
        let of = self.evaluate(wi);
        LobeValue {
            value: of.value * shadowing,
            ..of
        }
    }

    /// Draws a direction by the cosine.
    pub fn sample(&self, u: Vec2) -> Option<LobeSample> {
        let wi = Frame::from_normal(-self.normal).to_world(warp::cosine_hemisphere(u));
        let of = self.evaluate(wi);
        LobeSample::transmitted(wi, of)
    }
}
