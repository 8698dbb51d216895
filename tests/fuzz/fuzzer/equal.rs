//! A kernel that has only the effects that are called for gives the bits of the one that has all, and leaving out what
//! changes nothing changes nothing.

use super::build;
use super::dull::dull;
use super::recipe;
use super::rng::Rng;
use serde_json::{Value, json};
use sundog::film::Picture;
use sundog::render::{EffectChoice, RenderSettings, Silent, render};
use sundog::scene::validate::clean;
use sundog::scene::{Diagnostics, LeftOut, Scene, simplify};

/// Draws a scene for [`kernels`]: any scene, most of them with much in them that changes nothing.
pub fn draw(seed: u64) -> Value {
    let mut rng = Rng::new(seed);
    let mut recipe = recipe::draw(&mut rng);
    // Tables of reflection take longer than the pictures; few are enough here.
    for thing in recipe["things"].as_array_mut().into_iter().flatten() {
        if let Some(material) = thing["material"].as_object_mut() {
            for (name, values) in [
                ("ior", [0.0, 1.0, 1.5, 2.4]),
                ("specular", [0.0, 0.5, 1.0, 1.0]),
            ] {
                if material.contains_key(name) {
                    material.insert(name.into(), json!(rng.pick(&values)));
                }
            }
        }
    }
    if rng.chance(0.7) {
        recipe["dull"] = json!(rng.below(1 << 16));
    }
    recipe
}

/// What was compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Compared {
    /// Something was left out of the scene.
    pub simplified: bool,
    /// … and all of it must not change a bit.
    pub exact: bool,
    /// Some light was there.
    pub lit: bool,
}

/// Renders the scene of a recipe as it is and simplified, each by the kernel made for it and by the general one.
///
/// # Errors
/// What differs, in one sentence.
pub fn kernels(recipe: &Value) -> Result<Compared, String> {
    let mut scene = build::scene(recipe);
    clean(&mut scene, &mut Diagnostics::default());
    if let Some(seed) = recipe["dull"].as_u64() {
        dull(&mut scene, seed);
    }
    if scene.cameras.is_empty() {
        return Ok(Compared::default());
    }
    let settings = tiny(recipe);
    let whole = same_by_both(&scene, &settings, "as it is")?;
    let left_out = simplify(&mut scene);
    let exact = left_out.iter().all(is_exact);
    if !left_out.is_empty() {
        let simple = same_by_both(&scene, &settings, "simplified")?;
        if exact && simple != whole {
            let told: Vec<_> = left_out.iter().map(ToString::to_string).collect();
            return Err(format!("other bits without {}", told.join("; ")));
        }
    }
    Ok(Compared {
        simplified: !left_out.is_empty(),
        exact: exact && !left_out.is_empty(),
        lit: whole.iter().flatten().any(|&bits| bits != 0),
    })
}

/// A few pixels, so that many scenes have their turn.
fn tiny(recipe: &Value) -> RenderSettings {
    let settings = build::settings(recipe);
    RenderSettings {
        width: 6,
        height: 4,
        samples: settings.samples.min(2),
        bounces: settings.bounces.min(8),
        threads: Some(1),
        ..settings
    }
}

type Bits = Vec<Vec<u32>>;

fn same_by_both(scene: &Scene, settings: &RenderSettings, which: &str) -> Result<Bits, String> {
    let by = |effects: EffectChoice| -> Result<Bits, String> {
        let settings = RenderSettings {
            effects,
            ..settings.clone()
        };
        let rendering = render(scene, &settings, &Silent);
        let rendering = rendering.map_err(|error| format!("no picture: {error}"))?;
        Ok(bits(&rendering.picture))
    };
    let (special, general) = (by(EffectChoice::Auto)?, by(EffectChoice::All)?);
    if special != general {
        return Err(format!("other bits by the general kernel, {which}"));
    }
    Ok(special)
}

/// All layers.
fn bits(picture: &Picture) -> Bits {
    let layers = picture.layers.iter();
    let bits = |data: &[f32]| data.iter().map(|v| v.to_bits()).collect();
    layers.map(|layer| bits(&layer.data)).collect()
}

/// What may change bits when it is left out, and why.
const INEXACT: [&str; 9] = [
    // Other objects are asked first, and shadows of blends are drawn by the numbers of objects.
    "no ray sees the object",
    // Light is drawn from fewer.
    "no ray sees the light",
    "no ray sees the world",
    // Another sampling of the same light.
    "the image is the same everywhere and becomes a colour",
    // Factors are multiplied in another order beside colours of vertices; what emits is drawn by its factor; the tables of a
    // reflection are exact where they were interpolated.
    "the image is the same everywhere and becomes a factor",
    // Of two surfaces at one distance the query that asks about opacity may find the other.
    "opacity is 1 everywhere",
    "opacity is above the threshold everywhere",
    // Half a step of its bits.
    "the map is flat everywhere",
    // Emitters are drawn by the factor of their emission.
    "not seen on an unlit surface",
];

fn is_exact(entry: &LeftOut) -> bool {
    !INEXACT.contains(&entry.why)
}
