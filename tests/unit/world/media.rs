use super::*;
use crate::sampler::hashed;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::volume_absorption;
use crate::scene::graph::{Function, Input, Node, NodeKind, VolumeShader};
use crate::selftest::kit::{camera, constant_environment, diffuse, place, prepared, sphere};
use crate::selftest::media::{boundary, scattering};
use glam::DAffine3;

/// Two balls of fog that overlap, and a solid one in their middle.
fn world() -> World {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 9.0), 0.5)],
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let fog = |color: [f32; 3]| {
        boundary(scene::Medium {
            absorption: [0.1, 0.0, 0.3],
            scatterers: vec![scattering(color, 0.2)],
            ..scene::Medium::default()
        })
    };
    let at = |x: f64, size: f64| {
        let moved = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        [moved * DAffine3::from_scale(DVec3::splat(size))]
    };
    let (red, grey) = (fog([0.9, 0.2, 0.4]), fog([0.5; 3]));
    place(&mut scene, sphere(8, 0.0, false), red, &at(-0.6, 1.0));
    place(&mut scene, sphere(8, 0.0, false), grey, &at(0.6, 1.0));
    let solid = diffuse([0.5; 3]);
    place(&mut scene, sphere(6, 0.0, false), solid, &at(0.0, 0.2));
    prepared(&scene).expect("a world")
}

/// What one query finds of surfaces and media is what two find, one after the other.
#[test]
fn light_comes_through_as_by_surfaces_and_media_one_after_the_other() {
    let world = world();
    let number = |i: u32, which: u32| 4.0 * hashed(1, i, which) - 2.0;
    let point = |i: u32, which: u32| {
        // The world begins at the camera.
        Vec3::new(
            number(i, which),
            number(i, which + 1),
            number(i, which + 2) - 9.0,
        )
    };
    let (mut blocked, mut dimmed) = (0, 0);
    for i in 0..2000 {
        let (from, to) = (point(i, 0), point(i, 3));
        let within = world.around(from, RayKind::Camera);
        let direction = (to - from).normalize();
        for target in [Some(to), None] {
            let sender = Sender::from(RayKind::Shadow);
            let limited = (u32::MAX, &sender);
            let found = world.light_through(&within, (from, direction), target, limited, 7);
            let surfaces = match target {
                Some(to) => world.transmittance_to::<General>(from, to, limited),
                None => world.transmittance::<General>(from, direction, f32::INFINITY, limited),
            };
            let media = world.media_before(&within, (from, direction), target, (&sender, 7));
            assert_eq!(found, surfaces * media, "{from} {target:?}");
            blocked += u32::from(found == Vec3::ZERO);
            dimmed += u32::from(found != Vec3::ZERO && found != Vec3::ONE);
        }
    }
    assert!(blocked > 10 && dimmed > 1000, "{blocked} {dimmed}");
}

/// A ball that takes e-fold a metre of rays of one kind.
fn fog_for(kind: RayKind) -> World {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 9.0), 0.5)],
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    let mut graph = Graph::default();
    let asks = Function::Place(PlaceInput::IsRay(kind.bit()));
    let asks = graph.add(Node::new(NodeKind::Function(asks)));
    let absorbs = Node::new(NodeKind::Volume(VolumeShader::Absorption))
        .with(volume_absorption::COLOR, Input::Value([0.0; 3]))
        .with(volume_absorption::DENSITY, Input::Link(asks));
    graph.volume = Some(graph.add(absorbs));
    let fog = boundary(scene::Medium {
        varying: Some(Box::new(graph)),
        ..scene::Medium::default()
    });
    place(
        &mut scene,
        sphere(8, 0.0, false),
        fog,
        &[DAffine3::IDENTITY],
    );
    prepared(&scene).expect("a world")
}

/// Rays of that kind lose what they should, in the mean of many numbers; all others lose nothing.
#[test]
fn a_volume_takes_light_of_the_rays_that_it_asks_for() {
    let ray = (Vec3::new(-3.0, 0.1, -8.9), Vec3::X);
    for (kind, _) in RayKind::ALL {
        let world = fog_for(kind);
        let within = world.around(ray.0, RayKind::Camera);
        let crossings = world.crossings(ray, f32::INFINITY, 0.0);
        let [enters, leaves] = crossings[..] else {
            panic!("a ball has two faces on a ray: {crossings:?}");
        };
        let expected = (enters.distance - leaves.distance).exp();
        for (other, _) in RayKind::ALL {
            let sender = Sender::from(other);
            let share = |key| {
                let media = world.media_before(&within, ray, None, (&sender, key));
                f64::from(media.x)
            };
            let count = 20_000;
            let found: f64 = (0..count).map(share).sum::<f64>() / f64::from(count);
            if other == kind {
                // Shares are between 0 and 1: four and a half of the greatest standard errors that such have.
                let error = 4.5 * 0.5 / f64::from(count).sqrt();
                assert!(
                    (found - expected).abs() < error,
                    "{kind:?}: {found} {expected}"
                );
            } else {
                assert_eq!(found, 1.0, "{kind:?} {other:?}");
            }
        }
    }
}
