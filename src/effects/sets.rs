//! Sets of effects: which can be left out, which kernels are made for, and how sets are named.

use super::table::{Decided, row};
use crate::scene::Effect;
use enumset::{EnumSet, enum_set};

/// Images on surfaces, but normal maps, and vertex colours.
pub const TEXTURES: EnumSet<Effect> = enum_set!(
    Effect::BaseColorTexture
        | Effect::MetallicRoughnessTexture
        | Effect::EmissionTexture
        | Effect::SpecularTexture
        | Effect::SpecularColorTexture
        | Effect::TransmissionTexture
        | Effect::VertexColors
);
/// Cut-outs and blends.
pub const ALPHA: EnumSet<Effect> = enum_set!(Effect::AlphaBlend | Effect::AlphaClip);
/// Glass, rough or clear, solid or thin.
pub const TRANSMISSION: EnumSet<Effect> =
    enum_set!(Effect::ClearGlass | Effect::RoughGlass | Effect::ThinGlass);
/// Point, spot and area lights.
pub const LAMPS: EnumSet<Effect> =
    enum_set!(Effect::PointLights | Effect::SpotLights | Effect::AreaLights);
/// Light from all around.
pub const ENVIRONMENT: EnumSet<Effect> =
    enum_set!(Effect::ConstantEnvironment | Effect::ImageEnvironment);

/// Everything that the path loop is compiled for.
pub const PATHS: EnumSet<Effect> = enum_set!(
    TEXTURES
        | ALPHA
        | TRANSMISSION
        | LAMPS
        | ENVIRONMENT
        | Effect::NormalMaps
        | Effect::MeshLights
        | Effect::Suns
        | Effect::RayVisibility
        | Effect::LightLinking
        | Effect::ShadowTerminators
        | Effect::Metal
        | Effect::Gloss
        | Effect::DiffuseRoughness
        | Effect::Anisotropy
        | Effect::Coat
        | Effect::Sheen
        | Effect::DiffuseTransmission
        | Effect::ThinFilm
        | Effect::Dispersion
        | Effect::Subsurface
        | Effect::CoincidentFaces
        | Effect::ShadowCatcher
        | Effect::RayPortals
        | Effect::HairShaders
        | Effect::MotionBlur
        | Effect::Media
        | Effect::Absorption
        | Effect::NestedDielectrics
        | Effect::FastGi
        | STRUCTURE
);
/// Patterns that materials' programs compute.
pub const PROCEDURAL_TEXTURES: EnumSet<Effect> = enum_set!(
    Effect::NoiseTexture
        | Effect::VoronoiTexture
        | Effect::WaveTexture
        | Effect::MagicTexture
        | Effect::BrickTexture
        | Effect::CheckerTexture
        | Effect::GradientTexture
        | Effect::WhiteNoiseTexture
        | Effect::GaborTexture
);
/// What can't be left out, as it is how the world is built.
pub const STRUCTURE: EnumSet<Effect> =
    enum_set!(Effect::SmoothNormals | Effect::Instances | Effect::Strands);
/// Everything that kernels and worlds may have or lack.
pub const ALL: EnumSet<Effect> = enum_set!(
    PATHS | PROCEDURAL_TEXTURES | Effect::DepthOfField | Effect::Holdouts | Effect::LightTree
);

/// Names that stand for several effects, which share their code.
pub const GROUPS: [(EnumSet<Effect>, &str); 6] = [
    (TEXTURES, "textures"),
    (PROCEDURAL_TEXTURES, "procedural-textures"),
    (ALPHA, "alpha"),
    (TRANSMISSION, "transmission"),
    (LAMPS, "lamps"),
    (ENVIRONMENT, "environment"),
];

/// Names of those in a set that kernels and worlds may have or lack; a group that is there as a whole has its own name.
pub fn names(set: EnumSet<Effect>) -> Vec<String> {
    let mut left = set & ALL;
    let mut names = Vec::new();
    while let Some(effect) = left.iter().next() {
        let group = GROUPS
            .iter()
            .find(|(group, _)| group.contains(effect) && set.is_superset(*group));
        let (all, name) = group.map_or((effect.into(), effect.id()), |&(all, name)| (all, name));
        names.push(name.to_owned());
        left -= all;
    }
    names
}

/// The set with these names. What can't be left out may be named.
///
/// # Errors
/// Names the first one that is unknown, or that the program does not have yet.
pub fn parse(list: &[String]) -> Result<EnumSet<Effect>, String> {
    list.iter().try_fold(EnumSet::empty(), |set, name| {
        if let Some((group, _)) = GROUPS.iter().find(|(_, n)| n == name) {
            return Ok(set | *group);
        }
        match name.parse::<Effect>() {
            Ok(effect) if row(effect).decided == Decided::Absent => Err(format!(
                "the effect '{name}' is not in the program yet: leave it out of the list"
            )),
            Ok(effect) => Ok(set | (ALL & effect)),
            Err(_) => {
                let groups = GROUPS.iter().map(|(_, n)| *n);
                let all: Vec<_> = groups.chain(ALL.iter().map(Effect::id)).collect();
                Err(format!(
                    "there is no effect '{name}'; there are: {}",
                    all.join(", ")
                ))
            }
        }
    })
}

#[cfg(test)]
#[path = "../../tests/unit/effects/sets.rs"]
mod tests;
