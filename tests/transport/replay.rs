//! One sample once more: its path adds up to the bits that the picture has; and what is not finite has a cause.

use super::*;
use sundog::render::{Detail, Region, RenderSettings, Replay, replay};
use sundog::scene::Scene;
use sundog::scene::graph::NodeKind;
use sundog::scene::graph::node::{mix_shader, principled};

/// A room with something of everything: lamps, a sun, glass, metal, a picture of alpha, an instance.
fn room() -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.9)],
        environment: constant_environment(0.3),
        ..Scene::default()
    };
    let at = |x: f64, y: f64| DAffine3::from_translation(DVec3::new(x, y, 0.0));
    let glass = MetallicRoughness {
        name: "glass".into(),
        transmission: 1.0,
        metallic: 0.0,
        roughness: 0.2,
        ..MetallicRoughness::default()
    };
    let veil = MetallicRoughness {
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..diffuse([0.2, 0.8, 0.4])
    };
    let shining = MetallicRoughness {
        emission: [2.0, 1.0, 0.5],
        name: "shining".into(),
        ..diffuse([0.5; 3])
    };
    place(
        &mut scene,
        sphere(8, 0.2, true),
        glass,
        &[at(-1.2, 0.0), at(1.2, 0.3)],
    );
    place(
        &mut scene,
        quad([-3.0, -1.2, -3.0], [0.0, 0.0, 6.0], [6.0, 0.0, 0.0]),
        diffuse([0.7; 3]),
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        quad([-0.5, -0.5, 1.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        veil,
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        quad([-0.4, 1.8, -0.4], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8]),
        shining,
        &[DAffine3::IDENTITY],
    );
    scene.lights.push(lamp(
        LightKind::Point {
            intensity: 3.0,
            radius: 0.2,
            soft_falloff: false,
        },
        DVec3::new(1.0, 1.5, 1.0),
    ));
    scene.lights.push(lamp(
        LightKind::Sun {
            irradiance: 0.5,
            angle: 0.1,
        },
        DVec3::ZERO,
    ));
    scene
}

fn lamp(kind: LightKind, at: DVec3) -> Light {
    light("lamp", kind, DAffine3::from_translation(at))
}

fn numbers(detail: &Detail) -> &[f32] {
    match detail {
        Detail::Numbers(numbers) => numbers,
        _ => panic!("no numbers: {detail:?}"),
    }
}

/// The light that the steps of a path add, in their order.
fn sum(replay: &Replay) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for step in replay.steps.iter().filter(|step| step.step == "added") {
        let last = step.details.last().unwrap();
        sum += Vec3::from_slice(numbers(&last.1));
    }
    sum
}

/// A picture of one sample of one pixel is that sample.
#[test]
fn a_replay_has_the_bits_of_its_sample() {
    let scene = room();
    for (clamp, light_samples, light_sampling) in [
        (0.0, 1, LightSampling::Mis),
        (0.5, 3, LightSampling::Nee),
        (0.0, 1, LightSampling::Hemisphere),
    ] {
        let mut lit = 0;
        for number in 0..48 {
            let (x, y, sample) = (number % 6 * 5 + 3, number / 6 % 4 * 6 + 3, 17 * number);
            let settings = RenderSettings {
                seed: 5,
                clamp_indirect: clamp,
                light_samples,
                light_sampling,
                first_sample: sample,
                region: Some(Region {
                    x0: x,
                    y0: y,
                    x1: x + 1,
                    y1: y + 1,
                }),
                ..small(1, 8)
            };
            let pixel = run(&scene, &settings).picture.layers[0].data[..3].to_vec();
            let replay = replay(&scene, &settings, (x, y, sample)).unwrap();
            assert_eq!(numbers(&replay.radiance), pixel, "{x} {y} {sample}");
            assert_eq!(sum(&replay).to_array(), pixel[..], "{x} {y} {sample}");
            assert!(replay.same_bits);
            assert_eq!(replay.cause, None);
            assert_eq!(replay.steps.first().map(|s| s.step), Some("ray"));
            assert_eq!(replay.steps.last().map(|s| s.step), Some("end"));
            let surfaces = replay.steps.iter().filter(|s| s.step == "surface").count();
            lit += usize::from(surfaces > 1);
        }
        assert!(lit > 8, "only {lit} paths of more than one vertex");
    }
}

/// The kernels with fewer effects tell the same story.
#[test]
fn small_kernels_have_the_bits_of_the_one_that_tells() {
    let mut scene = room();
    for node in scene.materials.iter_mut().flat_map(|m| &mut m.graph.nodes) {
        match node.kind {
            NodeKind::PrincipledBsdf { .. } => {
                node.inputs[principled::TRANSMISSION_WEIGHT] = 0.0.into();
            }
            NodeKind::MixShader => node.inputs[mix_shader::FACTOR] = 1.0.into(),
            _ => {}
        }
    }
    for sample in 0..20 {
        let replay = replay(&scene, &small(1, 4), (sample + 6, sample, sample)).unwrap();
        assert!(replay.same_bits, "{sample}");
    }
    assert!(replay(&scene, &small(1, 4), (32, 0, 0)).is_err());
}
