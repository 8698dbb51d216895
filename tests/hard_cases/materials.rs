//! Materials at the ends of their parameters.

use super::kit::{self, Bench, Mean};
use super::{Case, Effort, Finding};
use glam::{DAffine3, DVec3, Vec3};
use sundog::math::float::gamma;
use sundog::render::{Filter, FilterKind, RenderError, RenderSettings};
use sundog::sampler::{Dimension, Sequence};
use sundog::scene::{AlphaMode, LightKind, MetallicRoughness, Scene};
use sundog::shading::tables::{LutCoordinate, Reflection, layer_albedo};
use sundog::shading::{AllFeatures, Bsdf, Dielectrics, Normals, Principled, fresnel};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "white-surfaces",
        about: "White metal, coat over diffuse, glass from both sides and thin glass, roughness 0, 1e-8 to 1, index 1, 1 + 1e-7 to 1000 and infinite: all light comes back, no more.",
        run: white_surfaces,
    },
    Case {
        name: "sharp-reflections",
        about: "A mirror of roughness 0 and ones that are nearly so show a lamp alike: nothing happens where the facets become a mirror.",
        run: sharp_reflections,
    },
    Case {
        name: "indices-of-refraction",
        about: "Glass of index 1, 1 + 1e-7 to 1000 and infinite, clear and rough, in a uniform light: as bright as the light.",
        run: indices,
    },
    Case {
        name: "alpha-layers",
        about: "200 layers of opacity 0, 1e-7 to 0.05 let through (1 - alpha)^200, for rays and for shadows.",
        run: alpha_layers,
    },
];

/// A white dielectric.
fn white() -> Principled {
    Principled {
        base_color: Vec3::ONE,
        metallic: 0.0,
        roughness: 0.5,
        ior: 1.5,
        specular: 1.0,
        specular_color: Vec3::ONE,
        transmission: 0.0,
        thin_walled: false,
        ..Principled::default()
    }
}

/// Lobes by name, and whether they are seen from inside.
pub(super) fn lobes(ior: f32) -> [(&'static str, Principled, bool); 5] {
    let base = Principled { ior, ..white() };
    let metal = Principled {
        metallic: 1.0,
        ..base
    };
    let glass = Principled {
        transmission: 1.0,
        ..base
    };
    let thin = Principled {
        thin_walled: true,
        ..glass
    };
    [
        ("metal", metal, false),
        ("coat over diffuse", base, false),
        ("glass", glass, false),
        ("glass from inside", glass, true),
        ("thin glass", thin, false),
    ]
}

/// What the layer of a white dielectric leaves to its base, which is Cycles' estimate and not what it does not reflect: of an index
/// near 1 the estimate knows nothing of the reflection at grazing views.
pub(super) fn left_to_base(p: &Principled, cos: f32) -> f64 {
    let f0 = fresnel::f0_from_ior(p.ior);
    let average = f0 + (1.0 - f0) * fresnel::average_blend(p.ior, f0);
    let all = (p.roughness > 0.0).then(|| Reflection::at(LutCoordinate::new(cos, p.roughness)));
    let reflectances = [f0, average].map(Vec3::splat);
    1.0 - f64::from(
        layer_albedo(
            (cos, p.roughness),
            (p.ior, p.rules),
            reflectances,
            all.as_ref(),
        )
        .x,
    )
}

/// A view at a cosine over a plane.
pub(super) fn seen_at(cos: f32) -> (Normals, Vec3) {
    let normals = Normals {
        geometric: Vec3::Z,
        curved: Vec3::Z,
        smooth: Vec3::Z,
        shading: Vec3::Z,
    };
    (
        normals,
        Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos),
    )
}

/// Mean weight of a surface's samples, and how many are not finite or negative.
pub(super) fn albedo(bsdf: &Bsdf, samples: u32) -> (Mean, u64) {
    let sequence = Sequence::new(5);
    let (mut mean, mut wrong) = (Mean::default(), 0);
    for i in 0..samples {
        let u = sequence.sampler(0, 0, i).triple(Dimension::Bsdf, 0);
        let sample = bsdf.sample(u);
        let fine = |w: Vec3| w.is_finite() && w.min_element() >= 0.0;
        wrong += u64::from(
            sample.is_some_and(|s| !(fine(s.weight) && s.pdf >= 0.0 && s.pdf.is_finite())),
        );
        mean.add(sample.map_or(0.0, |s| f64::from(s.weight.element_sum()) / 3.0));
    }
    (mean, wrong)
}

