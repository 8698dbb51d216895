//! What stands for indirect light: the world past what is not near, and openness.

use super::*;
use sundog::scene::{Effect, FastGi, FastGiMethod};

/// A grey floor under a black ceiling that is a metre away and without end, seen from between them.
fn between(method: FastGiMethod, distance: f32) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 0.5), 0.5)],
        environment: constant_environment(1.0),
        fast_gi: Some(FastGi {
            method,
            factor: 0.7,
            distance,
        }),
        ..Scene::default()
    };
    let side = 1e4;
    let floor = quad(
        [-side / 2.0, -side / 2.0, 0.0],
        [side, 0.0, 0.0],
        [0.0, side, 0.0],
    );
    place(&mut scene, floor, diffuse([0.5; 3]), &[DAffine3::IDENTITY]);
    let ceiling = quad(
        [-side / 2.0, -side / 2.0, 1.0],
        [side, 0.0, 0.0],
        [0.0, side, 0.0],
    );
    place(
        &mut scene,
        ceiling,
        diffuse([0.0; 3]),
        &[DAffine3::IDENTITY],
    );
    scene
}

/// A scene that calls for it.
pub(super) fn of_floor() -> Scene {
    between(REPLACE, 0.5)
}

/// The mean by directions of BSDFs alone.
fn by_rays(scene: &Scene, settings: RenderSettings) -> f64 {
    let settings = RenderSettings {
        light_sampling: LightSampling::Bsdf,
        ..settings
    };
    mean(&run(scene, &settings))
}

/// A mean of 256 samples a pixel, each of which is 0.35 or nothing, where such a share of the rays meets nothing that is near.
fn agrees(found: f64, open: f64, distance: f32) {
    let expected = 0.5 * 0.7 * open;
    let bound = 5.0 * 0.175 / f64::from(256 * 32 * 24).sqrt() + 1e-5;
    assert!(
        (found - expected).abs() < bound,
        "{distance}: {found} {expected}"
    );
}

const REPLACE: FastGiMethod = FastGiMethod::Replace { bounces: 1 };

/// Of the rays from the floor those pass the ceiling that go more than the distance d: their share is 1/d² of the cosines.
#[test]
fn the_world_shines_past_what_is_not_near() {
    for (distance, open) in [(0.5, 1.0), (2.0, 0.25), (1e6, 0.0)] {
        let found = by_rays(&between(REPLACE, distance), small(256, 3));
        agrees(found, open, distance);
    }
}

/// What an object says of itself counts for rays that leave it.
#[test]
fn objects_have_distances_of_their_own() {
    let mut scene = between(REPLACE, 1e6);
    scene.instances[0].info.reach = 0.5;
    let found = by_rays(&scene, small(16, 3));
    assert!((found - 0.35).abs() < 1e-5, "{found}");
    scene.instances[0].info.reach = 0.0;
    scene.instances[1].info.reach = 0.5;
    assert!(by_rays(&scene, small(16, 3)) < 1e-6);
}

/// Later bounces alone are replaced: all that the rays of a first one meet is black.
#[test]
fn so_many_bounces_are_traced() {
    let scene = between(FastGiMethod::Replace { bounces: 2 }, 0.5);
    assert!(by_rays(&scene, small(16, 3)) < 1e-6);
}

#[test]
fn openness_is_added_once_a_surface() {
    for (distance, open) in [(0.5, 1.0), (2.0, 0.25)] {
        let mut scene = between(FastGiMethod::Add, distance);
        scene.environment = None;
        let found = mean(&run(&scene, &small(256, 0)));
        agrees(found, open, distance);
    }
}

#[test]
fn it_is_an_effect_that_can_be_left_out() {
    let settings = RenderSettings {
        effects: EffectChoice::List(effects::names(effects::ALL - Effect::FastGi)),
        ..small(16, 3)
    };
    assert!(by_rays(&between(REPLACE, 0.5), settings) < 1e-6);
}
