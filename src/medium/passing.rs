//! Directions of rays that pass by a light.
//!
//! What a medium scatters of a lamp's light towards a ray goes with the angle that the ray takes as the lamp sees it, over how near
//! it comes to the lamp: (π − θ)/(d sin θ) for a ray without end at an angle θ to the direction of the lamp, which is d away. That
//! has no bound, so that directions which know nothing of the lamp leave bright dots. Directions are drawn by it here (as the middle
//! of a double scattering in Georgiev et al., *Joint Importance Sampling of Low-Order Volumetric Scattering*, 2013).

use super::phase::about;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Directions from a point about another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    /// To the other, of length 1.
    axis: Vec3,
    distance: f32,
}

impl Passing {
    /// None where one point is the other, as far as f32 tells.
    pub fn new(point: Vec3, other: Vec3) -> Option<Self> {
        let to = other - point;
        let distance = to.length();
        let axis = to / distance;
        axis.is_finite().then_some(Self { axis, distance })
    }

    /// Where the other point is.
    pub fn axis(&self) -> Vec3 {
        self.axis
    }

    /// How far away it is.
    pub fn distance(&self) -> f32 {
        self.distance
    }

    /// The direction of two numbers from 0 to 1.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let angle = PI * (1.0 - (1.0 - u.x).sqrt());
        about(self.axis, angle.sin_cos(), u.y)
    }

    /// Density of a direction of length 1 by solid angle; infinite on the axis.
    pub fn density(&self, direction: Vec3) -> f32 {
        let cos = self.axis.dot(direction);
        let sin = self.axis.cross(direction).length();
        // π − θ, of what is behind without a difference.
        let left = if cos < 0.0 {
            sin.atan2(-cos)
        } else {
            PI - sin.atan2(cos)
        };
        let over_sin = if sin > 0.0 {
            left / sin
        } else if cos < 0.0 {
            1.0
        } else {
            f32::INFINITY
        };
        over_sin / (PI * PI * PI)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/medium/passing.rs"]
mod tests;
