//! Solids that overlap, by their priorities, where the answer is known.

use super::{RenderSettings, estimate, floor, mean, run, small};
use glam::{DAffine3, DVec3};
use sundog::scene::graph::node::glass as refract;
use sundog::scene::graph::{Distribution, Graph, Node, NodeKind, SimpleBsdf};
use sundog::scene::validate::clean;
use sundog::scene::{
    Diagnostics, Effect, LightKind, Medium, Mesh, MetallicRoughness, Scene, Verdict,
};
use sundog::selftest::kit::{
    camera, constant_environment, diffuse, glass, light, place, quad, sphere,
};

/// A block about the axis from one place along Z down to another; those that begin higher are wider.
fn slab(from: f32, to: f32) -> Mesh {
    let (h, d) = (4.0 + 0.1 * from, from - to);
    let w = 2.0 * h;
    let faces = [
        quad([-h, -h, from], [w, 0.0, 0.0], [0.0, w, 0.0]),
        quad([-h, h, to], [w, 0.0, 0.0], [0.0, -w, 0.0]),
        quad([h, -h, to], [0.0, w, 0.0], [0.0, 0.0, d]),
        quad([-h, h, to], [0.0, -w, 0.0], [0.0, 0.0, d]),
        quad([h, h, to], [-w, 0.0, 0.0], [0.0, 0.0, d]),
        quad([-h, -h, to], [w, 0.0, 0.0], [0.0, 0.0, d]),
    ];
    let mut block = Mesh {
        name: "block".into(),
        ..Mesh::default()
    };
    for face in faces {
        let first = block.positions.len() as u32;
        block.positions.extend(face.positions);
        let triangles = face.triangles.iter().map(|t| t.map(|i| i + first));
        block.triangles.extend(triangles);
    }
    block
}

fn solid(ior: f32, sigma: f32, priority: Option<i32>) -> MetallicRoughness {
    MetallicRoughness {
        base_color: [1.0; 3],
        priority,
        medium: (sigma > 0.0).then(|| Medium {
            absorption: [sigma; 3],
            ..Medium::default()
        }),
        ..glass(0.0, ior)
    }
}

