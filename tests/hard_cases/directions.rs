//! Directions along surfaces, and normals that do not belong to their triangles.

use super::kit::{self, Bench};
use super::materials::{TABLE_ERROR, albedo, left_to_base, lobes, seen_at};
use super::{Case, Effort, Finding};
use glam::{DAffine3, DVec2, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;
use sundog::render::{Filter, FilterKind, RenderError, RenderSettings};
use sundog::sampler::hashed;
use sundog::scene::{Image, ImageId, LightKind, Mesh, MetallicRoughness, NormalTexture, Scene};
use sundog::shading::{AllFeatures, Bsdf, Dielectrics, Principled};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "grazing-views",
        about: "White surfaces seen under cosines from 4.5e-4 (a sine of 1 - 1e-7) to 1e-30, and glass from 0.03 on, give back what falls on them; a layer leaves to its base what Cycles says.",
        run: grazing,
    },
    Case {
        name: "shadow-terminator",
        about: "A smooth sphere of 8 rings in the sun is shaded as one of 128: no black facets along the terminator.",
        run: terminator,
    },
    Case {
        name: "coarse-furnace",
        about: "A white smooth sphere of 6 rings, and the inside of a half one, under a white sky are white: no direction above their smooth normals is lost.",
        run: coarse_furnace,
    },
    Case {
        name: "normals-that-point-away",
        about: "A closed room whose vertex normals point anywhere: not a ray of light from outside gets in, nothing is not finite.",
        run: away,
    },
    Case {
        name: "strong-normal-maps",
        about: "Normal maps of noise, as strong as they can be and on the horizon: no energy from nowhere.",
        run: normal_maps,
    },
];

/// What is not white as a whole: the layer's reflection, and what it leaves to its base.
const LAYERED: &str = "coat over diffuse";

fn grazing(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(1 << 9, 1 << 13, 1 << 16);
    let mut wrong = 0;
    let mut findings = Vec::new();
    // For those between see "What does not hold yet".
    const NEARLY_NONE: [f32; 5] = [4.5e-4, 1e-5, 1e-7, 1e-15, 1e-30];
    // Where the albedo of rough glass bends.
    const SMALL: [f32; 5] = [0.03, 0.012, 6e-3, 2.5e-3, 1e-3];
    for (ior, cosines, glass_alone) in [
        (1.0f32 + 1e-6, NEARLY_NONE, false),
        (1.0 + 9e-5, NEARLY_NONE, false),
        (1.5, NEARLY_NONE, false),
        (1.03, SMALL, true),
        (1.1, SMALL, true),
        (1.33, SMALL, true),
        (1.5, SMALL, true),
    ] {
        let tables = Dielectrics::new(ior, true);
        let lobes = lobes(ior).into_iter();
        for (name, p, inside) in lobes.filter(|&(name, ..)| !glass_alone || name == "glass") {
            let mut worst = (0f64, String::new());
            for roughness in [0.0f32, 3.9e-3, 0.03, 0.3, 1.0] {
                for cos in cosines {
                    let (normals, wo) = seen_at(cos);
                    let reflected = |p: &Principled| {
                        let bsdf = Bsdf::<AllFeatures>::principled(p, &tables, normals, wo, inside);
                        albedo(&bsdf, samples)
                    };
                    let p = Principled { roughness, ..p };
                    let (mean, not_fine) = reflected(&p);
                    wrong += not_fine;
                    let (mut expected, mut noise) = (1.0, mean.deviation());
                    if name == LAYERED {
                        let black = Principled {
                            base_color: Vec3::ZERO,
                            ..p
                        };
                        let (black, _) = reflected(&black);
                        expected = black.mean() + left_to_base(&p, cos);
                        noise += black.deviation();
                    }
                    let off = ((mean.mean() - expected).abs() - 4.0 * noise).max(0.0);
                    if off >= worst.0 {
                        worst = (off, format!("roughness {roughness}, cosine {cos:e}"));
                    }
                }
            }
            findings.push(Finding::at_most(
                format!(
                    "{name} of index {ior}: albedo, from {}, 4 σ off (worst: {})",
                    if name == LAYERED {
                        "what is left to the base"
                    } else {
                        "1"
                    },
                    worst.1
                ),
                TABLE_ERROR,
                worst.0,
            ));
        }
    }
    findings.push(Finding::none(
        "samples that are negative or not finite",
        wrong,
    ));
    Ok(findings)
}

