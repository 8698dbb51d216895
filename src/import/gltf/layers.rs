//! Anisotropy and the layers of materials, from the KHR_materials_* that the `gltf` crate does not read.

use ::gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::extensions::report_property;
use super::schema::{AnisotropyJson, BsdfJson, BsdfKindJson, CoatJson, SheenJson, TangentJson};
use super::textures::Images;
use super::words;
use crate::scene::graph::{
    Distribution, Input, Node, NodeKind, ShaderRules, SimpleBsdf, SocketKind, TangentKind,
};
use crate::scene::{
    Anisotropy, Coat, CoatNormal, Diagnostics, Effect, MetallicRoughness, NormalTexture, Sheen,
    Subject, Texture, Verdict,
};

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

pub(super) fn read<T: DeserializeOwned>(value: &Value, name: &str) -> Result<T, String> {
    T::deserialize(value)
        .map_err(|problem| format!("its {name} cannot be read: {}", words::plain(&problem)))
}

pub(super) fn texture(
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
fn anisotropy(
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

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct ClearcoatKhr {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Value>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Value>,
    clearcoat_normal_texture: Option<Value>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct SheenKhr {
    sheen_color_factor: [f32; 3],
    sheen_color_texture: Option<Value>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<Value>,
}

/// Reads the layers that SUNDOG_material does not tell of.
pub(super) fn read_khr<'v>(
    at: &dyn Fn(&str) -> Option<&'v Value>,
    owner: &str,
    material: &mut MetallicRoughness,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<(), String> {
    if material.anisotropy.is_none()
        && let Some(extension) = at("/extensions/KHR_materials_anisotropy")
    {
        material.anisotropy = anisotropy(extension, owner, images, diagnostics)?;
        report_anisotropy(material, diagnostics);
    }
    if material.coat.is_none()
        && let Some(extension) = at("/extensions/KHR_materials_clearcoat")
    {
        material.coat = clearcoat(extension, owner, images, diagnostics)?;
    }
    if material.sheen.is_none()
        && let Some(extension) = at("/extensions/KHR_materials_sheen")
    {
        let name = &material.name;
        material.sheen = sheen(extension, (owner, name), images, diagnostics)?;
    }
    Ok(())
}

fn clearcoat(
    extension: &Value,
    owner: &str,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Box<Coat>>, String> {
    let khr: ClearcoatKhr = read(extension, "KHR_materials_clearcoat")?;
    if khr.clearcoat_factor <= 0.0 {
        return Ok(None);
    }
    let mut texture = |value: &Option<Value>| texture(value.as_ref(), owner, images, diagnostics);
    let scale = |value: &Value| value.get("scale").and_then(Value::as_f64).unwrap_or(1.0) as f32;
    let map = texture(&khr.clearcoat_normal_texture)?.zip(khr.clearcoat_normal_texture.as_ref());
    Ok(Some(Box::new(Coat {
        weight: khr.clearcoat_factor,
        texture: texture(&khr.clearcoat_texture)?,
        roughness: khr.clearcoat_roughness_factor,
        roughness_texture: texture(&khr.clearcoat_roughness_texture)?,
        ior: 1.5,
        tint: [1.0; 3],
        normal: match map {
            Some((texture, value)) => CoatNormal::Map(NormalTexture {
                texture,
                scale: scale(value),
            }),
            None => CoatNormal::Smooth,
        },
    })))
}

fn sheen(
    extension: &Value,
    (owner, name): (&str, &str),
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Box<Sheen>>, String> {
    let khr: SheenKhr = read(extension, "KHR_materials_sheen")?;
    if khr.sheen_color_factor.iter().all(|&c| c <= 0.0) {
        return Ok(None);
    }
    diagnostics.report_effect(
        Effect::Sheen,
        "charlie-sheen",
        Verdict::Approximated,
        "KHR_materials_sheen",
        Subject::Material(name.into()),
        "rendered as Blender's sheen of the same colour and roughness",
    );
    let mut texture = |value: &Option<Value>| texture(value.as_ref(), owner, images, diagnostics);
    Ok(Some(Box::new(Sheen {
        color: khr.sheen_color_factor,
        color_texture: texture(&khr.sheen_color_texture)?,
        roughness: khr.sheen_roughness_factor,
        roughness_texture: texture(&khr.sheen_roughness_texture)?,
    })))
}

/// A shader of one lobe with what stands in its sockets.
pub(super) fn simple(
    (json, rules): (&BsdfJson, ShaderRules),
    owner: &str,
    diagnostics: &mut Diagnostics,
) -> Node {
    let distribution = if json.multiscatter {
        Distribution::MultiscatterGgx
    } else {
        Distribution::Ggx
    };
    let metallic = |conductor| SimpleBsdf::Metallic {
        conductor,
        distribution,
    };
    let mut node = Node::new(NodeKind::Bsdf(match json.kind {
        BsdfKindJson::Translucent => SimpleBsdf::Translucent,
        BsdfKindJson::Refraction => SimpleBsdf::Refraction { distribution },
        BsdfKindJson::Glass => SimpleBsdf::Glass {
            distribution,
            rules,
        },
        BsdfKindJson::Metallic => metallic(false),
        BsdfKindJson::Conductor => metallic(true),
        BsdfKindJson::Sheen => SimpleBsdf::Sheen { velvet: false },
        BsdfKindJson::DiffuseToon => SimpleBsdf::Toon { glossy: false },
        BsdfKindJson::GlossyToon => SimpleBsdf::Toon { glossy: true },
    }));
    for (name, value) in &json.inputs {
        let mut sockets = node.kind.sockets().iter();
        let socket = sockets.position(|s| s.name == name && s.kind != SocketKind::Vector);
        let color = <[f32; 3]>::deserialize(value).map(Input::Value);
        let input = color.or_else(|_| f32::deserialize(value).map(Input::float));
        match (socket, input) {
            (Some(socket), Ok(input)) => node.inputs[socket] = input,
            _ => report_property(diagnostics, "SUNDOG_material", name, owner),
        }
    }
    node
}

/// What SUNDOG_material says of a coat.
pub(super) fn blender_coat(json: &CoatJson) -> Box<Coat> {
    Box::new(Coat {
        weight: json.weight,
        texture: None,
        roughness: json.roughness,
        roughness_texture: None,
        ior: json.ior.unwrap_or(1.5),
        tint: json.tint,
        normal: CoatNormal::OfBase,
    })
}

/// What SUNDOG_material says of a sheen.
pub(super) fn blender_sheen(json: &SheenJson) -> Box<Sheen> {
    Box::new(Sheen {
        color: json.tint.map(|c| c * json.weight),
        color_texture: None,
        roughness: json.roughness,
        roughness_texture: None,
    })
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
fn report_anisotropy(material: &MetallicRoughness, diagnostics: &mut Diagnostics) {
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
