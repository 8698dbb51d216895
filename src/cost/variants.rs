//! The pictures that are rendered beside the full one: each leaves one thing out.

use crate::effects::{self, Effect, TRANSMISSION};
use crate::render::{BounceLimits, EffectChoice, LightSampling, RenderSettings, called_for};
use crate::scene::{Scene, coincident};
use enumset::EnumSet;
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
    let called_for = called_for((scene, &coincident::find(scene)), settings);
    let mut list = without_effects(settings, called_for);
    list.extend(fewer_bounces(settings, called_for));
    list.extend(other_techniques(settings));
    list.extend(without_bias(settings));
    list
}

impl Variant {
    /// The picture of settings from which something is taken.
    fn new(
        (name, about): (&str, &str),
        worth: Worth,
        settings: &RenderSettings,
        take: impl FnOnce(&mut RenderSettings),
    ) -> Self {
        let mut without = settings.clone();
        take(&mut without);
        Self {
            name: name.into(),
            about: about.into(),
            worth,
            settings: without,
        }
    }
}

fn without_effects(settings: &RenderSettings, called_for: EnumSet<Effect>) -> Vec<Variant> {
    let without = |effect: Effect| Variant {
        name: effect.id().into(),
        // Triangles shine where paths meet them without it too.
        about: match effect {
            Effect::MeshLights => "emissive triangles looked for, not only met".into(),
            Effect::LightTree => "lights drawn by where they are, not by their power alone".into(),
            _ => effects::row(effect).about.into(),
        },
        worth: match effect {
            Effect::MeshLights | Effect::LightTree => Worth::Noise,
            _ => Worth::Picture,
        },
        settings: RenderSettings {
            effects: EffectChoice::List(effects::names(called_for - effect)),
            ..settings.clone()
        },
    };
    let left_out = called_for - effects::STRUCTURE;
    left_out.iter().map(without).collect()
}

fn fewer_bounces(settings: &RenderSettings, called_for: EnumSet<Effect>) -> Vec<Variant> {
    let depths = std::iter::once(0)
        .chain((0..u32::BITS).map(|k| 1 << k))
        .take_while(|depth| *depth < settings.bounces);
    let less = |bounces: u32| {
        let name = format!("bounces beyond {bounces}");
        let about = format!("bounces {} to {} of a path", bounces + 1, settings.bounces);
        Variant::new((&name, &about), Worth::Picture, settings, |without| {
            without.bounces = bounces;
        })
    };
    let mut list: Vec<Variant> = depths.map(less).collect();
    if settings.bounces == 0 {
        return list;
    }
    type Limit = fn(&mut BounceLimits) -> &mut Option<u32>;
    let kinds: [(&str, &str, bool, Limit); 3] = [
        (
            "diffuse bounces",
            "light by way of matt surfaces",
            true,
            |limits| &mut limits.diffuse,
        ),
        (
            "glossy bounces",
            "what mirrors and sheen show, and the light that they throw",
            true,
            |limits| &mut limits.glossy,
        ),
        (
            "transmission bounces",
            "what is seen through glass, and the light that passes it",
            !called_for.is_disjoint(TRANSMISSION),
            |limits| &mut limits.transmission,
        ),
    ];
    for (name, about, there, limit) in kinds {
        let without = Variant::new((name, about), Worth::Picture, settings, |without| {
            *limit(&mut without.bounce_limits) = Some(0);
        });
        if there && without.settings.bounce_limits != settings.bounce_limits {
            list.push(without);
        }
    }
    list
}

/// Light that is sampled in other ways, and paths that go on to their last bounce.
fn other_techniques(settings: &RenderSettings) -> Vec<Variant> {
    let mut list = Vec::new();
    let mut add = |words: (&str, &str), take: &dyn Fn(&mut RenderSettings)| {
        list.push(Variant::new(words, Worth::Noise, settings, take));
    };
    if settings.light_sampling == LightSampling::Mis {
        let nee = "multiple importance sampling instead of next-event estimation alone";
        add(("sampling BSDFs for light", nee), &|without| {
            without.light_sampling = LightSampling::Nee;
        });
        let bsdf = "multiple importance sampling instead of BSDF sampling alone";
        add(("sampling lights", bsdf), &|without| {
            without.light_sampling = LightSampling::Bsdf;
        });
    }
    if settings.light_samples > 1 {
        let about = format!(
            "{} light samples where the camera looks instead of one",
            settings.light_samples
        );
        add(("light samples", &about), &|without| {
            without.light_samples = 1
        });
    }
    if settings
        .roulette
        .is_some_and(|from| from < settings.bounces)
    {
        add(
            ("roulette", "paths that carry little ended by chance"),
            &|without| without.roulette = None,
        );
    }
    list
}

/// What the settings take away, given back.
fn without_bias(settings: &RenderSettings) -> Vec<Variant> {
    type Setting = fn(&mut RenderSettings) -> &mut f32;
    let biased: [(&str, &str, Setting); 3] = [
        (
            "clamp-direct",
            "bright samples of direct light made darker",
            |settings| &mut settings.clamp_direct,
        ),
        (
            "clamp-indirect",
            "bright samples of indirect light made darker",
            |settings| &mut settings.clamp_indirect,
        ),
        (
            "filter-glossy",
            "sharp reflections behind blurring bounces made rougher",
            |settings| &mut settings.filter_glossy,
        ),
    ];
    let without = |(name, about, setting): (&str, &str, Setting)| {
        let mut given = 0.0;
        let without = Variant::new((name, about), Worth::Noise, settings, |without| {
            given = std::mem::take(setting(without));
        });
        (given > 0.0).then_some(without)
    };
    biased.into_iter().filter_map(without).collect()
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
            links: Default::default(),
            graph: None,
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
