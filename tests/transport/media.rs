//! What fills meshes and space, where the answer is known.

use super::{
    RenderSettings, estimate, floor, mean, run, small, techniques_agree, under_a_white_picture,
};
use glam::{DAffine3, DMat3, DVec3};
use sundog::scene::graph::function::PlaceInput;
use sundog::scene::graph::{
    Function, Graph, MathOperation, Node, NodeKind, PhaseKind, VolumeShader,
};
use sundog::scene::validate::clean;
use sundog::scene::{Diagnostics, LightKind, Medium, MetallicRoughness, Phase, Scatterer, Scene};
use sundog::selftest::kit::{
    camera, constant_environment, diffuse, glass, light, place, quad, sphere,
};
use sundog::selftest::media::{add_slab, behind_a_slab, boundary, scattering};

/// A ball of fog in a thin haze, over a floor, under a lamp and a sky.
pub fn fog() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.4),
        cameras: vec![camera(DVec3::new(0.0, 0.2, 4.0), 0.8)],
        medium: Some(Medium {
            absorption: [0.01, 0.02, 0.0],
            ..Medium::default()
        }),
        ..floor()
    };
    let inside = Medium {
        absorption: [0.3, 0.1, 0.0],
        emission: [0.02, 0.0, 0.05],
        varying: None,
        scatterers: vec![
            scattering([0.5, 0.9, 1.4], 0.4),
            Scatterer {
                coefficient: [0.1, 0.2, 0.4],
                phase: Phase::Rayleigh,
            },
        ],
    };
    place(
        &mut scene,
        sphere(12, 0.0, true),
        boundary(inside),
        &[DAffine3::IDENTITY],
    );
    let at = DAffine3::from_translation(DVec3::new(1.0, 2.5, 1.0));
    let lamp = LightKind::Point {
        intensity: 6.0,
        radius: 0.3,
        soft_falloff: false,
    };
    scene.lights.push(light("lamp", lamp, at));
    scene
}

/// A node tree of a density that grows along the object's X axis, from 0 on: by so much for each metre.
pub fn growing(slope: f32, shader: VolumeShader) -> Graph {
    let mut graph = Graph::default();
    let place = graph.add(Node::new(NodeKind::Function(Function::Place(
        PlaceInput::Object,
    ))));
    let split = graph.add(Node::new(NodeKind::SeparateColor).with(0, place));
    let density = Node::new(NodeKind::Math {
        operation: MathOperation::Multiply,
        clamp: false,
    });
    let density = graph.add(density.with(0, split).with(1, slope));
    let shader = Node::new(NodeKind::Volume(shader));
    let shader = shader.with(0, [0.9, 0.7, 0.5]).with(1, density);
    graph.volume = Some(graph.add(shader));
    graph
}

/// A ball of what varies in a haze, over a floor, under a lamp and a sky.
pub fn cloud() -> Scene {
    let mut scene = fog();
    let shader = VolumeShader::Scatter(PhaseKind::HenyeyGreenstein);
    if let Some(ball) = scene.materials.last_mut() {
        ball.medium = Some(Medium {
            emission: [0.02, 0.0, 0.05],
            varying: Some(Box::new(growing(4.0, shader))),
            ..Medium::default()
        });
    }
    scene
}

/// A slab that takes light by how far along X it is met lets exp(−σ(x) d) through, in the mean over the picture.
#[test]
fn a_slab_that_varies_lets_through_what_it_must() {
    let medium = Medium {
        varying: Some(Box::new(growing(2.0, VolumeShader::Absorption))),
        ..Medium::default()
    };
    let mut scene = behind_a_slab(medium, 1.5);
    // The camera's narrow view goes through where x is 1, and the density 2 m⁻¹.
    scene.cameras[0].world_from_camera.translation.x = 1.0;
    let (found, variance) = estimate(&scene, &small(32, 8), 0..16);
    let share = |color: f64| (-(1.0 - color) * 2.0 * 1.5).exp();
    let expected = [0.9f32, 0.7, 0.5].map(|c| share(f64::from(c)));
    let expected = expected.iter().sum::<f64>() / 3.0;
    assert!(
        // Of Student's distribution with 15 degrees of freedom: exceeded by chance once in 4000 times.
        (found - expected).abs() < 4.5 * variance.sqrt() + 1e-4,
        "{found} ± {}, {expected}",
        variance.sqrt()
    );
}