/// A square picture of a ball of radius 1 from 4 away.
fn settings(samples: u32, bounces: u32) -> RenderSettings {
    RenderSettings {
        width: 64,
        height: 64,
        filter: Filter {
            kind: FilterKind::Box,
            width: 1.0,
        },
        ..kit::small(samples, bounces)
    }
}

fn ball(rings: u32, material: MetallicRoughness) -> Scene {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::Z * 4.0, FIELD)],
        ..Scene::default()
    };
    // The poles' fans out of sight.
    let turned = DAffine3::from_rotation_z(FRAC_PI_2) * DAffine3::from_rotation_y(0.3);
    kit::place(
        &mut scene,
        kit::sphere(rings, 0.0, true),
        material,
        &[turned],
    );
    scene
}

/// Field of view of the ball's camera.
const FIELD: f64 = 0.6;

/// Pixels whose distance from the middle is at most this share of the ball's radius in the picture.
const INNER: f64 = 0.85;

/// Whether pixel `i` of the ball's picture is well inside of its outline.
fn is_inner(i: usize) -> bool {
    let at = |k: usize| (0.5 * FIELD).tan() * ((k as f64 + 0.5) / 32.0 - 1.0);
    let outline = 1.0 / 15f64.sqrt();
    DVec2::new(at(i % 64), at(i / 64)).length() < INNER * outline
}

/// The interpolated normal of a point on a facet of a unit sphere is the point itself, normalised: all that differs from the
/// true sphere is where the view meets the facet. Facets of 22.5° by 22.5° have their middle up to 1 − cos 16° = 0.038 below
/// the sphere, which the view crosses under up to asin 0.85 = 58°: the normal turns by 0.038·tan 58° = 0.061, and so much may
/// the cosine differ. A facet that is black up to where the sun touches the sphere would be wrong by sin 11° = 0.2 or more.
fn terminator(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = settings(effort.of(16, 64, 256), 0);
    let mut shaded = |rings| {
        let mut scene = ball(rings, kit::diffuse([1.0; 3]));
        scene.lights.push(kit::light(
            "sun",
            LightKind::Sun {
                irradiance: std::f32::consts::PI,
                angle: 0.0,
            },
            DAffine3::from_rotation_y(FRAC_PI_2 * 0.9),
        ));
        bench.render(&scene, &settings)
    };
    let (dense, coarse) = (shaded(128)?, shaded(8)?);
    let (mut worst, mut black) = (0f64, 0u64);
    let (mut light, mut true_light) = (0.0, 0.0);
    let pixels = kit::colors(&dense.picture).zip(kit::colors(&coarse.picture));
    for (_, (d, c)) in pixels.enumerate().filter(|(i, _)| is_inner(*i)) {
        worst = worst.max((d[0] - c[0]).abs());
        black += u64::from(d[0] > 0.1 && c[0] < 0.5 * d[0]);
        light += c[0];
        true_light += d[0];
    }
    Ok(bench.with(vec![
        Finding::at_most("largest difference of cosines", 0.061, worst),
        Finding::none("pixels less than half as bright", black),
        Finding::new("light of all of it", 1.0, light / true_light, 0.061),
    ]))
}

/// Half a smooth sphere of so many rings whose inside is turned to the camera.
fn bowl(rings: u32, material: MetallicRoughness) -> Scene {
    let mut scene = ball(rings, material);
    let mesh = &mut scene.meshes[0];
    let positions = &mesh.positions;
    // The ring at the middle is at half the roundings of a circle from 0.
    mesh.triangles
        .retain(|t| t.iter().all(|&i| positions[i as usize][1] < 1e-6));
    scene.instances[0].world_from_object = DAffine3::from_rotation_x(FRAC_PI_2);
    scene
}

/// White under a white sky is 1 in each sample that gets out within the bounces; a ray of a convex body is out at once but for
/// the edges of its facets; of the rays in the bowl half stay in it at each bounce, and what meets its own facet at most half
/// of the time anew.
fn coarse_furnace(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = settings(effort.of(16, 64, 1024), 64);
    let mut findings = Vec::new();
    for (shape, scene) in [
        ("ball", ball as fn(u32, MetallicRoughness) -> Scene),
        ("bowl", bowl),
    ] {
        for (name, material) in [
            ("diffuse", kit::diffuse([1.0; 3])),
            (
                "metal of roughness 0.3",
                MetallicRoughness {
                    roughness: 0.3,
                    ..MetallicRoughness::default()
                },
            ),
            ("metal of roughness 1", MetallicRoughness::default()),
        ] {
            let mut scene = scene(6, material);
            scene.environment = kit::constant_environment(1.0);
            let picture = bench.render(&scene, &settings)?.picture;
            let mut mean = kit::Mean::default();
            for (_, c) in kit::colors(&picture)
                .enumerate()
                .filter(|(i, _)| is_inner(*i))
            {
                mean.add(c[0]);
            }
            let off = (mean.mean() - 1.0).abs() - 4.0 * mean.deviation();
            findings.push(Finding::at_most(
                format!("{shape}, {name}: difference from 1, 4 σ off"),
                TABLE_ERROR,
                off.max(0.0),
            ));
        }
    }
    Ok(bench.with(findings))
}

