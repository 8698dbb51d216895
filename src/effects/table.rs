//! The one table of effects.

use super::mask::{self, Mask};
use serde::Serialize;

/// What a scene or the settings may call for, in the order of [`TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(usize)]
pub enum Effect {
    /// Images for the base colour.
    BaseColorTexture,
    /// Images for metallic and roughness.
    MetallicRoughnessTexture,
    /// Images for the emission.
    EmissionTexture,
    /// Images for the strength of the dielectric's reflection.
    SpecularTexture,
    /// Images for its tint.
    SpecularColorTexture,
    /// Images for the transmission.
    TransmissionTexture,
    /// Colours of vertices.
    VertexColors,
    /// Normal maps.
    NormalMaps,
    /// Smooth shading.
    SmoothNormals,
    /// Surfaces that light passes by chance.
    AlphaBlend,
    /// Holes.
    AlphaClip,
    /// The diffuse lobe.
    Diffuse,
    /// The dielectric's reflection.
    Gloss,
    /// Metals.
    Metal,
    /// Clear solid glass.
    ClearGlass,
    /// Rough solid glass.
    RoughGlass,
    /// Sheets.
    ThinGlass,
    /// Materials that show their colour without light.
    Unlit,
    /// Point lights.
    PointLights,
    /// Spot lights.
    SpotLights,
    /// Area lights.
    AreaLights,
    /// Emissive triangles.
    MeshLights,
    /// Sun lights.
    Suns,
    /// The same light from all around.
    ConstantEnvironment,
    /// Light from all around by an image.
    ImageEnvironment,
    /// The choice between several lights.
    LightTree,
    /// Meshes that are placed more than once.
    Instances,
    /// Objects and lights that some rays do not see.
    Visibility,
    /// Objects that cut holes into the picture.
    Holdouts,
    /// Lenses with an opening.
    DepthOfField,
    /// Parallel rays from the camera.
    OrthographicCamera,
    /// Rays all around.
    PanoramaCamera,
    /// Passes that keep the light apart.
    LightPasses,
    /// Depth and position.
    PositionPasses,
    /// Time of each pixel.
    CostPass,
    /// Samples where the error is.
    AdaptiveSampling,
    /// Bright contributions made darker.
    Clamping,
    /// Sharp reflections behind blurring bounces made rougher.
    FilterGlossy,
    /// The world is no part of the picture.
    TransparentFilm,
    /// Limits of transparent surfaces on a path.
    TransparentLimit,
    /// Back faces that are not there.
    BackfaceCulling,
    /// A clear coat.
    Coat,
    /// Fabric.
    Sheen,
    /// Brushed metal.
    Anisotropy,
    /// Oren and Nayar's kind of diffuse reflection.
    DiffuseRoughness,
    /// Interference.
    ThinFilm,
    /// Light below the surface.
    Subsurface,
    /// Leaves, paper.
    DiffuseTransmission,
    /// Prisms.
    Dispersion,
    /// Coloured glass by its thickness.
    Absorption,
    /// Fog, smoke.
    Media,
    /// Things that move while the shutter is open.
    MotionBlur,
    /// Objects that show nothing but shadows on them.
    ShadowCatcher,
}

/// Where it is decided whether an effect costs anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decided {
    /// When the program is compiled: kernels without it have neither its code nor its state.
    Kernels,
    /// While paths are traced: a branch in all kernels.
    Branch,
    /// When the scene is prepared: tables, buffers and the camera's rays have it or not.
    Preparation,
    /// By the settings of the render, outside of the path loop.
    Settings,
    /// It is not in the program yet.
    Absent,
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Which one.
    pub effect: Effect,
    /// Its bit, if sets may have it.
    pub bit: Mask,
    /// As the user calls it.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Where it is decided.
    pub decided: Decided,
    /// How it is found in a scene.
    pub found: &'static str,
}

