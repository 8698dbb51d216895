//! The pictures that are rendered beside the full one: each leaves one thing out.

use crate::effects::{self, LIGHT_TREE, MESH_LIGHTS, Mask, TRANSMISSION};
use crate::render::{BounceLimits, EffectChoice, LightSampling, RenderSettings, called_for};
use crate::scene::Scene;
use serde::Serialize;

/// What an effect is for, and so what its absence does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Worth {
    /// Without it the picture is another one.
    Picture,
    /// Without it the picture is the same, with more or less noise.
    Noise,
}

/// A picture without something.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What it is without: a name of [`effects::TABLE`], or of a setting.
    pub name: String,
    /// What that is.
    pub about: String,
    /// What it is for.
    pub worth: Worth,
    /// How the picture without it is rendered.
    pub settings: RenderSettings,
}

/// One for each effect that the scene and the settings call for.
pub fn variants(scene: &Scene, settings: &RenderSettings) -> Vec<Variant> {
    let called_for = called_for(scene, settings);
    let mut list = without_effects(settings, called_for);
    list.extend(fewer_bounces(settings, called_for));
    list.extend(other_light_sampling(settings));
    list.extend(one_light_sample(settings));
    list.extend(without_roulette(settings));
    list.extend(without_bias(settings));
    list
}

fn without_effects(settings: &RenderSettings, called_for: Mask) -> Vec<Variant> {
    effects::TABLE
        .iter()
        .filter(|row| effects::has(called_for & !effects::STRUCTURE, row.bit))
        .map(|row| Variant {
            name: row.effect.id().into(),
            // Triangles shine where paths meet them without it too.
            about: match row.bit {
                MESH_LIGHTS => "emissive triangles looked for, not only met".into(),
                LIGHT_TREE => "lights drawn by where they are, not by their power alone".into(),
                _ => row.about.into(),
            },
            worth: match row.bit {
                MESH_LIGHTS | LIGHT_TREE => Worth::Noise,
                _ => Worth::Picture,
            },
            settings: RenderSettings {
                effects: EffectChoice::List(effects::names(called_for & !row.bit)),
                ..settings.clone()
            },
        })
        .collect()
}

fn fewer_bounces(settings: &RenderSettings, called_for: Mask) -> Vec<Variant> {
    let depths = std::iter::once(0)
        .chain((0..u32::BITS).map(|k| 1 << k))
        .take_while(|depth| *depth < settings.bounces);
    let mut list: Vec<Variant> = depths
        .map(|bounces| Variant {
            name: format!("bounces beyond {bounces}"),
            about: format!("bounces {} to {} of a path", bounces + 1, settings.bounces),
            worth: Worth::Picture,
            settings: RenderSettings {
                bounces,
                ..settings.clone()
            },
        })
        .collect();
    if settings.bounces == 0 {
        return list;
    }
    let limits = settings.bounce_limits;
    let none = Some(0);
    let glass = effects::has(called_for, TRANSMISSION);
    for (name, about, there, without) in [
        (
            "diffuse bounces",
            "light by way of matt surfaces",
            true,
            BounceLimits {
                diffuse: none,
                ..limits
            },
        ),
        (
            "glossy bounces",
            "what mirrors and sheen show, and the light that they throw",
            true,
            BounceLimits {
                glossy: none,
                ..limits
            },
        ),
        (
            "transmission bounces",
            "what is seen through glass, and the light that passes it",
            glass,
            BounceLimits {
                transmission: none,
                ..limits
            },
        ),
    ] {
        if there && without != limits {
            list.push(Variant {
                name: name.into(),
                about: about.into(),
                worth: Worth::Picture,
                settings: RenderSettings {
                    bounce_limits: without,
                    ..settings.clone()
                },
            });
        }
    }
    list
}

