//! Floating-point bounds, frames, warps.

pub mod float;
pub mod frame;
pub mod motion;
pub mod panorama;
pub mod primaries;
pub mod srgb;
pub mod warp;
pub mod words;

pub use frame::Frame;

use glam::Vec3;

/// The sides of a box, counter-clockwise from outside: numbers of corners, whose bits are their X, Y and Z.
pub const BOX_SIDES: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

/// Weights of linear Rec.709 in luminance, as ITU-R BT.709-6 (item 3.2) and the measures of pictures round them.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Rec.709 luminance of a linear colour, as nodes take it for a number: by Y of the primaries and the white (item 1.3). The rounded
/// weights are up to 5e-5 beside Cycles 5's.
pub fn luminance(color: Vec3) -> f32 {
    0.212_639 * color.x + 0.715_169 * color.y + 0.072_192 * color.z
}

/// Mean of the three channels: the weight used to choose between lobes.
pub fn average(color: Vec3) -> f32 {
    (color.x + color.y + color.z) * (1.0 / 3.0)
}

/// The whole number below, and what is left. (The library's floor is a call of a function.)
#[inline]
pub fn floor(x: f32) -> (i64, f32) {
    // From here on all are whole.
    const WHOLE: f32 = 8_388_608.0;
    if x.abs() >= WHOLE {
        return (x as i64, 0.0);
    }
    let toward_zero = x as i32;
    let below = toward_zero - i32::from(toward_zero as f32 > x);
    (i64::from(below), x - below as f32)
}

/// Albedo of a single scattering in a half space that gives back a colour altogether, with a mean cosine of scatterings: d'Eon,
/// *A Hitchhiker's Guide to Multiple Scattering*, eq. 53.7; Kulla and Conty, *Revisiting Physically Based Shading at Imageworks*, 2017.
pub fn single_scattering_albedo(color: Vec3, g: f32) -> Vec3 {
    let root = 9.59217 + color * 41.6808 + color * color * 17.7126;
    let root = Vec3::new(root.x.sqrt(), root.y.sqrt(), root.z.sqrt());
    let s = color * 4.20863 - root + 4.09712;
    let s2 = s * s;
    (1.0 - s2) / (1.0 - g * s2)
}

/// Linear interpolation that is exact at both ends.
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Square.
pub fn sqr(x: f32) -> f32 {
    x * x
}

#[cfg(test)]
#[path = "../../tests/unit/math/mod.rs"]
mod tests;