/// A wall that shines with 1 at −5, behind solids, each with where it begins and ends along Z; a narrow camera looks at them.
fn behind(camera_at: f64, solids: &[(MetallicRoughness, [f32; 2])]) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, camera_at), 1e-3)],
        ..Scene::default()
    };
    let wall = quad([-9.0, -9.0, -5.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let shining = MetallicRoughness {
        emission: [1.0; 3],
        ..diffuse([0.0; 3])
    };
    place(&mut scene, wall, shining, &[DAffine3::IDENTITY]);
    for (material, [from, to]) in solids {
        let mesh = slab(*from, *to);
        place(&mut scene, mesh, material.clone(), &[DAffine3::IDENTITY]);
    }
    scene
}

/// What a row of interfaces between indices lets through straight on, with all reflections between them.
fn through(indices: &[f64]) -> f64 {
    let (mut passed, mut back) = (1.0, 0.0);
    for pair in indices.windows(2) {
        let reflected = ((pair[0] - pair[1]) / (pair[0] + pair[1])).powi(2);
        let between = 1.0 - back * reflected;
        passed *= (1.0 - reflected) / between;
        back = reflected + (1.0 - reflected).powi(2) * back / between;
    }
    passed
}

fn settings(samples: u32) -> RenderSettings {
    small(samples, 32)
}

/// As [`estimate`], beside what is expected: 4.5 standard deviations of 16 runs are exceeded once in 4000 times.
fn assert_mean(scene: &Scene, expected: f64, about: &str) {
    let (found, variance) = estimate(scene, &settings(32), 0..16);
    let bound = 4.5 * variance.sqrt() + 1e-4;
    assert!(
        (found - expected).abs() < bound,
        "{about}: {found} ± {}, expected {expected}",
        variance.sqrt()
    );
}

const WATER: f64 = 1.33;
const GLASS: f64 = 1.5;

/// Light meets the interface from water to glass where they overlap, or where they touch, whichever has the higher priority.
fn water_in_glass_reflects_at_their_interface_by(priorities: &[(i32, i32)]) {
    let expected = through(&[1.0, GLASS, WATER, 1.0]);
    for &(glass_priority, water_priority) in priorities {
        for end in [-1.0, -1.2] {
            let solids = [
                (solid(1.5, 0.0, Some(glass_priority)), [0.0, end]),
                (solid(1.33, 0.0, Some(water_priority)), [-1.0, -2.0]),
            ];
            let about = format!("priorities {glass_priority} {water_priority}, glass to {end}");
            assert_mean(&behind(4.0, &solids), expected, &about);
        }
    }
    // Without priorities both are beside air, as in Cycles.
    let solids = [
        (solid(1.5, 0.0, None), [0.0, -1.2]),
        (solid(1.33, 0.0, None), [-1.0, -2.0]),
    ];
    // What a row lets through does not hang on its order.
    let expected = through(&[1.0, GLASS, 1.0, WATER, 1.0]);
    assert_mean(&behind(4.0, &solids), expected, "no priorities");
}

/// `long` has more of them.
#[test]
fn water_in_glass_reflects_at_their_interface() {
    water_in_glass_reflects_at_their_interface_by(&[(0, 1)]);
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn water_in_glass_reflects_at_their_interface_by_any_priorities() {
        super::water_in_glass_reflects_at_their_interface_by(&[(1, 0), (0, 1), (7, 7), (-3, -5)]);
    }
}

/// A Refraction BSDF, clear and smooth.
fn refraction(ior: f32) -> Graph {
    let distribution = Distribution::Ggx;
    let bsdf = SimpleBsdf::Refraction { distribution };
    let node = Node::new(NodeKind::Bsdf(bsdf))
        .with(refract::COLOR, [1.0; 3])
        .with(refract::ROUGHNESS, 0.0)
        .with(refract::IOR, ior);
    let mut graph = Graph::default();
    graph.surface = Some(graph.add(node));
    graph
}

/// Ice in water in glass.
fn ice() -> [(MetallicRoughness, [f32; 2]); 3] {
    [
        (solid(1.5, 0.0, Some(0)), [0.0, -1.5]),
        (solid(1.33, 0.0, Some(1)), [-0.5, -3.0]),
        (solid(1.31, 0.0, Some(2)), [-1.0, -2.0]),
    ]
}

/// A scene with all of it.
pub(super) fn ice_in_water() -> Scene {
    behind(4.0, &ice())
}

/// One in the other, by another shader as well, and seen from inside.
#[test]
fn ice_floats_in_a_glass_of_water() {
    let solids = ice();
    let mut scene = ice_in_water();
    let expected = through(&[1.0, GLASS, WATER, 1.31, WATER, 1.0]);
    assert_mean(&scene, expected, "Principled BSDFs");
    if let Some(ice) = scene.materials.last_mut() {
        ice.graph = refraction(1.31);
    }
    // A Refraction BSDF lets all through.
    let reflecting = through(&[1.0, GLASS, WATER, 1.0]);
    assert_mean(&scene, reflecting, "a Refraction BSDF");
    // From inside what is reflected below comes back from above.
    let inside = behind(-1.2, &solids);
    let below = through(&[1.31, WATER, 1.0]);
    let above = through(&[1.31, WATER, GLASS, 1.0]);
    let expected = below / (1.0 - (1.0 - below) * (1.0 - above));
    assert_mean(&inside, expected, "from inside");
}

/// Of media that overlap that of the highest priority takes light, and takes it once.
#[test]
fn an_overlap_takes_light_once() {
    // Indices of 1: nothing is reflected, and the depth is exact. Without roulette, so is what comes through.
    let exact = RenderSettings {
        roulette: None,
        ..settings(4)
    };
    let cases = [
        (Some((1, 0)), [1.2, 0.8]),
        (Some((0, 1)), [1.0, 1.0]),
        (None, [1.2, 1.0]),
    ];
    for (priorities, lengths) in cases {
        let solids = [
            (solid(1.0, 0.7, priorities.map(|p| p.0)), [0.0, -1.2]),
            (solid(1.0, 1.3, priorities.map(|p| p.1)), [-1.0, -2.0]),
        ];
        let expected = f64::exp(-0.7 * lengths[0] - 1.3 * lengths[1]);
        let found = mean(&run(&behind(4.0, &solids), &exact));
        assert!(
            (found / expected - 1.0).abs() < 1e-4,
            "{priorities:?}: {found} {expected}"
        );
    }
    // What is clear and of the higher priority takes the other's place.
    let solids = [
        (solid(1.0, 0.7, Some(0)), [0.0, -2.0]),
        (solid(1.0, 0.0, Some(1)), [-0.5, -1.0]),
    ];
    let found = mean(&run(&behind(4.0, &solids), &exact));
    let expected = f64::exp(-0.7 * 1.5);
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
}

/// The camera, a floor and a lamp in water, with a ball of something else somewhere.
fn under_water(ball: MetallicRoughness, at: DVec3) -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.4),
        cameras: vec![camera(DVec3::new(0.0, 0.2, 3.0), 0.8)],
        ..floor()
    };
    let water = solid(1.33, 0.1, Some(0));
    let around = DAffine3::from_scale(DVec3::splat(20.0));
    place(&mut scene, sphere(24, 0.0, false), water, &[around]);
    let placed = DAffine3::from_translation(at);
    place(&mut scene, sphere(12, 0.0, true), ball, &[placed]);
    let at = DAffine3::from_translation(DVec3::new(0.5, 3.0, 1.0));
    let lamp = LightKind::Point {
        intensity: 20.0,
        radius: 0.2,
        soft_falloff: false,
    };
    scene.lights.push(light("lamp", lamp, at));
    scene
}

