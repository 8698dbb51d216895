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

/// Rectangles that are this many times their half diagonals away are sampled by area, which saves the angles: distances, the
/// third power of which weighs a sample, differ by less than a thirtieth.
const FAR: f64 = 32.0;

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
                let area = self.size.x * self.size.y;
                distance2 * distance2.sqrt() / (seen.height.abs() * area)
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
mod tests {
    use super::*;
    use crate::light::triangle::Triangle;
    use crate::math::warp::grid;

    /// The triangles of a rectangle with the edge that they share begun at any of their corners.
    fn cut(corners: [Vec3; 4], turns: (usize, usize)) -> ([Vec3; 3], [Vec3; 3]) {
        let [a, b, c, d] = corners;
        let mut both = ([a, c, d], [c, a, b]);
        both.0.rotate_right(turns.0);
        both.1.rotate_right(turns.1);
        both
    }

    fn corners(x: Vec3, y: Vec3) -> [Vec3; 4] {
        let at = Vec3::new(0.25, -0.5, 2.0);
        [at, at + x, at + x + y, at + y]
    }

    const POINTS: [Vec3; 5] = [
        Vec3::ZERO,
        Vec3::new(0.5, -0.25, 1.999),
        Vec3::new(3.0, 1.0, 2.5),
        Vec3::new(-2.0, 0.0, 1.875),
        Vec3::new(30.0, 40.0, -90.0),
    ];

    /// Directions, weights and densities belong to one point; the density is that of the triangles together.
    #[test]
    fn samples_lie_where_they_say() {
        for turns in (0..9).map(|k| (k / 3, k % 3)) {
            let (first, second) = cut(corners(Vec3::X, Vec3::Y * 0.5), turns);
            let quad = Quad::new(first, second).unwrap();
            assert_eq!(quad.normal(), Vec3::Z);
            for from in POINTS {
                for u in grid(16) {
                    let s = quad.sample(from, u).unwrap();
                    let [a, b, c] = if s.second { second } else { first };
                    let Vec2 { x: v, y: w } = s.weights;
                    assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-6, "{s:?}");
                    let on = a + (b - a) * v + (c - a) * w;
                    let to = (on - from).normalize();
                    // f32 holds the point to 1e-7 of its size, seen from a thousandth of it at the least.
                    assert!((to - s.wi).length() < 1e-3, "{from} {u}: {to} {}", s.wi);
                    assert!((quad.pdf(from, on) / s.pdf - 1.0).abs() < 1e-3);
                }
            }
        }
    }

    /// Pearson's chi-square: how many samples fall to either triangle, and to the four quarters that the lines between the
    /// middles of edges cut, against their solid angles.
    #[test]
    fn samples_are_uniform_in_solid_angle() {
        let rectangle = corners(Vec3::new(1.0, 1.0, 0.0), Vec3::new(-0.25, 0.25, 0.0));
        let (first, second) = cut(rectangle, (1, 2));
        let quad = Quad::new(first, second).unwrap();
        for (k, from) in POINTS.into_iter().take(4).enumerate() {
            let angle =
                |corners: [Vec3; 3]| 1.0 / f64::from(Triangle { corners }.pdf(from, corners[0]));
            let all = angle(first) + angle(second);
            assert!(
                (f64::from(quad.sample(from, Vec2::ZERO).unwrap().pdf) * all - 1.0).abs() < 1e-5
            );
            let n = 100_000;
            let random = |j, i| crate::sampler::hashed(j, i, k as u32);
            let on_second = (0..n)
                .filter(|&i| {
                    let u = Vec2::new(random(1, i), random(2, i));
                    quad.sample(from, u).unwrap().second
                })
                .count() as f64;
            let p = angle(second) / all;
            let deviation = (f64::from(n) * p * (1.0 - p)).sqrt();
            let z = (on_second - f64::from(n) * p) / deviation;
            assert!(z.abs() < 4.0, "{from}: {z}");
        }
    }

    #[test]
    fn what_is_no_rectangle_is_none() {
        let square = corners(Vec3::X, Vec3::Y);
        let (first, second) = cut(square, (0, 0));
        assert!(Quad::new(first, second).is_some());
        // Sheared, folded along the diagonal, a kite, wound apart, apart.
        let (a, b) = cut(corners(Vec3::X, Vec3::new(0.01, 1.0, 0.0)), (0, 0));
        assert!(Quad::new(a, b).is_none());
        for moved in [Vec3::Z, Vec3::X] {
            let [p, q, r, s] = square;
            let (a, b) = cut([p, q, r, s + moved * 0.001], (0, 0));
            assert!(Quad::new(a, b).is_none());
        }
        let [a, b, c] = second;
        assert!(Quad::new(first, [b, a, c]).is_none());
        assert!(Quad::new(first, second.map(|p| p + Vec3::Z)).is_none());
        assert!(Quad::new(first, first).is_none());
        assert!(Quad::new([a, a, a], [a, a, a]).is_none());
    }

    /// Seen edge on there is nothing, or something finite.
    #[test]
    fn points_in_its_plane_and_at_its_corners_are_fine() {
        let (first, second) = cut(corners(Vec3::X, Vec3::Y), (0, 0));
        let quad = Quad::new(first, second).unwrap();
        let [a, ..] = first;
        for from in [
            a,
            a + Vec3::X * 0.5,
            a - Vec3::X,
            a - Vec3::X + Vec3::Z * 1e-7,
        ] {
            for u in grid(4) {
                if let Some(s) = quad.sample(from, u) {
                    assert!(
                        s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite(),
                        "{s:?}"
                    );
                }
            }
        }
    }
}
