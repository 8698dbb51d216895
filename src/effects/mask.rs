//! Sets of effects as bits. Kernels are compiled for sets; worlds are prepared for them.

use super::table::{Decided, TABLE};

/// A set of effects. Where several effects share their code in the kernels, a name here stands for all of their bits, and
/// [`has`] asks whether any is there.
pub type Mask = u32;

/// Images for the base colour.
pub const BASE_COLOR_TEXTURE: Mask = 1;
/// Images for metallic and roughness.
pub const METALLIC_ROUGHNESS_TEXTURE: Mask = 1 << 1;
/// Images for the emission.
pub const EMISSION_TEXTURE: Mask = 1 << 2;
/// Images for the strength of the dielectric's reflection.
pub const SPECULAR_TEXTURE: Mask = 1 << 3;
/// Images for its tint.
pub const SPECULAR_COLOR_TEXTURE: Mask = 1 << 4;
/// Images for the transmission.
pub const TRANSMISSION_TEXTURE: Mask = 1 << 5;
/// Colours of vertices.
pub const VERTEX_COLORS: Mask = 1 << 6;
/// Normal maps.
pub const NORMAL_MAPS: Mask = 1 << 7;
/// Surfaces that light passes by chance.
pub const ALPHA_BLEND: Mask = 1 << 8;
/// Holes.
pub const ALPHA_CLIP: Mask = 1 << 9;
/// Clear solid glass.
pub const CLEAR_GLASS: Mask = 1 << 10;
/// Rough solid glass.
pub const ROUGH_GLASS: Mask = 1 << 11;
/// Sheets that light goes straight through.
pub const THIN_GLASS: Mask = 1 << 12;
/// Point lights.
pub const POINT_LIGHTS: Mask = 1 << 13;
/// Spot lights.
pub const SPOT_LIGHTS: Mask = 1 << 14;
/// Area lights.
pub const AREA_LIGHTS: Mask = 1 << 15;
/// Emissive triangles.
pub const MESH_LIGHTS: Mask = 1 << 16;
/// Sun lights.
pub const SUNS: Mask = 1 << 17;
/// The same light from all around.
pub const CONSTANT_ENVIRONMENT: Mask = 1 << 18;
/// Light from all around by an image.
pub const IMAGE_ENVIRONMENT: Mask = 1 << 19;
/// Objects and lights that some kinds of rays do not see.
pub const VISIBILITY: Mask = 1 << 20;
/// Lenses with an opening. It lies in the camera's rays, before the path loop.
pub const DEPTH_OF_FIELD: Mask = 1 << 24;
/// Metals.
pub const METAL: Mask = 1 << 25;
/// Reflections of dielectrics over their diffuse base.
pub const GLOSS: Mask = 1 << 26;
/// Objects that cut holes into the picture.
pub const HOLDOUTS: Mask = 1 << 27;

/// Normals of vertices, and the curved surface that they stand for.
pub const SMOOTH_NORMALS: Mask = 1 << 28;
/// Meshes that are placed more than once.
pub const INSTANCES: Mask = 1 << 29;

/// The choice between lights by where they are. Without it their power alone decides.
pub const LIGHT_TREE: Mask = 1 << 30;

/// Images on surfaces, but normal maps, and vertex colours.
pub const TEXTURES: Mask = BASE_COLOR_TEXTURE
    | METALLIC_ROUGHNESS_TEXTURE
    | EMISSION_TEXTURE
    | SPECULAR_TEXTURE
    | SPECULAR_COLOR_TEXTURE
    | TRANSMISSION_TEXTURE
    | VERTEX_COLORS;
/// Cut-outs and blends.
pub const ALPHA: Mask = ALPHA_BLEND | ALPHA_CLIP;
/// Glass, rough or clear, solid or thin.
pub const TRANSMISSION: Mask = CLEAR_GLASS | ROUGH_GLASS | THIN_GLASS;
/// Point, spot and area lights.
pub const LAMPS: Mask = POINT_LIGHTS | SPOT_LIGHTS | AREA_LIGHTS;
/// Light from all around.
pub const ENVIRONMENT: Mask = CONSTANT_ENVIRONMENT | IMAGE_ENVIRONMENT;

