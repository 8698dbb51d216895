//! Rectangles, sampled by solid angle
//! (Ureña, Fajardo, King, *An Area-Preserving Parametrization for Spherical Rectangles*, EGSR 2013).

use glam::{DVec2, Vec2};

/// A rectangle at a height over a point: [x0, x1] × [y0, y1] in its own plane, measured from the
/// foot of the perpendicular.
///
/// In f64: the solid angle is a sum of four angles of order 1, which leaves it an absolute error of about
/// 1e-15; in f32 (1e-6) lights at grazing angles, whose solid angle is small however near they are, would have none
/// of their digits.
#[derive(Clone, Copy, Debug)]
pub struct SphericalRectangle {
    low: DVec2,
    high: DVec2,
    height: f64,
    /// Along the sum of the angles of the last two corners.
    last_two: DVec2,
    solid_angle: f64,
}

/// Least solid angle that keeps five digits of what f64's roundings leave.
const LEAST: f64 = 1e-10;

/// A corner's part of the solid angle, arcsin(p/√(p²+h²) · q/√(q²+h²)), as the angle of a complex number: the square of the
/// cosine is h²(p²+q²+h²) over the same denominator. Near ±π/2 the arcsine itself would lose half of the digits.
fn corner(p: f64, q: f64, height: f64) -> DVec2 {
    DVec2::new(height * (p * p + q * q + height * height).sqrt(), p * q)
}

impl SphericalRectangle {
    /// `None` where the solid angle is too small to be told from rounding; `height` is above 0.
    pub fn new(low: DVec2, high: DVec2, height: f64) -> Option<Self> {
        let [a, b, c, d] = [-low.y, high.x, high.y, -low.x];
        // Angles add where complex numbers are multiplied: one arctangent instead of four.
        let first_two = corner(a, b, height).rotate(corner(b, c, height));
        let last_two = corner(c, d, height).rotate(corner(d, a, height));
        let mut solid_angle = first_two.rotate(last_two).to_angle();
        // It is above π only over the rectangle, where all four angles are positive.
        if solid_angle < 0.0 && [a, b, c, d].iter().all(|side| *side > 0.0) {
            solid_angle += std::f64::consts::TAU;
        }
        (solid_angle >= LEAST).then_some(Self {
            low,
            high,
            height,
            last_two,
            solid_angle,
        })
    }

    /// Solid angle.
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A point of the rectangle, distributed uniformly over its solid angle.
    pub fn sample(&self, u: Vec2) -> DVec2 {
        let u = u.as_dvec2();
        let height2 = self.height * self.height;
        // z-components of the normals of the planes through the point and the lower and the upper side.
        let b0 = -self.low.y / (self.low.y * self.low.y + height2).sqrt();
        let b1 = self.high.y / (self.high.y * self.high.y + height2).sqrt();
        // The paper's angle φ less π, so that small rectangles have small terms.
        let turned = DVec2::from_angle(u.x * self.solid_angle);
        let back = self.last_two / self.last_two.length();
        let DVec2 { x: cos, y: sin } = DVec2::new(back.x, -back.y).rotate(turned);
        let f = (cos * b0 + b1) / sin;
        // c/√(1 − c²) of the paper's c = ±1/√(f² + b0²), with 1 − b0² from the sides.
        let lowest = height2 / (self.low.y * self.low.y + height2);
        let x = (self.height.copysign(f) / (f * f - lowest).max(0.0).sqrt())
            .clamp(self.low.x, self.high.x);
        let d2 = x * x + height2;
        let sine = |y: f64| y / (d2 + y * y).sqrt();
        let (h0, h1) = (sine(self.low.y), sine(self.high.y));
        let h = h0 + u.y * (h1 - h0);
        let y =
            (h * (d2 / (1.0 - h * h).max(f64::MIN_POSITIVE)).sqrt()).clamp(self.low.y, self.high.y);
        DVec2::new(x, y)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/rectangle.rs"]
mod tests;
