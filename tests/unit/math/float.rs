use super::*;
use proptest::prelude::*;

#[test]
fn gamma_grows_a_little_faster_than_its_argument() {
    assert!(gamma(1) >= UNIT_ROUNDOFF);
    assert!(gamma(8) > 8.0 * UNIT_ROUNDOFF && gamma(8) < 8.001 * UNIT_ROUNDOFF);
}

/// Tables of the normal distribution; 6.3e-6 is 5 % of 8160 blocks.
#[test]
fn so_many_deviations_leave_a_share_beyond() {
    for (beyond, deviations) in [
        (0.5, 0.67449),
        (0.05, TWO_SIDED_95),
        (0.01, 2.57583),
        (6.3e-6, 4.5161),
        (1e-9, 6.1094),
    ] {
        let found = two_sided(beyond);
        assert!((found - deviations).abs() < 4.5e-4, "{beyond}: {found}");
    }
}

/// Tables of Student's t.
#[test]
fn few_degrees_of_freedom_make_intervals_wider() {
    for (degrees, wide, off) in [
        (3.0, 3.1824, 0.03),
        (5.0, 2.5706, 4e-3),
        (10.0, 2.2281, 5e-4),
        (30.0, 2.0423, 1e-4),
        (f64::MAX, TWO_SIDED_95, 1e-12),
    ] {
        let found = student_95(degrees);
        assert!((found - wide).abs() < off, "{degrees}: {found}");
    }
    assert_eq!(student_95(-1.0), student_95(1.0));
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
