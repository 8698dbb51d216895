//! Surfaces that paths pass by chance.

use super::portals::material;
use super::{all_passes, colors, layer, run, small};
use glam::{DAffine3, DVec3};
use sundog::scene::graph::node::{diffuse as diffuse_bsdf, mix_shader, principled, transparent};
use sundog::scene::graph::{Graph, Node, NodeKind};
use sundog::scene::{LightKind, Scene};
use sundog::selftest::kit::{camera, light, place, quad};

const WHITE: [f32; 3] = [1.0; 3];
const COLOR: [f32; 3] = [0.6, 0.7, 0.8];

fn matte() -> Node {
    let matte = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    });
    matte.with(diffuse_bsdf::COLOR, COLOR)
}

/// Rough glass that spreads colours.
fn prism() -> Node {
    let glass = Node::new(NodeKind::PrincipledBsdf {
        thin_wall: false,
        pane: false,
        edge_tint: true,
        once: false,
        walk: None,
        rules: Default::default(),
    });
    let glass = glass.with(principled::TRANSMISSION_WEIGHT, 1.0);
    let glass = glass.with(principled::ROUGHNESS, 0.7);
    glass.with(principled::DISPERSION, 5.0)
}

/// A sheet below a point lamp, of which so much is there; the rest lets light of a color pass.
fn sheet(share: f32, there: Node, passes: [f32; 3]) -> Scene {
    let mut graph = Graph::default();
    let clear = graph.add(Node::new(NodeKind::TransparentBsdf).with(transparent::COLOR, passes));
    let there = graph.add(there);
    let mix = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, share);
    let mix = mix.with(mix_shader::A, clear).with(mix_shader::B, there);
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

/// Paths that pass the sheet bring its light as well as those that stop: a part of it has no noise that the whole has not. Light of
/// what spreads colors is of one wavelength for both.
#[test]
fn light_samples_do_not_hang_on_whether_a_path_passes() {
    let settings = small(4, 0);
    for there in [matte, prism] {
        let whole = colors(&run(&sheet(1.0, there(), WHITE), &settings));
        assert!(whole[0][0] > 0.001, "{:?}", whole[0]);
        for share in [0.25, 0.5, 0.875] {
            let part = colors(&run(&sheet(share, there(), WHITE), &settings));
            for (part, whole) in part.iter().flatten().zip(whole.iter().flatten()) {
                let expected = f64::from(share) * whole;
                // Rounding of a sum of products, some of which are below 0 where a wavelength is out of the screen's colors.
                assert!((part - expected).abs() < 1e-5, "{part} {expected}");
            }
        }
    }
}

/// Where all samples of a pixel have passed the sheet, too, its light has a color.
#[test]
fn passes_of_what_is_passed_recombine_to_the_picture() {
    for (there, kind) in [(matte(), "Diff"), (prism(), "Gloss")] {
        let rendering = run(&sheet(0.05, there, WHITE), &all_passes(4));
        let combined = layer(&rendering, "Combined").chunks_exact(4);
        let of = |what: &str| layer(&rendering, &format!("{kind}{what}")).chunks_exact(3);
        let (light, color) = (of("Dir"), of("Col"));
        for ((whole, light), color) in combined.zip(light).zip(color) {
            for ((whole, light), color) in whole.iter().zip(light).zip(color) {
                assert!(
                    (light * color - whole).abs() <= 1e-5 * whole.abs(),
                    "{light} {color} {whole}"
                );
            }
        }
    }
}

/// Ambient occlusion of a sheet before nothing is how much of it is there.
#[test]
fn occlusion_counts_by_what_is_there() {
    let rendering = run(&sheet(0.5, matte(), WHITE), &all_passes(16));
    let open = layer(&rendering, "AO");
    let mean = open.iter().sum::<f32>() / open.len() as f32;
    // Five standard deviations of a coin's mean.
    let bound = 5.0 * 0.5 / (16.0 * open.len() as f32 / 3.0).sqrt();
    assert!((mean - 0.5).abs() < bound, "{mean}");
}