/// What fills an object that moves stands still, and the scene says so once.
#[test]
fn a_cloud_that_moves_is_told() {
    for (moves, expected) in [(false, 0), (true, 1)] {
        let (mut scene, mut told) = (cloud(), Diagnostics::default());
        if let (true, Some(ball)) = (moves, scene.instances.last_mut()) {
            let further = DAffine3::from_translation(DVec3::X);
            ball.motion = vec![ball.world_from_object, further * ball.world_from_object];
        }
        clean(&mut scene, &mut told);
        let of_volumes = told.iter().filter(|d| d.code == "still-volume");
        assert_eq!(of_volumes.count(), expected);
    }
}

/// A cloud that varies and takes nothing is invisible in a white furnace.
#[test]
fn a_white_cloud_that_varies_vanishes_in_a_white_furnace() {
    let mut graph = growing(6.0, VolumeShader::Scatter(PhaseKind::Rayleigh));
    if let Some(shader) = graph.nodes.last_mut() {
        *shader = shader.clone().with(0, [1.0; 3]);
    }
    let mut scene = Scene {
        environment: constant_environment(1.0),
        cameras: vec![camera(DVec3::new(0.0, 0.2, 4.0), 0.4)],
        ..Scene::default()
    };
    let filled = Medium {
        varying: Some(Box::new(graph)),
        ..Medium::default()
    };
    place(
        &mut scene,
        sphere(12, 0.0, true),
        boundary(filled),
        &[DAffine3::IDENTITY],
    );
    let (found, variance) = estimate(&scene, &small(16, 100), 0..8);
    // Of Student's distribution with 7 degrees of freedom: exceeded by chance once in 1000 times.
    assert!(
        (found - 1.0).abs() < 5.4 * variance.sqrt() + 1e-4,
        "{found} ± {}",
        variance.sqrt()
    );
}

/// A ball of glass that takes light by its thickness.
pub fn liquid() -> Scene {
    let mut scene = fog();
    scene.medium = None;
    if let Some(ball) = scene.materials.last_mut() {
        *ball = MetallicRoughness {
            medium: Some(Medium::absorbing([0.3, 0.7, 0.9], 0.5)),
            ..glass(0.0, 1.4)
        }
        .into();
    }
    scene
}

/// What a slab lets through is exp(−σ d), and what it emits ε (1 − exp(−σ d))/σ.
#[test]
fn a_slab_takes_and_emits_by_its_thickness() {
    for (sigma, thickness) in [
        (0.5, 2.0),
        (1e-3, 1.0),
        (3.0, 4.0),
        (20.0, 4.0),
        (1e5, 1e-5),
    ] {
        let medium = Medium {
            absorption: [sigma; 3],
            emission: [0.7; 3],
            ..Medium::default()
        };
        let rendering = run(&behind_a_slab(medium, thickness), &small(4, 4));
        let through = f64::from(-sigma * thickness).exp();
        let expected = through + 0.7 * (1.0 - through) / f64::from(sigma);
        let found = mean(&rendering);
        // The slab of 1e-5 m is known to the roundings of its corners' distances from the camera, 4 m.
        let bound = 1e-4 + f64::from(f32::EPSILON) * 8.0 * f64::from(sigma);
        assert!(
            (found / expected - 1.0).abs() < bound,
            "{sigma} {thickness}: {found} {expected}"
        );
    }
}

/// A cloud that takes nothing is invisible in a white furnace, thin or thick, however it scatters.
#[test]
fn a_white_cloud_vanishes_in_a_white_furnace() {
    for (sigma, g) in [(0.3, 0.0), (2.0, -0.7), (8.0, 0.8)] {
        let medium = Medium {
            scatterers: vec![scattering([sigma, 0.5 * sigma, 2.0 * sigma], g)],
            ..Medium::default()
        };
        let mut scene = Scene {
            cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.4)],
            ..under_a_white_picture()
        };
        place(
            &mut scene,
            sphere(16, 0.0, false),
            boundary(medium),
            &[DAffine3::IDENTITY],
        );
        let settings = RenderSettings {
            roulette: None,
            ..small(8, 1024)
        };
        let (found, variance) = estimate(&scene, &settings, 0..12);
        let z = (found - 1.0) / variance.sqrt();
        assert!(
            z.abs() < 4.0 && variance.sqrt() < 1e-2,
            "{sigma} {g}: {found} ± {}",
            variance.sqrt()
        );
    }
}

