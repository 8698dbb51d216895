use super::*;
use crate::light::program::LookingRay;
use crate::math::warp::{grid, sphere};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::f32::consts::PI;

const ANY: LookingRay = LookingRay { kind: 0, depth: 0 };

/// Two openings that are looked through from below: a rectangle overhead, and an ellipse to one side, tilted.
fn openings() -> Vec<Area> {
    let overhead = DAffine3::from_translation(DVec3::Z * 2.0);
    let aside =
        DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.9), DVec3::new(2.0, 0.4, 1.5));
    vec![
        Area::new(&overhead, [1.0, 0.6], false, Vec3::ONE, false, PI).unwrap(),
        Area::new(&aside, [1.5, 0.7], true, Vec3::ONE, false, PI).unwrap(),
    ]
}

fn image() -> Environment {
    let texels: Vec<Vec3> = (0..32)
        .map(|i| Vec3::splat(0.1 + (i * i % 7) as f32))
        .collect();
    Environment::image(8, 4, texels, Vec3::ONE, &DMat3::from_rotation_z(1.0))
}

fn environments() -> [Environment; 2] {
    [Environment::constant(Vec3::splat(0.7)), image()]
}

/// Samples of the mixture integrate the environment as uniform ones do, and their density is the one that is told of
/// directions.
#[test]
fn the_mixture_finds_all_light_with_its_density() {
    let n = 256;
    let count = f64::from(n * n);
    for environment in environments().map(|e| e.with_portals(openings())) {
        for (point, normal) in [
            (Vec3::ZERO, Some(Vec3::Z)),
            (Vec3::new(0.3, -0.2, 1.9), None),
            // Right below an edge, and behind one of the two.
            (Vec3::new(0.5, 0.3, 0.0), None),
            (Vec3::new(3.0, 0.5, 1.0), None),
        ] {
            let at = LightSampleContext::new(point, normal);
            let (mut mixed, mut uniform, mut agree, mut found) = (0.0, 0.0, 0.0, 0.0);
            for u in grid(n) {
                let d = sphere(u);
                uniform += f64::from(environment.emitted(d, ANY).y) * 4.0 * f64::from(PI);
                let Some(s) = environment.sample_from(&at, u) else {
                    continue;
                };
                assert!(s.pdf > 0.0 && s.pdf.is_finite());
                let hit = environment.le(s.wi, ANY);
                let told = environment.pdf_from(&at, s.wi, hit.on);
                found += 1.0;
                agree += f64::from(u8::from((told / s.pdf - 1.0).abs() < 1e-3));
                mixed += f64::from(hit.radiance.y / s.pdf);
            }
            assert!(agree > 0.99 * found, "{point}: {agree} of {found}");
            // A grid of 256² cells; the discontinuity at the openings' edges is met by 1 cell in 64.
            assert!(
                (mixed / uniform - 1.0).abs() < 0.02,
                "{point}: {} and {}",
                mixed / count,
                uniform / count
            );
        }
    }
}

/// Toward an opening overhead goes the share of the samples, and no more.
#[test]
fn a_share_goes_toward_openings() {
    let one = openings().into_iter().take(1).collect();
    let environment = Environment::constant(Vec3::ONE).with_portals(one);
    let at = LightSampleContext::new(Vec3::ZERO, Some(Vec3::Z));
    let through = grid(128).filter(|u| {
        let s = environment.sample_from(&at, *u).unwrap();
        let on = s.wi * (2.0 / s.wi.z);
        s.wi.z > 0.0 && on.x.abs() < 0.501 && on.y.abs() < 0.301
    });
    let share = through.count() as f32 / (128.0 * 128.0);
    // Of the others, the opening's part of the sphere.
    let solid_angle = 0.6 / 4.0 / (4.0 * PI);
    assert!((share - (0.5 + 0.5 * solid_angle)).abs() < 0.01, "{share}");
}

/// From behind, and from a side that faces away, there is nothing to be seen through it: all samples follow the radiance.
#[test]
fn openings_that_cannot_be_seen_take_no_samples() {
    let environment = image().with_portals(openings().into_iter().take(1).collect());
    let plain = image();
    for (point, normal) in [
        (Vec3::Z * 3.0, None),
        (Vec3::ZERO, Some(Vec3::NEG_Z)),
        (Vec3::Z * 2.0, None),
    ] {
        let at = LightSampleContext::new(point, normal);
        for u in grid(16) {
            let (mixed, alone) = (environment.sample_from(&at, u).unwrap(), plain.sample(u));
            assert_eq!((mixed.wi, mixed.pdf), (alone.wi, alone.pdf));
        }
    }
}
