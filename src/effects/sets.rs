//! Sets of effects: which can be left out, which kernels are made for, and how sets are named.

use super::table::{Decided, row};
use crate::scene::Effect;
use enumset::{EnumSet, enum_set};

/// A set of effects, as worlds and kernels are made for it.
pub type Mask = EnumSet<Effect>;

/// Normal maps.
pub const NORMAL_MAPS: EnumSet<Effect> = enum_set!(Effect::NormalMaps);
/// Colours of vertices.
pub const VERTEX_COLORS: EnumSet<Effect> = enum_set!(Effect::VertexColors);
/// Surfaces that light passes by chance.
pub const ALPHA_BLEND: EnumSet<Effect> = enum_set!(Effect::AlphaBlend);
/// Holes.
pub const ALPHA_CLIP: EnumSet<Effect> = enum_set!(Effect::AlphaClip);
/// Emissive triangles.
pub const MESH_LIGHTS: EnumSet<Effect> = enum_set!(Effect::MeshLights);
/// Sun lights.
pub const SUNS: EnumSet<Effect> = enum_set!(Effect::Suns);
/// Objects and lights that some kinds of rays do not see.
pub const VISIBILITY: EnumSet<Effect> = enum_set!(Effect::RayVisibility);
/// Lenses with an opening. It lies in the camera's rays, before the path loop.
pub const DEPTH_OF_FIELD: EnumSet<Effect> = enum_set!(Effect::DepthOfField);
/// Metals.
pub const METAL: EnumSet<Effect> = enum_set!(Effect::Metal);
/// Reflections of dielectrics over their diffuse base.
pub const GLOSS: EnumSet<Effect> = enum_set!(Effect::Gloss);
/// Objects that cut holes into the picture.
pub const HOLDOUTS: EnumSet<Effect> = enum_set!(Effect::Holdouts);
/// Normals of vertices, and the curved surface that they stand for.
pub const SMOOTH_NORMALS: EnumSet<Effect> = enum_set!(Effect::SmoothNormals);
/// Meshes that are placed more than once.
pub const INSTANCES: EnumSet<Effect> = enum_set!(Effect::Instances);
/// The choice between lights by where they are. Without it their power alone decides.
pub const LIGHT_TREE: EnumSet<Effect> = enum_set!(Effect::LightTree);

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
        | Effect::Metal
        | Effect::Gloss
        | Effect::DiffuseRoughness
        | STRUCTURE
);
/// What can't be left out, as it is how the world is built.
pub const STRUCTURE: EnumSet<Effect> = enum_set!(Effect::SmoothNormals | Effect::Instances);
/// Everything that kernels and worlds may have or lack.
pub const ALL: EnumSet<Effect> =
    enum_set!(PATHS | Effect::DepthOfField | Effect::Holdouts | Effect::LightTree);

/// Names that stand for several effects, which share their code.
pub const GROUPS: [(EnumSet<Effect>, &str); 5] = [
    (TEXTURES, "textures"),
    (ALPHA, "alpha"),
    (TRANSMISSION, "transmission"),
    (LAMPS, "lamps"),
    (ENVIRONMENT, "environment"),
];

/// Whether a set has any of some effects.
pub fn has(set: EnumSet<Effect>, any: EnumSet<Effect>) -> bool {
    !set.is_disjoint(any)
}

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
mod tests {
    use super::*;

    #[test]
    fn names_and_sets_say_the_same() {
        let list = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(parse(&list(&["alpha", "suns"])), Ok(ALPHA | SUNS));
        assert_eq!(parse(&list(&["alpha-clip"])), Ok(Effect::AlphaClip.into()));
        assert_eq!(
            parse(&list(&["instances", "diffuse", "suns"])),
            Ok(SUNS | INSTANCES)
        );
        assert!(parse(&list(&["fog"])).unwrap_err().contains("rough-glass"));
        assert!(
            parse(&list(&["coat"]))
                .unwrap_err()
                .contains("not in the program yet")
        );
        assert_eq!(names(ALPHA | SUNS), ["alpha", "suns"]);
        assert_eq!(
            names(Effect::AlphaClip | Effect::PointLights),
            ["alpha-clip", "point-lights"]
        );
        assert_eq!(names(SUNS | Effect::Diffuse), ["suns"]);
        for set in [ALL, PATHS, EnumSet::empty(), TEXTURES - VERTEX_COLORS] {
            assert_eq!(parse(&names(set)), Ok(set));
        }
    }
}
