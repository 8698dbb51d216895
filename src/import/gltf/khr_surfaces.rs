//! Specular and glossiness, thin films, dispersion and diffuse transmission, from the KHR_materials_* that the `gltf` crate does not read.

use serde::Deserialize;
use serde_json::Value;

use super::layers::{read, texture};
use super::textures::Images;
use crate::scene::{Diagnostics, DiffuseTransmission, Iridescence, MetallicRoughness, Verdict};

/// The name of the extension that takes the place of metallic and roughness.
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// What the format does not allow beside it.
pub(super) const NOT_BESIDE: [&str; 3] = [
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_iridescence",
];

/// The index of refraction of a reflection whose colour is said: its curve is within 0.04 of Schlick's, which the extension
/// has. The colour is a multiple of its reflectance at normal incidence, 0.04.
const INDEX: f32 = 1.5;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct SpecularGlossinessKhr {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<Value>,
    specular_factor: [f32; 3],
    glossiness_factor: f32,
    specular_glossiness_texture: Option<Value>,
}

impl Default for SpecularGlossinessKhr {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct IridescenceKhr {
    iridescence_factor: f32,
    iridescence_texture: Option<Value>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    iridescence_thickness_texture: Option<Value>,
}

impl Default for IridescenceKhr {
    fn default() -> Self {
        Self {
            iridescence_factor: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct DispersionKhr {
    dispersion: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct DiffuseTransmissionKhr {
    diffuse_transmission_factor: f32,
    diffuse_transmission_texture: Option<Value>,
    diffuse_transmission_color_factor: [f32; 3],
    diffuse_transmission_color_texture: Option<Value>,
}

impl Default for DiffuseTransmissionKhr {
    fn default() -> Self {
        Self {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

/// KHR_materials_pbrSpecularGlossiness in the place of metallic and roughness: a dielectric whose reflection has the specular
/// colour at normal incidence. What it leaves is the diffuse base's, as the (1 − max(specular)) of the extension means.
pub(super) fn specular_glossiness(
    extension: &Value,
    owner: &str,
    material: &mut MetallicRoughness,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<(), String> {
    let khr: SpecularGlossinessKhr = read(extension, SPECULAR_GLOSSINESS)?;
    let mut texture = |value: &Option<Value>| texture(value.as_ref(), owner, images, diagnostics);
    let [r, g, b, alpha] = khr.diffuse_factor;
    material.base_color = [r, g, b];
    material.alpha = alpha;
    material.base_color_texture = texture(&khr.diffuse_texture)?;
    material.metallic = 0.0;
    material.roughness = 1.0 - khr.glossiness_factor;
    material.ior = INDEX;
    let reflectance = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    material.specular_color = khr.specular_factor.map(|c| c / reflectance);
    material.specular_color_texture = texture(&khr.specular_glossiness_texture)?;
    let is_textured = material.specular_color_texture.is_some();
    material.glossiness = is_textured.then_some(khr.glossiness_factor);
    Ok(())
}

/// Tells of an extension that must not stand beside specular and glossiness.
pub(super) fn report_beside(name: &str, owner: &str, diagnostics: &mut Diagnostics) {
    diagnostics.report(
        "beside-specular-glossiness",
        Verdict::Approximated,
        format!("{name} beside {SPECULAR_GLOSSINESS}"),
        owner,
        "left out: the format does not allow both",
    );
}

/// What of a surface SUNDOG_material does not tell of. `glossy`: it is of specular and glossiness.
pub(super) fn read_khr<'v>(
    at: &dyn Fn(&str) -> Option<&'v Value>,
    (owner, glossy): (&str, bool),
    material: &mut MetallicRoughness,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<(), String> {
    // What is unlit has neither.
    if material.unlit {
        return Ok(());
    }
    if material.thin_film.is_none()
        && !glossy
        && let Some(extension) = at("/extensions/KHR_materials_iridescence")
    {
        material.iridescence = iridescence(extension, owner, images, diagnostics)?;
    }
    if let Some(extension) = at("/extensions/KHR_materials_dispersion") {
        let khr: DispersionKhr = read(extension, "KHR_materials_dispersion")?;
        material.dispersion = khr.dispersion;
    }
    if let Some(extension) = at("/extensions/KHR_materials_diffuse_transmission") {
        material.diffuse_transmission =
            diffuse_transmission(extension, owner, images, diagnostics)?;
    }
    Ok(())
}

fn iridescence(
    extension: &Value,
    owner: &str,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Box<Iridescence>>, String> {
    let khr: IridescenceKhr = read(extension, "KHR_materials_iridescence")?;
    if khr.iridescence_factor <= 0.0 {
        return Ok(None);
    }
    let mut texture = |value: &Option<Value>| texture(value.as_ref(), owner, images, diagnostics);
    Ok(Some(Box::new(Iridescence {
        factor: khr.iridescence_factor,
        texture: texture(&khr.iridescence_texture)?,
        ior: khr.iridescence_ior,
        thickness: [
            khr.iridescence_thickness_minimum,
            khr.iridescence_thickness_maximum,
        ],
        thickness_texture: texture(&khr.iridescence_thickness_texture)?,
    })))
}

fn diffuse_transmission(
    extension: &Value,
    owner: &str,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<Option<Box<DiffuseTransmission>>, String> {
    let khr: DiffuseTransmissionKhr = read(extension, "KHR_materials_diffuse_transmission")?;
    if khr.diffuse_transmission_factor <= 0.0 {
        return Ok(None);
    }
    let mut texture = |value: &Option<Value>| texture(value.as_ref(), owner, images, diagnostics);
    Ok(Some(Box::new(DiffuseTransmission {
        factor: khr.diffuse_transmission_factor,
        texture: texture(&khr.diffuse_transmission_texture)?,
        color: khr.diffuse_transmission_color_factor,
        color_texture: texture(&khr.diffuse_transmission_color_texture)?,
    })))
}
