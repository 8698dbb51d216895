//! Things that move while the shutter is open: coverage, profiles and means that are known.

use super::{run, small, techniques_agree};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use sundog::render::{EffectChoice, Filter, FilterKind, LightSampling, RenderSettings, Rendering};
use sundog::scene::{
    Camera, CameraMotion, MaterialId, Mesh, MeshStep, MetallicRoughness, Projection, Scene, Shutter,
};
use sundog::selftest::kit::{camera, constant_environment, diffuse, place, quad, sphere};

fn shining(radiance: f32) -> MetallicRoughness {
    MetallicRoughness {
        emission: [radiance; 3],
        ..diffuse([0.0; 3])
    }
}

/// Looks down −Z at a square of so many half metres.
fn orthographic(half: f64) -> Camera {
    Camera {
        projection: Projection::Orthographic {
            half_width: half,
            half_height: half,
        },
        ..camera(DVec3::Z * 5.0, 1.0)
    }
}

/// One ray for each sample and its own pixel.
fn sharp(side: u32, samples: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        width: side,
        height: side,
        filter: Filter {
            kind: FilterKind::Box,
            width: 1.0,
        },
        ..small(samples, bounces)
    }
}

fn at(rendering: &Rendering, x: u32, y: u32) -> f64 {
    let layer = &rendering.picture.layers[0];
    let index = (y * rendering.picture.width + x) as usize * layer.channels.len();
    f64::from(layer.data[index])
}

