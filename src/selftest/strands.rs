//! Strands of hair and points: what is far thinner than it is long, in Embree's own curves.

use super::kit::{self, Bench, differing, diffuse, rel_mse, small};
use super::still_life::Similarity;
use super::{Case, Effort, Finding};
use crate::math::float::gamma;
use crate::render::{LightSampling, RenderError, RenderSettings};
use crate::scene::{Mesh, Scene, StrandShape, Strands};
use glam::{DAffine3, DVec3, Vec3};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "strands-in-a-white-furnace",
        about: "White ribbons, tubes and points, from a tenth of a metre to a tenth of a millimetre thick, in a white furnace: they vanish.",
        run: in_a_white_furnace,
    },
    Case {
        name: "strands-scaled",
        about: "A tuft of strands from a thousandth to a thousand times its size, and turned: the same picture.",
        run: scaled,
    },
];

const SHAPES: [(&str, StrandShape); 4] = [
    ("ribbons", StrandShape::Ribbon(3)),
    ("tubes", StrandShape::Round),
    ("straight tubes", StrandShape::RoundLinear),
    ("points", StrandShape::Points),
];

/// A tuft of bent strands that grow thinner, or of the points of their keys, about the origin.
fn tuft(shape: StrandShape, radius: f32) -> Mesh {
    const STRANDS: u32 = 60;
    const KEYS: u32 = 5;
    let mut mesh = Mesh {
        name: "tuft".into(),
        ..Mesh::default()
    };
    let mut radii = Vec::new();
    for strand in 0..STRANDS {
        // Roots on a spiral, which is as good as any numbers.
        let turn = strand as f32 * 2.4;
        let out = Vec3::new(turn.cos(), 0.0, turn.sin()) * (strand as f32 / STRANDS as f32).sqrt();
        for key in 0..KEYS {
            let up = key as f32 / (KEYS - 1) as f32;
            let bend = Vec3::new((turn * 3.0).sin(), 0.0, (turn * 5.0).cos()) * (0.6 * up * up);
            let at = out * 0.8 + bend + Vec3::Y * (1.6 * up - 0.8);
            let number = mesh.positions.len() as u32;
            mesh.positions.push(at.to_array());
            radii.push(radius * (1.0 - 0.8 * up));
            if shape == StrandShape::Points {
                mesh.triangles.push(Strands::point(number));
            } else if key > 0 {
                mesh.triangles.push(Strands::segment(number - 1, number));
            }
        }
    }
    mesh.strands = Some(Strands {
        shape,
        radii,
        normals: Vec::new(),
    });
    mesh
}

fn scene_of(mesh: Mesh, color: [f32; 3]) -> Scene {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 4.0), 0.8)],
        environment: kit::constant_environment(1.0),
        ..Scene::default()
    };
    kit::place(&mut scene, mesh, diffuse(color), &[DAffine3::IDENTITY]);
    scene
}

/// So many bounces that no path ends: they leave a tuft after few, and tubes by their open ends.
const BOUNCES: u32 = 1000;

/// A white matte surface returns what falls on it. Each path has met the world once, after weights of six roundings each, some
/// ten of them on the way; the mean over samples is in f64.
fn in_a_white_furnace(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = RenderSettings {
        light_sampling: LightSampling::Bsdf,
        roulette: None,
        ..small(effort.of(2, 16, 256), BOUNCES)
    };
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for (name, shape) in SHAPES {
        for radius in [0.1, 1e-2, 1e-4] {
            let scene = scene_of(tuft(shape, radius), [1.0; 3]);
            let picture = bench.render(&scene, &settings)?.picture;
            let off = kit::colors(&picture).map(|c| (c[0] - 1.0).abs());
            findings.push(Finding::at_most(
                format!("|radiance − 1| of {name} of {radius} m"),
                f64::from(gamma(256)),
                off.fold(0.0, f64::max),
            ));
        }
    }
    Ok(bench.with(findings))
}

/// Embree's tubes know lengths of their own, so that paths which graze go other ways: some of N samples a pixel, each of which counts
/// 1/N. Of straight tubes a thousandth as large some hits are others, too. Measured with 4 and 64 samples: 1.1e-4 and 6e-6 of tubes,
/// 2.3e-3 and 8e-4 of straight ones; ribbons and points keep within 1e-5.
fn largest_rel_mse(shape: StrandShape, samples: u32) -> f64 {
    match shape {
        StrandShape::RoundLinear => 4e-3,
        _ => 1e-3 / f64::from(samples),
    }
}

fn scaled(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 64, 256), 6);
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    for (name, shape) in SHAPES {
        let scene = scene_of(tuft(shape, 0.02), [0.8, 0.5, 0.3]);
        let reference = bench.render(&scene, &settings)?.picture;
        for scale in [1e-3, 2f64.powi(-10), 1e3] {
            let by = Similarity {
                scale,
                ..Similarity::NONE
            };
            let picture = bench.render(&by.of(&scene), &settings)?.picture;
            findings.push(Finding::at_most(
                format!("relMSE of {name} scaled by {scale:.1e}"),
                largest_rel_mse(shape, settings.samples),
                rel_mse(&picture, &reference),
            ));
            let keeps_bits = matches!(shape, StrandShape::Ribbon(_) | StrandShape::Points);
            if keeps_bits && scale == 2f64.powi(-10) {
                let other = differing(&picture, &reference);
                findings.push(Finding::none(format!("other pixels of {name}"), other));
            }
        }
    }
    Ok(bench.with(findings))
}
