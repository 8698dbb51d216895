//! Emissive rectangles that a mesh has as two triangles, sampled as one by solid angle.

use super::rectangle::SphericalRectangle;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Two triangles that are a rectangle.
#[derive(Clone, Debug)]
pub struct Quad {
    /// An end of the edge that the triangles share.
    corner: DVec3,
    /// Unit vectors along the edges from there, and of the winding's normal.
    x: DVec3,
    y: DVec3,
    normal: DVec3,
    size: DVec2,
    /// Which corner of each triangle begins the shared edge.
    turns: [u8; 2],
}

/// A point on a rectangle.
#[derive(Clone, Copy, Debug)]
pub struct QuadSample {
    /// It is on the second of the triangles.
    pub second: bool,
    /// Weights of the second and third corner of its triangle.
    pub weights: Vec2,
    /// Direction from the lit point, unit length.
    pub wi: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
}

/// Corners may be so far from those of a rectangle, by its shorter edge, as what is rounded to f32 and turned and moved is:
/// 64 roundings. The density is that of the rectangle, and off by no more than a few times that.
const ASKEW: f64 = 1.0 / 131_072.0;

/// Rectangles that are this many times their half diagonals away are sampled by area, which saves the angles. Seen from the side
/// their distances, the third power of which weighs a sample, have a standard deviation of 3 · (1/√3) / 16 of one at most: a relative
/// variance of 1.2 %.
const FAR: f64 = 16.0;

/// How points are drawn.
enum Plan {
    Spherical(SphericalRectangle),
    /// Its middle is far away, or its solid angle is less than rounding tells.
    Flat,
}

/// A rectangle as a point sees it.
struct Seen {
    /// Its first corner by its own axes, from the foot of the point's perpendicular.
    low: DVec2,
    /// To its plane, along its normal.
    height: f64,
    plan: Plan,
}

impl Quad {
    /// Its area.
    pub fn area(&self) -> f64 {
        self.size.x * self.size.y
    }

    /// `None` if the triangles are none together.
    pub fn new(first: [Vec3; 3], second: [Vec3; 3]) -> Option<Self> {
        let turns = (0..9).map(|k| [k / 3, k % 3]);
        let [i, j] = turns
            .into_iter()
            .find(|[i, j]| first[*i] == second[(j + 1) % 3] && first[(i + 1) % 3] == second[*j])?;
        let corner = first[i].as_dvec3();
        let from = |p: Vec3| p.as_dvec3() - corner;
        let (across, a, b) = (
            from(first[(i + 1) % 3]),
            from(second[(j + 2) % 3]),
            from(first[(i + 2) % 3]),
        );
        let size = DVec2::new(a.length(), b.length());
        let x = a.try_normalize()?;
        let normal = a.cross(b).try_normalize()?;
        let askew = (across - a - b).length();
        let is_rectangle =
            askew <= ASKEW * size.min_element() && a.dot(b).abs() <= ASKEW * size.x * size.y;
        is_rectangle.then(|| Self {
            corner,
            x,
            y: normal.cross(x),
            normal,
            size,
            turns: [i as u8, j as u8],
        })
    }

    /// Unit normal by winding.
    pub fn normal(&self) -> Vec3 {
        self.normal.as_vec3()
    }

    /// `None` for points in its plane.
    #[inline]
    fn seen(&self, from: Vec3) -> Option<Seen> {
        let to = self.corner - from.as_dvec3();
        let low = DVec2::new(to.dot(self.x), to.dot(self.y));
        let height = to.dot(self.normal);
        let half = self.size * 0.5;
        if height == 0.0 {
            return None;
        }
        let distance2 = height * height + (low + half).length_squared();
        let plan = if distance2 > FAR * FAR * half.length_squared() {
            Plan::Flat
        } else {
            SphericalRectangle::new(low, low + self.size, height.abs())
                .map_or(Plan::Flat, Plan::Spherical)
        };
        Some(Seen { low, height, plan })
    }

    /// Density at a point by its place from the foot of the perpendicular.
    #[inline]
    fn density(&self, seen: &Seen, lateral: DVec2) -> f32 {
        let pdf = match &seen.plan {
            Plan::Spherical(rectangle) => 1.0 / rectangle.solid_angle(),
            Plan::Flat => {
                let distance2 = lateral.length_squared() + seen.height * seen.height;
                distance2 * distance2.sqrt() / (seen.height.abs() * self.area())
            }
        };
        pdf as f32
    }

    /// Draws a point.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<QuadSample> {
        let seen = self.seen(from)?;
        let lateral = match &seen.plan {
            Plan::Spherical(rectangle) => rectangle.sample(u),
            Plan::Flat => seen.low + self.size * u.as_dvec2(),
        };
        let pdf = self.density(&seen, lateral);
        if !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        let wi = self.x * lateral.x + self.y * lateral.y + self.normal * seen.height;
        let place = ((lateral - seen.low) / self.size).clamp(DVec2::ZERO, DVec2::ONE);
        let (second, weights) = self.on_triangle(place);
        Some(QuadSample {
            second,
            weights,
            wi: wi.normalize().as_vec3(),
            pdf,
        })
    }

    /// Density of [`Self::sample`] for the point `on` of the rectangle.
    #[inline]
    pub fn pdf(&self, from: Vec3, on: Vec3) -> f32 {
        let Some(seen) = self.seen(from) else {
            return 0.0;
        };
        let to = on.as_dvec3() - from.as_dvec3();
        self.density(&seen, DVec2::new(to.dot(self.x), to.dot(self.y)))
    }

    /// On which triangle a point is that has shares of the edges, and where. The shared edge is the diagonal from (0, 0) to
    /// (1, 1); the first triangle has (0, 1) beside it, the second, which has the diagonal the other way, (1, 0).
    #[inline]
    fn on_triangle(&self, place: DVec2) -> (bool, Vec2) {
        let DVec2 { x, y } = place;
        let second = x > y;
        let (weights, turn) = if second {
            ([y, 1.0 - x, x - y], self.turns[1])
        } else {
            ([1.0 - y, x, y - x], self.turns[0])
        };
        // The weights begin with the corner that begins the shared edge.
        let of = |corner: usize| weights[(corner + 3 - turn as usize) % 3] as f32;
        (second, Vec2::new(of(1), of(2)))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/quad.rs"]
mod tests;
