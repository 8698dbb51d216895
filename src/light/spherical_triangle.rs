//! Triangles, sampled by solid angle (Arvo, *Stratified Sampling of Spherical Triangles*, SIGGRAPH 1995).

use glam::{DVec3, Vec2};

/// A triangle as a point sees it.
///
/// In f64, of differences of f32 numbers, which it holds exactly: seen edge on or from a ten-thousandth of its size, the angles
/// at its corners are within f32's rounding of 0 or π. Arvo's way from the area of a part to its third corner goes by the
/// cosine of an arc, which keeps nothing of a short one; here it goes by the tangents of half angles, in which nothing cancels:
/// tan(E/2) = tan(b/2) tan(c/2) sin α / (1 + tan(b/2) tan(c/2) cos α) for two sides b and c about the angle α
/// (Todhunter, *Spherical Trigonometry*, 1886, art. 103), hence
/// tan(b/2) = sin(E/2) / (tan(c/2) sin(α − E/2)).
#[derive(Clone, Copy, Debug)]
pub struct SphericalTriangle {
    /// From the point.
    corners: [DVec3; 3],
    /// To the corners.
    units: [DVec3; 3],
    /// Twice the area times the normal.
    normal: DVec3,
    /// Six times the volume with the point, of the triangle of unit vectors.
    volume: f64,
    solid_angle: f64,
}

impl SphericalTriangle {
    /// From corners relative to the point; `None` where it has no solid angle.
    pub fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [p, q, r] = corners;
        let lengths = corners.map(DVec3::length);
        let normal = (q - p).cross(r - p);
        // By the plane: the volume of three unit vectors would cancel.
        let volume = p.dot(normal).abs() / (lengths[0] * lengths[1] * lengths[2]);
        let units = [p / lengths[0], q / lengths[1], r / lengths[2]];
        let [a, b, c] = units;
        // Van Oosterom and Strackee, *The Solid Angle of a Plane Triangle*, 1983.
        let solid_angle = 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        // Also false for what is not a number: the point is a corner.
        (solid_angle > 0.0).then_some(Self {
            corners,
            units,
            normal,
            volume,
            solid_angle,
        })
    }

    /// Solid angle.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A direction, distributed uniformly over the solid angle.
    pub fn sample(&self, u: Vec2) -> Option<DVec3> {
        let [a, b, c] = self.units;
        let (u, v) = (f64::from(u.x), f64::from(u.y));
        // Tangents at a toward b and c: their lengths are the sines of the sides.
        let to_b = tangent(a, b);
        let to_c = tangent(a, c);
        let (sin_alpha, cos_alpha) = {
            let (s, c) = (self.volume, to_b.dot(to_c));
            let length = (s * s + c * c).sqrt();
            (s / length, c / length)
        };
        let (sin, cos) = (0.5 * u * self.solid_angle).sin_cos();
        // tan(b/2) as a fraction: the arc may be half a turn.
        let over = sin * (a + b).length();
        let under = (b - a).length() * (sin_alpha * cos - cos_alpha * sin).max(0.0);
        let square = over * over + under * under;
        let third = if square > 0.0 {
            let (sin_b, cos_b) = (
                2.0 * over * under / square,
                (under * under - over * over) / square,
            );
            a * cos_b + to_c.try_normalize()? * sin_b
        } else {
            a
        };
        // Uniform on the arc from b to the new corner: 1 − cos grows linearly, up to half the square of the chord.
        let gap = v * 0.5 * (third - b).length_squared();
        let on = b * (1.0 - gap)
            + tangent(b, third).try_normalize()? * (gap * (2.0 - gap)).max(0.0).sqrt();
        on.try_normalize()
    }

    /// Weights of the second and the third corner where a direction meets the plane.
    pub fn barycentrics(&self, direction: DVec3) -> Option<(f64, f64)> {
        let [p, q, r] = self.corners;
        let n = self.normal;
        let t = p.dot(n) / direction.dot(n);
        let on = direction * t - p;
        let square = n.length_squared();
        let (u, v) = (
            on.cross(r - p).dot(n) / square,
            (q - p).cross(on).dot(n) / square,
        );
        (u.is_finite() && v.is_finite()).then_some((u, v))
    }
}

