//! Effects: everything that a scene may do without, rendered or not.

use enumset::EnumSetType;
use serde::Serialize;
use strum::{EnumCount, EnumString, IntoStaticStr};

/// What a scene or the settings may call for; its id is its name in kebab case.
#[derive(
    Debug, Hash, PartialOrd, Ord, Serialize, EnumSetType, EnumCount, EnumString, IntoStaticStr,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
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
    RayVisibility,
    /// Lights that light some objects, or of which some cast shadows.
    LightLinking,
    /// Objects that cut holes into the picture.
    Holdouts,
    /// Surfaces on which light that grazes them counts less.
    ShadowTerminators,
    /// Faces in one plane that lie on each other.
    CoincidentFaces,
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
    /// What stands for indirect light.
    FastGi,
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
    /// Noise textures.
    NoiseTexture,
    /// Voronoi textures.
    VoronoiTexture,
    /// Wave textures.
    WaveTexture,
    /// Magic textures.
    MagicTexture,
    /// Brick textures.
    BrickTexture,
    /// Checker textures.
    CheckerTexture,
    /// Gradient textures.
    GradientTexture,
    /// White Noise textures.
    WhiteNoiseTexture,
    /// Gabor textures.
    GaborTexture,
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
    /// Solids that overlap, by priorities.
    NestedDielectrics,
    /// Things that move while the shutter is open.
    MotionBlur,
    /// Objects that show nothing but shadows on them.
    ShadowCatcher,
    /// Surfaces that send rays elsewhere.
    RayPortals,
    /// Hair, and points.
    Strands,
    /// What fibres do to light.
    HairShaders,
}

impl Effect {
    /// As the user calls it: `rough-glass`.
    pub fn id(self) -> &'static str {
        self.into()
    }
}

impl std::fmt::Display for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.id())
    }
}

#[cfg(test)]
#[path = "../../tests/unit/scene/effect.rs"]
mod tests;
