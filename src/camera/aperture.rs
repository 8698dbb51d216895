//! The opening of a lens: where on it a ray starts.

use crate::math::warp;
use glam::Vec2;
use std::f32::consts::{PI, TAU};

/// Fewest corners of a polygon; fewer blades are a circle, as in Blender.
const LEAST_BLADES: u32 = 3;

/// Nearer focus, as a share of the opening's greatest radius, changes no bit of a direction: the least point that is drawn off
/// the middle is 2⁻¹² of a radius off it (the root of a number of 24 bits), and from there on rays lean by 2²⁸ to 1, of which f32
/// holds 2²⁴. Without a limit the quotient of lens and focus leaves f32.
const NEAREST_FOCUS: f64 = 1.0 / (1u64 << 40) as f64;

/// The nearest focus that can be told from nearer ones, for an opening of a radius and a ratio.
pub fn nearest_focus(radius: f64, ratio: f64) -> f64 {
    radius * ratio.recip().max(1.0) * NEAREST_FOCUS
}

/// An opening of which points can be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Of the circle about it, metres.
    pub radius: f32,
    /// Corners; fewer than 3 are a circle.
    pub blades: u32,
    /// Turns the polygon counter-clockwise, radians; at 0 the middle of an edge lies on the +X axis.
    pub rotation: f32,
    /// So much narrower along X, after the rotation.
    pub ratio: f32,
    /// Distance of what is sharp, metres.
    pub focus_distance: f32,
}

impl Aperture {
    /// A point of the opening, uniform over its area.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let p = if self.blades < LEAST_BLADES {
            warp::disk(u)
        } else {
            self.polygon(u)
        };
        Vec2::new(p.x / self.ratio, p.y) * self.radius
    }

    /// Each blade has its share of the first number, and within it the triangle between the centre and
    /// its edge is sampled.
    #[inline]
    fn polygon(&self, u: Vec2) -> Vec2 {
        let blades = self.blades as f32;
        let blade = (u.x * blades).floor().min(blades - 1.0);
        let weights = warp::triangle(Vec2::new(u.x * blades - blade, u.y));
        let middle = self.rotation + blade * (TAU / blades);
        let corner = |angle: f32| Vec2::new(angle.cos(), angle.sin());
        corner(middle - PI / blades) * weights.x + corner(middle + PI / blades) * weights.y
    }
}

#[cfg(test)]
#[path = "../../tests/unit/camera/aperture.rs"]
mod tests;
