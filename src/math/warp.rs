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

/// Solid angle of a triangle seen from the origin, by the formula of
/// Van Oosterom and Strackee (1983): tan(Ω/2) = |a·(b×c)| / (1 + a·b + b·c + c·a),
/// for unit vectors. The atan2 keeps it well behaved up to a hemisphere.
pub fn spherical_triangle_area(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    // The differences carry the small triangles: a·(b×c) = a·((b−a)×(c−a)), without cancellation.
    let volume = a.dot((b - a).cross(c - a)).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// A direction distributed uniformly over the solid angle of the triangle (a, b, c) of unit
/// vectors (Arvo, *Stratified Sampling of Spherical Triangles*, SIGGRAPH 1995).
///
/// `None` where the triangle is too thin for the angles to be defined in f32.
pub fn spherical_triangle(a: Vec3, b: Vec3, c: Vec3, u: Vec2) -> Option<Vec3> {
    let normal = |p: Vec3, q: Vec3| p.cross(q - p).try_normalize();
    let (ab, bc, ca) = (normal(a, b)?, normal(b, c)?, normal(c, a)?);
    // Inner angles at the corners, from the normals of the great circles; the atan2 form keeps
    // nearly parallel normals accurate (Kahan's angle between unit vectors).
    let angle = |p: Vec3, q: Vec3| 2.0 * (p - q).length().atan2((p + q).length());
    let (alpha, beta, gamma) = (angle(ab, -ca), angle(bc, -ab), angle(ca, -bc));
    let area = alpha + beta + gamma - PI;
    if area <= 0.0 {
        return None;
    }
    let phi = u.x * area - alpha;
    let (sin_phi, cos_phi) = phi.sin_cos();
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    let cos_c = a.dot(b);
    let s = cos_phi - cos_alpha;
    let t = sin_phi + sin_alpha * cos_c;
    let divisor = (t * sin_phi + s * cos_phi) * sin_alpha;
    if divisor == 0.0 {
        return None;
    }
    let cos_b = (((t * cos_phi - s * sin_phi) * cos_alpha - t) / divisor).clamp(-1.0, 1.0);
    let sin_b = (1.0 - cos_b * cos_b).max(0.0).sqrt();
    let toward_c = (c - a * c.dot(a)).try_normalize()?;
    let c_new = a * cos_b + toward_c * sin_b;
    // Uniform on the arc from b to the new corner: 1 − z grows linearly.
    let z_gap = u.y * (1.0 - c_new.dot(b));
    let toward_new = (c_new - b * c_new.dot(b)).try_normalize()?;
    let direction = b * (1.0 - z_gap) + toward_new * (z_gap * (2.0 - z_gap)).max(0.0).sqrt();
    direction.try_normalize()
}

/// Möller–Trumbore barycentric coordinates (u, v) and distance of a direction from the origin,
/// with no bounds test.
pub fn ray_plane_barycentrics(
    p0: Vec3,
    e1: Vec3,
    e2: Vec3,
    origin: Vec3,
    direction: Vec3,
) -> Option<(f32, f32, f32)> {
    let p = direction.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let inv = 1.0 / det;
    let s = origin - p0;
    let u = s.dot(p) * inv;
    let q = s.cross(e1);
    Some((u, direction.dot(q) * inv, e2.dot(q) * inv))
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
    fn spherical_triangle_area_agrees_with_f64_for_all_sizes() {
        let corners = |scale: f64| {
            [
                glam::DVec3::new(-0.3 * scale, -0.2 * scale, 1.0),
                glam::DVec3::new(0.5 * scale, -0.1 * scale, 1.0),
                glam::DVec3::new(0.1 * scale, 0.6 * scale, 1.0),
            ]
            .map(|p| p.normalize())
        };
        // The corners themselves are rounded to f32, relative to a distance of 1: the edges of a
        // triangle of size s carry an error of UNIT_ROUNDOFF / s.
        for scale in [10.0, 1.0, 0.1, 1e-2, 1e-3] {
            let [a, b, c] = corners(scale);
            let exact = 2.0
                * a.dot(b.cross(c))
                    .abs()
                    .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
            let found = f64::from(spherical_triangle_area(
                a.as_vec3(),
                b.as_vec3(),
                c.as_vec3(),
            ));
            let bound = 16.0 * f64::from(UNIT_ROUNDOFF_F32) * (1.0 + 1.0 / scale);
            assert!(
                (found / exact - 1.0).abs() < bound,
                "{scale}: {found} {exact}"
            );
        }
    }
    const UNIT_ROUNDOFF_F32: f32 = super::super::float::UNIT_ROUNDOFF;

    #[test]
    fn spherical_triangle_samples_have_the_mean_direction_of_the_triangle() {
        let a = Vec3::new(1.0, 0.1, 0.2).normalize();
        let b = Vec3::new(-0.2, 1.0, 0.1).normalize();
        let c = Vec3::new(0.1, -0.3, 1.0).normalize();
        let n = 512;
        let mut sum = glam::DVec3::ZERO;
        for u in grid(n) {
            let d = spherical_triangle(a, b, c, u).unwrap();
            sum += d.as_dvec3();
            // Inside: on the inner side of all three great circles.
            for (p, q) in [(a, b), (b, c), (c, a)] {
                assert!(p.cross(q).dot(d) > -1e-5);
            }
        }
        let mean = sum / (n * n) as f64;
        // Exact vector irradiance-like integral: ∫ω dΩ = ½ Σ θ_i n_i (Lambert's formula without
        // the cosine), so the mean direction is that over the area.
        let (ad, bd, cd) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let edge = |p: glam::DVec3, q: glam::DVec3| p.cross(q).normalize() * p.dot(q).acos();
        let exact = 0.5 * (edge(ad, bd) + edge(bd, cd) + edge(cd, ad));
        let area = f64::from(spherical_triangle_area(a, b, c));
        assert!(
            (mean - exact / area).length() < 1e-3,
            "{mean} {}",
            exact / area
        );
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