/// The part of unit vector `b` beside unit vector `a`.
fn tangent(a: DVec3, b: DVec3) -> DVec3 {
    (b - a) + a * (0.5 * (b - a).length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::grid;

    /// L'Huilier's theorem, by the sides: another way to the area.
    fn area_by_sides(corners: [DVec3; 3]) -> f64 {
        let [a, b, c] = corners.map(DVec3::normalize);
        let side = |p: DVec3, q: DVec3| 2.0 * (p - q).length().atan2((p + q).length());
        let (x, y, z) = (side(b, c), side(c, a), side(a, b));
        let s = 0.5 * (x + y + z);
        let t = |angle: f64| (0.5 * angle).tan();
        4.0 * (t(s) * t(s - x) * t(s - y) * t(s - z))
            .max(0.0)
            .sqrt()
            .atan()
    }

    fn shapes() -> Vec<[DVec3; 3]> {
        let about = |s: f64, h: f64| {
            [
                DVec3::new(-0.3 * s, -0.2 * s, h),
                DVec3::new(0.5 * s, -0.1 * s, h),
                DVec3::new(0.1 * s, 0.6 * s, h),
            ]
        };
        vec![
            about(1.0, 1.0),
            about(10.0, 1.0),
            about(1e-3, 1.0),
            about(1e-6, 1.0),
            about(1e4, 1.0),
            // Beside it, edge on.
            about(1.0, 1e-3).map(|c| c + DVec3::X),
            // A needle.
            [
                DVec3::new(-1.0, 0.5, 1.0),
                DVec3::new(1.0, 0.5, 1.0),
                DVec3::new(0.0, 0.501, 1.0),
            ],
        ]
    }

    #[test]
    fn the_solid_angle_is_that_by_the_sides() {
        for corners in shapes() {
            let found = SphericalTriangle::new(corners).unwrap().solid_angle();
            let exact = area_by_sides(corners);
            // The differences of sides cancel in the oracle.
            assert!(
                (found / exact - 1.0).abs() < 1e-4,
                "{corners:?}: {found} {exact}"
            );
        }
    }

    /// ∫ω dΩ = ½ Σ angle · (normal of the edge's plane): the mean direction is that over the solid angle.
    #[test]
    fn samples_have_the_mean_direction_and_are_inside() {
        for corners in shapes() {
            let triangle = SphericalTriangle::new(corners).unwrap();
            let n = 128;
            let mut sum = DVec3::ZERO;
            for u in grid(n) {
                let d = triangle.sample(u).unwrap();
                let (v, w) = triangle.barycentrics(d).unwrap();
                let inside = v > -1e-6 && w > -1e-6 && v + w < 1.0 + 1e-6;
                assert!(inside, "{corners:?} {u}: {v} {w}");
                sum += d;
            }
            let [a, b, c] = corners.map(DVec3::normalize);
            let edge = |p: DVec3, q: DVec3| {
                p.cross(q - p).normalize() * 2.0 * (p - q).length().atan2((p + q).length())
            };
            let exact = (edge(a, b) + edge(b, c) + edge(c, a)) * 0.5 / triangle.solid_angle();
            let exact = exact * exact.dot(sum).signum();
            let mean = sum / f64::from(n * n);
            let size = (a - b).length().max((b - c).length());
            assert!(
                (mean - exact).length() < 1e-3 * size,
                "{corners:?}: {mean} {exact}"
            );
        }
    }

    #[test]
    fn what_has_no_solid_angle_is_none() {
        let flat = [DVec3::X, DVec3::Y, DVec3::new(2.0, 3.0, 0.0)];
        assert!(SphericalTriangle::new(flat).is_none());
        assert!(SphericalTriangle::new([DVec3::ZERO, DVec3::X, DVec3::Y]).is_none());
    }
}