const fn row(
    effect: Effect,
    bit: Mask,
    decided: Decided,
    [name, about, found]: [&'static str; 3],
) -> Row {
    Row {
        effect,
        bit,
        name,
        about,
        decided,
        found,
    }
}

/// How many there are.
pub const COUNT: usize = Effect::ShadowCatcher as usize + 1;

/// The one table of effects.
#[rustfmt::skip]
pub const TABLE: [Row; COUNT] = {
    use Decided::{Absent, Branch, Kernels, Preparation, Settings};
    use Effect as E;
    [
        row(E::BaseColorTexture, mask::BASE_COLOR_TEXTURE, Kernels, ["base-color-texture", "images for the base colour and opacity", "a used material has one, not the same everywhere, and a colour that is not black"]),
        row(E::MetallicRoughnessTexture, mask::METALLIC_ROUGHNESS_TEXTURE, Kernels, ["metallic-roughness-texture", "images for metallic and roughness", "a used material has one, not the same everywhere, and metallic or roughness above 0"]),
        row(E::EmissionTexture, mask::EMISSION_TEXTURE, Kernels, ["emission-texture", "images for the emission", "a used material has one, not the same everywhere, and emits"]),
        row(E::SpecularTexture, mask::SPECULAR_TEXTURE, Kernels, ["specular-texture", "images for the strength of a dielectric's reflection", "a used material that is not all metal has one, not the same everywhere, and a strength above 0"]),
        row(E::SpecularColorTexture, mask::SPECULAR_COLOR_TEXTURE, Kernels, ["specular-color-texture", "images for the tint of a dielectric's reflection", "a used material that is not all metal has one, not the same everywhere, and a tint that is not black"]),
        row(E::TransmissionTexture, mask::TRANSMISSION_TEXTURE, Kernels, ["transmission-texture", "images for the transmission", "a used material that is not all metal has one, not the same everywhere, and transmits"]),
        row(E::VertexColors, mask::VERTEX_COLORS, Kernels, ["vertex-colors", "colours of vertices", "a placed mesh has them, not all white and opaque"]),
        row(E::NormalMaps, mask::NORMAL_MAPS, Kernels, ["normal-maps", "tangent-space normal maps", "a used material has one that is not flat, with a strength that is not 0"]),
        row(E::SmoothNormals, mask::SMOOTH_NORMALS, Kernels, ["smooth-normals", "normals of vertices, and the curved surface that they stand for", "a placed mesh has them, and they are not those of its triangles"]),
        row(E::AlphaBlend, mask::ALPHA_BLEND, Kernels, ["alpha-blend", "surfaces that a share of the light passes", "a used material that blends has an opacity below 1, by its factor, some texel or some vertex"]),
        row(E::AlphaClip, mask::ALPHA_CLIP, Kernels, ["alpha-clip", "surfaces with holes", "a used material with a threshold has an opacity below it, by its factor, some texel or some vertex"]),
        row(E::Diffuse, 0, Branch, ["diffuse", "diffuse reflection", "a used material has a share that is neither metal nor glass, and a colour"]),
        row(E::Gloss, mask::GLOSS, Kernels, ["gloss", "reflections of dielectrics over their diffuse base", "a used material that is neither all metal nor all glass has a specular level above 0 and an index of refraction other than 1"]),
        row(E::Metal, mask::METAL, Kernels, ["metal", "metals, rough or mirrors", "a used material has metallic above 0"]),
        row(E::ClearGlass, mask::CLEAR_GLASS, Kernels, ["clear-glass", "solid glass, clear", "a used material that is not all metal transmits, is solid, and has no roughness"]),
        row(E::RoughGlass, mask::ROUGH_GLASS, Kernels, ["rough-glass", "solid glass, rough", "a used material that is not all metal transmits, is solid, and has roughness"]),
        row(E::ThinGlass, mask::THIN_GLASS, Kernels, ["thin-glass", "sheets that light goes straight through", "a used material that is not all metal transmits and is thin"]),
        row(E::Unlit, 0, Branch, ["unlit", "surfaces that show their colour without light", "a used material is unlit"]),
        row(E::PointLights, mask::POINT_LIGHTS, Kernels, ["point-lights", "point lights, with a size or without", "there is one that is not black and that some rays see"]),
        row(E::SpotLights, mask::SPOT_LIGHTS, Kernels, ["spot-lights", "spot lights", "there is one that is not black and that some rays see"]),
        row(E::AreaLights, mask::AREA_LIGHTS, Kernels, ["area-lights", "rectangles and ellipses that shine", "there is one that is not black and that some rays see"]),
        row(E::MeshLights, mask::MESH_LIGHTS, Kernels, ["mesh-lights", "emissive triangles", "a used material emits (an unlit one: is not black)"]),
        row(E::Suns, mask::SUNS, Kernels, ["suns", "sun lights", "there is one that is not black and that some rays see"]),
        row(E::ConstantEnvironment, mask::CONSTANT_ENVIRONMENT, Kernels, ["constant-environment", "the same light from all around", "the world is not black, and has no image or one that is the same everywhere"]),
        row(E::ImageEnvironment, mask::IMAGE_ENVIRONMENT, Kernels, ["image-environment", "light from all around by an image", "the world is not black and has an image that is not the same everywhere"]),
        row(E::LightTree, mask::LIGHT_TREE, Preparation, ["light-tree", "the choice between lights by where they are, among many by a tree", "there is more than one lamp or emissive triangle"]),
        row(E::Instances, mask::INSTANCES, Kernels, ["instances", "meshes that are placed more than once", "a mesh is"]),
        row(E::Visibility, mask::VISIBILITY, Kernels, ["ray-visibility", "objects and lights that some rays do not see", "an object, a light or the world is hidden from diffuse, glossy or transmission rays, or a light casts no shadow or has a limit of bounces"]),
        row(E::Holdouts, mask::HOLDOUTS, Branch, ["holdouts", "objects that cut holes into the picture", "a placed object is one, and the camera sees it"]),
        row(E::DepthOfField, mask::DEPTH_OF_FIELD, Preparation, ["depth-of-field", "lenses with an opening, sharp at one distance", "the camera that renders has an aperture"]),
        row(E::OrthographicCamera, 0, Preparation, ["orthographic-camera", "parallel rays from the camera", "the camera that renders is one"]),
        row(E::PanoramaCamera, 0, Preparation, ["panorama-camera", "rays from the camera all around", "the camera that renders is one"]),
        row(E::LightPasses, 0, Settings, ["light-passes", "passes that keep the light apart: DiffDir to TransCol, Emit, Env, UV", "one of them is asked for"]),
        row(E::PositionPasses, 0, Settings, ["position-passes", "Depth and Position: a ray more a pixel", "one of them is asked for"]),
        row(E::CostPass, 0, Settings, ["cost-pass", "the time of each pixel", "it is asked for"]),
        row(E::AdaptiveSampling, 0, Settings, ["adaptive-sampling", "samples where the error is", "an error of pixels is asked for"]),
        row(E::Clamping, 0, Branch, ["clamping", "bright contributions made darker", "a limit is set"]),
        row(E::FilterGlossy, 0, Branch, ["filter-glossy", "sharp reflections behind blurring bounces made rougher", "it is set"]),
        row(E::TransparentFilm, 0, Branch, ["transparent-film", "the world is no part of the picture", "it is asked for"]),
        row(E::TransparentLimit, 0, Branch, ["transparent-limit", "a limit of transparent surfaces on a path", "it is set"]),
        row(E::BackfaceCulling, 0, Branch, ["backface-culling", "back faces of single-sided materials are not there", "it is asked for"]),
        row(E::Coat, 0, Absent, ["coat", "a clear coat over the surface", "the importer meets a coat whose weight is not 0"]),
        row(E::Sheen, 0, Absent, ["sheen", "the shine of fabric", "the importer meets a sheen whose weight is not 0"]),
        row(E::Anisotropy, 0, Absent, ["anisotropy", "highlights that are longer one way", "the importer meets a strength that is not 0"]),
        row(E::DiffuseRoughness, 0, Absent, ["diffuse-roughness", "rough diffuse reflection", "the importer meets one that is not 0"]),
        row(E::ThinFilm, 0, Absent, ["thin-film", "interference of a thin film", "the importer meets one whose weight is not 0"]),
        row(E::Subsurface, 0, Absent, ["subsurface", "light that goes on below the surface", "the importer meets one whose weight is not 0"]),
        row(E::DiffuseTransmission, 0, Absent, ["diffuse-transmission", "light that is scattered through a sheet", "the importer meets one whose weight is not 0"]),
        row(E::Dispersion, 0, Absent, ["dispersion", "an index of refraction by wavelength", "the importer meets one that is not 0"]),
        row(E::Absorption, 0, Absent, ["absorption", "glass that takes light by its thickness", "the importer meets a finite distance and a colour that is not white"]),
        row(E::Media, 0, Absent, ["media", "fog, smoke and what else scatters between surfaces", "the importer meets one"]),
        row(E::MotionBlur, 0, Absent, ["motion-blur", "things that move while the shutter is open", "the file has animations, of which one moment is shown"]),
        row(E::ShadowCatcher, 0, Absent, ["shadow-catcher", "objects that show nothing but the shadows on them", "an object is one"]),
    ]
};

impl Decided {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Kernels => "kernels",
            Self::Branch => "branch",
            Self::Preparation => "preparation",
            Self::Settings => "settings",
            Self::Absent => "not in the program yet",
        }
    }
}