/// Where light of a color passes, what is there is the rest of each channel, whatever scatters there: also of black, which scatters
/// nothing and lets nothing pass.
#[test]
fn occlusion_is_the_rest_of_what_passes() {
    for (share, passes) in [
        (0.4, [0.9, 0.5, 0.25]),
        (0.0, [0.5, 0.3, 0.0]),
        (0.5, [0.0; 3]),
    ] {
        let rendering = run(&sheet(share, matte(), passes), &all_passes(4));
        for open in layer(&rendering, "AO").chunks_exact(3) {
            for (open, passes) in open.iter().zip(passes) {
                let there = 1.0 - (1.0 - share) * passes;
                // Paths that pass bring as much as those that stop.
                assert!((open - there).abs() < 1e-5, "{open} {there}");
            }
        }
        let combined = layer(&rendering, "Combined");
        assert!(
            combined
                .iter()
                .skip(3)
                .step_by(4)
                .all(|&alpha| alpha == 1.0)
        );
    }
}

/// A holdout among other shaders takes nothing of their light, and its share of the picture.
#[test]
fn a_holdout_empties_its_share() {
    for passes in [[0.0; 3], [0.5; 3]] {
        for share in [0.25, 0.75] {
            let mut scene = sheet(share, matte(), passes);
            let whole = run(&scene, &all_passes(16));
            let graph = &mut scene.materials[0].graph;
            let held = graph.add(Node::new(NodeKind::Holdout));
            let below = Node::new(NodeKind::MixShader).with(mix_shader::FACTOR, 0.5);
            let below = below
                .with(mix_shader::A, held)
                .with(mix_shader::B, graph.surface.expect("one"));
            graph.surface = Some(graph.add(below));
            let half = run(&scene, &all_passes(16));
            for (half, whole) in colors(&half)
                .iter()
                .flatten()
                .zip(colors(&whole).iter().flatten())
            {
                assert!(
                    (2.0 * half - whole).abs() < 0.02 * whole + 1e-5,
                    "{half} {whole}"
                );
            }
            let alpha = |rendering| {
                let combined: Vec<_> = layer(rendering, "Combined")
                    .chunks_exact(4)
                    .map(|c| c[3])
                    .collect();
                (
                    combined.iter().sum::<f32>() / combined.len() as f32,
                    combined.len(),
                )
            };
            let (alpha, pixels) = alpha(&half);
            // What passes meets the world, which is there. Five standard deviations of a coin's mean.
            let bound = 5.0 * 0.5 / (16.0 * pixels as f32).sqrt();
            assert!((alpha - 0.5).abs() < bound, "{alpha}");
        }
    }
}

/// A tinted sheet tints the colors of what lies behind it, and not the light that falls there: as in Cycles.
#[test]
fn what_is_behind_a_tinted_sheet_has_its_color() {
    const TINT: [f32; 3] = [0.9, 0.5, 0.25];
    let bare = {
        let mut scene = sheet(0.0, matte(), TINT);
        scene.lights[0].world_from_light = DAffine3::from_translation(DVec3::new(0.1, 0.2, -0.5));
        let mut graph = Graph::default();
        let surface = graph.add(matte());
        let floor = quad([-4.0, -4.0, -1.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
        place(
            &mut scene,
            floor,
            material(graph, surface),
            &[DAffine3::IDENTITY],
        );
        scene
    };
    let mut open = bare.clone();
    open.instances.remove(0);
    let (tinted, open) = (run(&bare, &all_passes(4)), run(&open, &all_passes(4)));
    let color = layer(&tinted, "DiffCol");
    for (found, (tint, color)) in color.iter().zip(TINT.iter().zip(COLOR).cycle()) {
        assert!((found - tint * color).abs() < 1e-6, "{found}");
    }
    let pairs = layer(&tinted, "DiffDir")
        .iter()
        .zip(layer(&open, "DiffDir"));
    for (tinted, open) in pairs {
        assert!((tinted - open).abs() < 1e-5 * open, "{tinted} {open}");
    }
}