/// What the path loop is compiled with or without, each as a whole.
pub const COMPILED: [(Mask, &str); 13] = [
    (TEXTURES, "textures"),
    (NORMAL_MAPS, "normal-maps"),
    (ALPHA, "alpha"),
    (TRANSMISSION, "transmission"),
    (LAMPS, "lamps"),
    (MESH_LIGHTS, "mesh-lights"),
    (SUNS, "suns"),
    (ENVIRONMENT, "environment"),
    (VISIBILITY, "ray-visibility"),
    (METAL, "metal"),
    (GLOSS, "gloss"),
    (SMOOTH_NORMALS, "smooth-normals"),
    (INSTANCES, "instances"),
];
/// Everything that the path loop is compiled for.
pub const PATHS: Mask = {
    let (mut set, mut i) = (0, 0);
    while i < COMPILED.len() {
        set |= COMPILED[i].0;
        i += 1;
    }
    set
};
/// What facets do: without any of it, all surfaces are matte.
pub const FACETS: Mask = METAL | GLOSS | TRANSMISSION;
/// What can't be left out, as it is how the world is built.
pub const STRUCTURE: Mask = SMOOTH_NORMALS | INSTANCES;
/// Everything.
pub const ALL: Mask = PATHS | DEPTH_OF_FIELD | HOLDOUTS | LIGHT_TREE;

/// Names that stand for several effects, which share their code.
pub const GROUPS: [(Mask, &str); 5] = [
    (TEXTURES, "textures"),
    (ALPHA, "alpha"),
    (TRANSMISSION, "transmission"),
    (LAMPS, "lamps"),
    (ENVIRONMENT, "environment"),
];

/// Whether a set has an effect, or any of several.
#[inline(always)]
pub const fn has(set: Mask, effect: Mask) -> bool {
    set & effect != 0
}

/// Names of the effects in a set; a group that is there as a whole has its own name.
pub fn names(set: Mask) -> Vec<String> {
    let mut left = set;
    let mut names = Vec::new();
    for row in TABLE.iter().filter(|row| row.bit != 0) {
        if !has(left, row.bit) {
            continue;
        }
        let group = GROUPS
            .iter()
            .find(|(group, _)| has(*group, row.bit) && set & group == *group);
        let (bits, name) = group.map_or((row.bit, row.effect.id()), |&(bits, name)| (bits, name));
        names.push(name.to_owned());
        left &= !bits;
    }
    names
}

/// The set with these names. What can't be left out may be named.
///
/// # Errors
/// Names the first one that is unknown, or that the program does not have yet.
pub fn parse(list: &[String]) -> Result<Mask, String> {
    list.iter().try_fold(0, |set, name| {
        if let Some((bits, _)) = GROUPS.iter().find(|(_, n)| n == name) {
            return Ok(set | bits);
        }
        match TABLE.iter().find(|row| row.effect.id() == name) {
            Some(row) if row.decided == Decided::Absent => Err(format!(
                "the effect '{name}' is not in the program yet: leave it out of the list"
            )),
            Some(row) => Ok(set | row.bit),
            None => {
                let single = TABLE
                    .iter()
                    .filter(|row| row.bit != 0)
                    .map(|row| row.effect.id());
                let all: Vec<_> = GROUPS.iter().map(|(_, n)| *n).chain(single).collect();
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
        assert_eq!(parse(&list(&["alpha-clip"])), Ok(ALPHA_CLIP));
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
            names(ALPHA_CLIP | POINT_LIGHTS),
            ["alpha-clip", "point-lights"]
        );
        for set in [ALL, PATHS, 0, TEXTURES & !VERTEX_COLORS] {
            assert_eq!(parse(&names(set)), Ok(set));
        }
    }

    #[test]
    fn bits_and_rows_are_one_to_one() {
        let bits: Vec<Mask> = TABLE
            .iter()
            .map(|row| row.bit)
            .filter(|b| *b != 0)
            .collect();
        assert!(bits.iter().all(|bit| bit.is_power_of_two()));
        assert_eq!(bits.iter().fold(0, |all, bit| all | bit), ALL);
        assert_eq!(bits.len() as u32, ALL.count_ones());
        for (group, name) in GROUPS {
            assert_eq!(group & PATHS, group, "{name}");
        }
    }
}