fn other_light_sampling(settings: &RenderSettings) -> Vec<Variant> {
    if settings.light_sampling != LightSampling::Mis {
        return Vec::new();
    }
    [
        (
            "sampling BSDFs for light",
            "multiple importance sampling instead of next-event estimation alone",
            LightSampling::Nee,
        ),
        (
            "sampling lights",
            "multiple importance sampling instead of BSDF sampling alone",
            LightSampling::Bsdf,
        ),
    ]
    .map(|(name, about, light_sampling)| Variant {
        name: name.into(),
        about: about.into(),
        worth: Worth::Noise,
        settings: RenderSettings {
            light_sampling,
            ..settings.clone()
        },
    })
    .into()
}

/// One light sample where several are asked for.
fn one_light_sample(settings: &RenderSettings) -> Option<Variant> {
    (settings.light_samples > 1).then(|| Variant {
        name: "light samples".into(),
        about: format!(
            "{} light samples where the camera looks instead of one",
            settings.light_samples
        ),
        worth: Worth::Noise,
        settings: RenderSettings {
            light_samples: 1,
            ..settings.clone()
        },
    })
}

/// Paths that go on to their last bounce.
fn without_roulette(settings: &RenderSettings) -> Option<Variant> {
    let from = settings.roulette?;
    (from < settings.bounces).then(|| Variant {
        name: "roulette".into(),
        about: "paths that carry little ended by chance".into(),
        worth: Worth::Noise,
        settings: RenderSettings {
            roulette: None,
            ..settings.clone()
        },
    })
}

/// What the settings take away, given back.
fn without_bias(settings: &RenderSettings) -> Vec<Variant> {
    let mut list = Vec::new();
    let mut add = |name: &str, about: &str, without: RenderSettings| {
        list.push(Variant {
            name: name.into(),
            about: about.into(),
            worth: Worth::Noise,
            settings: without,
        });
    };
    type Off = fn(&mut RenderSettings);
    let biased: [(&str, &str, f32, Off); 3] = [
        (
            "clamp-direct",
            "bright samples of direct light made darker",
            settings.clamp_direct,
            |without| without.clamp_direct = 0.0,
        ),
        (
            "clamp-indirect",
            "bright samples of indirect light made darker",
            settings.clamp_indirect,
            |without| without.clamp_indirect = 0.0,
        ),
        (
            "filter-glossy",
            "sharp reflections behind blurring bounces made rougher",
            settings.filter_glossy,
            |without| without.filter_glossy = 0.0,
        ),
    ];
    for (name, about, value, off) in biased {
        if value > 0.0 {
            let mut without = settings.clone();
            off(&mut without);
            add(name, about, without);
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Environment;

    fn names(scene: &Scene, settings: &RenderSettings) -> Vec<String> {
        let list = variants(scene, settings);
        list.into_iter().map(|variant| variant.name).collect()
    }

    #[test]
    fn only_what_is_called_for_is_left_out() {
        let mut scene = Scene::default();
        let settings = RenderSettings {
            bounces: 3,
            ..RenderSettings::default()
        };
        scene.environment = Some(Environment {
            image: None,
            radiance: [1.0; 3],
            rotation: glam::DMat3::IDENTITY,
            visibility: crate::scene::Visibility::ALL,
        });
        assert_eq!(
            names(&scene, &settings),
            [
                "constant-environment",
                "bounces beyond 0",
                "bounces beyond 1",
                "bounces beyond 2",
                "diffuse bounces",
                "glossy bounces",
                "sampling BSDFs for light",
                "sampling lights",
                "roulette",
            ]
        );
        let settings = RenderSettings {
            bounces: 0,
            clamp_indirect: 10.0,
            filter_glossy: 1.0,
            light_sampling: LightSampling::Nee,
            light_samples: 4,
            ..settings
        };
        assert_eq!(
            names(&scene, &settings),
            [
                "constant-environment",
                "light samples",
                "clamp-indirect",
                "filter-glossy"
            ]
        );
    }
}
