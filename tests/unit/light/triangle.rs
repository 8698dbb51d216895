use super::*;
use crate::math::warp::grid;

/// ∫ cosθ/π over the triangle's solid angle = its form factor (Lambert's formula), at
/// distances from touching to far away.
#[test]
fn samples_integrate_the_form_factor_at_all_distances() {
    let triangle = Triangle {
        corners: [
            Vec3::new(-0.5, -0.4, 0.0),
            Vec3::new(0.6, -0.3, 0.0),
            Vec3::new(0.1, 0.7, 0.0),
        ],
    };
    for distance in [0.01f32, 0.1, 1.0, 10.0, 100.0, 1e4] {
        let from = Vec3::new(0.05, 0.02, -distance);
        let unit = triangle
            .corners
            .map(|p| (p.as_dvec3() - from.as_dvec3()).normalize());
        let edge = |p: glam::DVec3, q: glam::DVec3| {
            p.cross(q).normalize().z * 2.0 * ((p - q).length() * 0.5).asin()
        };
        let exact = ((edge(unit[0], unit[1]) + edge(unit[1], unit[2]) + edge(unit[2], unit[0]))
            / std::f64::consts::TAU)
            .abs();
        let n = 256;
        let mut sum = 0f64;
        for u in grid(n) {
            let Some(s) = triangle.sample(from, u) else {
                continue;
            };
            let on = triangle.corners[0]
                + (triangle.corners[1] - triangle.corners[0]) * s.u
                + (triangle.corners[2] - triangle.corners[0]) * s.v;
            let pdf = triangle.pdf(from, on);
            assert!(
                (pdf / s.pdf - 1.0).abs() < 2e-3,
                "{distance}: {pdf} {}",
                s.pdf
            );
            sum += f64::from(s.wi.z / s.pdf) * std::f64::consts::FRAC_1_PI;
        }
        let found = sum / f64::from(n * n);
        assert!(
            (found / exact - 1.0).abs() < 3e-3,
            "{distance}: {found} {exact}"
        );
    }
}

#[test]
fn edge_on_and_degenerate_triangles_give_nothing_or_something_finite() {
    let flat = Triangle {
        corners: [
            Vec3::new(0.0, 0.0, 1.0),
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::new(0.0, 0.0, 2.0),
        ],
    };
    let needle = Triangle {
        corners: [
            Vec3::ZERO,
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(2.0, 1e-12, 0.0),
        ],
    };
    for t in [flat, needle] {
        for from in [
            Vec3::new(0.3, 0.0, 0.0),
            Vec3::new(0.3, 1e-6, -1.0),
            Vec3::new(0.0, 0.0, 1.0),
        ] {
            for u in [
                Vec2::ZERO,
                Vec2::splat(0.5),
                Vec2::splat(crate::math::float::ONE_MINUS_EPSILON),
            ] {
                if let Some(s) = t.sample(from, u) {
                    assert!(
                        s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite(),
                        "{s:?}"
                    );
                }
            }
        }
    }
}