/// A point lamp in all space that absorbs: the floor has what the formula says, by the way there and back.
#[test]
fn haze_dims_lamps_by_both_ways() {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 1e-3)],
        ..Scene::default()
    };
    let wall = quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    place(&mut scene, wall, diffuse([1.0; 3]), &[DAffine3::IDENTITY]);
    let point = LightKind::Point {
        intensity: 10.0,
        radius: 0.0,
        soft_falloff: false,
    };
    let at = DAffine3::from_translation(DVec3::new(0.0, 0.0, 2.0));
    scene.lights.push(light("lamp", point, at));
    let clear = mean(&run(&scene, &small(4, 0)));
    scene.medium = Some(Medium {
        absorption: [0.3; 3],
        ..Medium::default()
    });
    let hazy = mean(&run(&scene, &small(4, 0)));
    assert!(
        (hazy / clear / (-0.3f64 * 6.0).exp() - 1.0).abs() < 1e-4,
        "{hazy} {clear}"
    );
    // A camera inside of a large ball is in it, as in all space.
    scene.medium = None;
    let medium = Medium::absorbing([(-0.3f32).exp(); 3], 1.0);
    let around = DAffine3::from_scale(DVec3::splat(50.0));
    place(
        &mut scene,
        sphere(16, 0.0, false),
        boundary(medium),
        &[around],
    );
    let inside = mean(&run(&scene, &small(4, 0)));
    assert!((inside / hazy - 1.0).abs() < 1e-4, "{inside} {hazy}");
}

/// Light of a point lamp that is scattered once in a medium without end, beside ∫ σ_s exp(−σ (t + r)) I/(4π r²) dt.
#[test]
fn single_scattering_of_a_point_lamp() {
    let (scattered, absorbed, intensity) = (0.3f64, 0.2, 10.0);
    for (beside, ahead) in [(0.05, 2.0), (1.0, 3.0), (0.3, -0.5)] {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::ZERO, 1e-4)],
            medium: Some(Medium {
                absorption: [absorbed as f32; 3],
                scatterers: vec![scattering([scattered as f32; 3], 0.0)],
                ..Medium::default()
            }),
            ..Scene::default()
        };
        let point = LightKind::Point {
            intensity: intensity as f32,
            radius: 0.0,
            soft_falloff: false,
        };
        let at = DAffine3::from_translation(DVec3::new(beside, 0.0, -ahead));
        scene.lights.push(light("lamp", point, at));
        let sigma = scattered + absorbed;
        // Substituted by the angle at which the lamp sees the way: the integrand is smooth in it.
        let (low, high) = ((-ahead / beside).atan(), std::f64::consts::FRAC_PI_2);
        let steps = 100_000;
        let width = (high - low) / f64::from(steps);
        let part = |i: i32| {
            let angle = low + (f64::from(i) + 0.5) * width;
            let t = ahead + beside * angle.tan();
            let r = beside / angle.cos();
            (-sigma * (t + r)).exp() / beside
        };
        let sum: f64 = (0..steps).map(|i| part(i) * width).sum();
        let expected = scattered * intensity / (4.0 * std::f64::consts::PI) * sum;
        let settings = RenderSettings {
            roulette: None,
            bounces: 0,
            ..small(64, 0)
        };
        // Few seeds do not tell the variance: even samples err by much the same, to one side or the other.
        let (found, variance) = estimate(&scene, &settings, 0..32);
        // Of Student's distribution with 31 degrees of freedom: exceeded by chance once in 1000 times.
        assert!(
            (found - expected).abs() < 3.64 * variance.sqrt() + 1e-4 * expected,
            "{beside} {ahead}: {found} ± {}, {expected}",
            variance.sqrt()
        );
        // By angles the noise is small: by free paths alone it is ten times this, and more near the lamp.
        assert!(
            variance.sqrt() < 2e-3 * expected,
            "{beside} {ahead}: {}",
            variance.sqrt() / expected
        );
    }
}

