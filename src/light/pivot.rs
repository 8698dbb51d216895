//! A light as a ray through a medium sees it: what places along the ray are chosen by.

use super::estimate::LightBounds;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Where a light is, and which part of a ray it may shine on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pivot {
    /// The middle of its bounds.
    pub center: Vec3,
    /// About how far it reaches from there.
    pub radius: f32,
    /// Distances along the ray: no light is elsewhere, but for rounding.
    pub lit: (f32, f32),
}

/// Of the radius of a light's bounds: a square of side a has an area of a² and about the light of a ball of this radius.
const SMALLER: f32 = 0.7;

impl Pivot {
    /// The radius of a ball that sheds as much light.
    pub fn ball(&self) -> f32 {
        SMALLER * self.radius
    }

    /// The inverse square of the distance to the light, summed over the part of a ray that it shines on: what lies further than what
    /// is `seen` of it counts less and less.
    pub fn falls_on(&self, (origin, direction): (Vec3, Vec3), seen: f32) -> f32 {
        let to = self.center - origin;
        let nearest = to.dot(direction);
        let height = Vec2::new(to.cross(direction).length(), self.ball()).length();
        let (from, to) = self.lit;
        let angle = |t: f32| ((t - nearest) / height).atan();
        let height = height.max(f32::MIN_POSITIVE);
        let dimmed = (-nearest.clamp(from, to) / seen).exp();
        (angle(to) - angle(from)).max(0.0) / height * dimmed.max(1e-3)
    }
}

impl LightBounds {
    /// The light for a ray (direction of length 1) up to an end, which may be infinite. None where it shines on nothing of that.
    pub fn pivot(&self, ray: (Vec3, Vec3), end: f32) -> Option<Pivot> {
        let center = self.center();
        let radius = 0.5 * (self.max - self.min).length();
        let (mut from, mut to) = (0.0f32, end);
        if let Some(front) = &self.front {
            let height = front.normal.dot(ray.0) - front.offset;
            let slope = front.normal.dot(ray.1);
            if slope > 0.0 {
                from = from.max(-height / slope);
            } else if slope < 0.0 {
                to = to.min(-height / slope);
            } else if height <= 0.0 {
                return None;
            }
        }
        // A ray that begins behind the light may end before it begins.
        if from >= to {
            return None;
        }
        let half = self.normals.radians() + self.cos_emission.clamp(-1.0, 1.0).acos();
        if !self.two_sided && half < FRAC_PI_2 {
            // The cone around a ball of that radius.
            let apex = center - self.axis * (radius / half.sin());
            (from, to) = within_cone(ray, (apex, self.axis, half.cos()), (from, to))?;
        }
        let is_some = from < to && center.is_finite() && radius.is_finite();
        is_some.then_some(Pivot {
            center,
            radius,
            lit: (from, to),
        })
    }
}

/// The part of a ray between two distances that lies in a cone, which is one piece.
fn within_cone(
    (origin, direction): (Vec3, Vec3),
    (apex, axis, cos): (Vec3, Vec3, f32),
    (from, to): (f32, f32),
) -> Option<(f32, f32)> {
    let start = origin - apex;
    let (along, across) = (axis.dot(direction), axis.dot(start));
    // (axis · x)² ≥ cos² x² on the ray.
    let a = along * along - cos * cos;
    let b = along * across - cos * cos * direction.dot(start);
    let c = across * across - cos * cos * start.length_squared();
    let root = (b * b - a * c).max(0.0).sqrt();
    let q = -(b + root.copysign(b));
    let (first, second) = (q / a, c / q);
    let (first, second) = (first.min(second), first.max(second));
    let inside = |t: f32| {
        let x = start + direction * t;
        axis.dot(x) >= cos * x.length()
    };
    let stop = |t: f32| if t.is_nan() { from } else { t.clamp(from, to) };
    let stops = [from, stop(first), stop(second), to];
    let piece = |i: usize| {
        let (low, high) = (stops[i], stops[i + 1]);
        let middle = if high.is_finite() {
            0.5 * (low + high)
        } else {
            2.0 * low + start.length()
        };
        (low < high && inside(middle)).then_some((low, high))
    };
    (0..3).find_map(piece)
}

#[cfg(test)]
#[path = "../../tests/unit/light/pivot.rs"]
mod tests;
