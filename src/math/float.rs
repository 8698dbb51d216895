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
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn gamma_grows_a_little_faster_than_its_argument() {
        assert!(gamma(1) >= UNIT_ROUNDOFF);
        assert!(gamma(8) > 8.0 * UNIT_ROUNDOFF && gamma(8) < 8.001 * UNIT_ROUNDOFF);
    }

    /// A ray of 5 mm onto a level ground of 10⁷ m, 3 mm below: within the bound of the height, and where the ray goes.
    #[test]
    fn a_point_on_a_huge_triangle_is_where_the_ray_goes() {
        let h = -3e-3f32;
        let corners = [[-1e7, h, 1e7], [1e7, h, 1e7], [1e7, h, -1e7]].map(Vec3::from);
        let (origin, along) = (Vec3::new(1e-3, 0.0, 2e-3), Vec3::new(4e-3, h, 1e-3));
        let by_corners = triangle_point(corners, 0.5, 0.5);
        let point = hit_point(by_corners, origin, along);
        assert!((point.point - Vec3::new(5e-3, h, 3e-3)).abs().max_element() < 1e-9);
        assert!(point.error.y < 4e-3 * gamma(32));
        // A triangle of the ray's size keeps its own point.
        let near = triangle_point(corners.map(|c| c * 1e-9), 0.5, 0.5);
        assert_eq!(hit_point(near, origin, along), near);
    }

    /// By the distances to the edges in f64; those within the edges' reach stay where they are.
    #[test]
    fn points_off_the_edges_have_their_distance() {
        let (a, b) = (Vec3::new(3.0, 0.1, 0.0), Vec3::new(0.2, 0.5, 0.4));
        let distances = |u: f32, v: f32| {
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            let area = a.cross(b).length();
            let (u, v) = (f64::from(u), f64::from(v));
            let by = |weight: f64, edge: DVec3| weight * area / edge.length();
            [by(u, b), by(v, a), by(1.0 - u - v, b - a)]
        };
        let error = 1e-4;
        for (u, v) in [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (0.5, 0.5),
            (0.3, 0.0),
            (-1e-7, 1e-3),
        ] {
            let (u, v) = off_the_edges([a, b], u, v, error);
            for distance in distances(u, v) {
                assert!(distance > 7.999 * f64::from(error), "{u} {v}: {distance}");
            }
        }
        let (u, v) = off_the_edges([a, b], 0.3, 0.4, error);
        assert!((u - 0.3).abs() < 1e-6 && (v - 0.4).abs() < 1e-6);
        // No place is so far from all edges: the one that is farthest has the same distance from each.
        let (u, v) = off_the_edges([a, b], 0.9, 0.05, 1.0);
        let [x, y, z] = distances(u, v);
        assert!((x - y).abs() < 1e-6 && (y - z).abs() < 1e-6);
        assert_eq!(off_the_edges([a, a * 2.0], 0.5, 0.0, error), (0.5, 0.0));
    }

    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![-1.0f32..1.0, -1e5f32..1e5, -1e-4f32..1e-4]
    }

    prop_compose! {
        fn point()(x in coordinate(), y in coordinate(), z in coordinate()) -> Vec3 { Vec3::new(x, y, z) }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..Default::default() })]

        #[test]
        fn the_error_bound_of_a_triangle_point_holds(p0 in point(), p1 in point(), p2 in point(), a in 0.0f32..1.0, b in 0.0f32..1.0) {
            let (u, v) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            let found = triangle_point([p0, p1, p2], u, v);
            let (ud, vd) = (f64::from(u), f64::from(v));
            let exact = p0.as_dvec3() * (1.0 - ud - vd) + p1.as_dvec3() * ud + p2.as_dvec3() * vd;
            let error = (found.point.as_dvec3() - exact).abs();
            prop_assert!(error.cmple(found.error.as_dvec3()).all(), "{error:?} > {:?}", found.error);
        }

        #[test]
        fn the_error_bound_of_a_transformed_point_holds(p in point(), x in point(), y in point(), z in point(), t in point()) {
            let m = Affine { x, y, z, translation: t };
            let found = m.bounded_point(BoundedPoint { point: p, error: Vec3::ZERO });
            let p = p.as_dvec3();
            let exact = x.as_dvec3() * p.x + y.as_dvec3() * p.y + z.as_dvec3() * p.z + t.as_dvec3();
            let error = (found.point.as_dvec3() - exact).abs();
            prop_assert!(error.cmple(found.error.as_dvec3()).all(), "{error:?} > {:?}", found.error);
        }

        #[test]
        fn a_ray_origin_lies_beyond_the_error_box(p in point(), n in point(), scale in 1e-7f32..1e-3) {
            prop_assume!(n.length() > 1e-3);
            let n = n.normalize();
            let error = p.abs() * scale;
            let origin = ray_origin(BoundedPoint { point: p, error }, n);
            let moved = (origin - p).as_dvec3().dot(n.as_dvec3());
            let reach = n.abs().as_dvec3().dot(error.as_dvec3());
            // Each axis is rounded to the nearest once and away from the surface once.
            prop_assert!(moved >= reach * (1.0 - 1e-5) - 1e-30, "{moved} < {reach}");
        }
    }
}