/// A square of two metres that goes from `from` on by two metres to the right.
fn passing(from: f32) -> Scene {
    let mut scene = Scene::default();
    let square = quad([-1.0, -4.0, 0.0], [2.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    place(
        &mut scene,
        square,
        shining(1.0),
        &[DAffine3::from_translation(DVec3::X * f64::from(from + 1.0))],
    );
    let step = |x: f64| DAffine3::from_translation(DVec3::X * (f64::from(from) + x));
    scene.instances[0].motion = vec![step(0.0), step(1.0), step(2.0)];
    scene.cameras.push(orthographic(4.0));
    scene
}

/// How long a square from `from` − 1 to `from` + 1 that moves on by 2 covers a place, by the share of all light that the
/// shutter lets through until a time.
fn covered(from: f64, x: f64, until: impl Fn(f64) -> f64) -> f64 {
    let enters = ((x - (from + 1.0)) / 2.0).clamp(0.0, 1.0);
    let leaves = ((x - (from - 1.0)) / 2.0).clamp(0.0, 1.0);
    until(leaves) - until(enters)
}

/// The mean over a pixel.
fn over_pixel(x: u32, side: u32, of: impl Fn(f64) -> f64) -> f64 {
    let width = 8.0 / f64::from(side);
    let parts = 64;
    let place =
        |part: u32| -4.0 + width * (f64::from(x) + (f64::from(part) + 0.5) / f64::from(parts));
    (0..parts).map(|part| of(place(part))).sum::<f64>() / f64::from(parts)
}

#[test]
fn a_square_that_passes_is_a_ramp() {
    let side = 16;
    let picture = run(&passing(-1.0), &sharp(side, 1024, 0));
    for x in 0..side {
        let expected = over_pixel(x, side, |x| covered(-1.0, x, |t| t));
        let found = at(&picture, x, side / 2);
        assert!(
            (found - expected).abs() < 0.01,
            "{x}: {found} of {expected}"
        );
    }
}

#[test]
fn the_curve_of_the_shutter_is_the_profile_of_what_passes() {
    let side = 16;
    let mut scene = passing(-1.0);
    scene.shutter.curve = vec![0.0, 1.0];
    let picture = run(&scene, &sharp(side, 8192, 0));
    for x in 0..side {
        // The light until t is t².
        let expected = over_pixel(x, side, |x| covered(-1.0, x, |t| t * t));
        let found = at(&picture, x, side / 2);
        assert!(
            (found - expected).abs() < 0.015,
            "{x}: {found} of {expected}"
        );
    }
}

#[test]
fn a_rolling_shutter_shears_what_passes() {
    let side = 16;
    let mut scene = passing(-1.0);
    for duration in [0.0, 0.25] {
        scene.shutter = Shutter {
            curve: Vec::new(),
            rolling: Some(duration),
            ..Shutter::default()
        };
        let picture = run(&scene, &sharp(side, 1024, 0));
        for y in 0..side {
            let row = f64::from(y + 1) / f64::from(side);
            let duration = f64::from(duration);
            let middle = if duration > 0.0 {
                (row - 0.5) * (1.0 - duration) + 0.5
            } else {
                row
            };
            let until = |t: f64| match duration > 0.0 {
                true => ((t - middle) / duration + 0.5).clamp(0.0, 1.0),
                false => f64::from(u8::from(t >= middle)),
            };
            for x in 0..side {
                let expected = over_pixel(x, side, |x| covered(-1.0, x, until));
                let found = at(&picture, x, y);
                assert!(
                    (found - expected).abs() < 0.02,
                    "{duration} {x} {y}: {found} of {expected}"
                );
            }
        }
    }
}

/// The angles from 0 to 1 of a wedge that turns by 2 about the picture's middle: a place at an angle φ sees it while the turn is
/// between φ − 1 and φ.
#[test]
fn a_wedge_that_turns_is_a_ramp_of_angles() {
    let mut scene = Scene::default();
    let far = |angle: f32| [20.0 * angle.cos(), 20.0 * angle.sin(), 0.0];
    let wedge = Mesh {
        positions: vec![[0.0; 3], far(0.0), far(1.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let turned = |angle: f64| DAffine3::from_rotation_z(angle);
    place(&mut scene, wedge, shining(1.0), &[turned(1.0)]);
    scene.instances[0].motion = vec![turned(0.0), turned(2.0)];
    scene.cameras.push(orthographic(4.0));
    let side = 32;
    let picture = run(&scene, &sharp(side, 1024, 0));
    let mut checked = 0;
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let place = |i: u32| 8.0 * (f64::from(i) + 0.5) / f64::from(side) - 4.0;
        let (x_at, y_at) = (place(x), -place(y));
        if x_at * x_at + y_at * y_at < 2.25 || (y_at.abs() < 0.5 && x_at < 0.0) {
            continue;
        }
        let angle = y_at.atan2(x_at);
        let expected = (angle.clamp(0.0, 2.0) - (angle - 1.0).clamp(0.0, 2.0)) / 2.0;
        // A pixel sees up to 0.17 of angle: near the corners of the ramp less than 0.03 of what is missing there.
        let found = at(&picture, x, y);
        assert!(
            (found - expected).abs() < 0.03,
            "{x} {y}: {found} of {expected}"
        );
        checked += 1;
    }
    assert!(checked > 800);
}

/// Steps of a mesh's vertices that are moved.
fn moved(mesh: &Mesh, steps: &[DVec3]) -> Vec<MeshStep> {
    let step = |by: &DVec3| MeshStep {
        positions: mesh
            .positions
            .iter()
            .map(|p| (Vec3::from(*p) + by.as_vec3()).into())
            .collect(),
        normals: mesh.normals.clone(),
    };
    steps.iter().map(step).collect()
}

fn difference(a: &Rendering, b: &Rendering) -> (f64, f64) {
    let pairs = || {
        a.picture.layers[0]
            .data
            .iter()
            .zip(&b.picture.layers[0].data)
    };
    let count = pairs().count() as f64;
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        pairs()
            .map(|(a, b)| of(f64::from(*a), f64::from(*b)))
            .sum::<f64>()
            / count
    };
    (
        mean(&|a, b| (a - b).abs()),
        mean(&|a, b| a - b) / mean(&|_, b| b),
    )
}

/// A ball before a wall, with normals of vertices, below a sky and a lamp.
fn still_life() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.3),
        ..Scene::default()
    };
    place(
        &mut scene,
        quad([-9.0, -9.0, -2.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]),
        diffuse([0.6, 0.5, 0.4]),
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        sphere(24, 0.0, true),
        diffuse([0.7, 0.3, 0.2]),
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        quad([-1.0, 5.0, 1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]),
        shining(9.0),
        &[DAffine3::IDENTITY],
    );
    scene.cameras.push(camera(DVec3::Z * 6.0, 0.9));
    scene
}

