//! Every bound and tolerance of the project, named and derived.

use glam::{DAffine3, DVec3, Vec3};

/// Half the distance from 1 to the next f32: the largest relative error of one rounding.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// The largest f32 below 1: random numbers never reach 1.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - UNIT_ROUNDOFF;

/// relMSE is the mean of (x - r)² / (r² + this): it keeps errors finite where the reference is black. The project's goals are
/// stated with it (Rousselle et al. 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization").
pub const REL_MSE_OFFSET: f64 = 0.01;

/// Of a normal distribution, 95 % lie within so many standard deviations.
pub const TWO_SIDED_95: f64 = 1.959_963_985;

/// How many standard deviations of a normal distribution lie to each side within which all but a share is: 0.05 gives
/// [`TWO_SIDED_95`], to 4.5e-4 (Abramowitz and Stegun, *Handbook of Mathematical Functions*, 26.2.23, after Hastings).
pub fn two_sided(beyond: f64) -> f64 {
    let t = (-2.0 * (0.5 * beyond).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

/// [`TWO_SIDED_95`] for a deviation that is itself known from so many degrees of freedom, 1 at least: the expansion of Student's t
/// about the normal distribution (Abramowitz and Stegun, 26.7.5). 1 % too low at 3 degrees, 3 % at 2.
pub fn student_95(degrees: f64) -> f64 {
    let z = TWO_SIDED_95;
    let odd = |a: f64, b: f64, c: f64, d: f64| z * (a + z * z * (b + z * z * (c + z * z * d)));
    let terms = [
        odd(1.0, 1.0, 0.0, 0.0) / 4.0,
        odd(3.0, 16.0, 5.0, 0.0) / 96.0,
        odd(-15.0, 17.0, 19.0, 3.0) / 384.0,
    ];
    let by = degrees.max(1.0).recip();
    z + by * (terms[0] + by * (terms[1] + by * terms[2]))
}

/// γ(n) = n·u / (1 − n·u): bounds the relative error of n roundings in a row
/// (Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., lemma 3.1).
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// The next larger f32; infinity and NaN stay as they are.
pub fn next_up(x: f32) -> f32 {
    x.next_up()
}

/// The next smaller f32.
pub fn next_down(x: f32) -> f32 {
    x.next_down()
}

/// A point with a bound on its absolute error along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedPoint {
    /// The computed point.
    pub point: Vec3,
    /// The true point lies within ± this along each axis.
    pub error: Vec3,
}

/// The point p0 + u·e1 + v·e2 takes at most four roundings on any way through it (edge, product,
/// two sums), so γ(4) of the magnitudes bounds its own error (Pharr, Jakob, Humphreys,
/// *Physically Based Rendering*, 4th ed., §6.8). Embree's robust test subtracts the ray's origin
/// from the corners and forms edges and products of them anew, four roundings more, before it can
/// tell that a ray that starts here leaves: hence eight. Measured without leaks: NUMERICS.md 2.2.
const TRIANGLE_POINT_ROUNDINGS: u32 = 8;

/// The point at barycentric coordinates (u, v) of a triangle, with its error bound.
///
/// Computed from the corners and not from the ray, so that the error does not grow with the
/// distance that the ray has come; and from edges, so that 1 − u − v does not cancel.
#[inline]
pub fn triangle_point(corners: [Vec3; 3], u: f32, v: f32) -> BoundedPoint {
    let [p0, p1, p2] = corners;
    let (a, b) = ((p1 - p0) * u, (p2 - p0) * v);
    BoundedPoint {
        point: p0 + a + b,
        error: (p0.abs() + a.abs() + b.abs()) * gamma(TRIANGLE_POINT_ROUNDINGS),
    }
}

/// Points keep so many times their error from the edges of their triangle. A point that lies on the wrong side of the
/// neighbour by its error, or comes there when it is moved along the normal, would see what is behind it. In a corner
/// of angle θ the neighbour is d sin θ − e cos θ away from a point at d from the edge that is moved by e, of which it
/// needs e to be safe: with e ≤ √3 times the largest error of an axis, 8 times that do for angles from 30° on.
const EDGE_ERRORS: f32 = 8.0;

/// Weights below this are looked at more closely. A triangle so small that this is too little has 256 errors of a
/// point between an edge and its opposite corner.
const NEAR_AN_EDGE: f32 = 1.0 / 32.0;

/// Whether a point may lie too near to an edge; a twelfth of all do.
#[inline]
pub fn is_near_an_edge(u: f32, v: f32) -> bool {
    u < NEAR_AN_EDGE || v < NEAR_AN_EDGE || 1.0 - u - v < NEAR_AN_EDGE
}

/// Weights of a point so far from all edges that its error (the largest of an axis) cannot bring it to their other
/// side; the middle of the inscribed circle if none is so far. `edges`: from the first corner to the others.
#[cold]
pub fn off_the_edges([a, b]: [Vec3; 2], u: f32, v: f32, error: f32) -> (f32, f32) {
    // By the longest edge, so that no product leaves the range of f32.
    let size = a.abs().max_element().max(b.abs().max_element());
    if size <= 0.0 || !size.is_finite() {
        return (u, v);
    }
    let (a, b) = (a / size, b / size);
    let area = a.cross(b).length();
    // A weight is the distance from an edge over the height, which is twice the area over the edge.
    let least =
        Vec3::new(b.length(), a.length(), (b - a).length()) * (EDGE_ERRORS * error / size / area);
    let sum = least.element_sum();
    if !sum.is_finite() {
        return (u, v);
    }
    if sum >= 1.0 {
        return (least.x / sum, least.y / sum);
    }
    let beyond = (Vec3::new(u, v, 1.0 - u - v) - least).max(Vec3::ZERO);
    let share = (1.0 - sum) / beyond.element_sum();
    (least.x + beyond.x * share, least.y + beyond.y * share)
}

/// How much less certain the point on a triangle has to be than the point on the ray for the latter to be taken.
/// A 20th of a pixel of a picture 1000 pixels wide: the ray's error is γ(3), 256 of which are 5e-5 of its length.
const MUCH_LESS_CERTAIN: f32 = 256.0;

/// The point where a ray meets a triangle: `by_corners`, or `origin + along` where the triangle is so large that its
/// corners tell nearly nothing of the place. A ground of 10⁷ m has points that are a metre apart, and none for the
/// shadow of what is a millimetre large.
///
/// The distance to the plane keeps the bound of `by_corners`, as Embree has the ray's length from the same corners,
/// and adds the three roundings of the point on the ray. (Along the axes in which the plane does not extend, the large
/// errors of `by_corners` do not count: [`ray_origin`] weighs them with the normal.)
#[inline]
pub fn hit_point(by_corners: BoundedPoint, origin: Vec3, along: Vec3) -> BoundedPoint {
    let error = (origin.abs() + along.abs()) * gamma(3);
    if by_corners.error.max_element() <= error.max_element() * MUCH_LESS_CERTAIN {
        return by_corners;
    }
    BoundedPoint {
        point: origin + along,
        error: by_corners.error + error,
    }
}

/// Row-major 3×4 affine transform in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Images of the axes.
    pub x: Vec3,
    /// Image of the y axis.
    pub y: Vec3,
    /// Image of the z axis.
    pub z: Vec3,
    /// Image of the origin.
    pub translation: Vec3,
}

