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