/// How far a single view's albedo may be from 1: the tables of compensation are linear between 40 points, and from inside the
/// albedo has a crest at the critical angle with E'' about 50, 50/8·(1/39)² = 4e-3; the rest is the points' own.
pub(super) const TABLE_ERROR: f64 = 5e-3;

fn white_surfaces(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples = effort.of(1 << 9, 1 << 12, 1 << 16);
    let (mut gain, mut loss, mut wrong) = (0f64, 0f64, 0);
    // 0 stands for an index that is infinite.
    for ior in [1.0f32, 1.0 + 1.2e-7, 1.0 + 1e-4, 1.5, 1000.0, 0.0] {
        let tables = Dielectrics::new(ior, true);
        for (_, p, inside) in lobes(ior) {
            for roughness in [0.0f32, 1e-8, 3.7e-3, 3.9e-3, 0.03, 0.3, 1.0] {
                for cos in [1.0f32, 0.7, 0.2] {
                    let (normals, wo) = seen_at(cos);
                    let p = Principled { roughness, ..p };
                    let bsdf = Bsdf::<AllFeatures>::principled(&p, &tables, normals, wo, inside);
                    let (mean, not_fine) = albedo(&bsdf, samples);
                    // What is told beyond the noise of the samples.
                    let noise = 4.0 * mean.deviation();
                    gain = gain.max(mean.mean() - 1.0 - noise);
                    loss = loss.max(1.0 - mean.mean() - noise);
                    wrong += not_fine;
                }
            }
        }
    }
    Ok(vec![
        Finding::at_most("largest gain of energy, 4 σ off", TABLE_ERROR, gain),
        Finding::at_most("largest loss of energy, 4 σ off", TABLE_ERROR, loss),
        Finding::none("samples that are negative or not finite", wrong),
    ])
}

/// A white mirror before the camera shows the wall of radiance 1 behind it, whatever it does to directions.
fn sharp_reflections(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = RenderSettings {
        filter: Filter {
            kind: FilterKind::Box,
            width: 1.0,
        },
        ..kit::small(effort.of(8, 64, 512), 1)
    };
    let mut findings = Vec::new();
    for alpha in [0.0f32, 1e-16, 1.4e-5, 1.43e-5, 1e-4, 1e-3, 1e-2] {
        let mut scene = Scene {
            cameras: vec![kit::camera(DVec3::ZERO, 0.6)],
            ..Scene::default()
        };
        let mirror = kit::quad([-5.0, -5.0, -2.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
        let metal = MetallicRoughness {
            roughness: alpha.sqrt(),
            ..MetallicRoughness::default()
        };
        kit::place(&mut scene, mirror, metal, &[DAffine3::IDENTITY]);
        let wall = kit::quad([-9.0, -9.0, 1.0], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0]);
        let shining = MetallicRoughness {
            emission: [1.0; 3],
            unlit: false,
            ..kit::diffuse([0.0; 3])
        };
        kit::place(&mut scene, wall, shining, &[DAffine3::IDENTITY]);
        let rendering = bench.render(&scene, &settings)?;
        let mut mean = Mean::default();
        kit::colors(&rendering.picture).for_each(|c| mean.add(c[0]));
        findings.push(Finding::at_most(
            format!("alpha {alpha:e}: difference from 1, 4 σ off"),
            TABLE_ERROR,
            ((mean.mean() - 1.0).abs() - 4.0 * mean.deviation()).max(0.0),
        ));
    }
    Ok(bench.with(findings))
}

/// Light that is the same from everywhere looks the same through anything that keeps all of it. What enters glass of a high
/// index stays for long: paths that are not out after the last bounce have lost at most what entered, 1 − ((n − 1)/(n + 1))².
fn indices(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = kit::small(effort.of(4, 16, 256), 512);
    let mut findings = Vec::new();
    for ior in [
        1.0f32,
        1.0 + 1.2e-7,
        1.0 + 1e-5,
        1.0 + 2e-4,
        1.5,
        1000.0,
        0.0,
    ] {
        for roughness in [0.0f32, 0.3] {
            let mut scene = Scene {
                cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 4.0), 0.6)],
                environment: kit::constant_environment(1.0),
                ..Scene::default()
            };
            let glass = MetallicRoughness {
                ior,
                roughness,
                transmission: 1.0,
                thin_walled: false,
                ..kit::diffuse([1.0; 3])
            };
            let glass = MetallicRoughness {
                specular: 1.0,
                ..glass
            };
            kit::place(
                &mut scene,
                kit::sphere(24, 0.0, false),
                glass,
                &[DAffine3::IDENTITY],
            );
            let found = kit::mean(&bench.render(&scene, &settings)?.picture);
            let n = f64::from(if ior == 0.0 { 1e4 } else { ior });
            let enters = 1.0 - ((n - 1.0) / (n + 1.0)).powi(2);
            let stays = if n > 10.0 { enters } else { 0.0 };
            findings.push(Finding::new(
                format!("index {ior}, roughness {roughness}: radiance"),
                1.0,
                found,
                TABLE_ERROR + stays,
            ));
        }
    }
    Ok(bench.with(findings))
}