#[test]
fn a_mesh_that_is_deformed_alike_is_as_an_object_that_moves() {
    let way = [
        DVec3::new(-1.0, 0.0, 0.0),
        DVec3::ZERO,
        DVec3::new(1.0, 0.5, 0.25),
    ];
    let mut by_object = still_life();
    by_object.instances[1].motion = way.map(DAffine3::from_translation).to_vec();
    let mut by_mesh = still_life();
    by_mesh.meshes[1].motion = moved(&by_mesh.meshes[1], &way);
    // And placed twice, so that it is instanced; the second is out of the picture.
    let mut shared = by_mesh.clone();
    let mut second = shared.instances[1].clone();
    second.world_from_object.translation = DVec3::Z * 50.0;
    shared.instances.push(second);
    let settings = small(64, 3);
    let first = run(&by_object, &settings);
    for (name, other) in [("mesh", by_mesh), ("instance", shared)] {
        let (apart, mean) = difference(&first, &run(&other, &settings));
        println!("{name}: {apart:.2e}, {mean:.2e}");
        assert!(apart < 2e-3 && mean.abs() < 1e-3, "{name}: {apart} {mean}");
    }
    let (apart, _) = difference(&first, &run(&still_life(), &settings));
    assert!(apart > 1e-3, "it does move: {apart}");
    let without = RenderSettings {
        effects: EffectChoice::List(sundog::effects::names(
            sundog::effects::ALL - sundog::effects::Effect::MotionBlur,
        )),
        ..settings.clone()
    };
    let mut still = still_life();
    still.instances[1].motion.clear();
    let (apart, _) = difference(&run(&by_object, &without), &run(&still, &settings));
    assert_eq!(apart, 0.0, "left out, it stands half-way");
}

#[test]
fn a_camera_that_moves_is_as_a_world_that_moves_the_other_way() {
    let turn = |i: f64| {
        DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(0.3 * i),
            DVec3::new(0.5 * i, 0.2 * i, 0.0),
        )
    };
    let mut by_camera = still_life();
    by_camera.environment = None;
    let place = by_camera.cameras[0].world_from_camera;
    let ways = [-1.0, -0.5, 0.0, 0.5, 1.0].map(turn);
    by_camera.cameras[0].motion = Some(Box::new(CameraMotion {
        steps: ways.map(|way| place * way).to_vec(),
        zoom: [1.0; 2],
    }));
    let mut by_world = by_camera.clone();
    by_world.cameras[0].motion = None;
    for instance in &mut by_world.instances {
        let still = instance.world_from_object;
        // Many steps: it does not go along the same curve between them.
        let steps = (-32..=32).map(|i| turn_back(place, &ways, f64::from(i) / 32.0) * still);
        instance.motion = steps.collect();
    }
    let settings = small(128, 3);
    let (apart, mean) = difference(&run(&by_camera, &settings), &run(&by_world, &settings));
    println!("{apart:.2e}, {mean:.2e}");
    assert!(apart < 5e-3 && mean.abs() < 2e-3, "{apart} {mean}");
}

/// What brings the world to where a camera on its way sees it as the still one does.
fn turn_back(place: DAffine3, ways: &[DAffine3; 5], time: f64) -> DAffine3 {
    let steps: Vec<DAffine3> = ways.iter().map(|way| place * *way).collect();
    let parts = sundog::math::motion::decompose(&steps);
    let now = sundog::math::motion::at(&parts, (0.5 * (time + 1.0)) as f32);
    place * now.inverse()
}

/// A lamp that turns and is squeezed on its way, another of vertices that move, and what they light.
pub(super) fn moving_lamps() -> Scene {
    let mut scene = still_life();
    scene.environment = None;
    let lamp = &mut scene.instances[2];
    let at = |angle: f64, x: f64, scale: f64| {
        DAffine3::from_translation(DVec3::new(x, 3.0, 1.0))
            * DAffine3::from_rotation_z(angle)
            * DAffine3::from_scale(DVec3::new(scale, 1.0, 1.0))
            * DAffine3::from_translation(DVec3::new(0.0, -5.0, -2.0))
    };
    lamp.world_from_object = at(0.0, 0.0, 1.0);
    lamp.motion = vec![at(-0.8, -2.0, 0.5), at(0.0, 0.0, 1.0), at(0.9, 2.0, 2.0)];
    let bar = quad([-0.2, -2.0, 0.5], [0.4, 0.0, 0.0], [0.0, 0.2, 0.2]);
    place(&mut scene, bar, shining(20.0), &[DAffine3::IDENTITY]);
    let mesh = &mut scene.meshes[3];
    mesh.motion = moved(
        mesh,
        &[DVec3::X * -2.0, DVec3::ZERO, DVec3::new(2.0, 0.5, 0.0)],
    );
    scene
}

