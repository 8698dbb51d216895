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
#[path = "../../tests/unit/light/spherical_triangle.rs"]
mod tests;