const LAYERS: u32 = 200;

/// 200 black sheets under the camera's eye, or over a floor in the sun.
fn layers(alpha: f32, along: DVec3, shining: bool) -> Scene {
    let mut scene = Scene {
        cameras: vec![kit::camera(DVec3::new(0.0, 0.0, 1.0), 0.6)],
        ..Scene::default()
    };
    let sheet = kit::quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    let black = MetallicRoughness {
        alpha,
        alpha_mode: AlphaMode::Blend,
        ..kit::diffuse([0.0; 3])
    };
    let places: Vec<DAffine3> = (0..LAYERS)
        .map(|i| DAffine3::from_translation(along * (1.0 + 0.01 * f64::from(i))))
        .collect();
    kit::place(&mut scene, sheet.clone(), black, &places);
    let wall = MetallicRoughness {
        emission: [if shining { 1.0 } else { 0.0 }; 3],
        ..kit::diffuse([0.5; 3])
    };
    let behind = DAffine3::from_translation(DVec3::NEG_Z * 5.0);
    kit::place(&mut scene, sheet, wall, &[behind]);
    scene
}

/// Fewer samples than this, which are met or missed, are counted by Poisson's distribution: a normal one is too narrow for them.
const FEW: f64 = 10.0;

/// The count that a Poisson variable of this mean exceeds as seldom as a normal one exceeds 4 σ.
fn seldom_exceeded(mean: f64) -> f64 {
    let (mut count, mut term) = (0.0, (-mean).exp());
    let mut not_above = term;
    while 1.0 - not_above > 3.2e-5 {
        count += 1.0;
        term *= mean / count;
        not_above += term;
    }
    count
}

/// Seen through, a layer is met or not: random numbers of 24 bits can miss its opacity by 2^-24, 200 times. In shadows the
/// share is a product: two roundings a layer.
fn alpha_layers(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = RenderSettings {
        filter: Filter {
            kind: FilterKind::Box,
            width: 1.0,
        },
        ..kit::small(effort.of(2, 4, 256), 0)
    };
    let sun = kit::light(
        "sun",
        LightKind::Sun {
            irradiance: 1.0,
            angle: 0.0,
        },
        DAffine3::IDENTITY,
    );
    let mut findings = Vec::new();
    let mut unshaded = None;
    for alpha in [0.0f32, 1e-7, 1e-5, 1e-3, 0.05] {
        let exact = (1.0 - f64::from(alpha)).powi(LAYERS as i32);
        let seen = kit::mean(
            &bench
                .render(&layers(alpha, DVec3::NEG_Z, true), &settings)?
                .picture,
        );
        let samples = f64::from(settings.width * settings.height * settings.samples);
        let noise = (exact * (1.0 - exact) / samples).sqrt();
        let rare = exact.min(1.0 - exact) * samples;
        let bound = if rare < FEW {
            (seldom_exceeded(rare) - rare) / samples
        } else {
            4.0 * noise
        };
        findings.push(Finding::new(
            format!("opacity {alpha:e}: seen through"),
            exact,
            seen,
            bound + f64::from(LAYERS) * 2f64.powi(-24),
        ));
        // Behind the camera, between the sun and the wall.
        let mut shaded = layers(alpha, DVec3::Z * 2.0, false);
        shaded.lights.push(sun.clone());
        let lit = kit::mean(&bench.render(&shaded, &settings)?.picture);
        let full = *unshaded.get_or_insert(lit);
        findings.push(Finding::new(
            format!("opacity {alpha:e}: shone through"),
            exact,
            lit / full,
            f64::from(gamma(2 * LAYERS + 8)),
        ));
    }
    Ok(bench.with(findings))
}
