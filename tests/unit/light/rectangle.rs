use super::*;
use std::f64::consts::TAU;

fn rectangles() -> Vec<(DVec2, DVec2, f64)> {
    vec![
        (DVec2::new(-1.0, -1.0), DVec2::new(1.0, 1.0), 1.0),
        (DVec2::new(-0.3, 0.2), DVec2::new(1.7, 0.9), 0.5),
        (DVec2::new(3.0, -5.0), DVec2::new(4.0, 2.0), 0.01),
        (DVec2::new(-2.0, -3.0), DVec2::new(2.0, 1.0), 1e-5),
        (DVec2::new(-1e-3, -1e-3), DVec2::new(2e-3, 1e-3), 1.0),
        (DVec2::new(40.0, 10.0), DVec2::new(40.5, 10.2), 3.0),
    ]
}

/// Against the sum of two triangles (Van Oosterom and Strackee), in f64.
#[test]
fn the_solid_angle_is_that_of_two_triangles() {
    for (low, high, height) in rectangles() {
        let corner = |x: f64, y: f64| glam::DVec3::new(x, y, height).normalize();
        let (a, b, c, d) = (
            corner(low.x, low.y),
            corner(high.x, low.y),
            corner(high.x, high.y),
            corner(low.x, high.y),
        );
        let triangle = |a: glam::DVec3, b: glam::DVec3, c: glam::DVec3| {
            2.0 * a
                .dot((b - a).cross(c - a))
                .abs()
                .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
        };
        let exact = triangle(a, b, c) + triangle(a, c, d);
        let found = SphericalRectangle::new(low, high, height)
            .unwrap()
            .solid_angle();
        assert!((found / exact - 1.0).abs() < 1e-8, "{low} {high} {height}");
    }
    let half_space = SphericalRectangle::new(DVec2::splat(-1e6), DVec2::splat(1e6), 1e-3).unwrap();
    assert!((half_space.solid_angle() / TAU - 1.0).abs() < 1e-8);
}

/// Pearson's chi-square over 8 × 8 cells of the rectangle, whose shares are the cells' own solid angles.
#[test]
fn samples_are_uniform_in_solid_angle() {
    for (k, (low, high, height)) in rectangles().into_iter().enumerate() {
        let rectangle = SphericalRectangle::new(low, high, height).unwrap();
        const CELLS: usize = 8;
        let cell = |i: usize, j: usize| {
            let size = (high - low) / CELLS as f64;
            let at = low + size * DVec2::new(i as f64, j as f64);
            SphericalRectangle::new(at, at + size, height).map_or(0.0, |r| r.solid_angle())
        };
        let n = 100_000u32;
        let mut counts = [[0u32; CELLS]; CELLS];
        for s in 0..n {
            let u = Vec2::new(
                crate::sampler::hashed(s, 1, k as u32),
                crate::sampler::hashed(s, 2, k as u32),
            );
            let p = (rectangle.sample(u) - low) / (high - low) * CELLS as f64;
            counts[(p.x as usize).min(CELLS - 1)][(p.y as usize).min(CELLS - 1)] += 1;
        }
        // Cells that expect fewer than five samples are taken together.
        let (mut chi2, mut degrees, mut rest) = (0.0, -1.0, (0.0, 0.0));
        for (i, column) in counts.iter().enumerate() {
            for (j, &count) in column.iter().enumerate() {
                let expected = cell(i, j) / rectangle.solid_angle() * f64::from(n);
                if expected < 5.0 {
                    rest.0 += expected;
                    rest.1 += f64::from(count);
                } else {
                    chi2 += (f64::from(count) - expected).powi(2) / expected;
                    degrees += 1.0;
                }
            }
        }
        if rest.0 >= 5.0 {
            chi2 += (rest.1 - rest.0).powi(2) / rest.0;
            degrees += 1.0;
        }
        // Wilson and Hilferty: the cube root is nearly normal. 4 σ: one false alarm in 30 000.
        let degrees: f64 = degrees;
        let spread = 2.0 / (9.0 * degrees);
        let z = ((chi2 / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
        assert!(z < 4.0, "{k}: {z} ({chi2} with {degrees})");
    }
}

#[test]
fn corners_of_the_square_stay_inside_and_nothing_is_nan() {
    let ends = [0.0, 0.5, crate::math::float::ONE_MINUS_EPSILON];
    for (low, high, height) in rectangles() {
        let rectangle = SphericalRectangle::new(low, high, height).unwrap();
        for (u, v) in ends.iter().flat_map(|&u| ends.map(|v| (u, v))) {
            let p = rectangle.sample(Vec2::new(u, v));
            assert!(p.cmpge(low).all() && p.cmple(high).all(), "{p}");
        }
    }
    assert!(SphericalRectangle::new(DVec2::ZERO, DVec2::splat(1e-7), 1.0).is_none());
}