impl Affine {
    /// Rounds an f64 transform after its translation was made relative to `origin`.
    pub fn from_f64(transform: &DAffine3, origin: DVec3) -> Self {
        Self {
            x: transform.matrix3.x_axis.as_vec3(),
            y: transform.matrix3.y_axis.as_vec3(),
            z: transform.matrix3.z_axis.as_vec3(),
            translation: (transform.translation - origin).as_vec3(),
        }
    }

    /// Transforms a direction.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// Transforms a point and its error bound: the incoming error is carried by |M|, and the
    /// product itself adds γ(4) of the summed magnitudes (three products, three additions in a
    /// row of at most four roundings; PBR 4th ed., §6.8.6).
    pub fn bounded_point(&self, p: BoundedPoint) -> BoundedPoint {
        let q = p.point;
        let point = self.vector(q) + self.translation;
        let magnitude =
            self.x.abs() * q.x.abs() + self.y.abs() * q.y.abs() + self.z.abs() * q.z.abs();
        let carried =
            self.x.abs() * p.error.x + self.y.abs() * p.error.y + self.z.abs() * p.error.z;
        BoundedPoint {
            point,
            error: carried * (1.0 + gamma(4)) + (magnitude + self.translation.abs()) * gamma(4),
        }
    }
}

/// The origin of a ray that leaves the surface through `p` to the side to which the unit normal
/// points: moved along it until the error box of `p` lies behind, then
/// rounded away from the surface (PBR 4th ed., §6.8.6). No epsilon: the offset is the bound.
///
/// Which side that is has to be known, not told by the ray's direction: the cosine of one that grazes rounds to either
/// side of 0, and then the ray starts behind a wall that it has never passed.
pub fn ray_origin(p: BoundedPoint, side: Vec3) -> Vec3 {
    let offset = side * side.abs().dot(p.error);
    let moved = p.point + offset;
    let away = |value: f32, toward: f32| {
        if toward > 0.0 {
            next_up(value)
        } else if toward < 0.0 {
            next_down(value)
        } else {
            value
        }
    };
    Vec3::new(
        away(moved.x, offset.x),
        away(moved.y, offset.y),
        away(moved.z, offset.z),
    )
}

/// Where rays that leave a surface begin to look for others. A plane of which all points have 0 as one coordinate has
/// no error along it, so that rays leave it from where it is; Embree then finds it at distance 0, which is no hit.
pub const RAY_START: f32 = f32::MIN_POSITIVE;

/// How much of a shadow ray's length is traced: the far end is as uncertain as a computed point
/// (direction and distance come from a difference, a square root and a division: γ(8) covers
/// them), so a shadow ray ends that share before the light.
pub const SHADOW_RAY_SHARE: f32 = 1.0 - 2.0 * gamma(8);

/// Whether a vector is of unit length but for roundings: each component of a normalised one is off by at most 5 u (a sum
/// of three squares, its root, a reciprocal, a product), one that a frame has turned by 10 more (three products and two
/// sums with axes that are themselves off), a square doubles that and is itself a sum of three: below 64 u.
pub fn is_unit(v: Vec3) -> bool {
    (v.length_squared() - 1.0).abs() <= 64.0 * UNIT_ROUNDOFF
}

#[cfg(test)]
#[path = "../../tests/unit/math/float.rs"]
mod tests;
