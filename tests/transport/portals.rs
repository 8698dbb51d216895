//! Surfaces that send rays elsewhere.

use super::{RenderSettings, colors, estimate, floor, run, small};
use glam::{DAffine3, DVec3};
use sundog::effects::{self, Effect};
use sundog::render::EffectChoice;
use sundog::scene::graph::node::{diffuse as diffuse_bsdf, mix_shader, ray_portal, transparent};
use sundog::scene::graph::{Graph, Link, Node, NodeKind, SimpleBsdf};
use sundog::scene::{Material, MetallicRoughness, Scene};
use sundog::selftest::kit::{camera, constant_environment, diffuse, place, quad};

/// Of Student's t with 23 degrees of freedom, so much is exceeded with a probability of 1e-4.
const LARGEST_T: f64 = 4.7;

pub fn material(graph: Graph, surface: Link) -> Material {
    Material {
        name: "portal".into(),
        graph: Graph {
            surface: Some(surface),
            ..graph
        },
        double_sided: true,
        medium: None,
        priority: None,
    }
}

/// A node with a portal of a colour; place and direction in Blender's axes.
fn portal(color: [f32; 3], position: Option<[f32; 3]>, direction: [f32; 3]) -> Node {
    let moves = position.is_some();
    Node::new(NodeKind::Bsdf(SimpleBsdf::RayPortal { moves }))
        .with(ray_portal::COLOR, color)
        .with(ray_portal::POSITION, position.unwrap_or_default())
        .with(ray_portal::DIRECTION, direction)
}

/// A portal of a share, and another shader for the rest.
fn mixed(share: f32, portal: Node, other: Node) -> Material {
    let mut graph = Graph::default();
    let (portal, other) = (graph.add(portal), graph.add(other));
    let mix = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, share);
    let mix = mix.with(mix_shader::A, other).with(mix_shader::B, portal);
    let surface = graph.add(mix);
    material(graph, surface)
}

fn alone(portal: Node) -> Material {
    let mut graph = Graph::default();
    let surface = graph.add(portal);
    material(graph, surface)
}

/// A sheet that fills the view of a camera above it.
fn sheet(of: Material) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.0, 2.0), 0.5)],
        ..Scene::default()
    };
    let wall = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    place(&mut scene, wall, of, &[DAffine3::IDENTITY]);
    scene
}

fn shining(emission: f32) -> MetallicRoughness {
    MetallicRoughness {
        emission: [emission; 3],
        ..diffuse([0.0; 3])
    }
}

/// A wall that shines far from all else, along X.
fn add_far_wall(scene: &mut Scene) {
    let wall = quad([60.0, -9.0, -9.0], [0.0, 18.0, 0.0], [0.0, 0.0, 18.0]);
    place(scene, wall, shining(3.0), &[DAffine3::IDENTITY]);
}

/// A gallery's scene: a half portal through which a floor shows another place, and a sheet that light passes beside it.
pub fn scene() -> Scene {
    let mut scene = Scene {
        environment: constant_environment(0.3),
        cameras: vec![camera(DVec3::new(0.0, 0.3, 4.0), 0.8)],
        ..floor()
    };
    scene.lights.clear();
    let lamp = quad([-1.0, 1.8, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    place(&mut scene, lamp, shining(4.0), &[DAffine3::IDENTITY]);
    let white = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    })
    .with(diffuse_bsdf::COLOR, [0.6, 0.7, 0.8]);
    let elsewhere = portal([0.9, 0.8, 0.7], Some([0.2, 0.1, 1.2]), [0.3, 0.2, -1.0]);
    let wall = quad([-1.5, -0.9, -0.5], [1.4, 0.0, 0.0], [0.0, 1.6, 0.0]);
    place(
        &mut scene,
        wall,
        mixed(0.5, elsewhere, white),
        &[DAffine3::IDENTITY],
    );
    let clear = Node::new(NodeKind::TransparentBsdf).with(transparent::COLOR, 1.0);
    let through = portal([1.0; 3], None, [0.0; 3]);
    let pane = quad([0.1, -0.9, 0.0], [1.2, 0.0, 0.0], [0.0, 1.4, 0.0]);
    place(
        &mut scene,
        pane,
        mixed(0.4, through, clear),
        &[DAffine3::IDENTITY],
    );
    scene
}

#[test]
fn a_portal_shows_another_place() {
    let color = [0.5, 1.0, 0.25];
    // Up in Blender is up in glTF; a direction of any length.
    let elsewhere = portal(color, Some([50.0, 0.0, 2.0]), [1e25, 0.0, 0.0]);
    let mut scene = sheet(alone(elsewhere));
    add_far_wall(&mut scene);
    for shown in colors(&run(&scene, &small(2, 0))) {
        for (value, color) in shown.into_iter().zip(color) {
            assert!((value - 3.0 * f64::from(color)).abs() < 1e-5, "{shown:?}");
        }
    }
    let without = RenderSettings {
        effects: EffectChoice::List(effects::names(effects::ALL - Effect::RayPortals)),
        ..small(1, 2)
    };
    assert_eq!(colors(&run(&scene, &without))[0], [0.0; 3]);
}

