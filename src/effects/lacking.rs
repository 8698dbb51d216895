//! Effects that the program lacks, by what the importer says of them.

use super::detect::Thing;
use super::table::Effect;
use crate::scene::Diagnostic;

/// What the importer calls them: a code, what the feature is or begins with, the effect.
const TOLD: [(&str, &str, Effect); 17] = [
    (
        "unsupported-material",
        "KHR_materials_clearcoat",
        Effect::Coat,
    ),
    ("unsupported-material", "the coat", Effect::Coat),
    ("unsupported-material", "KHR_materials_sheen", Effect::Sheen),
    ("unsupported-material", "sheen", Effect::Sheen),
    (
        "unsupported-material",
        "KHR_materials_anisotropy",
        Effect::Anisotropy,
    ),
    ("unsupported-material", "anisotropy", Effect::Anisotropy),
    (
        "unsupported-material",
        "diffuse roughness",
        Effect::DiffuseRoughness,
    ),
    (
        "unsupported-material",
        "KHR_materials_iridescence",
        Effect::ThinFilm,
    ),
    ("unsupported-material", "the thin film", Effect::ThinFilm),
    (
        "unsupported-material",
        "KHR_materials_subsurface",
        Effect::Subsurface,
    ),
    (
        "unsupported-material",
        "subsurface scattering",
        Effect::Subsurface,
    ),
    (
        "unsupported-material",
        "KHR_materials_diffuse_transmission",
        Effect::DiffuseTransmission,
    ),
    (
        "unsupported-material",
        "KHR_materials_dispersion",
        Effect::Dispersion,
    ),
    (
        "unsupported-material",
        "KHR_materials_volume_scatter",
        Effect::Media,
    ),
    ("attenuation", "", Effect::Absorption),
    ("animation", "", Effect::MotionBlur),
    ("shadow-catcher", "", Effect::ShadowCatcher),
];

/// The effect that a message says is lacking.
pub fn effect(message: &Diagnostic) -> Option<Effect> {
    let told = TOLD
        .iter()
        .find(|(code, feature, _)| message.code == *code && message.feature.starts_with(feature));
    told.map(|(.., effect)| *effect)
}

/// The name of a thing, which messages have in quotes: `material "Paint"`.
pub fn name(object: &str) -> &str {
    let inner = object.split_once('"').map(|(_, rest)| rest);
    inner
        .and_then(|rest| rest.strip_suffix('"'))
        .unwrap_or(object)
}

/// What the things are that a message names.
pub fn kind(message: &Diagnostic) -> Thing {
    match message.code {
        "unsupported-material" | "attenuation" => Thing::Material,
        "shadow-catcher" => Thing::Object,
        _ => Thing::File,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Asked, EffectSet, State};
    use crate::scene::{Diagnostics, Scene, Verdict};

    #[test]
    fn what_the_importer_tells_is_lacking_by_name() {
        let mut told = Diagnostics::default();
        for i in 0..5 {
            let owner = format!("material \"Paint {i}\"");
            let instead = "rendered without the coat";
            told.report(
                "unsupported-material",
                Verdict::Lost,
                "the coat",
                owner,
                instead,
            );
        }
        let set = EffectSet::of(&Scene::default(), &Asked::default(), &[], &told);
        let coat = set.findings.iter().find(|f| f.effect == "coat").unwrap();
        assert_eq!((coat.state, coat.count), (State::Lacking, 5));
        assert_eq!(coat.because_of[0].name, "Paint 0");
        assert_eq!(set.mask, 0);
        assert_eq!(name("node 3"), "node 3");
    }
}
