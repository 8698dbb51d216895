//! Floating-point bounds, frames, warps.

pub mod float;
pub mod frame;
pub mod primaries;
pub mod srgb;
pub mod warp;
pub mod words;

pub use frame::Frame;

use glam::Vec3;

/// Weights of linear Rec.709 in luminance (ITU-R BT.709-6, item 3.2).
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Rec.709 luminance of a linear colour.
pub fn luminance(color: Vec3) -> f32 {
    let [r, g, b] = LUMINANCE.map(|weight| weight as f32);
    r * color.x + g * color.y + b * color.z
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
