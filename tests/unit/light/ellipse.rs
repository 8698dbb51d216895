use super::*;
use crate::math::warp::grid;
use crate::sampler::hashed;
use std::f64::consts::{FRAC_PI_2, PI};

/// Over, near the edge, beside the tip, beside, far beside; round, long, like a needle; down to the plane.
fn ellipses(heights: &[f64]) -> Vec<(DVec2, DVec2, f64)> {
    let halves = [(1.0, 1.0), (1.0, 0.3), (0.2, 1.0), (1.0, 1e-3)];
    let centers = [
        (0.0, 0.0),
        (0.9, 0.05),
        (1.0001, 0.0),
        (0.75, 0.75),
        (3.0, -1.0),
        (-30.0, 0.5),
    ];
    let mut all = Vec::new();
    for (half, center) in halves.into_iter().flat_map(|h| centers.map(|c| (h, c))) {
        all.extend(heights.iter().map(|&h| (half.into(), center.into(), h)));
    }
    all
}

/// y/√(d² + y²) from `low` to `high`, without the cancellation of far ends.
fn sines(d2: f64, low: f64, high: f64) -> f64 {
    let length = |y: f64| (d2 + y * y).sqrt();
    if low < 0.0 && high > 0.0 {
        return high / length(high) - low / length(low);
    }
    let (near, far) = (low.abs().min(high.abs()), low.abs().max(high.abs()));
    let (a, b) = (length(far), length(near));
    (far * far - near * near) * d2 / (a * b * (far * b + near * a))
}

/// The solid angle by strips along y, h/(x² + h²) [y/√(x² + y² + h²)] each; x = h sinh t makes their width follow the
/// distance, and t by a cosine makes it vanish at the ends, where the strips' lengths have vertical tangents.
fn solid_angle(half: DVec2, center: DVec2, h: f64) -> f64 {
    let n = 100_000;
    let ends = [center.x - half.x, center.x + half.x].map(|x| (x / h).asinh());
    let radius = 0.5 * (ends[1] - ends[0]);
    let strip = |i: u32| {
        let (sin, cos) = (PI * (f64::from(i) + 0.5) / f64::from(n)).sin_cos();
        let t = ends[0] + radius * (1.0 - cos);
        let x = h * t.sinh();
        let beside = (x - center.x) / half.x;
        let y = half.y * (1.0 - beside * beside).max(0.0).sqrt();
        let d2 = x * x + h * h;
        h / d2 * sines(d2, center.y - y, center.y + y) * h * t.cosh() * sin
    };
    (0..n).map(strip).sum::<f64>() * radius * PI / f64::from(n)
}

/// The mean of one over the density is the solid angle, and densities differ by less than they are said to.
#[test]
fn the_solid_angle_is_that_of_strips() {
    for (half, center, h) in ellipses(&[3.0, 0.3, 1e-2, 1e-4, 1e-7]) {
        let cone = SphericalEllipse::new(half, center, h).unwrap();
        let exact = solid_angle(half, center, h);
        let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, 0f64);
        for u in grid(128) {
            let (on, density) = cone.sample(u).unwrap();
            assert!(((on - center) / half).length_squared() <= 1.0 + 1e-6);
            // Where the point is, too, it is the same.
            let again = cone.density(on);
            assert!((again / density - 1.0).abs() < 1e-9, "{half} {center} {h}");
            sum += 1.0 / density;
            (least, most) = (least.min(density), most.max(density));
        }
        // The middle rule on azimuths, of a needle's as well.
        let found = sum / (128.0 * 128.0);
        assert!(
            (found / exact - 1.0).abs() < 1e-4,
            "{half} {center} {h}: {found} {exact}"
        );
        assert!(least / most > 0.82, "{half} {center} {h}: {least} {most}");
    }
}

/// Pearson's chi-square over 6 rings of 12 sectors of the ellipse, against the integral of density · h/d³ over each.
#[test]
fn points_have_their_density() {
    const RINGS: u32 = 6;
    const SECTORS: u32 = 12;
    const FINE: u32 = 24;
    for (k, (half, center, h)) in ellipses(&[1.0, 0.1]).into_iter().enumerate() {
        let cone = SphericalEllipse::new(half, center, h).unwrap();
        let mut expected = [[0f64; SECTORS as usize]; RINGS as usize];
        let (rings, sectors) = (RINGS * FINE, SECTORS * FINE);
        for (i, j) in (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
            let radius = (f64::from(i) + 0.5) / f64::from(rings);
            let (sin, cos) = (TAU * (f64::from(j) + 0.5) / f64::from(sectors)).sin_cos();
            let on = center + half * DVec2::new(cos, sin) * radius;
            let area = half.x * half.y * radius / f64::from(rings) * TAU / f64::from(sectors);
            let d = on.extend(h).length();
            expected[(i / FINE) as usize][(j / FINE) as usize] +=
                cone.density(on) * area * h / (d * d * d);
        }
        let whole: f64 = expected.iter().flatten().sum();
        assert!((whole - 1.0).abs() < 1e-3, "{half} {center} {h}: {whole}");
        let n = 40_000u32;
        let mut counts = [[0u32; SECTORS as usize]; RINGS as usize];
        for s in 0..n {
            let u = Vec2::new(hashed(s, 41, k as u32), hashed(s, 42, k as u32));
            let p = (cone.sample(u).unwrap().0 - center) / half;
            let turn = p.y.atan2(p.x).rem_euclid(TAU) / TAU;
            let ring = ((p.length() * f64::from(RINGS)) as usize).min(RINGS as usize - 1);
            counts[ring][((turn * f64::from(SECTORS)) as usize).min(SECTORS as usize - 1)] += 1;
        }
        let (mut chi2, mut degrees) = (0.0, -1f64);
        for (expected, &count) in expected.iter().flatten().zip(counts.iter().flatten()) {
            let expected = expected / whole * f64::from(n);
            if expected >= 5.0 {
                chi2 += (f64::from(count) - expected).powi(2) / expected;
                degrees += 1.0;
            }
        }
        // Wilson and Hilferty: the cube root is nearly normal. 4 σ: one false alarm in 30 000.
        let spread = 2.0 / (9.0 * degrees);
        let z = ((chi2 / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
        assert!(z < 4.0, "{half} {center} {h}: {z} ({chi2} with {degrees})");
    }
}

/// Half a right angle, in the plane itself, and at the corners of the square of numbers.
#[test]
fn known_cones_and_ends() {
    let cone = SphericalEllipse::new(DVec2::ONE, DVec2::ZERO, 1.0).unwrap();
    let density = 1.0 / (TAU * (1.0 - FRAC_PI_2.sin() / 2f64.sqrt()));
    let ends = [0.0, 0.5, crate::math::float::ONE_MINUS_EPSILON];
    for (u, v) in ends.iter().flat_map(|&u| ends.map(|v| (u, v))) {
        let (on, found) = cone.sample(Vec2::new(u, v)).unwrap();
        assert!(on.length() <= 1.0 + 1e-12 && (found / density - 1.0).abs() < 1e-12);
    }
    assert!(SphericalEllipse::new(DVec2::ONE, DVec2::new(2.0, 0.0), 0.0).is_none());
    assert!(SphericalEllipse::new(DVec2::ONE, DVec2::new(f64::NAN, 0.0), 1.0).is_none());
}
