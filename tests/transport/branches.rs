//! Several paths that go on from the first vertex.

use super::media::{cloud, fog, growing};
use super::{RenderSettings, colors, estimate, floor, run, small};
use sundog::film::Passes;
use sundog::render::Rendering;
use sundog::scene::graph::VolumeShader;
use sundog::scene::{Medium, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, glass, place, sphere};
use sundog::selftest::media::add_slab;

use glam::{DAffine3, DVec3};

fn settings(branches: u32) -> RenderSettings {
    RenderSettings {
        branches: Some(branches),
        ..small(16, 6)
    }
}

/// A ball of clear glass and a white one over a floor.
fn balls() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.7),
        cameras: vec![camera(DVec3::new(0.0, 0.8, 5.0), 0.8)],
        ..floor()
    };
    for (x, material) in [(-1.0, glass(0.2, 1.45)), (1.0, diffuse([0.8; 3]))] {
        let at = DAffine3::from_translation(DVec3::new(x, 0.5, 0.0));
        place(&mut scene, sphere(12, 0.0, true), material, &[at]);
    }
    scene
}

/// These before a slab that takes light by how far along X it is met, and scatters none.
fn before_what_absorbs() -> Scene {
    let mut scene = balls();
    let medium = Medium {
        varying: Some(Box::new(growing(2.0, VolumeShader::Absorption))),
        ..Medium::default()
    };
    add_slab(&mut scene, medium, 1.0);
    scene
}

/// Half the mean squared difference of two pictures.
fn noise(a: &Rendering, b: &Rendering) -> f64 {
    let (a, b) = (colors(a), colors(b));
    let squares = a.iter().flatten().zip(b.iter().flatten());
    squares.map(|(a, b)| 0.5 * (a - b).powi(2)).sum::<f64>() / (3 * a.len()) as f64
}

/// The means are those of one path: 4 σ, the variance from independent seeds.
#[test]
fn more_branches_have_the_same_mean() {
    for (name, scene) in [("fog", fog()), ("balls", balls()), ("cloud", cloud())] {
        let one = estimate(&scene, &settings(1), 0..16);
        for branches in [2, 3, 8] {
            let more = estimate(&scene, &settings(branches), 16..32);
            let sigma = (one.1 + more.1).sqrt();
            let z = (more.0 - one.0) / sigma;
            let told = format!("{name}, {branches}: {} against {}, z {z:.2}", more.0, one.0);
            println!("{told}");
            assert!(z.abs() < 4.0 && sigma / one.0 < 2e-3, "{told}");
        }
    }
}

/// Eight have less noise than one, by more than 2304 pairs of numbers differ by chance: their variances' quotient is within 10 % of
/// its mean, were they normal.
#[test]
fn more_branches_have_less_noise() {
    let scene = fog();
    let of = |branches: u32| {
        let [a, b] = [0, 1].map(|seed| {
            let settings = settings(branches);
            run(&scene, &RenderSettings { seed, ..settings })
        });
        noise(&a, &b)
    };
    let (one, eight) = (of(1), of(8));
    println!("{eight:.2e} / {one:.2e}");
    assert!(eight < 0.5 * one, "{eight:.2e} / {one:.2e}");
}

/// Even fog has several unless it is said otherwise, four where it scatters: less noise than two, by more than chance makes of 2304
/// pairs of numbers (see above). Passes change no bit.
#[test]
fn fog_branches_by_itself() {
    let scene = fog();
    let of = |branches| {
        [0, 1].map(|seed| {
            let settings = RenderSettings {
                branches,
                seed,
                ..small(16, 6)
            };
            run(&scene, &settings)
        })
    };
    let (chosen, two) = (of(None), of(Some(2)));
    let (less, more) = (noise(&chosen[0], &chosen[1]), noise(&two[0], &two[1]));
    println!("{less:.2e} / {more:.2e}");
    assert!(less < 0.8 * more, "{less:.2e} / {more:.2e}");
    let with_passes = RenderSettings {
        passes: Passes::ALL,
        ..small(16, 6)
    };
    assert_eq!(colors(&chosen[0]), colors(&run(&scene, &with_passes)));
}

/// Fog that varies has two, and one where it scatters light once alone; what scatters nothing has one. All to the bit.
#[test]
fn fog_that_varies_branches_twice() {
    let cases = [
        (cloud(), None, 2),
        (cloud(), Some(0), 1),
        (before_what_absorbs(), None, 1),
    ];
    for (scene, volume, expected) in cases {
        let of = |branches| {
            let mut settings = RenderSettings {
                branches,
                ..small(16, 2)
            };
            settings.bounce_limits.volume = volume;
            colors(&run(&scene, &settings))
        };
        assert_eq!(of(None), of(Some(expected)));
        assert_ne!(of(None), of(Some(3 - expected)));
    }
}
