use super::*;

const WHITE: Fibre = Fibre {
    absorption: Vec3::ZERO,
    roughness: Vec2::new(0.4, 0.5),
    first: 1.0,
    tilt: -0.035,
    ior: 1.55,
};

fn lean(angle: f32) -> Vec2 {
    Vec2::new(angle.sin(), angle.cos())
}

/// I₀(x) = ∫ exp(x cos t) dt/π over 0 to π, by the trapezoidal rule, which is exact to roundings for what is periodic.
#[test]
fn bessel_functions_are_those_of_their_integral() {
    for x in [0.0f32, 0.3, 2.0, 3.7, 3.8, 12.0, 80.0, 2000.0] {
        let n = 4000;
        let at = |k: i32| {
            (f64::from(x) * ((std::f64::consts::PI * f64::from(k) / f64::from(n)).cos() - 1.0))
                .exp()
        };
        let sum: f64 = (0..n).map(|k| 0.5 * (at(k) + at(k + 1))).sum();
        let expected = (sum / f64::from(n)).ln();
        let found = f64::from(ln_bessel_i0_scaled(x));
        // 2e-7 of the polynomials, and roundings of the logarithm's parts.
        assert!(
            (found - expected).abs() < 2e-6 + 2e-7 * f64::from(x).min(4.0),
            "{x}: {found} {expected}"
        );
    }
}

#[test]
fn spreads_integrate_to_one() {
    for roughness in [0.05, 0.1, 0.3, 0.6, 1.0] {
        for view in [0.0f32, 0.5, 1.3] {
            let v = variance(roughness);
            let n = 20_000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
            let mut sum = 0f64;
            for k in 0..n {
                let angle = (std::f64::consts::PI * at(k)) as f32;
                let density = along(lean(angle), lean(view), v);
                sum += f64::from(density * angle.cos()) * std::f64::consts::PI / f64::from(n);
            }
            assert!((sum - 1.0).abs() < 2e-4, "along {roughness} {view}: {sum}");
        }
        let (n, s) = (20_000, scale(roughness));
        let turn = |k: i32| TAU * ((k as f32 + 0.5) / n as f32 - 0.5);
        let sum: f64 = (0..n).map(|k| f64::from(around(turn(k), s))).sum();
        let sum = sum * f64::from(TAU) / f64::from(n);
        assert!((sum - 1.0).abs() < 2e-4, "around {roughness}: {sum}");
    }
}

/// A furnace of 1 gives 1 back where nothing is absorbed: the shares of light sum to 1 (Chiang et al., section 3.2), and so do the
/// spreads, but for views along the fibre, whose tilt takes the lean beyond it.
#[test]
fn a_white_fibre_gives_back_all() {
    for (across, view, roughness) in [
        (0.0, 0.2, Vec2::new(0.4, 0.5)),
        (0.7, 0.6, Vec2::new(0.3, 0.3)),
        (-0.95, -0.9, Vec2::new(0.6, 1.0)),
    ] {
        let fibre = Fibre { roughness, ..WHITE };
        let wo = Vec3::new(f32::sin(view), 0.0, view.cos());
        let lobe = Chiang::new(
            Vec3::ONE,
            &fibre,
            (Vec3::X, Vec3::Z, across),
            wo,
            (0.0, false),
        );
        let (n, m) = (600, 600);
        let mut sum = 0f64;
        for i in 0..n {
            let x = 2.0 * (i as f32 + 0.5) / n as f32 - 1.0;
            for k in 0..m {
                let (y, z) = (TAU * (k as f32 + 0.5) / m as f32).sin_cos();
                let wi = Vec3::new(x, cosine(x) * y, cosine(x) * z);
                sum += f64::from(lobe.evaluate(wi).value.x);
            }
        }
        let found = sum * 2.0 * f64::from(TAU) / f64::from(n * m);
        assert!((found - 1.0).abs() < 3e-3, "{across} {view}: {found}");
    }
}

/// What is absorbed takes the more of light the longer its way is.
#[test]
fn absorption_takes_of_ways_through() {
    let left = Vec3::new(0.9, 0.5, 0.1);
    let [reflected, through, back, rest] = attenuation(0.04, left);
    assert_eq!(reflected, Vec3::splat(0.04));
    assert!((through - left * 0.96 * 0.96).abs().max_element() < 1e-6);
    assert!(
        (back - left * left * (0.96 * 0.96 * 0.04))
            .abs()
            .max_element()
            < 1e-7
    );
    // The sum of 0.96² · 0.04ⁿ · leftⁿ⁺¹ from n = 2 on.
    let series: Vec3 = (2..30)
        .map(|n| (left * 0.04).powf(n as f32) * left * (0.96 * 0.96))
        .sum();
    assert!(
        (rest - series).abs().max_element() < 1e-8,
        "{rest} {series}"
    );
}

/// The offset of a flat strand is that of the round one which it stands for.
#[test]
fn flat_strands_are_seen_as_round_ones() {
    let wo = Vec3::new(0.3, 0.0, 1.0).normalize();
    let h = 0.6f32;
    // The normal at an offset across a round strand along X.
    let normal = Vec3::new(0.0, h, cosine(h));
    let wi = Vec3::new(0.1, 0.5, -0.6).normalize();
    let round = Chiang::new(Vec3::ONE, &WHITE, (Vec3::X, normal, 0.0), wo, (0.0, false));
    let [one, other] = [h, -h].map(|across| {
        let place = (Vec3::X, wo, across);
        let lobe = Chiang::new(Vec3::ONE, &WHITE, place, wo, (0.0, false));
        (lobe.evaluate(wi).value.x - round.evaluate(wi).value.x).abs()
    });
    assert!(
        one.min(other) < 1e-5 && one.max(other) > 1e-3,
        "{one} {other}"
    );
}

/// On meshes light sampling loses one of the frame's sides.
#[test]
fn masked_light_is_taken_away() {
    let wo = Vec3::new(0.3, 0.5, 0.7).normalize();
    let lobe = Chiang::new(Vec3::ONE, &WHITE, (Vec3::X, Vec3::Z, 0.0), wo, (0.0, true));
    let normal = lobe.normal();
    let mut lost = 0;
    for k in 0..64 {
        let (sin, cos) = (TAU * k as f32 / 64.0).sin_cos();
        let wi = Vec3::new(0.2, sin, cos).normalize();
        let backs = lobe.evaluate_backs(Vec3::Z, wi);
        let is_lost = wi.z * normal.z * normal.dot(wi) < 0.0;
        lost += i32::from(is_lost);
        let expected = if is_lost {
            -lobe.evaluate(wi).value
        } else {
            Vec3::ZERO
        };
        assert_eq!(backs.value, expected);
    }
    assert!((8..56).contains(&lost), "{lost}");
}

/// Of an index below 1 nothing gets in where the view leans more than its critical angle.
#[test]
fn fibres_thinner_than_air_have_a_critical_lean() {
    let lets_in = |lean: f32, ior: f32| {
        let wo = Vec3::new(lean.sin(), 0.0, lean.cos());
        let fibre = Fibre { ior, ..WHITE };
        Chiang::new(Vec3::ONE, &fibre, (Vec3::X, Vec3::Z, 0.0), wo, (0.0, false)).lets_in(ior)
    };
    assert!(lets_in(1.5, 1.0) && lets_in(-1.5, 1.55));
    let critical = 0.7f32.asin();
    assert!(lets_in(critical - 1e-3, 0.7) && !lets_in(critical + 1e-3, 0.7));
    assert!(!lets_in(-critical - 1e-3, 0.7));
}