/// Lamps of all kinds, the one lights the way where the others do not: together they shed what they shed one by one.
#[test]
fn lamps_along_a_way_add_up() {
    lamps_along_a_way(false);
}

mod long {
    /// That is found along the way as by the phase function alone, where that finds them.
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn lamps_along_a_way_are_found_by_the_phase_function() {
        super::lamps_along_a_way(true);
    }
}

fn lamps_along_a_way(also_blind: bool) {
    let down = |at: DVec3| {
        let turned = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        DAffine3::from_mat3_translation(turned, at)
    };
    let spot = LightKind::Spot {
        intensity: 30.0,
        radius: 0.05,
        soft_falloff: false,
        half_angle: 0.3,
        blend: 0.2,
    };
    let area = LightKind::Area {
        shape: sundog::scene::AreaShape::Rectangle,
        size: [0.8, 0.3],
        power: 20.0,
        normalize: true,
        spread: std::f32::consts::PI,
    };
    let point = LightKind::Point {
        intensity: 2.0,
        radius: 0.1,
        soft_falloff: false,
    };
    let lamps = [
        (spot, down(DVec3::new(0.1, 1.5, -2.0))),
        // Above the way, and below it with its back.
        (area, down(DVec3::new(0.0, 0.4, -4.0))),
        (area, down(DVec3::new(0.0, -0.5, -5.0))),
        (point, down(DVec3::new(-0.4, -0.2, -1.0))),
    ];
    let scene_of = |shining: &[(LightKind, DAffine3)]| {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::ZERO, 1e-2)],
            medium: Some(Medium {
                absorption: [0.1; 3],
                scatterers: vec![scattering([0.2, 0.3, 0.4], 0.5)],
                ..Medium::default()
            }),
            ..Scene::default()
        };
        for &(kind, at) in shining {
            scene.lights.push(light("lamp", kind, at));
        }
        scene
    };
    let settings = RenderSettings {
        roulette: None,
        bounces: 2,
        ..small(64, 2)
    };
    let (together, variance) = estimate(&scene_of(&lamps), &settings, 0..8);
    let (mut sum, mut spread) = (0.0, variance);
    for lamp in lamps {
        let (one, variance) = estimate(&scene_of(&[lamp]), &settings, 0..8);
        (sum, spread) = (sum + one, spread + variance);
    }
    let off = (together - sum).abs();
    assert!(
        off < 5.4 * spread.sqrt(),
        "{together} {sum} ± {}",
        spread.sqrt()
    );
    if !also_blind {
        return;
    }
    let blind = RenderSettings {
        light_sampling: sundog::render::LightSampling::Bsdf,
        ..RenderSettings {
            samples: 512,
            ..settings
        }
    };
    let (found, more) = estimate(&scene_of(&lamps), &blind, 0..8);
    let error = (variance + more).sqrt();
    assert!(
        (found - together).abs() < 5.4 * error,
        "{found} {together} ± {error}"
    );
}

/// Large lamps that the face of a fog cuts, and the floor beneath: all ways to find their light agree. A ray that has passed the face
/// meets no lamp a second time, and a disc faces what it shines on, not the face.
#[test]
fn lamps_that_the_face_of_a_fog_cuts_are_found_once() {
    let down = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    for soft_falloff in [false, true] {
        let point = LightKind::Point {
            intensity: 3.0,
            radius: 0.6,
            soft_falloff,
        };
        let spot = LightKind::Spot {
            intensity: 9.0,
            radius: 0.8,
            soft_falloff,
            half_angle: 0.7,
            blend: 0.3,
        };
        let mut scene = Scene {
            cameras: vec![camera(DVec3::new(0.0, 0.2, 4.0), 0.8)],
            ..floor()
        };
        let fog = Medium {
            absorption: [0.2; 3],
            scatterers: vec![scattering([0.4, 0.5, 0.6], 0.3)],
            ..Medium::default()
        };
        place(
            &mut scene,
            sphere(12, 0.0, true),
            boundary(fog),
            &[DAffine3::from_scale(DVec3::splat(0.9))],
        );
        for (kind, x) in [(point, -0.5), (spot, 0.6), (point, 0.1)] {
            let at = DAffine3::from_mat3_translation(down, DVec3::new(x, 0.9, 0.1));
            scene.lights.push(light("lamp", kind, at));
        }
        let settings = RenderSettings {
            roulette: None,
            ..small(64, 1)
        };
        techniques_agree(
            if soft_falloff { "discs" } else { "spheres" },
            &scene,
            &settings,
            // Of Student's distribution with 15 degrees of freedom: exceeded by chance once in 1000 times.
            4.1,
            0.01,
        );
    }
}

