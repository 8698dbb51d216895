use super::*;
use crate::math::warp::{self, grid};
use std::f64::consts::PI;

fn sample() -> Medium {
    let lobes = vec![
        Lobe {
            coefficient: Vec3::new(0.2, 0.5, 0.0),
            phase: Phase::HenyeyGreenstein(0.6),
        },
        Lobe {
            coefficient: Vec3::new(0.3, 0.1, 0.9),
            phase: Phase::Rayleigh,
        },
    ];
    let scattering = lobes.iter().map(|l| l.coefficient).sum();
    Medium {
        extinction: scattering + Vec3::new(0.4, 0.0, 0.1),
        scattering,
        emission: Vec3::new(2.0, 0.0, 1e-3),
        lobes,
    }
}

/// All light that is scattered goes somewhere, its mean cosine is g, and directions are drawn as often as their density says.
#[test]
fn phase_functions_are_densities_and_are_drawn_by_them() {
    for g in [-0.999, -0.7, -1e-4, 0.0, 2e-3, 0.5, 0.9, 0.999] {
        phase_holds(Phase::HenyeyGreenstein(g), f64::from(g));
    }
    phase_holds(Phase::Rayleigh, 0.0);
}

fn phase_holds(phase: Phase, mean: f64) {
    let n = 1u32 << 20;
    // By cosines that crowd where the needle is: c = ±(1 − 2 s⁴).
    let sign = if mean < 0.0 { -1.0 } else { 1.0 };
    let (mut all, mut cosines) = (0.0, 0.0);
    for k in 0..n {
        let s = (f64::from(k) + 0.5) / f64::from(n);
        let c = sign * (1.0 - 2.0 * s.powi(4));
        let part = f64::from(phase.density(c as f32)) * 2.0 * PI * 8.0 * s.powi(3) / f64::from(n);
        all += part;
        cosines += part * c;
    }
    // The needle of 0.999 is 1e-3 wide, and cosines in f32 are 6e-8 apart.
    assert!((all - 1.0).abs() < 2e-3, "{phase:?}: {all}");
    assert!((cosines - mean).abs() < 2e-3, "{phase:?}: {cosines}");
    let medium = Medium {
        scattering: Vec3::ONE,
        lobes: vec![Lobe {
            coefficient: Vec3::ONE,
            phase,
        }],
        ..Medium::EMPTY
    };
    let forward = Vec3::new(0.36, 0.48, 0.8);
    let drawn = grid(256).map(|u| medium.scatter(forward, u.extend(0.5)).dot(forward));
    let drawn = drawn.map(f64::from).sum::<f64>() / f64::from(256 * 256);
    assert!((drawn - mean).abs() < 2e-3, "{phase:?}: {drawn}");
}

/// The value over the density has the mean that integrating the value gives, channel by channel, whatever the lobes.
#[test]
fn several_lobes_are_one_estimate() {
    let medium = sample();
    let forward = Vec3::new(0.0, 0.6, 0.8);
    let moment = |value: Vec3, cos: f32| value * (1.0 + cos + cos * cos);
    let n = 96;
    let mut integral = Vec3::ZERO;
    for wi in grid(1000).map(warp::sphere) {
        let cos = forward.dot(wi);
        integral += moment(medium.phase(cos).0, cos) * (4.0 * std::f32::consts::PI / 1e6);
    }
    let mut estimate = Vec3::ZERO;
    for k in 0..n {
        for u in grid(n) {
            let wi = medium.scatter(forward, u.extend((k as f32 + 0.5) / n as f32));
            let cos = forward.dot(wi);
            let (value, pdf) = medium.phase(cos);
            estimate += moment(value, cos) / (pdf * (n * n * n) as f32);
        }
    }
    assert!(
        (estimate / integral - 1.0).abs().max_element() < 5e-3,
        "{estimate} {integral}"
    );
}

/// What comes through and what is scattered are the analytic shares, for thin and thick media.
#[test]
fn flights_have_the_analytic_means() {
    let medium = sample();
    let throughput = Vec3::new(0.1, 2.0, 0.7);
    for distance in [1e-3, 0.5, 4.0, f32::INFINITY] {
        let n = 1_000_000u32;
        let (mut through, mut scattered) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
        for k in 0..n {
            match medium.fly(throughput, distance, (k as f32 + 0.5) / n as f32) {
                Flight::Scattered(t, weight) => {
                    assert!(t >= 0.0 && t < distance);
                    scattered += weight.as_dvec3();
                }
                Flight::Through(weight) => through += weight.as_dvec3(),
            }
        }
        let t = transmittance(medium.extinction, distance).as_dvec3();
        let albedo = (medium.scattering / medium.extinction).as_dvec3();
        let off = (through / f64::from(n) - t).abs().max_element();
        assert!(off < 2e-4, "{distance}: {off}");
        let off = scattered / f64::from(n) - albedo * (1.0 - t);
        assert!(off.abs().max_element() < 2e-4, "{distance}: {off}");
    }
}

/// Nothing cancels where a medium is thin, nothing overflows where it is thick.
#[test]
fn emission_and_transmittance_hold_at_the_ends() {
    let of = |sigma: f32, distance: f32| {
        let medium = Medium {
            extinction: Vec3::splat(sigma),
            emission: Vec3::splat(2.0),
            ..Medium::EMPTY
        };
        (
            medium.emitted(distance).x,
            transmittance(medium.extinction, distance).x,
        )
    };
    assert!((of(1e-9, 1e-3).0 / 2e-3 - 1.0).abs() < 1e-6);
    assert_eq!(of(0.0, 3.0), (6.0, 1.0));
    assert_eq!(of(0.0, f32::INFINITY).1, 1.0);
    assert_eq!(of(1e6, f32::INFINITY), (2e-6, 0.0));
    let empty = Medium::EMPTY.fly(Vec3::ONE, f32::INFINITY, 0.5);
    assert_eq!(empty, Flight::Through(Vec3::ONE));
}