/// Directions that have nothing to do with the mesh.
fn with_random_normals(mesh: Mesh) -> Mesh {
    let random = |i: u32| {
        let n = Vec3::new(hashed(21, i, 0), hashed(22, i, 0), hashed(23, i, 0)) * 2.0 - 1.0;
        n.normalize_or(Vec3::Y).to_array()
    };
    let normals = (0..mesh.positions.len() as u32).map(random).collect();
    Mesh {
        normals: Some(normals),
        ..mesh
    }
}

fn away(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = kit::small(effort.of(2, 16, 4096), 32);
    let mut findings = Vec::new();
    for (name, rings, material) in [
        ("diffuse", 12, kit::diffuse([1.0; 3])),
        ("diffuse, very coarse", 2, kit::diffuse([1.0; 3])),
        (
            "metal",
            12,
            MetallicRoughness {
                roughness: 0.3,
                ..MetallicRoughness::default()
            },
        ),
        (
            "mirror",
            12,
            MetallicRoughness {
                roughness: 0.0,
                ..MetallicRoughness::default()
            },
        ),
    ] {
        let mut scene = Scene {
            cameras: vec![kit::camera(DVec3::new(0.1, 0.2, 0.1), 1.5)],
            environment: kit::constant_environment(1.0),
            ..Scene::default()
        };
        let room = with_random_normals(kit::sphere(rings, 0.3, false));
        kit::place(&mut scene, room, material, &[DAffine3::IDENTITY]);
        let picture = bench.render(&scene, &settings)?.picture;
        let lit = kit::colors(&picture).filter(|c| *c != [0.0; 3]).count();
        findings.push(Finding::none(
            format!("{name}: pixels with light"),
            lit as u64,
        ));
    }
    Ok(bench.with(findings))
}

/// A normal map of noise; every fourth texel's normal lies on the horizon.
fn noise(size: u32) -> Image {
    let texel = |i: u32| {
        let mut t = [1, 2, 3].map(|k| (hashed(30 + k, i, 0) * 256.0) as u8);
        if i.is_multiple_of(4) {
            t[2] = 128;
        }
        t
    };
    Image {
        name: "noise".into(),
        width: size,
        height: size,
        channels: 3,
        pixels: (0..size * size).flat_map(texel).collect::<Vec<u8>>().into(),
    }
}

fn normal_maps(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = kit::small(effort.of(4, 32, 1024), 16);
    let mut findings = Vec::new();
    for scale in [1.0f32, 100.0, 1e30] {
        let mut gain = 0f64;
        for material in [
            kit::diffuse([1.0; 3]),
            MetallicRoughness {
                roughness: 0.0,
                ..MetallicRoughness::default()
            },
            MetallicRoughness {
                roughness: 0.3,
                ..MetallicRoughness::default()
            },
            MetallicRoughness {
                metallic: 0.0,
                roughness: 0.3,
                ..MetallicRoughness::default()
            },
            kit::glass(0.3, 1.5),
        ] {
            let mut scene = ball(
                24,
                MetallicRoughness {
                    normal_texture: Some(NormalTexture {
                        texture: ImageId(0).into(),
                        scale,
                    }),
                    ..material
                },
            );
            scene.images.push(noise(64));
            scene.environment = kit::constant_environment(1.0);
            let picture = bench.render(&scene, &settings)?.picture;
            let mut mean = kit::Mean::default();
            kit::colors(&picture).for_each(|c| mean.add(c[0]));
            gain = gain.max(mean.mean() - 1.0 - 4.0 * mean.deviation());
        }
        findings.push(Finding::at_most(
            format!("scale {scale:e}: largest gain of energy, 4 σ off"),
            TABLE_ERROR,
            gain,
        ));
    }
    Ok(bench.with(findings))
}
