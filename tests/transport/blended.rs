//! Surfaces that paths pass by chance.

use super::portals::material;
use super::{colors, run, small};
use glam::{DAffine3, DVec3};
use sundog::scene::graph::node::{diffuse as diffuse_bsdf, mix_shader, transparent};
use sundog::scene::graph::{Graph, Node, NodeKind};
use sundog::scene::{LightKind, Scene};
use sundog::selftest::kit::{camera, light, place, quad};

/// A sheet below a point lamp, of which so much is there.
fn sheet(share: f32) -> Scene {
    let mut graph = Graph::default();
    let clear = graph.add(Node::new(NodeKind::TransparentBsdf).with(transparent::COLOR, 1.0));
    let matte = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    });
    let matte = graph.add(matte.with(diffuse_bsdf::COLOR, [0.6, 0.7, 0.8]));
    let mix = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, share);
    let mix = mix.with(mix_shader::A, clear).with(mix_shader::B, matte);
    let surface = graph.add(mix);
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 2.0), 0.5)],
        ..Scene::default()
    };
    let wall = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    let of = material(graph, surface);
    place(&mut scene, wall, of, &[DAffine3::IDENTITY]);
    let lamp = LightKind::Point {
        intensity: 10.0,
        radius: 0.0,
        soft_falloff: false,
    };
    let above = DAffine3::from_translation(DVec3::new(0.3, 0.2, 1.5));
    scene.lights.push(light("lamp", lamp, above));
    scene
}

/// Paths that pass the sheet bring its light as well as those that stop: a part of it has no noise that the whole has not.
#[test]
fn light_samples_do_not_hang_on_whether_a_path_passes() {
    let settings = small(4, 0);
    let whole = colors(&run(&sheet(1.0), &settings));
    assert!(whole[0][0] > 0.01, "{:?}", whole[0]);
    for share in [0.25, 0.5, 0.875] {
        let part = colors(&run(&sheet(share), &settings));
        for (part, whole) in part.iter().flatten().zip(whole.iter().flatten()) {
            let expected = f64::from(share) * whole;
            // Rounding of a sum of products.
            assert!(
                (part - expected).abs() < 1e-5 * expected,
                "{part} {expected}"
            );
        }
    }
}