#[test]
fn light_sampling_finds_lamps_that_move_as_rays_do() {
    techniques_agree("moving lamps", &moving_lamps(), &small(16, 3), 4.0, 0.05);
}

/// A closed room that flies, turns and is deformed under a sky, with the camera in it: no light gets in. The same from outside:
/// a white ball in a white sky is not to be seen.
#[test]
fn no_light_gets_through_walls_that_move() {
    for (name, offset, scale) in [
        ("here", 0.0, 1.0),
        ("far", 300.0, 3.0),
        ("large", 10.0, 1e4),
    ] {
        for deforms in [false, true] {
            let mut scene = Scene {
                environment: constant_environment(1.0),
                ..Scene::default()
            };
            let ball = sphere(12, 0.0, false);
            let place_at = |time: f64| {
                DAffine3::from_translation(DVec3::new(
                    offset + 0.3 * scale * time,
                    0.1 * scale * time,
                    0.0,
                )) * DAffine3::from_rotation_y(2.5 * time)
                    * DAffine3::from_scale(DVec3::new(scale, scale * (1.0 + 0.2 * time), scale))
            };
            place(&mut scene, ball, diffuse([1.0; 3]), &[place_at(0.0)]);
            scene.instances[0].motion = [-1.0, 0.0, 1.0].map(place_at).to_vec();
            if deforms {
                let mesh = &mut scene.meshes[0];
                mesh.motion = moved(mesh, &[DVec3::splat(-0.1), DVec3::ZERO, DVec3::splat(0.1)]);
            }
            scene.cameras.push(camera(DVec3::X * offset, 1.5));
            let settings = RenderSettings {
                roulette: Some(100),
                // White surfaces then bring exactly what comes from the sky.
                light_sampling: LightSampling::Bsdf,
                ..small(32, 12)
            };
            let inside = run(&scene, &settings);
            let light = inside.picture.layers[0]
                .data
                .iter()
                .filter(|c| **c > 0.0)
                .count();
            // The alpha of each pixel is light, too.
            let channels = inside.picture.layers[0].channels.len();
            let alphas = if channels == 4 { 32 * 24 } else { 0 };
            assert_eq!(light, alphas, "{name}, deformed {deforms}: light got in");
            scene.cameras[0] = camera(DVec3::new(offset, 0.0, 4.0 * scale), 0.8);
            let outside = run(&scene, &settings);
            for x in outside.picture.layers[0].data.iter() {
                assert!((x - 1.0).abs() < 1e-4, "{name}, deformed {deforms}: {x}");
            }
        }
    }
}

#[test]
fn what_moves_too_oddly_stands_still_and_is_told() {
    let mut scene = still_life();
    scene.instances[1].motion = vec![DAffine3::IDENTITY];
    scene.meshes[2].motion = vec![MeshStep::default(); 3];
    scene.cameras[0].motion = Some(Box::new(CameraMotion {
        steps: Vec::new(),
        zoom: [0.0, 1.0],
    }));
    scene.shutter.curve = vec![0.0, f32::NAN];
    scene.meshes[0].material = Some(MaterialId(0));
    let mut told = sundog::scene::Diagnostics::default();
    sundog::scene::validate::clean(&mut scene, &mut told);
    let bad: usize = told
        .iter()
        .filter(|d| d.code == "bad-motion")
        .map(|d| d.count)
        .sum();
    assert_eq!(bad, 4);
    assert!(
        !sundog::effects::EffectReport::detect(&scene)
            .called_for
            .contains(sundog::effects::Effect::MotionBlur)
    );
}
