//! Tests of mixtures: Principled BSDFs of all kinds.

use super::*;
use crate::math::sqr;
use crate::scene::graph::Distribution;
use crate::scene::{RayKind, Visibility};
use crate::shading::closure::{AllFeatures, Portal, Translucent};
use crate::shading::tables::{LutCoordinate, Reflection};
use crate::shading::{Dielectrics, Principled, fresnel};

/// All but glass.
#[derive(Clone, Copy, Debug)]
struct Opaque;

impl BsdfFeatures for Opaque {
    const FACETS: bool = true;
    const TRANSMISSION: bool = false;
    const SMOOTH: bool = true;
    const BUMPS: bool = true;
}
use crate::sampler::{Dimension, Sequence};
use rayon::prelude::*;

fn plain() -> Principled {
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

fn normals(n: Vec3) -> Normals {
    Normals {
        geometric: n,
        curved: n,
        smooth: n,
        shading: n,
    }
}

fn direction(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// Mean weight of `n` sampled directions: the albedo. Each `run` has its own points, of the kind
/// that paths draw.
fn albedo(bsdf: &Bsdf, n: u32, run: u32) -> f64 {
    let sequence = Sequence::new(run);
    let weight = |i| {
        bsdf.sample(sequence.sampler(0, 0, i).triple(Dimension::Bsdf, 0))
            .map_or(0.0, |x| f64::from(average(x.weight)))
    };
    (0..n).into_par_iter().map(weight).sum::<f64>() / f64::from(n)
}

fn white_cases(ior: f32) -> [(&'static str, Principled, bool); 9] {
    let base = Principled { ior, ..plain() };
    let glass = Principled {
        transmission: 1.0,
        ..base
    };
    [
        (
            "metal",
            Principled {
                metallic: 1.0,
                ..base
            },
            false,
        ),
        ("coat over diffuse", base, false),
        (
            "half metal",
            Principled {
                metallic: 0.5,
                ..base
            },
            false,
        ),
        ("glass", glass, false),
        ("glass from inside", glass, true),
        (
            "thin glass",
            Principled {
                thin_walled: true,
                ..glass
            },
            false,
        ),
        (
            "half glass",
            Principled {
                transmission: 0.5,
                ..base
            },
            false,
        ),
        (
            "half scattered through",
            Principled {
                subsurface: 0.5,
                subsurface_anisotropy: 1.0,
                subsurface_color: Vec3::ONE,
                ..base
            },
            false,
        ),
        (
            "half specular",
            Principled {
                specular_color: Vec3::splat(0.5 / 0.04),
                ..base
            },
            false,
        ),
    ]
}

/// Directions that know nothing of the lobes have the same means of everything that paths take from a sample:
/// weights (times a function of the direction), their diffuse part, and each lobe alone. 24 independent runs
/// each; of about 700 comparisons one beyond 5 σ would come about by chance once in 300 times. (Within 1e-5
/// where both sides are exact.)
#[test]
fn uniform_directions_have_the_same_means() {
    let quantities = |s: &BsdfSample| {
        let weight = average(s.weight);
        let alone = |kind| {
            if s.scattering == kind {
                average(s.alone.0)
            } else {
                0.0
            }
        };
        [
            weight * (1.0 + s.wi.x),
            weight * s.wi.z.abs(),
            average(s.diffuse),
            alone(Scattering::Diffuse),
            alone(Scattering::Glossy),
            alone(Scattering::Transmission),
        ]
        .map(f64::from)
    };
    let (runs, n) = (24, 1 << 12);
    let estimate = |draw: &(dyn Fn(Vec3) -> Option<BsdfSample> + Sync), first: u32| {
        let means: Vec<[f64; 6]> = (first..first + runs)
            .into_par_iter()
            .map(|run| {
                let sequence = Sequence::new(run);
                let mut sum = [0.0; 6];
                for i in 0..n {
                    let u = sequence.sampler(0, 0, i).triple(Dimension::Bsdf, 0);
                    let found = draw(u).as_ref().map_or([0.0; 6], quantities);
                    sum = std::array::from_fn(|k| sum[k] + found[k] / f64::from(n));
                }
                sum
            })
            .collect();
        let runs = f64::from(runs);
        std::array::from_fn::<_, 6, _>(|k| {
            let mean = means.iter().map(|m| m[k]).sum::<f64>() / runs;
            let square = means.iter().map(|m| sqr((m[k] - mean) as f32)).sum::<f32>();
            (mean, f64::from(square) / (runs * (runs - 1.0)))
        })
    };
    for ior in [1.0f32, 1.5] {
        let tables = Dielectrics::new(ior, true);
        for (name, p, inside) in white_cases(ior) {
            for roughness in [0.0f32, 0.4, 0.9] {
                for cos in [0.3, 0.9] {
                    let p = Principled { roughness, ..p };
                    let view = direction(cos);
                    let bsdf = Bsdf::<AllFeatures>::principled(
                        &p,
                        &tables,
                        normals(Vec3::Z),
                        view,
                        inside,
                    );
                    let ours = estimate(&|u| bsdf.sample_uniform(u), 0);
                    let usual = estimate(&|u| bsdf.sample(u), 1000);
                    for (k, (a, b)) in ours.iter().zip(&usual).enumerate() {
                        let bound = 5.0 * (a.1 + b.1).sqrt() + 1e-5;
                        assert!(
                            (a.0 - b.0).abs() < bound,
                            "{name} {ior}, roughness {roughness}, cos {cos}, {k}: {} {} {bound}",
                            a.0,
                            b.0
                        );
                    }
                }
            }
        }
    }
}

/// White furnace: a white surface of every lobe and roughness returns all light.
///
/// Weighted by the cosine, as a closed white body sees itself, within 1e-3. A single view within
/// 5e-3: tables are linear between 40 points, and from inside the albedo has a crest at the
/// critical angle, E'' ≈ 50, which leaves 50/8·(1/39)² = 4e-3; the rest is for the points. Where a layer covers a base,
/// Cycles' estimate of what it leaves is up to 6.8e-3 less, and 1.5e-3 in the mean (roughness 0.55, index 1.5).
#[test]
fn white_surfaces_return_all_light() {
    // Gauss and Legendre with 5 points for cosθ², which makes the weight uniform.
    let nodes = [
        0.046_910_08f64,
        0.230_765_34,
        0.5,
        0.769_234_66,
        0.953_089_92,
    ];
    let weights = [
        0.118_463_44f64,
        0.239_314_34,
        0.284_444_44,
        0.239_314_34,
        0.118_463_44,
    ];
    for ior in [1.1f32, 1.5, 2.4] {
        let tables = Dielectrics::new(ior, true);
        for (name, p, inside) in white_cases(ior) {
            let layered = p.transmission < 1.0 && p.metallic < 1.0;
            let (bound, bound_of_mean) = if layered {
                (1e-2, 2.5e-3)
            } else {
                (5e-3, 1e-3)
            };
            for roughness in [0.0f32, 0.02, 0.1, 0.3, 0.55, 0.8, 1.0] {
                let p = Principled { roughness, ..p };
                let mut mean = 0.0;
                for (run, (x, weight)) in (0..).zip(nodes.iter().zip(weights)) {
                    let cos = x.sqrt() as f32;
                    let bsdf = Bsdf::<AllFeatures>::principled(
                        &p,
                        &tables,
                        normals(Vec3::Z),
                        direction(cos),
                        inside,
                    );
                    let found = albedo(&bsdf, 1 << 16, run);
                    assert!(
                        (found - 1.0).abs() < bound,
                        "{name} {ior}, roughness {roughness}, cos {cos}: {found}"
                    );
                    mean += weight * found;
                }
                assert!(
                    (mean - 1.0).abs() < bound_of_mean,
                    "{name} {ior}, roughness {roughness}: {mean}"
                );
            }
        }
    }
}

/// Values and densities summed over all directions are the mean weight of samples and the
/// share of them that comes back.
#[test]
fn values_and_densities_integrate_to_what_samples_find() {
    let tables = Dielectrics::new(1.5, true);
    for (name, p, inside) in white_cases(1.5) {
        for (roughness, cos) in [(0.5f32, 0.5f32), (0.8, 0.2)] {
            let p = Principled {
                roughness,
                base_color: Vec3::new(0.9, 0.5, 0.2),
                ..p
            };
            let bsdf = Bsdf::<AllFeatures>::principled(
                &p,
                &tables,
                normals(Vec3::Z),
                direction(cos),
                inside,
            );
            let n = 1 << 14;
            let sequence = Sequence::new(2);
            let (mut weight, mut came_back) = (0f64, 0f64);
            for i in 0..n {
                let s = sequence.sampler(0, 0, i);
                if let Some(x) = bsdf.sample(s.triple(Dimension::Bsdf, 0)) {
                    weight += f64::from(average(x.weight)) / f64::from(n);
                    came_back += 1.0 / f64::from(n);
                    // The same direction looked up has the same value and density, but for the
                    // digits that its half vector loses.
                    let v = bsdf.evaluate(x.wi);
                    assert!((v.pdf / x.pdf - 1.0).abs() < 1e-3, "{name}: {v:?} {x:?}");
                    assert!(
                        (v.value - x.weight * x.pdf).abs().max_element()
                            <= 1e-3 * v.value.max_element(),
                        "{name}: {v:?} {x:?}"
                    );
                }
            }
            // Midpoints of equal areas of the sphere, half of it by symmetry.
            let (nz, np) = (2048, 128);
            let (mut value, mut density) = (0f64, 0f64);
            for i in 0..nz {
                let z = (2 * i + 1 - nz) as f32 / nz as f32;
                let s = (1.0 - z * z).sqrt();
                for j in 0..np {
                    let (sin, cos) =
                        (std::f32::consts::PI * (j as f32 + 0.5) / np as f32).sin_cos();
                    let v = bsdf.evaluate(Vec3::new(s * cos, s * sin, z));
                    value += f64::from(average(v.value));
                    density += f64::from(v.pdf);
                }
            }
            let area = 4.0 * std::f64::consts::PI / f64::from(nz * np);
            // Peaks that are some 0.1 wide (α ≥ 0.25), steps of 0.025: second order leaves 2e-3.
            let (value, density) = (value * area, density * area);
            assert!(
                (value - weight).abs() < 3e-3,
                "{name}, roughness {roughness}: {value} {weight}"
            );
            assert!(
                (density - came_back).abs() < 3e-3,
                "{name}, roughness {roughness}: {density} {came_back}"
            );
        }
    }
}

/// f(wo, wi)·cosθi·cosθo is the same both ways for single scattering at facets without
/// compensation; compensation scales by a function of the view alone.
#[test]
fn metal_is_reciprocal_but_for_its_compensation() {
    let p = Principled {
        metallic: 1.0,
        roughness: 0.6,
        base_color: Vec3::new(0.8, 0.5, 0.1),
        ..plain()
    };
    let tables = Dielectrics::new(1.5, false);
    let (a, b) = (direction(0.3), Vec3::new(-0.5, 0.4, 0.6).normalize());
    let both = [(a, b), (b, a)].map(|(wo, wi)| {
        let bsdf = Bsdf::<Opaque>::principled(&p, &tables, normals(Vec3::Z), wo, false);
        let place = LutCoordinate::new(wo.z, p.roughness);
        bsdf.evaluate(wi).value
            / Reflection::at(place).compensation(fresnel::schlick_average(p.base_color))
            * wo.z
    });
    assert!(
        (both[0] - both[1]).abs().max_element() < 1e-5 * both[0].max_element(),
        "{both:?}"
    );
}

/// Whatever a file may say: no NaN, no negative value, no energy from nowhere.
#[test]
fn extreme_parameters_stay_finite_and_keep_the_energy() {
    let iors = [0.0f32, 1.0, 1.0 + 1.2e-7, 1.001, 1.5, 1000.0, 1e30];
    let roughnesses = [0.0f32, 1e-8, 3.7e-3, 3.8e-3, 0.03, 0.4, 1.0];
    for ior in iors {
        for specular in [1.0f32, 0.0, 1e-6] {
            let tables = Dielectrics::new(ior, true);
            for (name, p, inside) in white_cases(ior) {
                for roughness in roughnesses {
                    for cos in [1.0f32, 0.7, 0.1, 1e-3, 1e-7, 1e-30, 0.0] {
                        let p = Principled {
                            roughness,
                            specular,
                            ..p
                        };
                        let bsdf = Bsdf::<AllFeatures>::principled(
                            &p,
                            &tables,
                            normals(Vec3::Z),
                            direction(cos),
                            inside,
                        );
                        let what = format!(
                            "{name}, ior {ior}, specular {specular}, roughness {roughness}, cos {cos}"
                        );
                        assert!(
                            bsdf.albedo().is_finite() && bsdf.albedo().min_element() >= 0.0,
                            "{what}"
                        );
                        for z in [1e-30f32, 1e-7, 0.2, 1.0, -1e-7, -0.5] {
                            let v = bsdf.evaluate(Vec3::new(-(1.0 - z * z).sqrt(), 0.0, z));
                            assert!(
                                v.value.is_finite() && v.value.min_element() >= 0.0,
                                "{what}, light {z}: {v:?}"
                            );
                            assert!(
                                v.pdf.is_finite() && v.pdf >= 0.0,
                                "{what}, light {z}: {v:?}"
                            );
                        }
                        let sequence = Sequence::new(9);
                        for i in 0..64 {
                            let s = sequence.sampler(0, 0, i);
                            let Some(x) = bsdf.sample(s.triple(Dimension::Bsdf, 0)) else {
                                continue;
                            };
                            assert!(
                                x.weight.is_finite() && x.weight.min_element() >= 0.0,
                                "{what}: {x:?}"
                            );
                            assert!(
                                x.pdf.is_finite() && (x.wi.length() - 1.0).abs() < 1e-5,
                                "{what}: {x:?}"
                            );
                        }
                        if (0.1..1.0).contains(&cos) && specular == 1.0 {
                            // As in the furnace above.
                            let found = albedo(&bsdf, 1 << 13, 0);
                            assert!(found <= 1.0 + 5e-3, "{what}: {found}");
                        }
                    }
                }
            }
        }
    }
}

/// A kernel that knows of no transmission gives the same bits.
#[test]
fn kernels_with_and_without_transmission_agree() {
    let tables = Dielectrics::new(1.45, false);
    let sequence = Sequence::new(4);
    for i in 0..256 {
        let s = sequence.sampler(3, 1, i);
        let (u, v) = (s.pair(Dimension::Lens, 0), s.triple(Dimension::Bsdf, 0));
        let p = Principled {
            metallic: u.x,
            roughness: v.y,
            ior: 1.45,
            specular: 0.7,
            base_color: Vec3::new(u.y, v.x, 0.3),
            ..plain()
        };
        let view = direction(1.0 - u.y);
        let special = Bsdf::<Opaque>::principled(&p, &tables, normals(Vec3::Z), view, false);
        let general = Bsdf::<AllFeatures>::principled(&p, &tables, normals(Vec3::Z), view, false);
        assert_eq!(found(&special, v), found(&general, v));
    }
}

fn found<K: BsdfFeatures>(bsdf: &Bsdf<K>, u: Vec3) -> (Option<(Vec3, Vec3, f32)>, Vec3, f32) {
    let (x, e) = (bsdf.sample(u), bsdf.evaluate(direction(u.x)));
    (x.map(|x| (x.wi, x.weight, x.pdf)), e.value, e.pdf)
}

#[test]
fn kernels_with_and_without_facets_agree_on_matte_surfaces() {
    struct Matte;
    impl BsdfFeatures for Matte {
        const FACETS: bool = false;
        const TRANSMISSION: bool = false;
        const SMOOTH: bool = true;
        const BUMPS: bool = true;
    }
    let sequence = Sequence::new(5);
    for (specular, ior) in [(0.0, 1.45), (0.0, 1.0), (1.0, 1.0), (0.5, 1.0)] {
        let tables = Dielectrics::new(ior, false);
        for i in 0..256 {
            let s = sequence.sampler(3, 1, i);
            let (u, v) = (s.pair(Dimension::Lens, 0), s.triple(Dimension::Bsdf, 0));
            let p = Principled {
                metallic: 0.0,
                roughness: v.y,
                ior,
                specular,
                base_color: Vec3::new(u.y, v.x, 0.3),
                ..plain()
            };
            let tilted = |x: f32, y: f32| Vec3::new(x - 0.5, y - 0.5, 1.0).normalize();
            let normals = Normals {
                geometric: Vec3::Z,
                curved: tilted(v.x, u.x),
                smooth: tilted(v.x, u.x),
                shading: if i % 2 == 0 {
                    tilted(v.x, u.x)
                } else {
                    tilted(v.y, u.y)
                },
            };
            let view = direction(1.0 - u.y);
            let special = Bsdf::<Matte>::principled(&p, &tables, normals, view, false);
            let general = Bsdf::<AllFeatures>::principled(&p, &tables, normals, view, false);
            assert_eq!(found(&special, v), found(&general, v));
            assert_eq!(special.receiving_normal(), general.receiving_normal());
            assert_eq!(special.albedo(), general.albedo());
        }
    }
}

/// What is below the triangle is seen if the curved surface sees it; what a displacement that is a bump sees alone, lights that are
/// sampled find.
#[test]
fn a_bump_of_the_surface_sees_below_it_where_lights_are_sampled() {
    let leaning = Vec3::new(0.8, 0.0, 0.6);
    let below = Vec3::new(0.995, 0.0, -0.1).normalize();
    let away = Vec3::new(-0.995, 0.0, -0.1).normalize();
    let lit = |curved: Vec3, wi: Vec3| {
        let normals = Normals {
            curved,
            ..normals(leaning)
        };
        let normals = Normals {
            geometric: Vec3::Z,
            ..normals
        };
        let mut bsdf: Bsdf = Bsdf::new(normals, direction(0.7), false, Changes::NONE);
        let (color, normal) = (Vec3::ONE, leaning);
        bsdf.add(Lobe::Diffuse(Diffuse { color, normal }), color);
        bsdf.finish();
        [bsdf.evaluate(wi), bsdf.evaluate_sampled(wi)].map(|of| of.value != Vec3::ZERO)
    };
    assert_eq!(lit(Vec3::Z, Vec3::Z), [true, true]);
    assert_eq!(lit(Vec3::Z, below), [false, true]);
    assert_eq!(lit(leaning, below), [true, true]);
    assert_eq!(lit(Vec3::Z, away), [false, false]);
    assert_eq!(lit(-leaning, below), [false, false]);
}

#[test]
fn of_too_many_lobes_the_weakest_are_left_out_and_counted() {
    let n = normals(Vec3::Z);
    let mut bsdf: Bsdf = Bsdf::new(n, direction(0.7), false, Changes::NONE);
    let colors = (1..=MOST_LOBES + 3).map(|i| Vec3::splat(i as f32 / 100.0));
    for color in colors {
        let normal = n.shading;
        bsdf.add(Lobe::Diffuse(Diffuse { color, normal }), color);
    }
    bsdf.finish();
    assert_eq!(bsdf.left_out(), 3);
    let mut kept: Vec<f32> = bsdf.lobes().map(|(_, albedo)| albedo.x * 100.0).collect();
    kept.sort_by(f32::total_cmp);
    let expected: Vec<f32> = (4..=MOST_LOBES + 3).map(|i| i as f32).collect();
    for (kept, expected) in kept.iter().zip(&expected) {
        assert!((kept - expected).abs() < 1e-4, "{kept} {expected}");
    }
    assert_eq!(kept.len(), MOST_LOBES);
}

/// A portal takes its share of the choices with the weight that makes their mean its colour, and has no direction.
#[test]
fn a_portal_is_chosen_by_its_share_and_has_no_direction() {
    const CHOICES: u32 = 1000;
    let portal = Portal {
        weight: Vec3::new(0.2, 0.1, 0.3),
        position: None,
        direction: Vec3::ZERO,
        normal: Vec3::Z,
    };
    let mut bsdf: Bsdf = Bsdf::new(normals(Vec3::Z), direction(0.8), false, Changes::NONE);
    bsdf.add_lambert(Vec3::splat(0.3), Vec3::Z);
    bsdf.add(Lobe::Portal(portal), portal.weight);
    bsdf.finish();
    assert!(bsdf.is_samplable());
    for uniform in [false, true] {
        let (mut sum, mut most) = (Vec3::ZERO, 0f32);
        for i in 0..CHOICES {
            let choice = (i as f32 + 0.5) / CHOICES as f32;
            if let Some(Elsewhere::Portal(portal)) = bsdf.elsewhere(choice, uniform) {
                sum += portal.weight;
                most = most.max(portal.weight.max_element());
            }
            let numbers = Vec3::new(0.3, 0.4, choice);
            let is_elsewhere = bsdf.elsewhere(choice, false).is_some();
            assert_eq!(bsdf.sample(numbers).is_none(), is_elsewhere, "{choice}");
        }
        // One choice more or less at the border.
        let mean = sum / CHOICES as f32;
        let error = (mean - portal.weight).abs().max_element();
        assert!(error <= most / CHOICES as f32, "{mean} {uniform}");
    }
}

/// Lobes that see a light have together what all have where all see it, and those that do not have nothing.
#[test]
fn lights_that_some_rays_do_not_see_leave_lobes_out() {
    let mut bsdf: Bsdf = Bsdf::new(normals(Vec3::Z), direction(0.8), false, Changes::NONE);
    bsdf.add_lambert(Vec3::splat(0.3), Vec3::Z);
    bsdf.add_glossy(
        0.3,
        Vec3::ONE,
        (0.5, 0.0),
        (Vec3::Z, None),
        Distribution::Ggx,
    );
    let (color, normal) = (Vec3::splat(0.2), Vec3::Z);
    bsdf.add(Lobe::Translucent(Translucent { color, normal }), color);
    bsdf.finish();
    let [diffuse, glossy, through] = [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission]
        .map(|kind| Visibility::ALL.without(kind));
    for wi in [direction(0.6), direction(-0.7)] {
        let all = bsdf.evaluate_sampled(wi);
        let seen = |light| bsdf.seen_by_light(light, wi, true);
        let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= 4.0 * f32::EPSILON;
        assert!(near(seen(Visibility::ALL).0, all.value));
        assert!(near(seen(through).0, all.value));
        // Diffuse and what goes through diffusely; or facets.
        assert!(near(seen(diffuse).0 + seen(glossy).0, all.value));
        assert_eq!(seen(diffuse).1, Vec3::ZERO);
        assert_eq!(seen(diffuse).0 == Vec3::ZERO, wi.z < 0.0);
    }
}
