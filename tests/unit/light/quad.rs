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
        assert!((f64::from(quad.sample(from, Vec2::ZERO).unwrap().pdf) * all - 1.0).abs() < 1e-5);
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
