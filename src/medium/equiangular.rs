//! Distances along a ray by the angle at which a point beside it sees them.
//!
//! Kulla and Fajardo, *Importance Sampling Techniques for Path Tracing in Participating Media*, 2012: the density has the inverse
//! square of the distance to that point in it, as the light of a lamp there has.

use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Distances from 0 to an end, which may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equiangular {
    /// Where the ray is nearest to the point.
    nearest: f32,
    /// How near that is.
    height: f32,
    /// The angle that the whole way takes.
    angle: f32,
    end: f32,
}

impl Equiangular {
    /// Along a ray (direction of length 1) by a point, or by something around it: light of a lamp of a radius falls off no steeper
    /// than that of a point which is further away by it. None where a point lies on the ray, as far as f32 tells.
    pub fn new(
        (origin, direction): (Vec3, Vec3),
        end: f32,
        (point, radius): (Vec3, f32),
    ) -> Option<Self> {
        let to = point - origin;
        let nearest = to.dot(direction);
        // Not by a difference of squares, which cancels.
        let height = Vec2::new(to.cross(direction).length(), radius).length();
        let angle = if end.is_finite() {
            // Between the ways to both ends: differences of arcs would cancel where the point is far away.
            (height * end).atan2(height * height - nearest * (end - nearest))
        } else {
            FRAC_PI_2 + (nearest / height).atan()
        };
        let is_usable = height > 0.0 && nearest.is_finite() && angle > 0.0 && angle.is_finite();
        is_usable.then_some(Self {
            nearest,
            height,
            angle,
            end,
        })
    }

    /// How near the ray comes to the point.
    pub fn height(&self) -> f32 {
        self.height
    }

    /// The distance of a number from 0 to 1.
    pub fn sample(&self, u: f32) -> f32 {
        let Self {
            nearest, height, ..
        } = *self;
        // nearest + height tan(first angle + u angle), by the tangent of a sum.
        let turn = (u * self.angle).tan();
        let t = turn * (height * height + nearest * nearest) / (height + nearest * turn);
        t.clamp(0.0, self.end)
    }

    /// Density of a distance, 1/m.
    pub fn density(&self, t: f32) -> f32 {
        if !(0.0..=self.end).contains(&t) {
            return 0.0;
        }
        let off = t - self.nearest;
        self.height / (self.angle * (self.height * self.height + off * off))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/medium/equiangular.rs"]
mod tests;
