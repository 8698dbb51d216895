//! Light linking, shadow linking and light groups.

use super::{floor, light, run, small};
use glam::{DAffine3, DQuat, DVec3};
use sundog::film::Passes;
use sundog::render::{RenderSettings, Rendering};
use sundog::scene::{LightGrouping, LightKind, MetallicRoughness, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, place, quad, sphere};

/// A bit for each set.
const SETS: [u64; 2] = [1, 2];

/// A ball on a floor, in sets of its own. A panel lights the floor alone; another one, a lamp and a sun throw no shadows of the
/// ball.
pub fn scene() -> Scene {
    let mut scene = floor();
    place(
        &mut scene,
        sphere(12, 0.0, true),
        MetallicRoughness {
            metallic: 1.0,
            roughness: 0.4,
            ..diffuse([0.9, 0.8, 0.7])
        },
        &[DAffine3::from_scale(DVec3::splat(0.8))],
    );
    for (x, emission) in [(-1.5, [6.0, 5.0, 4.0]), (1.0, [2.0, 3.0, 4.0])] {
        place(
            &mut scene,
            quad([x, 1.6, -0.5], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8]),
            MetallicRoughness {
                emission,
                ..diffuse([0.0; 3])
            },
            &[DAffine3::IDENTITY],
        );
    }
    let down = |x: f64| {
        let turn = DQuat::from_rotation_x(-1.2);
        DAffine3::from_rotation_translation(turn, DVec3::new(x, 1.5, 1.0))
    };
    let lamp = LightKind::Point {
        intensity: 3.0,
        radius: 0.3,
        soft_falloff: false,
    };
    let sun = LightKind::Sun {
        irradiance: 1.0,
        angle: 0.3,
    };
    for (name, kind) in [("lamp", lamp), ("sun", sun)] {
        let mut made = light(name, kind, down(0.5));
        made.links.shadow_sets = SETS[0];
        scene.lights.push(made);
    }
    for (number, name) in ["floor", "ball", "panel", "linked panel"]
        .iter()
        .enumerate()
    {
        scene.instances[number].name = (*name).into();
    }
    let ball = &mut scene.instances[1].info.links;
    (ball.receiver_set, ball.blocker_set) = (1, 1);
    scene.instances[2].info.links.lit_sets = SETS[0];
    scene.instances[3].info.links.shadow_sets = SETS[0];
    scene.environment = constant_environment(0.2);
    scene.cameras.push(camera(DVec3::new(0.0, 0.2, 4.0), 0.8));
    scene
}

fn layer<'a>(rendering: &'a Rendering, name: &str) -> &'a [f32] {
    let mut layers = rendering.picture.layers.iter();
    &layers.find(|layer| layer.name == name).unwrap().data
}

/// The picture is that of a scene without the links where nothing is excluded by them.
#[test]
fn links_that_leave_nothing_out_change_no_more_than_the_noise() {
    let linked = scene();
    let mut all = linked.clone();
    for instance in &mut all.instances {
        (
            instance.info.links.lit_sets,
            instance.info.links.shadow_sets,
        ) = (3, 3);
    }
    for light in &mut all.lights {
        light.links.shadow_sets = 3;
    }
    let mut plain = all.clone();
    for links in plain.instances.iter_mut().map(|i| &mut i.info.links) {
        *links = Default::default();
    }
    for light in &mut plain.lights {
        light.links = Default::default();
    }
    let settings = small(64, 3);
    let mean = |scene: &Scene| super::estimate(scene, &settings, 0..8);
    let (a, b, c) = (mean(&all), mean(&plain), mean(&linked));
    assert!((a.0 - b.0).powi(2) < 16.0 * (a.1 + b.1), "{a:?} {b:?}");
    assert!((c.0 - b.0).powi(2) > 16.0 * (c.1 + b.1), "{c:?} {b:?}");
}

/// Each light has a pass; all of them are the picture.
#[test]
fn light_groups_sum_to_the_picture() {
    let mut scene = scene();
    LightGrouping::Each.choose(&mut scene);
    assert_eq!(
        scene.light_groups,
        ["lamp", "sun", "panel", "linked panel", "World"]
    );
    let settings = RenderSettings {
        passes: Passes::COMBINED,
        ..small(8, 3)
    };
    let rendering = run(&scene, &settings);
    let combined = layer(&rendering, "Combined").chunks(4);
    let groups = scene.light_groups.iter();
    let groups: Vec<_> = groups
        .map(|name| layer(&rendering, &format!("Combined_{name}")))
        .collect();
    for (number, pixel) in combined.enumerate() {
        for channel in 0..3 {
            let sum: f32 = groups.iter().map(|group| group[3 * number + channel]).sum();
            assert!((sum - pixel[channel]).abs() <= 1e-5 * pixel[channel].max(0.1));
        }
    }
    assert!(groups.iter().all(|group| group.iter().any(|&v| v > 0.0)));
}
