//! What there is in a scene to be looked at, and so why an effect is not called for.

use super::table::{Decided, row};
use crate::math::words;
use crate::scene::{Effect, Projection, Scene};

/// How many there are of what effects come from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Census {
    /// Materials of placed meshes.
    pub materials: usize,
    /// … which transmit or let light pass by their opacity.
    pub see_through: [usize; 2],
    /// Placed meshes with triangles.
    pub meshes: usize,
    /// What is placed.
    pub objects: usize,
    /// Lights of any kind.
    pub lights: usize,
    /// Lamps and emissive triangles.
    pub emitters: u64,
    /// Whether there is light from all around.
    pub environment: bool,
    /// The camera's kind.
    pub camera: &'static str,
}

fn all(count: usize, thing: &str) -> String {
    match count {
        0 => format!("there is no {thing}"),
        1 => format!("of the only {thing}"),
        n => format!("of all {n} {thing}s"),
    }
}

fn in_all(count: usize, thing: &str) -> String {
    match count {
        0 => format!("as there is no {thing}"),
        1 => format!("in the only {thing}"),
        n => format!("in all {}", counted(n, thing)),
    }
}

fn counted(n: usize, thing: &str) -> String {
    let many = match thing {
        "mesh" => "meshes".into(),
        _ => format!("{thing}s"),
    };
    words::counted(n, thing, &many)
}

/// The camera's kind.
pub fn camera(scene: &Scene, number: usize) -> &'static str {
    match scene.cameras.get(number).map(|camera| camera.projection) {
        None => "missing",
        Some(Projection::Perspective { .. }) => "perspective",
        Some(Projection::Orthographic { .. }) => "orthographic",
        Some(Projection::Equirectangular { .. } | Projection::Panorama { .. }) => "a panorama",
    }
}

impl Census {
    /// Why an effect is not called for: one clause.
    pub fn reason(&self, effect: Effect) -> String {
        let materials = |what: &str| format!("{what} {}", in_all(self.materials, "material"));
        let meshes = |what: &str| format!("{what} {}", in_all(self.meshes, "mesh"));
        match effect {
            Effect::BaseColorTexture
            | Effect::MetallicRoughnessTexture
            | Effect::EmissionTexture
            | Effect::SpecularTexture
            | Effect::SpecularColorTexture
            | Effect::TransmissionTexture
            | Effect::NormalMaps => materials("none"),
            Effect::VertexColors | Effect::SmoothNormals => meshes("none"),
            Effect::AlphaBlend | Effect::AlphaClip => match self.see_through[1] {
                0 => materials("opacity 1 or ignored"),
                _ => "opacity works the other way where it is below 1".into(),
            },
            Effect::Diffuse => materials("no such share"),
            Effect::Gloss => materials("no reflection"),
            Effect::Metal => materials("metallic 0"),
            Effect::ClearGlass | Effect::RoughGlass | Effect::ThinGlass => {
                match self.see_through[0] {
                    0 => materials("transmission 0"),
                    n => format!("none among {}", counted(n, "transmitting material")),
                }
            }
            Effect::Unlit => materials("lit"),
            Effect::PointLights | Effect::SpotLights | Effect::AreaLights | Effect::Suns => {
                format!("none among {}", counted(self.lights, "light"))
            }
            Effect::MeshLights => materials("emission 0"),
            Effect::ConstantEnvironment if self.environment => "the world has an image".into(),
            Effect::ImageEnvironment if self.environment => "the world has one colour".into(),
            Effect::ConstantEnvironment | Effect::ImageEnvironment => "the world is black".into(),
            Effect::LightTree => match self.emitters {
                0 => "there is no lamp and no emissive triangle".into(),
                _ => "there is but one lamp or emissive triangle".into(),
            },
            Effect::Instances => meshes("one place"),
            Effect::Strands => meshes("triangles"),
            Effect::RayVisibility => "all rays see all objects and lights that any sees".into(),
            Effect::LightLinking => {
                "all lights light all objects, and all objects cast shadows".into()
            }
            Effect::Holdouts => format!("none {}", all(self.objects, "object")),
            Effect::ShadowTerminators => "no object has a Shading Offset".into(),
            Effect::CoincidentFaces => "no face lies on another in one plane".into(),
            Effect::DepthOfField => "the camera that renders has no aperture".into(),
            Effect::OrthographicCamera | Effect::PanoramaCamera => {
                format!("the camera that renders is {}", self.camera)
            }
            Effect::Coat
            | Effect::Sheen
            | Effect::ThinFilm
            | Effect::Subsurface
            | Effect::DiffuseTransmission
            | Effect::Dispersion => materials("weight 0"),
            Effect::RayPortals | Effect::HairShaders => materials("none"),
            Effect::DiffuseRoughness => materials("smooth"),
            Effect::Anisotropy => materials("the same spread all around"),
            effect if super::sets::PROCEDURAL_TEXTURES.contains(effect) => {
                materials("no such pattern")
            }
            Effect::Absorption => "nothing is filled".into(),
            Effect::Media => "there is none in the file".into(),
            Effect::NestedDielectrics => "no two solids state priorities".into(),
            Effect::FastGi => "all bounces are traced".into(),
            Effect::MotionBlur => "nothing moves in the file".into(),
            Effect::ShadowCatcher => format!("none {}", all(self.objects, "object")),
            _ => match row(effect).decided {
                Decided::Settings | Decided::Branch => "not asked for".into(),
                _ => "not called for".into(),
            },
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/effects/census.rs"]
mod tests;
