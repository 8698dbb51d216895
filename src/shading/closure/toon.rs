//! Toon shading: light from within a cone counts, about the normal or about the mirrored view (Blender's Toon BSDF).

use super::{LobeSample, LobeValue};
use crate::math::Frame;
use crate::shading::normal;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// A cone of light that counts.
#[derive(Clone, Copy, Debug)]
pub struct Toon {
    /// Weight of the lobe.
    pub(super) weight: Vec3,
    /// The lobe's own normal.
    normal: Vec3,
    /// The cone's axis.
    axis: Vec3,
    /// Angle to which all light counts, and the width of the border.
    angle: f32,
    border: f32,
    /// Highlights instead of diffuse reflection.
    is_glossy: bool,
}

impl Toon {
    /// For sizes of 0..=1, which stand for 0 to 90 degrees; none where the mirrored view is below the surface.
    pub fn new(
        weight: Vec3,
        (size, smooth): (f32, f32),
        normal: Vec3,
        wo: Vec3,
        is_glossy: bool,
    ) -> Option<Self> {
        let cos = normal.dot(wo);
        let axis = if is_glossy {
            normal * (2.0 * cos) - wo
        } else {
            normal
        };
        (!is_glossy || cos > 0.0).then(|| Self {
            weight,
            normal,
            axis: axis.normalize(),
            angle: size.clamp(1e-5, 1.0) * FRAC_PI_2,
            border: smooth.clamp(0.0, 1.0) * FRAC_PI_2,
            is_glossy,
        })
    }

    /// Whether it is a highlight.
    pub fn is_glossy(&self) -> bool {
        self.is_glossy
    }

    /// The lobe's own normal.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Angle to which directions are drawn.
    fn greatest(&self) -> f32 {
        (self.angle + self.border).min(FRAC_PI_2)
    }

    /// 1 - cos of it, without cancellation.
    fn height(&self) -> f32 {
        let sine = (0.5 * self.greatest()).sin();
        2.0 * sine * sine
    }

    /// Value and density.
    pub fn evaluate(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        // Of the sine and the cosine: an arc cosine has no digits about the axis.
        let angle = self.axis.cross(wi).length().atan2(self.axis.dot(wi));
        if wi.dot(self.normal) <= 0.0 || angle >= self.greatest() {
            return LobeValue::ZERO;
        }
        let share = if angle < self.angle {
            1.0
        } else {
            1.0 - (angle - self.angle) / self.border
        };
        let pdf = 1.0 / (TAU * self.height());
        let mut value = self.weight * (pdf * share.max(0.0));
        if self.normal != smooth {
            value *= match normal::bump_shadowing(smooth, self.normal, wi) {
                // Highlights end at the terminator without being softened, as in Cycles.
                softened if softened > 0.0 && self.is_glossy => 1.0,
                softened => softened,
            };
        }
        LobeValue { value, pdf }
    }

    /// Draws a direction from the cone.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let down = u.x * self.height();
        let sine = (down * (2.0 - down)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let local = Vec3::new(sine * cos_phi, sine * sin_phi, 1.0 - down);
        let wi = Frame::from_normal(self.axis)
            .to_world(local)
            .try_normalize()?;
        let of = self.evaluate(smooth, wi);
        LobeSample::reflected(wi, of)
    }
}
