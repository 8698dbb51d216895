//! Shadow catchers.

use super::{floor, light, run, small};
use glam::{DAffine3, DVec3};
use sundog::film::{Pass, Passes};
use sundog::render::{EffectChoice, RenderSettings, Rendering};
use sundog::scene::{LightKind, MetallicRoughness, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, place, sphere};

/// A floor that is a catcher, below a sky of one colour.
fn alone() -> Scene {
    let mut scene = floor();
    scene.instances[0].info.links.shadow_catcher = Some(true);
    scene.environment = constant_environment(0.5);
    scene.cameras.push(camera(DVec3::new(0.0, 0.4, 4.0), 0.8));
    scene
}

/// With a lamp, and a ball that shades it and reflects the floor.
pub fn with_ball() -> Scene {
    let mut scene = alone();
    place(
        &mut scene,
        sphere(12, 0.0, true),
        MetallicRoughness {
            metallic: 1.0,
            roughness: 0.3,
            ..diffuse([0.9, 0.6, 0.3])
        },
        &[DAffine3::from_scale(DVec3::splat(0.5))],
    );
    let lamp = LightKind::Point {
        intensity: 3.0,
        radius: 0.2,
        soft_falloff: false,
    };
    let above = DAffine3::from_translation(DVec3::new(0.5, 2.0, 0.5));
    scene.lights.push(light("lamp", lamp, above));
    scene
}

/// With the passes of the picture alone, or of shadows too.
fn settings(apart: bool) -> RenderSettings {
    let passes = match apart {
        true => Passes::COMBINED.with(Pass::ShadowCatcher),
        false => Passes::COMBINED,
    };
    RenderSettings {
        passes,
        ..small(16, 3)
    }
}

fn layer<'a>(rendering: &'a Rendering, name: &str) -> &'a [f32] {
    let mut layers = rendering.picture.layers.iter();
    &layers.find(|layer| layer.name == name).unwrap().data
}

#[test]
fn a_catcher_below_nothing_is_not_there() {
    // Both halves of a path take the same numbers through the same scene: 1 to the last bit.
    let found = run(&alone(), &settings(true));
    assert!(layer(&found, "Shadow Catcher").iter().all(|&s| s == 1.0));
    for transparent_film in [false, true] {
        let shown = run(
            &alone(),
            &RenderSettings {
                transparent_film,
                ..settings(false)
            },
        );
        // The sky alone; sums of halves are rounded.
        let expected = if transparent_film {
            [0.0; 4]
        } else {
            [0.5, 0.5, 0.5, 1.0]
        };
        for pixel in shown.picture.layers[0].data.chunks(4) {
            for (c, e) in pixel.iter().zip(expected) {
                assert!((c - e).abs() <= 1e-6, "{pixel:?}");
            }
        }
    }
}

#[test]
fn a_picture_is_its_objects_over_its_shadows() {
    let scene = with_ball();
    let of = |apart, transparent_film| {
        let wanted = RenderSettings {
            transparent_film,
            ..settings(apart)
        };
        run(&scene, &wanted)
    };
    let (apart, over_nothing) = (of(true, true), of(false, true));
    let shadows = layer(&apart, "Shadow Catcher").chunks(3);
    let objects = apart.picture.layers[0].data.chunks(4);
    let shown = over_nothing.picture.layers[0].data.chunks(4);
    let mut darkest = 1.0f32;
    for ((shadow, object), shown) in shadows.zip(objects).zip(shown) {
        let mean = (shadow[0] + shadow[1] + shadow[2]) / 3.0;
        let expected = (1.0 - object[3]) * (1.0 - mean.clamp(0.0, 1.0)) + object[3];
        assert!((shown[3] - expected).abs() <= 1e-5, "{shown:?}");
        assert_eq!(shown[..3], object[..3]);
        darkest = darkest.min(mean);
    }
    assert!(darkest < 0.9, "{darkest}");
    let over_sky = of(false, false);
    let pixels = over_sky.picture.layers[0].data.chunks(4);
    assert!(pixels.clone().all(|pixel| pixel[3] == 1.0));
    // The sky in a shadow.
    assert!(pixels.clone().any(|pixel| pixel[0] < 0.5 * 0.9));
}

#[test]
fn without_the_effect_it_is_an_object() {
    let scene = with_ball();
    let mut plain = scene.clone();
    plain.instances[0].info.links.shadow_catcher = None;
    let effects = ["lamps", "environment", "gloss", "metal"];
    let effects = effects.map(String::from).to_vec();
    let without = RenderSettings {
        effects: EffectChoice::List(effects),
        ..settings(false)
    };
    let (found, expected) = (run(&scene, &without), run(&plain, &without));
    assert_eq!(
        found.picture.layers[0].data,
        expected.picture.layers[0].data
    );
}

#[test]
fn light_of_the_scene_alone_is_none_of_the_photographs() {
    let mut scene = with_ball();
    scene.instances.truncate(1);
    let pass = |scene: &Scene| layer(&run(scene, &settings(true)), "Shadow Catcher").to_vec();
    // The lamp lights both halves alike …
    assert!(pass(&scene).iter().all(|&s| s == 1.0));
    // … and now one of them: the pass is what two pictures of a plain floor have to each other.
    scene.lights[0].links.shadow_catcher = Some(false);
    let found = pass(&scene);
    let plain = |lamp: bool| {
        let mut scene = scene.clone();
        scene.instances[0].info.links.shadow_catcher = None;
        scene.lights.truncate(usize::from(lamp));
        let picture = run(
            &scene,
            &RenderSettings {
                transparent_film: true,
                ..settings(false)
            },
        );
        picture.picture.layers[0].data.clone()
    };
    let (lit, unlit) = (plain(true), plain(false));
    let mut covered = 0;
    for (shadow, (lit, unlit)) in found.chunks(3).zip(lit.chunks(4).zip(unlit.chunks(4))) {
        if lit[3] < 1.0 {
            continue;
        }
        covered += 1;
        for ((s, a), b) in shadow.iter().zip(lit).zip(unlit) {
            // Three roundings to f32.
            assert!((s * b / a - 1.0).abs() < 1e-6, "{s} {a} {b}");
        }
    }
    assert!(covered > 0 && found.iter().any(|&s| s > 1.0));
}
