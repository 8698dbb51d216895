//! Materials at the ends of their parameters: no energy from nowhere, none lost, nothing that is not finite.

use super::kit::{self, Bench, Mean};
use super::{Case, Effort, Finding};
use crate::math::float::gamma;
use crate::render::{Filter, FilterKind, LightSampling, RenderError, RenderSettings};
use crate::scene::{MetallicRoughness, Scene};
use glam::{DAffine3, DVec3};

/// The cases.
pub const CASES: &[Case] = &[Case {
    name: "white-room",
    about: "Closed rooms of albedo 1 that shine with radiance 1, 1000 bounces: radiance 1002.",
    run: white_room,
}];

/// Bounces of the closed rooms.
const BOUNCES: u32 = 1000;

/// Each bounce finds the wall's 1 again, from the one that the camera sees to that behind the last: 1002 terms. A diffuse
/// bounce's weight is value/density of six roundings, the sum of the terms rounds 1002 times: γ(3·1002 + 1002) of the whole.
///
/// Rough metal's weights differ from sample to sample, and the product of a thousand of them has its mean in its tail, where
/// no picture looks: 10 bounces. Tables are right to 1e-3 as a closed white body sees itself, weighted by the cosine.
fn white_room(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let metal = |roughness| MetallicRoughness {
        roughness,
        ..MetallicRoughness::default()
    };
    let mut findings = Vec::new();
    for (name, material, exact) in [
        ("diffuse", kit::diffuse([1.0; 3]), true),
        ("mirror", metal(0.0), true),
        ("metal of roughness 0.3", metal(0.3), false),
        ("metal of roughness 1", metal(1.0), false),
    ] {
        let bounces = if exact { BOUNCES } else { BOUNCES / 100 };
        let settings = RenderSettings {
            light_sampling: LightSampling::Bsdf,
            roulette: None,
            width: 16,
            height: 12,
            filter: Filter {
                kind: FilterKind::Box,
                width: 1.0,
            },
            ..kit::small(effort.of(1, 2, 64), bounces)
        };
        let mut scene = Scene {
            cameras: vec![kit::camera(DVec3::new(0.1, 0.2, 0.3), 1.0)],
            // Whatever gets out finds a lot.
            environment: kit::constant_environment(1e9),
            ..Scene::default()
        };
        let material = MetallicRoughness {
            emission: [1.0; 3],
            double_sided: true,
            ..material
        };
        kit::place(
            &mut scene,
            kit::sphere(12, 0.3, false),
            material,
            &[DAffine3::IDENTITY],
        );
        let rendering = bench.render(&scene, &settings)?;
        let mut mean = Mean::default();
        kit::colors(&rendering.picture).for_each(|c| mean.add(c[0]));
        let terms = bounces + 2;
        let whole = f64::from(terms);
        let bound = if exact {
            whole * f64::from(gamma(4 * terms))
        } else {
            // Each term has the error of all bounces before it.
            1e-3 * 0.5 * whole * whole + 4.0 * mean.deviation()
        };
        findings.push(Finding::new(name, whole, mean.mean(), bound));
    }
    Ok(bench.with(findings))
}
