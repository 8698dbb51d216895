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
mod tests {
    use super::*;

    #[test]
    fn cosine_hemisphere_has_the_moments_of_its_density() {
        let n = 256;
        let (mut z, mut xx) = (0f64, 0f64);
        for u in grid(n) {
            let d = cosine_hemisphere(u);
            z += f64::from(d.z);
            xx += f64::from(d.x * d.x);
        }
        let count = (n * n) as f64;
        // E[cosθ] = 2/3 and E[x²] = 1/4 under cosθ/π.
        // The midpoint rule errs by O(h^1.5) at the square root on the rim.
        let bound = 2.0 * (n as f64).powf(-1.5);
        assert!((z / count - 2.0 / 3.0).abs() < bound);
        assert!((xx / count - 0.25).abs() < bound);
    }

    #[test]
    fn cones_of_all_sizes_stay_inside_and_keep_their_mean() {
        for one_minus_cos in [1e-14f32, 1e-8, 1e-3, 0.5, 1.0, 2.0] {
            let n = 128;
            let mut sum = 0f64;
            for u in grid(n) {
                let d = cone(u, one_minus_cos);
                assert!(
                    (d.length() - 1.0).abs() < 1e-6,
                    "{one_minus_cos}: {}",
                    d.length()
                );
                // 1 − cos from the sine, which keeps it for tiny cones.
                let sin2 = f64::from(d.x) * f64::from(d.x) + f64::from(d.y) * f64::from(d.y);
                sum += if d.z > 0.0 {
                    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
                } else {
                    1.0 - f64::from(d.z)
                };
            }
            let mean = sum / (n * n) as f64;
            let expected = f64::from(one_minus_cos) * 0.5;
            assert!(
                (mean / expected - 1.0).abs() < 1e-3,
                "{one_minus_cos}: {mean} {expected}"
            );
        }
    }

    #[test]
    fn the_triangle_map_is_uniform() {
        let n = 256;
        let mut sum = glam::DVec2::ZERO;
        let mut square = 0f64;
        for u in grid(n) {
            let b = triangle(u);
            assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
            sum += b.as_dvec2();
            square += f64::from(b.x * b.x);
        }
        let count = (n * n) as f64;
        assert!((sum / count - glam::DVec2::splat(1.0 / 3.0)).length() < 1e-4);
        // E[u²] = 1/6 over the unit triangle.
        assert!((square / count - 1.0 / 6.0).abs() < 1e-4);
    }
}