/// A slab of two mean free paths, an albedo of 0.9 and g = 0.75, under light along its normal: van de Hulst (*Multiple Light Scattering*,
/// 1980, table 35) has 0.09739 for what goes back and 0.66096 for what goes through. By reciprocity that is what a camera along the
/// normal sees where light comes evenly from one side.
#[test]
fn a_slab_reflects_and_lets_through_by_van_de_hulsts_tables() {
    let (back, through) = (0.09739, 0.66096);
    let thickness = 1e-2f32;
    let sigma = 2.0 / thickness;
    let medium = Medium {
        scatterers: vec![scattering([0.9 * sigma; 3], 0.75)],
        absorption: [0.1 * sigma; 3],
        ..Medium::default()
    };
    for (name, black, expected) in [("back", true, back), ("both", false, back + through)] {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 1e-3)],
            ..Scene::default()
        };
        add_slab(&mut scene, medium.clone(), thickness);
        if black {
            let wall = quad(
                [-400.0, -400.0, -0.02],
                [800.0, 0.0, 0.0],
                [0.0, 800.0, 0.0],
            );
            place(&mut scene, wall, diffuse([0.0; 3]), &[DAffine3::IDENTITY]);
        }
        let settings = RenderSettings {
            roulette: None,
            ..small(16, 200)
        };
        let (found, variance) = estimate(&scene, &settings, 0..8);
        // The tables' last digit, and of Student's distribution with 7 degrees of freedom what chance exceeds once in 1000 times.
        assert!(
            (found - expected).abs() < 5.4 * variance.sqrt() + 1e-5,
            "{name}: {found} ± {}, {expected}",
            variance.sqrt()
        );
        assert!(variance.sqrt() < 1e-3, "{name}: {}", variance.sqrt());
    }
}

/// Among many lights, too, what shines on but a part of the way is drawn: here an area light whose plane cuts the way, which the middle of
/// what is seen is behind, beside many faint lamps.
#[test]
fn one_of_many_lamps_lights_a_part_of_the_way() {
    let area = LightKind::Area {
        shape: sundog::scene::AreaShape::Rectangle,
        size: [2.0, 2.0],
        power: 20.0,
        normalize: true,
        spread: std::f32::consts::PI,
    };
    let faint = LightKind::Point {
        intensity: 1e-4,
        radius: 0.0,
        soft_falloff: false,
    };
    let scene_of = |others: u32| {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::ZERO, 1e-2)],
            medium: Some(Medium {
                absorption: [0.02; 3],
                scatterers: vec![scattering([0.1; 3], 0.3)],
                ..Medium::default()
            }),
            ..Scene::default()
        };
        // It shines along −Z, away from the camera that looks there.
        let at = DAffine3::from_translation(DVec3::new(2.0, 0.0, -7.0));
        scene.lights.push(light("area", area, at));
        for number in 0..others {
            let at = DVec3::new(3.0, f64::from(number) - 10.0, 2.0);
            let at = DAffine3::from_translation(at);
            scene.lights.push(light("faint", faint, at));
        }
        scene
    };
    let settings = small(64, 0);
    let (alone, a) = estimate(&scene_of(0), &settings, 0..8);
    let (among, b) = estimate(&scene_of(20), &settings, 0..8);
    // The others bring less than a thousandth.
    let off = (among / alone - 1.0).abs();
    let error = (a + b).sqrt() / alone;
    assert!(off < 5.4 * error + 1e-3, "{among} {alone} ± {error}");
    assert!(error < 0.02, "{error}");
}
