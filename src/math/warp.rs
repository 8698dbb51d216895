//! Warps from the unit square, each with its density.

use super::{Frame, sqr};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Unit square to unit disc, with little distortion
/// (Shirley and Chiu, *A Low Distortion Map Between Disk and Square*, 1997). Density 1/π.
pub fn disk(u: Vec2) -> Vec2 {
    let p = u * 2.0 - 1.0;
    if p.x == 0.0 && p.y == 0.0 {
        return Vec2::ZERO;
    }
    let (r, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    Vec2::new(phi.cos(), phi.sin()) * r
}

/// Cosine-distributed direction about +Z (Malley's method). Density cosθ/π.
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = disk(u);
    Vec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] per solid angle.
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * (1.0 / PI)
}

/// Uniform direction on the sphere. Density 1/4π.
pub fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (4.0 * u.x * (1.0 - u.x)).max(0.0).sqrt();
    let phi = TAU * u.y;
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Uniform direction in a cone about +Z, given 1 − cos of its half angle (so that tiny cones
/// don't cancel). Density 1 / (2π·one_minus_cos).
pub fn cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    // A concentric disc keeps the strata of the square compact.
    let d = disk(u);
    let h = d.length_squared() * one_minus_cos; // 1 − cosθ
    let z = 1.0 - h;
    // sin²θ = h(2 − h); the disc's radius is sqrt(h / one_minus_cos).
    let scale = (one_minus_cos * (2.0 - h)).max(0.0).sqrt();
    Vec3::new(d.x * scale, d.y * scale, z)
}

/// Density of [`cone`] per solid angle.
pub fn cone_pdf(one_minus_cos: f32) -> f32 {
    1.0 / (TAU * one_minus_cos)
}

/// 1 − cosθ from sin²θ without cancellation: sin² / (1 + cos).
pub fn one_minus_cos_from_sin2(sin2: f32) -> f32 {
    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
}

/// Uniform barycentric coordinates (u, v) in a triangle. Density 1/area.
///
/// Heitz' low-distortion map (*A Low-Distortion Map Between Triangle and Square*, 2019).
pub fn triangle(u: Vec2) -> Vec2 {
    let (mut a, mut b) = (u.x, u.y);
    if b > a {
        a *= 0.5;
        b -= a;
    } else {
        b *= 0.5;
        a -= b;
    }
    Vec2::new(a, b)
}

/// Samples a direction about an axis in a cone.
pub fn cone_about(axis: Vec3, u: Vec2, one_minus_cos: f32) -> Vec3 {
    Frame::from_normal(axis).to_world(cone(u, one_minus_cos))
}

/// Smoothstep of a value clamped to 0..1.
pub fn smoothstep(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    sqr(x) * (3.0 - 2.0 * x)
}

/// Points of a regular grid, for the means of smooth functions in tests.
#[cfg(test)]
pub(crate) fn grid(n: u32) -> impl Iterator<Item = Vec2> {
    let middle = move |i: u32| (i as f32 + 0.5) / n as f32;
    (0..n * n).map(move |i| Vec2::new(middle(i % n), middle(i / n)))
}

#[cfg(test)]
#[path = "../../tests/unit/math/warp.rs"]
mod tests;
