//! What has to hold for any scene.

use super::build;
use serde_json::Value;
use sundog::effects::{Effect, EffectReport};
use sundog::film::Picture;
use sundog::render::{EffectChoice, RenderSettings, Rendering, Silent, render};
use sundog::scene::validate::clean;
use sundog::scene::{Diagnostics, Light, RayKind, Scene};
use sundog::selftest::kit::{colors, differing};

/// Renders the scene of a recipe by the kernel made for it and by the general one, by one thread and by two; says what
/// is wrong.
pub fn scene(recipe: &Value) -> Option<String> {
    let mut scene = build::scene(recipe);
    clean(&mut scene, &mut Diagnostics::default());
    if scene.cameras.is_empty() {
        return None;
    }
    let settings = build::settings(recipe);
    let furnace = recipe["furnace"].as_bool() == Some(true);
    judge(&scene, &settings, furnace).err()
}

fn judge(scene: &Scene, settings: &RenderSettings, furnace: bool) -> Result<(), String> {
    let with = |effects: EffectChoice, threads: usize| {
        let settings = RenderSettings {
            effects,
            threads: Some(threads),
            ..settings.clone()
        };
        render(scene, &settings, &Silent).map_err(|error| format!("no picture: {error}"))
    };
    let special = with(EffectChoice::Auto, 1)?;
    finite(scene, &special)?;
    same(&special, &with(EffectChoice::Auto, 2)?, "two threads")?;
    same(&special, &with(EffectChoice::All, 2)?, "the general kernel")?;
    // What casts no shadow is lit through itself, and may be brighter than all light.
    let mut instances = scene.instances.iter();
    let shadows = instances.all(|i| i.visibility.sees(RayKind::Shadow));
    if furnace && shadows && settings.clamp_direct == 0.0 {
        energy(scene, settings, &special.picture)?;
    }
    Ok(())
}

fn finite(scene: &Scene, rendering: &Rendering) -> Result<(), String> {
    let statistics = &rendering.statistics;
    if statistics.non_finite > 0 {
        return Err(format!(
            "samples that are not finite: {:?}, of {:?}",
            statistics.non_finite_causes,
            statistics.non_finite_examples.first()
        ));
    }
    // Pure colours lie outside of the primaries' triangle: a wavelength counts less than nothing for some of them. Lamps and
    // worlds may take light away, as in Blender.
    let called_for = EffectReport::detect(scene).called_for;
    let dark = |light: &Light| light.color.iter().any(|c| *c < 0.0);
    let world = scene.environment.as_ref();
    let below = called_for.contains(Effect::Dispersion)
        || scene.lights.iter().any(dark)
        || world.is_some_and(|world| world.radiance.iter().any(|c| *c < 0.0));
    let possible = |c: &f64| c.is_finite() && (*c >= 0.0 || below);
    let negative = colors(&rendering.picture)
        .flatten()
        .filter(|c| !possible(c));
    match negative.count() {
        0 => Ok(()),
        count => Err(format!("values that no light has: {count}")),
    }
}

fn same(a: &Rendering, b: &Rendering, by: &str) -> Result<(), String> {
    let pixels = differing(&a.picture, &b.picture);
    let values = |picture: &Picture| -> Vec<Vec<u32>> {
        let layers = picture.layers.iter();
        let bits = |data: &[f32]| data.iter().map(|v| v.to_bits()).collect();
        layers.map(|layer| bits(&layer.data)).collect()
    };
    if pixels > 0 {
        return Err(format!("other bits by {by} in pixels: {pixels}"));
    }
    if values(&a.picture) != values(&b.picture) {
        return Err(format!("other bits by {by} in other layers"));
    }
    Ok(())
}

/// Bounds of the energy that a scattering may give: what the albedo of a white surface is tested for, for any view
/// (`shading::bsdf`, `white_surfaces_return_all_light`).
const GAIN: f64 = 5e-3;
/// Samples a pixel that decide when a mean seems too high.
const DECIDING: u32 = 4096;

/// In light of 1 from everywhere nothing passive is brighter. Where the mean of a picture is above that by more than
/// what scatterings may give, and 4 standard deviations, many more samples of another seed decide.
fn energy(scene: &Scene, settings: &RenderSettings, picture: &Picture) -> Result<(), String> {
    let most = (1.0 + GAIN).powi(settings.bounces.min(30) as i32 + 1);
    let (mean, deviation) = mean(picture);
    if mean <= most + 4.0 * deviation {
        return Ok(());
    }
    let settings = RenderSettings {
        samples: DECIDING,
        seed: settings.seed ^ 0x5bd1_e995,
        ..settings.clone()
    };
    let rendering = render(scene, &settings, &Silent).map_err(|error| error.to_string())?;
    let (mean, deviation) = self::mean(&rendering.picture);
    if mean <= most + 4.0 * deviation {
        return Ok(());
    }
    Err(format!(
        "energy gained: a mean of {mean:.6} in light of 1, with a standard deviation of {deviation:.6}, where {most:.6} is the most"
    ))
}

/// The mean, and its standard deviation from that of the pixels.
fn mean(picture: &Picture) -> (f64, f64) {
    let values: Vec<f64> = colors(picture)
        .map(|c| c.iter().sum::<f64>() / 3.0)
        .collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}
