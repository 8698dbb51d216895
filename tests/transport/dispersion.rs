//! Glass whose index of refraction depends on the wavelength.

use super::{colors, run};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use sundog::effects::{self, Effect};
use sundog::math::primaries::WorkingSpace;
use sundog::render::{EffectChoice, RenderSettings};
use sundog::scene::{Environment, Image, ImageId, MetallicRoughness, Scene};
use sundog::selftest::kit::{camera, constant_environment, place, quad, sphere};
use sundog::shading::dispersion::Spectrum;

/// The angle between the prism's faces.
const ANGLE: f64 = PI / 9.0;

fn glass(dispersion: f32) -> MetallicRoughness {
    MetallicRoughness {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        thin_walled: false,
        ior: 1.5,
        dispersion,
        ..MetallicRoughness::default()
    }
}

/// What the environment shines from an angle beside −Z: a ramp over 30 degrees from 2 degrees on, so that the places of
/// red, green and blue are read from how bright they are.
fn ramp(angle: f64) -> f64 {
    ((angle.to_degrees() - 2.0) / 30.0).clamp(0.0, 1.0)
}

/// A prism before the ramp: the camera looks through its first face at a right angle.
fn prism(dispersion: f32) -> Scene {
    let width = 1440u32;
    let row = (0..width).flat_map(|column| {
        // The direction at u is π/2 less its angle beside −Z (`light::environment`).
        let phi = (0.5 - (f64::from(column) + 0.5) / f64::from(width)) * TAU;
        [ramp(FRAC_PI_2 - phi) as f32; 3]
    });
    let row: Vec<f32> = row.collect();
    let image = Image {
        name: "ramp".into(),
        width,
        height: 2,
        channels: 3,
        pixels: row.repeat(2).into(),
    };
    let mut scene = Scene {
        environment: Some(Environment {
            image: Some(ImageId(0)),
            ..constant_environment(1.0).unwrap()
        }),
        images: vec![image],
        cameras: vec![camera(DVec3::new(0.0, 0.0, 3.0), 1e-3)],
        ..Scene::default()
    };
    let front = quad([-1.0, -1.0, 0.5], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    // Its normal is −Z turned by the angle toward −X.
    let (sin, cos) = (ANGLE.sin() as f32, ANGLE.cos() as f32);
    let back = quad(
        [cos, -1.0, -0.5 - sin],
        [-2.0 * cos, 0.0, 2.0 * sin],
        [0.0, 2.0, 0.0],
    );
    place(&mut scene, front, glass(dispersion), &[DAffine3::IDENTITY]);
    place(&mut scene, back, glass(dispersion), &[DAffine3::IDENTITY]);
    scene
}

fn settings() -> RenderSettings {
    RenderSettings {
        width: 4,
        height: 4,
        samples: 1024,
        bounces: 1,
        threads: Some(2),
        ..RenderSettings::default()
    }
}

fn mean(scene: &Scene, settings: &RenderSettings) -> [f64; 3] {
    let all = colors(&run(scene, settings));
    let count = all.len() as f64;
    [0, 1, 2].map(|c| all.iter().map(|p| p[c]).sum::<f64>() / count)
}

/// Unpolarised reflectance of a dielectric, of index `n` relative to the side that light comes from.
fn fresnel(n: f64, cos: f64) -> f64 {
    let inner = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let across = (cos - n * inner) / (cos + n * inner);
    let along = (n * cos - inner) / (n * cos + inner);
    0.5 * (across * across + along * along)
}

/// Light that comes to the camera through a prism of an index: what both faces let through, from where Snell's law sends it,
/// and what the first reflects.
fn through(n: f64) -> f64 {
    let beyond = (n * ANGLE.sin()).asin();
    let kept = (1.0 - fresnel(n, 1.0)) * (1.0 - fresnel(1.0 / n, ANGLE.cos()));
    // The mirrored direction is +Z, half a turn beside −Z either way: there the ramp is at its end.
    kept * ramp(beyond - ANGLE) + fresnel(n, 1.0) * ramp(PI)
}

#[test]
fn a_prism_sends_each_colour_where_snell_says() {
    let dispersion = 5.0;
    let found = mean(&prism(dispersion), &settings());
    let spectrum = Spectrum::of(WorkingSpace::Rec709);
    let mut expected = [0.0; 3];
    let steps = 1 << 14;
    for step in 0..steps {
        let drawn = spectrum.sample((step as f32 + 0.5) / steps as f32);
        // Cauchy's two terms, through the lines d, F and C, for an Abbe number of 4.
        let (f, c, d) = (486.13f64, 656.27f64, 587.56f64);
        let slope = 0.5 / 4.0 / (f.powi(-2) - c.powi(-2));
        let n = 1.5 + slope * (f64::from(drawn.nanometres).powi(-2) - d.powi(-2));
        for (sum, weight) in expected.iter_mut().zip(drawn.weight.to_array()) {
            *sum += f64::from(weight) * through(n) / f64::from(steps);
        }
    }
    // A path counts at most 3: 16,384 independent ones would have a standard deviation below 0.5 of 3/√16384/2. They are
    // stratified besides; four of such deviations.
    let tolerance = 4.0 * 0.5 * 3.0 / 128.0 / 2.0;
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() < tolerance,
            "{found} for {expected}"
        );
    }
    // The colours are further apart than that: blue is refracted the most.
    assert!(found[2] - found[1] > tolerance && found[1] - found[0] > 0.5 * tolerance);
}

#[test]
fn without_dispersion_no_bit_changes() {
    let none = run(&prism(0.0), &settings()).picture;
    let left_out = RenderSettings {
        effects: EffectChoice::List(effects::names(effects::ALL - Effect::Dispersion)),
        ..settings()
    };
    let without = run(&prism(5.0), &left_out).picture;
    assert_eq!(none.layers[0].data, without.layers[0].data);
}

/// A ball of glass that spreads colours, in even light.
pub(super) fn with_ball() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.5),
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.7)],
        ..Scene::default()
    };
    let ball = DAffine3::IDENTITY;
    place(&mut scene, sphere(24, 0.0, true), glass(5.0), &[ball]);
    scene
}

#[test]
fn a_ball_in_even_light_stays_colourless() {
    let scene = with_ball();
    let settings = RenderSettings {
        width: 8,
        height: 8,
        samples: 512,
        bounces: 64,
        threads: Some(2),
        ..RenderSettings::default()
    };
    // Nothing absorbs: 0.5 for every wavelength, so that a colour's mean is 0.5 of its mean weight. 32,768 paths of weights
    // below 3: five standard deviations of at most 1.5·0.5/√32768.
    for channel in mean(&scene, &settings) {
        assert!((channel - 0.5).abs() < 5.0 * 0.75 / 181.0, "{channel}");
    }
}
