//! Floating-point bounds, frames, warps.

pub mod float;
pub mod frame;
pub mod warp;

pub use frame::Frame;

use glam::Vec3;

/// Rec.709 luminance of a linear colour (ITU-R BT.709-6, item 3.2).
pub fn luminance(color: Vec3) -> f32 {
    0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z
}

/// Mean of the three channels: the weight used to choose between lobes.
pub fn average(color: Vec3) -> f32 {
    (color.x + color.y + color.z) * (1.0 / 3.0)
}

/// Linear interpolation that is exact at both ends.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Square.
pub fn sqr(x: f32) -> f32 {
    x * x
}
