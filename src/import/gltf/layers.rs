//! Anisotropy and the layers of materials, from the KHR_materials_* that the `gltf` crate does not read.

use ::gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::schema::{AnisotropyJson, TangentJson};
use super::textures::Images;
use crate::scene::graph::TangentKind;
use crate::scene::{Anisotropy, Diagnostics, Effect, MetallicRoughness, Subject, Texture, Verdict};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct AnisotropyKhr {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<Value>,
}

impl Default for AnisotropyKhr {
    fn default() -> Self {
        Self {
            anisotropy_strength: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
        }
    }
}

fn read<T: DeserializeOwned>(value: &Value, name: &str) -> Result<T, String> {
    T::deserialize(value).map_err(|problem| format!("its {name} cannot be read: {problem}"))
}

fn texture(
    value: Option<&Value>,
    owner: &str,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Texture>, String> {
    let Some(value) = value else {
        return Ok(None);
    };
    let info: Info = read(value, "texture")?;
    images
        .texture(&info, Some(value), owner, diagnostics)
        .map_err(|error| error.to_string())
}

/// KHR_materials_anisotropy, if it has a strength.
pub(super) fn anisotropy(
    extension: &Value,
    owner: &str,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Anisotropy>, String> {
    let khr: AnisotropyKhr = read(extension, "KHR_materials_anisotropy")?;
    if khr.anisotropy_strength == 0.0 {
        return Ok(None);
    }
    let texture = texture(khr.anisotropy_texture.as_ref(), owner, images, diagnostics)?;
    Ok(Some(Anisotropy::Gltf {
        strength: khr.anisotropy_strength,
        rotation: khr.anisotropy_rotation,
        texture,
    }))
}

/// What SUNDOG_material says of it.
pub(super) fn blender_anisotropy(json: &AnisotropyJson) -> Anisotropy {
    Anisotropy::Blender {
        strength: json.strength,
        rotation: json.rotation,
        tangent: match json.tangent {
            TangentJson::Radial => TangentKind::Radial,
            TangentJson::Uv => TangentKind::Uv,
        },
        uv_set: json.uv_set,
    }
}

/// Highlights more than ten times as long as wide are rendered as those.
pub(super) fn report_anisotropy(material: &MetallicRoughness, diagnostics: &mut Diagnostics) {
    let Some(Anisotropy::Gltf { strength, .. }) = material.anisotropy else {
        return;
    };
    let alpha = material.roughness * material.roughness;
    if alpha < 0.1 * (alpha + (1.0 - alpha) * strength * strength) {
        diagnostics.report_effect(
            Effect::Anisotropy,
            "long-highlights",
            Verdict::Approximated,
            "anisotropy of more than ten to one",
            Subject::Material(material.name.clone()),
            "rendered with ten to one",
        );
    }
}
