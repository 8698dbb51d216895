//! The one table of effects.

use super::sets;
use crate::scene::Effect;
use serde::Serialize;
use strum::EnumCount;

/// Where it is decided whether an effect costs anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decided {
    /// When the program is compiled: kernels without it have neither its code nor its state.
    Kernels,
    /// While paths are traced: a branch in all kernels.
    Branch,
    /// When the scene is prepared: tables, buffers, materials' programs and the camera's rays have it or not.
    Preparation,
    /// By the settings of the render, outside of the path loop.
    Settings,
    /// It is not in the program yet.
    Absent,
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct EffectRow {
    /// Which one.
    pub effect: Effect,
    /// What it is.
    pub about: &'static str,
    /// Where it is decided.
    pub decided: Decided,
    /// How it is found in a scene.
    pub found: &'static str,
}

const fn line(effect: Effect, decided: Decided, [about, found]: [&'static str; 2]) -> EffectRow {
    EffectRow {
        effect,
        about,
        decided,
        found,
    }
}

/// How many there are.
pub const COUNT: usize = Effect::COUNT;

/// The one table of effects.
#[rustfmt::skip]
pub const TABLE: [EffectRow; COUNT] = {
    use Decided::{Branch, Kernels, Preparation, Settings};
    use Effect as E;
    [
        line(E::BaseColorTexture, Kernels, ["images for the base colour and opacity", "a used material has one, not the same everywhere, and a colour that is not black"]),
        line(E::MetallicRoughnessTexture, Kernels, ["images for metallic and roughness", "a used material has one, not the same everywhere, and metallic or roughness above 0"]),
        line(E::EmissionTexture, Kernels, ["images for the emission", "a used material has one, not the same everywhere, and emits"]),
        line(E::SpecularTexture, Kernels, ["images for the strength of a dielectric's reflection", "a used material that is not all metal has one, not the same everywhere, and a strength above 0"]),
        line(E::SpecularColorTexture, Kernels, ["images for the tint of a dielectric's reflection", "a used material that is not all metal has one, not the same everywhere, and a tint that is not black"]),
        line(E::TransmissionTexture, Kernels, ["images for the transmission", "a used material that is not all metal has one, not the same everywhere, and transmits"]),
        line(E::VertexColors, Kernels, ["colours of vertices", "a placed mesh has them, not all white and opaque"]),
        line(E::NormalMaps, Kernels, ["tangent-space normal maps", "a used material has one that is not flat, with a strength that is not 0"]),
        line(E::SmoothNormals, Kernels, ["normals of vertices, and the curved surface that they stand for", "a placed mesh has them, and they are not those of its triangles"]),
        line(E::AlphaBlend, Kernels, ["surfaces that a share of the light passes", "a used material that blends has an opacity below 1, by its factor, some texel or some vertex"]),
        line(E::AlphaClip, Kernels, ["surfaces with holes", "a used material with a threshold has an opacity below it, by its factor, some texel or some vertex"]),
        line(E::Diffuse, Branch, ["diffuse reflection", "a used material has a share that is neither metal nor glass, and a colour"]),
        line(E::Gloss, Kernels, ["reflections of dielectrics over their diffuse base", "a used material that is neither all metal nor all glass has a specular level above 0 and an index of refraction other than 1"]),
        line(E::Metal, Kernels, ["metals, rough or mirrors", "a used material has metallic above 0"]),
        line(E::ClearGlass, Kernels, ["solid glass, clear", "a used material that is not all metal transmits, is solid, and has no roughness"]),
        line(E::RoughGlass, Kernels, ["solid glass, rough", "a used material that is not all metal transmits, is solid, and has roughness"]),
        line(E::ThinGlass, Kernels, ["sheets that light goes straight through", "a used material that is not all metal transmits and is thin"]),
        line(E::Unlit, Branch, ["surfaces that show their colour without light", "a used material is unlit"]),
        line(E::PointLights, Kernels, ["point lights, with a size or without", "there is one that is not black and that some rays see"]),
        line(E::SpotLights, Kernels, ["spot lights", "there is one that is not black and that some rays see"]),
        line(E::AreaLights, Kernels, ["rectangles and ellipses that shine", "there is one that is not black and that some rays see"]),
        line(E::MeshLights, Kernels, ["emissive triangles", "a used material emits (an unlit one: is not black)"]),
        line(E::Suns, Kernels, ["sun lights", "there is one that is not black and that some rays see"]),
        line(E::ConstantEnvironment, Kernels, ["the same light from all around", "the world is not black, and has no image or one that is the same everywhere"]),
        line(E::ImageEnvironment, Kernels, ["light from all around by an image or a node tree", "the world is not black and has an image that is not the same everywhere, or a node tree"]),
        line(E::LightTree, Preparation, ["the choice between lights by where they are, among many by a tree", "there is more than one lamp or emissive triangle"]),
        line(E::Instances, Kernels, ["meshes that are placed more than once", "a mesh is"]),
        line(E::RayVisibility, Kernels, ["objects and lights that some rays do not see", "an object, a light or the world is hidden from diffuse, glossy or transmission rays, or a light casts no shadow or has a limit of bounces"]),
        line(E::LightLinking, Kernels, ["lights that light some objects alone, or of which some alone cast shadows", "a light or an object that shines has such a set of objects"]),
        line(E::Holdouts, Branch, ["objects that cut holes into the picture", "a placed object is one, and the camera sees it"]),
        line(E::ShadowTerminators, Kernels, ["surfaces on which light that grazes them counts less", "a placed object has a Shading Offset of the shadow terminator"]),
        line(E::CoincidentFaces, Kernels, ["faces in one plane that lie on each other and take each other's light", "in a file from Blender two faces overlap in one plane, or an area light lies in that of a face across an axis"]),
        line(E::DepthOfField, Preparation, ["lenses with an opening, sharp at one distance", "the camera that renders has an aperture"]),
        line(E::OrthographicCamera, Preparation, ["parallel rays from the camera", "the camera that renders is one"]),
        line(E::PanoramaCamera, Preparation, ["rays from the camera all around", "the camera that renders is one"]),
        line(E::LightPasses, Settings, ["passes that keep the light apart: DiffDir to TransCol, Emit, Env, UV; features for denoisers, objects, AOVs", "one of them is asked for"]),
        line(E::PositionPasses, Settings, ["Depth and Position: a ray more a pixel", "one of them is asked for"]),
        line(E::CostPass, Settings, ["the time of each pixel", "it is asked for"]),
        line(E::AdaptiveSampling, Settings, ["samples where the error is", "an error of pixels or a noise threshold is asked for"]),
        line(E::Clamping, Branch, ["bright contributions made darker", "a limit is set"]),
        line(E::FilterGlossy, Branch, ["sharp reflections behind blurring bounces made rougher", "it is set"]),
        line(E::TransparentFilm, Branch, ["the world is no part of the picture", "it is asked for"]),
        line(E::TransparentLimit, Branch, ["a limit of transparent surfaces on a path", "it is set"]),
        line(E::FastGi, Kernels, ["short rays that stand for indirect light: Cycles' fast GI approximation", "the file asks for it"]),
        line(E::BackfaceCulling, Branch, ["back faces of single-sided materials are not there", "it is asked for"]),
        line(E::Coat, Kernels, ["a clear coat over the surface", "a placed material has a coat whose weight is not 0"]),
        line(E::Sheen, Kernels, ["the shine of fabric", "a placed material has a sheen whose weight is not 0"]),
        line(E::Anisotropy, Kernels, ["highlights that are longer one way", "a placed material has an anisotropy that is not 0"]),
        line(E::DiffuseRoughness, Kernels, ["rough diffuse reflection", "a placed material has a diffuse roughness above 0"]),
        line(E::NoiseTexture, Preparation, ["clouds of noise", "a placed material has a Noise Texture that its program evaluates at hits"]),
        line(E::VoronoiTexture, Preparation, ["cells around points", "a placed material has a Voronoi Texture that its program evaluates at hits"]),
        line(E::WaveTexture, Preparation, ["bands and rings", "a placed material has a Wave Texture that its program evaluates at hits"]),
        line(E::MagicTexture, Preparation, ["folded sines", "a placed material has a Magic Texture that its program evaluates at hits"]),
        line(E::BrickTexture, Preparation, ["courses of bricks", "a placed material has a Brick Texture that its program evaluates at hits"]),
        line(E::CheckerTexture, Preparation, ["chequers", "a placed material has a Checker Texture that its program evaluates at hits"]),
        line(E::GradientTexture, Preparation, ["ramps across space", "a placed material has a Gradient Texture that its program evaluates at hits"]),
        line(E::WhiteNoiseTexture, Preparation, ["a random number for each place", "a placed material has a White Noise Texture that its program evaluates at hits"]),
        line(E::GaborTexture, Preparation, ["noise of one frequency and direction", "a placed material has a Gabor Texture that its program evaluates at hits"]),
        line(E::ThinFilm, Kernels, ["interference of a thin film", "a placed material has a film whose thickness is not 0"]),
        line(E::Subsurface, Kernels, ["light that goes on below the surface", "a placed material has a Subsurface Scattering node, or a subsurface weight above 0 that is no thin wall's"]),
        line(E::DiffuseTransmission, Kernels, ["light that is scattered through a sheet", "a placed material has a Translucent BSDF, light below the surface of a thin wall, or diffuse transmission"]),
        line(E::Dispersion, Kernels, ["an index of refraction by wavelength", "a placed material is solid glass whose dispersion is not 0"]),
        line(E::Absorption, Kernels, ["light that is taken by the way through a solid", "a placed material or the world has a volume that absorbs and does nothing else"]),
        line(E::Media, Kernels, ["fog and what else scatters or emits light between surfaces", "a placed material or the world has a volume that does"]),
        line(E::NestedDielectrics, Kernels, ["solids that overlap, by their priorities", "two placed objects of solid glass have materials that state one"]),
        line(E::MotionBlur, Kernels, ["things that move while the shutter is open", "a placed object, its vertices or the camera that renders does"]),
        line(E::ShadowCatcher, Kernels, ["objects that show nothing but the shadows on them", "a placed object is one"]),
        line(E::RayPortals, Kernels, ["surfaces that send rays elsewhere", "a placed material has a Ray Portal BSDF"]),
        line(E::Strands, Kernels, ["hair and points", "a placed mesh is made of curves with a radius, or of spheres"]),
        line(E::HairShaders, Kernels, ["what fibres of hair do to light", "a placed material has a Hair BSDF or a Principled Hair BSDF"]),
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
        let (name, about, found, decided) =
            (row.effect.id(), row.about, row.found, row.decided.words());
        let left_out = match (sets::ALL - sets::STRUCTURE).contains(row.effect) {
            true => "yes",
            false => "no",
        };
        format!("| {name} | {about} | {found} | {decided} | {left_out} |\n")
    });
    head.chars()
        .chain(lines.flat_map(|line| line.chars().collect::<Vec<_>>()))
        .collect()
}

/// The line of an effect.
pub fn row(effect: Effect) -> &'static EffectRow {
    &TABLE[effect as usize]
}

#[cfg(test)]
#[path = "../../tests/unit/effects/table.rs"]
mod tests;
