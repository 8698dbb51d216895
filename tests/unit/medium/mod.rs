use super::particles::{Draine, FournierForand};
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
    for g in [-0.9f32, -0.03, -0.01, 0.0, 0.019, 0.021, 0.5, 0.99] {
        for alpha in [0.0f32, 0.5, 250.0] {
            // The moments of Henyey and Greenstein's are powers of g.
            let (g64, a) = (f64::from(g), f64::from(alpha));
            let third = (2.0 * g64.powi(3) + 3.0 * g64) / 5.0;
            let second = (1.0 + 2.0 * g64 * g64) / 3.0;
            let mean = (g64 + a * third) / (1.0 + a * second);
            phase_holds(Phase::Draine(Draine { g, alpha }), mean);
        }
    }
}

/// Fournier and Forand's is the derivative of the share that it is drawn by; half of what they call scattered back goes back.
#[test]
fn what_floats_in_water_scatters_as_drawn() {
    for (ior, backscatter) in [(1.33, 0.1), (1.01, 0.02), (1.816_496_6, 0.2), (3.0, 0.49)] {
        let floating = FournierForand::new(ior, backscatter);
        let n = 20_000;
        let mut drawn: Vec<f64> = (0..n)
            .map(|k| floating.cosine((f64::from(k) + 0.5) / f64::from(n)))
            .collect();
        assert!(drawn.iter().all(|c| (-1.0..=1.0).contains(c)));
        // From straight on to straight back, as they are drawn.
        assert!(drawn.windows(2).all(|pair| pair[0] >= pair[1] - 1e-9));
        drawn.retain(|cos| *cos < 0.0);
        let back = drawn.len() as f64 / f64::from(n);
        assert!(
            (back - f64::from(backscatter)).abs() < 2e-4,
            "{ior} {backscatter}: {back}"
        );
        // By angles that are not needles: the mean over them of what falls there.
        let edges = [-1.0, -0.5, 0.0, 0.5, 0.9, 0.99];
        for pair in edges.windows(2) {
            let steps = 4000;
            let width = (pair[1] - pair[0]) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|k| floating.density(pair[0] + (f64::from(k) + 0.5) * width))
                .sum();
            let integral = sum * width * 2.0 * PI;
            let inside = (0..n)
                .map(|k| floating.cosine((f64::from(k) + 0.5) / f64::from(n)))
                .filter(|cos| *cos >= pair[0] && *cos < pair[1])
                .count();
            let share = inside as f64 / f64::from(n);
            assert!(
                (share - integral).abs() < 2e-4,
                "{ior} {pair:?}: {share} {integral}"
            );
        }
    }
}

/// The fits of droplets meet where they are joined, and their numbers are those of phase functions.
#[test]
fn droplets_of_all_sizes_scatter() {
    for step in 0..2000 {
        let diameter = 0.005 * 1.005f32.powi(step);
        let (g, draine, share) = particles::droplets(diameter);
        assert!((0.0..1.0).contains(&g), "{diameter}: {g}");
        assert!(
            draine.g.abs() < 1.0 && draine.alpha > 0.0,
            "{diameter}: {draine:?}"
        );
        assert!((0.0..=1.0).contains(&share), "{diameter}: {share}");
    }
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
    let cases = [1e-3, 0.5, 4.0, f32::INFINITY].map(|distance| (distance, 1.0));
    // However often it is scattered.
    let others = [(0.5, 0.25), (0.5, 3.0), (4.0, 1e-3), (0.5, f32::INFINITY)];
    for (distance, worth) in cases.into_iter().chain(others) {
        let n = 1_000_000u32;
        let (mut through, mut scattered) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
        // How often light comes through, and how often it is scattered.
        let mut by_light = glam::DVec2::ZERO;
        for k in 0..n {
            let u = (k as f32 + 0.5) / n as f32;
            let (flight, often) = medium.fly(throughput, distance, worth, u);
            match flight {
                Flight::Scattered(t, weight) => {
                    assert!(t >= 0.0 && t < distance);
                    scattered += weight.as_dvec3();
                    by_light.y += f64::from(often);
                }
                Flight::Through(weight) => {
                    through += weight.as_dvec3();
                    by_light.x += f64::from(often);
                }
            }
        }
        let passes = f64::from(medium.coming_through(throughput, distance));
        let right = glam::DVec2::new(passes, 1.0 - passes);
        let off = (by_light / f64::from(n) - right).abs();
        if worth != f32::INFINITY && distance != f32::INFINITY {
            assert!(off.x < 2e-4, "{distance}: {by_light}");
        }
        if distance != f32::INFINITY {
            assert!(off.y < 2e-4, "{distance}: {by_light}");
        }
        let t = transmittance(medium.extinction, distance).as_dvec3();
        let albedo = (medium.scattering / medium.extinction).as_dvec3();
        if worth == f32::INFINITY {
            assert!(through.max_element() < 1e-3 * f64::from(n));
        } else {
            let off = (through / f64::from(n) - t).abs().max_element();
            assert!(off < 2e-4, "{distance}: {off}");
        }
        let off = scattered / f64::from(n) - albedo * (1.0 - t);
        assert!(off.abs().max_element() < 2e-4, "{distance}: {off}");
    }
}

/// Distances among those on a way have the analytic mean of what is scattered, with no part that comes through.
#[test]
fn distances_have_the_analytic_means() {
    let medium = sample();
    let throughput = Vec3::new(0.1, 2.0, 0.7);
    for end in [1e-6, 0.5, 4.0, f32::INFINITY] {
        let n = 200_000u32;
        let distances = medium.distances(throughput, end).expect("it scatters");
        let mut scattered = glam::DVec3::ZERO;
        for k in 0..n {
            let t = distances.sample((k as f32 + 0.5) / n as f32);
            let t = t.expect("it is finite");
            assert!((0.0..=end).contains(&t), "{end}: {t}");
            let left = transmittance(medium.extinction, t);
            scattered += (medium.scattering * left / distances.density(left)).as_dvec3();
        }
        let taken = medium.taken(end).as_dvec3();
        let known = (medium.scattering / medium.extinction).as_dvec3() * taken;
        let off = (scattered / f64::from(n) / known - 1.0).abs();
        assert!(off.max_element() < 1e-3, "{end}: {off}");
    }
    assert_eq!(Medium::EMPTY.distances(Vec3::ONE, 1.0), None);
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
    let empty = Medium::EMPTY.fly(Vec3::ONE, f32::INFINITY, 1.0, 0.5);
    assert_eq!(empty, (Flight::Through(Vec3::ONE), 1.0));
}