/// A ball within a solid of a higher priority is not there: not for paths, for shadow rays, nor for what takes light.
#[test]
fn what_lies_within_a_higher_priority_is_not_there() {
    const BETWEEN: DVec3 = DVec3::new(0.3, 0.6, 0.5);
    // Where nothing asks for it.
    const AWAY: DVec3 = DVec3::new(0.0, 2.0, 12.0);
    let hidden = solid(1.6, 3.0, Some(-1));
    let expected = estimate(&under_water(hidden.clone(), AWAY), &small(64, 6), 0..16);
    let found = estimate(&under_water(hidden.clone(), BETWEEN), &small(64, 6), 16..32);
    let sigma = (expected.1 + found.1).sqrt();
    assert!(
        (found.0 - expected.0).abs() < 4.5 * sigma + 1e-4,
        "{} {} ± {sigma}",
        found.0,
        expected.0
    );
    // It is there with a higher one, and takes much of the light.
    let seen = MetallicRoughness {
        priority: Some(1),
        ..hidden
    };
    let seen = estimate(&under_water(seen, BETWEEN), &small(64, 6), 16..32);
    assert!(seen.0 < 0.95 * expected.0, "{} {}", seen.0, expected.0);
}

/// Rough glass in water in a white furnace takes no light.
#[test]
fn rough_interfaces_keep_the_light() {
    for (inner, outer) in [(1.5, 1.33), (1.33, 1.5)] {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            cameras: vec![camera(DVec3::new(0.0, 0.0, 4.0), 0.5)],
            ..Scene::default()
        };
        let rough = MetallicRoughness {
            roughness: 0.7,
            ..solid(inner, 0.0, Some(1))
        };
        place(
            &mut scene,
            sphere(24, 0.0, false),
            rough,
            &[DAffine3::IDENTITY],
        );
        let around = DAffine3::from_scale(DVec3::splat(1.2));
        let clear = solid(outer, 0.0, Some(0));
        place(&mut scene, sphere(24, 0.0, false), clear, &[around]);
        let (found, variance) = estimate(&scene, &small(64, 256), 0..16);
        // As rough glass in air is held to.
        let bound = 4.5 * variance.sqrt() + 5e-3;
        assert!((found - 1.0).abs() < bound, "{inner} in {outer}: {found}");
    }
}

/// What cannot take part is told, once, and a scene without overlaps calls for nothing.
#[test]
fn priorities_without_use_are_told() {
    let mut told = Diagnostics::default();
    let matte = MetallicRoughness {
        priority: Some(3),
        ..diffuse([0.5; 3])
    };
    let mut scene = behind(4.0, &[(matte, [0.0, -1.0])]);
    clean(&mut scene, &mut told);
    let of_nesting: Vec<_> = told.iter().filter(|d| d.code == "nesting").collect();
    assert_eq!(of_nesting.len(), 1);
    assert_eq!(of_nesting[0].verdict, Verdict::Lost);
    assert!(scene.materials.iter().all(|m| m.priority.is_none()));

    let called = |solids: &[(MetallicRoughness, [f32; 2])]| {
        let report = sundog::effects::EffectReport::detect(&behind(4.0, solids));
        report.called_for.contains(Effect::NestedDielectrics)
    };
    let (a, b) = (solid(1.5, 0.0, Some(1)), solid(1.33, 0.0, None));
    assert!(!called(&[(a.clone(), [0.0, -1.0]), (b, [0.0, -2.0])]));
    assert!(called(&[(a.clone(), [0.0, -1.0]), (a, [-1.0, -2.0])]));
}

/// A camera in water sees from its near plane on, be there another solid somewhere in the water's box or not.
#[test]
fn light_before_the_near_plane_is_not_absorbed() {
    let water = solid(1.0, 0.5, None);
    let mut scene = behind(0.0, &[(water, [1.0, -1.0])]);
    scene.cameras[0].clip_near = 0.5;
    let expected = (-0.5f64 * 0.5).exp();
    assert_mean(&scene, expected, "water alone");
    let aside = DAffine3::from_translation(DVec3::new(2.0, 2.0, -0.5))
        * DAffine3::from_scale(DVec3::splat(0.1));
    place(
        &mut scene,
        sphere(8, 0.0, false),
        solid(1.5, 0.0, None),
        &[aside],
    );
    assert_mean(&scene, expected, "water with a ball aside");
}