/// The table for docs/effects.md.
pub fn markdown() -> String {
    let head = "| effect | what it is | called for where | decided in | left out by `--effects` |\n| --- | --- | --- | --- | --- |\n";
    let lines = TABLE.iter().map(|row| {
        let (name, about, found, decided) = (row.name, row.about, row.found, row.decided.words());
        let left_out = match row.bit {
            0 => "no",
            bit if mask::has(mask::STRUCTURE, bit) => "no",
            _ => "yes",
        };
        format!("| {name} | {about} | {found} | {decided} | {left_out} |\n")
    });
    head.chars()
        .chain(lines.flat_map(|line| line.chars().collect::<Vec<_>>()))
        .collect()
}

impl Effect {
    /// Its line of the table.
    pub fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// As the user calls it.
    pub fn name(self) -> &'static str {
        self.row().name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `UPDATE=1 cargo test --release --lib the_page_has_the_table` writes it anew.
    #[test]
    fn the_page_has_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/effects.md");
        let page = std::fs::read_to_string(path).unwrap();
        let (begin, end) = ("<!-- table -->\n", "<!-- end -->");
        let (before, rest) = page.split_once(begin).unwrap();
        let (there, after) = rest.split_once(end).unwrap();
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(path, format!("{before}{begin}{}{end}{after}", markdown())).unwrap();
        } else {
            assert!(there == markdown(), "run this test with UPDATE=1");
        }
    }

    #[test]
    fn each_effect_stands_in_its_place_under_a_name_of_its_own() {
        let mut names: Vec<_> = TABLE.iter().map(|row| row.name).collect();
        names.extend(mask::GROUPS.map(|(_, name)| name));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for part in crate::scene::PARTS {
            assert!(names.contains(&part), "{part}");
        }
        for (i, row) in TABLE.iter().enumerate() {
            assert_eq!(row.effect as usize, i, "{}", row.name);
            let compiled = row.decided == Decided::Kernels;
            assert_eq!(mask::has(mask::PATHS, row.bit), compiled, "{}", row.name);
        }
    }
}