#[test]
fn a_portal_without_a_place_is_transparent() {
    let mut scene = sheet(alone(portal([0.5; 3], None, [0.0; 3])));
    let wall = quad([-4.0, -4.0, -1.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    place(&mut scene, wall, shining(2.0), &[DAffine3::IDENTITY]);
    for shown in colors(&run(&scene, &small(1, 0))) {
        assert!((shown[0] - 1.0).abs() < 1e-6, "{shown:?}");
    }
}

/// A direction of its own, and numbers that are none.
#[test]
fn portals_turn_rays_and_take_any_numbers() {
    let settings = small(1, 2);
    // Back to where the camera is: a wall behind it.
    let mut scene = sheet(alone(portal([1.0; 3], None, [0.0, -1.0, 0.0])));
    let wall = quad([-9.0, -9.0, 5.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    place(&mut scene, wall, shining(2.0), &[DAffine3::IDENTITY]);
    assert_eq!(colors(&run(&scene, &settings))[100], [2.0; 3]);
    for wrong in [f32::NAN, f32::INFINITY, 1e30, -1e-40] {
        for node in [
            portal([1.0; 3], Some([wrong; 3]), [0.0; 3]),
            portal([1.0; 3], None, [wrong; 3]),
            portal([wrong; 3], None, [0.0; 3]),
        ] {
            run(&sheet(alone(node)), &settings);
        }
    }
}

/// Two that send a ray to each other for ever end it.
#[test]
fn rays_do_not_go_round_for_ever() {
    let round = portal([1.0; 3], Some([0.0, -0.5, 0.0]), [0.0, 1.0, 0.0]);
    let scene = sheet(alone(round));
    for transparent in [None, Some(0), Some(1), Some(8)] {
        let mut settings = small(1, 1);
        settings.bounce_limits.transparent = transparent;
        let shown = run(&scene, &settings);
        assert_eq!(colors(&shown)[0], [0.0; 3]);
        // The ray through the pixel's middle (depths are asked for), the camera's, and one behind each portal.
        let behind = u64::from(transparent.unwrap_or(1024));
        assert_eq!(shown.statistics.rays, 32 * 24 * (2 + behind));
    }
}

/// What is half a portal and half white is white in a white furnace.
#[test]
fn a_mixture_with_a_portal_keeps_its_light() {
    let white = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    })
    .with(diffuse_bsdf::COLOR, 1.0);
    let elsewhere = portal([1.0; 3], Some([0.0, -70.0, 0.0]), [0.0, -1.0, 0.0]);
    let mut scene = sheet(mixed(0.3, elsewhere, white));
    scene.environment = constant_environment(1.0);
    let (mean, variance) = estimate(&scene, &small(8, 2), 0..24);
    let error = variance.sqrt();
    assert!(
        (mean - 1.0).abs() <= LARGEST_T * error + 1e-6,
        "{mean} ± {error}"
    );
    assert!(error < 0.01);
}

/// Shadow rays pass neither a portal nor beside it: rays find all the light there.
#[test]
fn light_comes_through_a_sheet_that_is_half_a_portal() {
    let lit = |sheet: Option<Material>| {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::new(0.0, 0.0, 2.0), 0.5)],
            ..Scene::default()
        };
        let wall = quad([-4.0, -4.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
        place(&mut scene, wall, diffuse([0.8; 3]), &[DAffine3::IDENTITY]);
        let lamp = quad([-3.0, -3.0, 4.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
        place(&mut scene, lamp, shining(2.0), &[DAffine3::IDENTITY]);
        if let Some(sheet) = sheet {
            let sheet_at = quad([-9.0, -9.0, 3.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
            place(&mut scene, sheet_at, sheet, &[DAffine3::IDENTITY]);
        }
        estimate(&scene, &small(32, 1), 0..24)
    };
    let clear = || Node::new(NodeKind::TransparentBsdf).with(transparent::COLOR, 1.0);
    let (open, a) = lit(None);
    for share in [0.0, 0.5, 1.0] {
        let through = portal([1.0; 3], None, [0.0; 3]);
        let (mean, b) = lit(Some(mixed(share, through, clear())));
        let error = (a + b).sqrt();
        assert!(
            (mean - open).abs() < LARGEST_T * error,
            "{share}: {mean} {open} ± {error}"
        );
        assert!(error < 0.02 * open, "{error}");
    }
}
