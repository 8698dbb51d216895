//! Lambert's diffuse reflection.

use super::{LobeSample, LobeValue};
use crate::math::{Frame, warp};
use crate::shading::normal;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The same radiance in all directions.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// Albedo times the lobe's weight.
    pub color: Vec3,
    /// The lobe's own normal.
    pub normal: Vec3,
}

impl Diffuse {
    /// Value and density. `smooth` is the normal without bumps, if `bumped` says that the lobe's differs.
    #[inline]
    pub fn evaluate(&self, (smooth, bumped): (Vec3, bool), wi: Vec3) -> LobeValue {
        let cos = wi.dot(self.normal);
        if self.color == Vec3::ZERO || cos <= 0.0 {
            return LobeValue::ZERO;
        }
        let mut value = self.color * (cos * FRAC_1_PI);
        if bumped {
            value *= normal::bump_shadowing(smooth, self.normal, wi);
        }
        LobeValue {
            value,
            pdf: warp::cosine_hemisphere_pdf(cos),
        }
    }

    /// Draws a direction by the cosine.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let wi = Frame::from_normal(self.normal).to_world(warp::cosine_hemisphere(u));
        let of = self.evaluate((smooth, self.normal != smooth), wi);
        LobeSample::reflected(wi, of)
    }
}
