//! Materials: metallic-roughness and the KHR_materials_* that are rendered.

use ::gltf::json;
use json::material::AlphaMode as Alpha;
use json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use super::container::Document;
use super::schema::{GlossyJson, SundogMaterial};
use super::textures::Images;
use super::{extensions, khr_surfaces, layers, medium};
use crate::import::{ImportError, ImportOptions, Transmission};
use crate::scene::graph::Distribution;
use crate::scene::{
    AlphaMode, Diagnostics, Effect, Medium, MetallicRoughness, NormalTexture, Subject, Verdict,
};

/// What a mesh without a material looks like, if it is not glTF's own default.
///
/// In Blender 4.5's Cycles that is a diffuse surface of albedo 0.8, in 5.0's the default Principled
/// BSDF (measured with `bpy` 4.5.15 and 5.0.1: a plane without a material, lit at a grazing angle,
/// has the same value to the last bit as one with a Diffuse BSDF of 0.8 and Principled BSDF).
/// Blender writes such meshes without a material, for which glTF would show white metal.
pub(super) fn without_material(document: &Document) -> Option<MetallicRoughness> {
    let version = document.blender_version()?;
    let grey = MetallicRoughness {
        name: "(no material)".into(),
        base_color: [0.8; 3],
        metallic: 0.0,
        double_sided: true,
        ..MetallicRoughness::default()
    };
    Some(if version < 5 {
        MetallicRoughness {
            roughness: 1.0,
            specular: 0.0,
            ..grey
        }
    } else {
        MetallicRoughness {
            roughness: 0.5,
            ..grey
        }
    })
}

/// Reads one material.
pub(super) fn load_material(
    document: &Document,
    index: usize,
    options: &ImportOptions,
    images: &mut Images,
    diagnostics: &mut Diagnostics,
) -> Result<MetallicRoughness, ImportError> {
    let Some(source) = document.core.materials.get(index) else {
        return Err(ImportError::malformed(
            &document.file,
            "a mesh",
            format!("it uses material {index}, which does not exist"),
        ));
    };
    let name = source
        .name
        .clone()
        .unwrap_or_else(|| format!("material {index}"));
    let owner = format!("material \"{name}\"");
    let malformed = |problem| ImportError::malformed(&document.file, owner.clone(), problem);
    let value = document.value.pointer(&format!("/materials/{index}"));
    let at = |pointer: &str| value.and_then(|v| v.pointer(pointer));
    let pbr = &source.pbr_metallic_roughness;

    let mut material = MetallicRoughness {
        name,
        double_sided: source.double_sided,
        rules: document.shader_rules(options.cycles),
        ..MetallicRoughness::default()
    };
    let known = source.extensions.as_ref();
    material.unlit = known.is_some_and(|e| e.unlit.is_some());
    let place = format!("/extensions/{}", khr_surfaces::SPECULAR_GLOSSINESS);
    // What is unlit shows the base colour.
    let glossy = at(&place).filter(|_| !material.unlit);
    if let Some(extension) = glossy {
        let m = &mut material;
        khr_surfaces::specular_glossiness(extension, &owner, m, images, diagnostics)
            .map_err(malformed)?;
    } else {
        let [r, g, b, a] = pbr.base_color_factor.0;
        material.base_color = [r, g, b];
        material.alpha = a;
        material.metallic = pbr.metallic_factor.0;
        material.roughness = pbr.roughness_factor.0;
    }
    material.base_color = legal_factor(material.base_color, &material.name, diagnostics);
    let mut texture = |info: &Option<json::texture::Info>,
                       pointer: &str,
                       diagnostics: &mut Diagnostics| match info {
        Some(info) => images.texture(info, at(pointer), &owner, diagnostics),
        None => Ok(None),
    };
    if glossy.is_none() {
        material.base_color_texture = texture(
            &pbr.base_color_texture,
            "/pbrMetallicRoughness/baseColorTexture",
            diagnostics,
        )?;
        material.metallic_roughness_texture = texture(
            &pbr.metallic_roughness_texture,
            "/pbrMetallicRoughness/metallicRoughnessTexture",
            diagnostics,
        )?;
    }
    material.emission = source.emissive_factor.0;
    material.emission_texture = texture(&source.emissive_texture, "/emissiveTexture", diagnostics)?;
    set_emission_strength(source, &mut material);
    let plain = known.filter(|_| glossy.is_none());
    if let Some(ior) = plain.and_then(|e| e.ior.as_ref()) {
        // "Valid values are 0 and what is at least 1": 0 stands for a reflectance of 1.
        let index = ior.ior.0;
        material.ior = if index == 0.0 { 1e4 } else { index.max(1.0) };
    }
    if let Some(specular) = plain.and_then(|e| e.specular.as_ref()) {
        let base = "/extensions/KHR_materials_specular";
        material.specular_texture = texture(
            &specular.specular_texture,
            &format!("{base}/specularTexture"),
            diagnostics,
        )?;
        material.specular_color_texture = texture(
            &specular.specular_color_texture,
            &format!("{base}/specularColorTexture"),
            diagnostics,
        )?;
        set_specular(specular, &mut material);
    }
    if let Some(transmission) = known.and_then(|e| e.transmission.as_ref()) {
        let base = "/extensions/KHR_materials_transmission";
        material.transmission = transmission.transmission_factor.0;
        if material.transmission != 0.0 {
            let (info, pointer) = (
                &transmission.transmission_texture,
                format!("{base}/transmissionTexture"),
            );
            material.transmission_texture = texture(info, &pointer, diagnostics)?;
        }
    }
    if let Some(normal) = &source.normal_texture {
        let (image, set) = (normal.index.value(), normal.tex_coord);
        let found = images.texture_at(image, set, at("/normalTexture"), &owner, diagnostics)?;
        let scale = normal.scale;
        material.normal_texture = found.map(|texture| NormalTexture { texture, scale });
    }
    if source.occlusion_texture.is_some() {
        diagnostics.report(
            "occlusion",
            Verdict::Exact,
            "occlusion textures",
            &owner,
            "ignored: a path tracer finds the shadows that they stand for",
        );
    }
    material.alpha_mode = alpha_mode(document, source, &owner)?;
    let said = at("/extensions/SUNDOG_material/thin_walled").is_some();
    volume(
        document,
        known,
        options,
        &owner,
        said,
        &mut material,
        diagnostics,
    );
    if let Some(scatter) = at("/extensions/KHR_materials_volume_scatter") {
        volume_scatter(scatter, options, &owner, &mut material, diagnostics);
    }
    if let Some(extension) = at("/extensions/SUNDOG_material") {
        let extension = SundogMaterial::deserialize(extension).map_err(|problem| {
            malformed(format!("its SUNDOG_material cannot be read: {problem}"))
        })?;
        apply_sundog(&extension, options, &owner, &mut material, diagnostics);
    }
    layers::read_khr(&at, &owner, &mut material, images, diagnostics).map_err(malformed)?;
    let m = &mut material;
    khr_surfaces::read_khr(&at, (&owner, glossy.is_some()), m, images, diagnostics)
        .map_err(malformed)?;
    report_unrendered(at("/extensions"), &material.name, diagnostics);
    for name in khr_surfaces::NOT_BESIDE {
        if glossy.is_some() && at(&format!("/extensions/{name}")).is_some() {
            khr_surfaces::report_beside(name, &owner, diagnostics);
        }
    }
    Ok(material)
}

/// Nothing shines without a strength, nor without the texture that says where.
fn set_emission_strength(source: &json::Material, material: &mut MetallicRoughness) {
    if source.emissive_texture.is_some() && material.emission_texture.is_none() {
        material.emission = [0.0; 3];
    }
    if let Some(strength) = source
        .extensions
        .as_ref()
        .and_then(|e| e.emissive_strength.as_ref())
    {
        material.emission = material.emission.map(|c| c * strength.emissive_strength.0);
    }
    if material.emission == [0.0; 3] {
        material.emission_texture = None;
    }
}

/// Takes over the factors of KHR_materials_specular.
///
/// Where Blender's specular level is above 1/2, its exporter leaves the factor at 1 and writes the level into the colour. A
/// factor says the same of the reflectance at normal incidence, and it is what changes the curve above that, as the level
/// does in Blender.
fn set_specular(specular: &json::extensions::material::Specular, material: &mut MetallicRoughness) {
    material.specular = specular.specular_factor.0;
    material.specular_color = specular.specular_color_factor.0;
    let brightest = material.specular_color.into_iter().fold(0.0, f32::max);
    if brightest > 1.0
        && brightest.is_finite()
        && material.specular == 1.0
        && material.specular_color_texture.is_none()
    {
        material.specular = brightest;
        material.specular_color = material.specular_color.map(|c| c / brightest);
    }
}

fn alpha_mode(
    document: &Document,
    source: &json::Material,
    owner: &str,
) -> Result<AlphaMode, ImportError> {
    Ok(match source.alpha_mode {
        Checked::Valid(Alpha::Mask) => AlphaMode::Mask {
            cutoff: source.alpha_cutoff.map_or(0.5, |c| c.0),
        },
        Checked::Valid(Alpha::Blend) => AlphaMode::Blend,
        Checked::Valid(Alpha::Opaque) => AlphaMode::Opaque,
        Checked::Invalid => {
            return Err(ImportError::malformed(
                &document.file,
                owner,
                "its alphaMode is none that glTF knows",
            ));
        }
    })
}

/// glTF's own factor ends at 1; only SUNDOG_material goes beyond. Not-a-numbers are left to `scene::validate`.
fn legal_factor(factor: [f32; 3], name: &str, diagnostics: &mut Diagnostics) -> [f32; 3] {
    let legal = factor.map(|c| if c > 1.0 { 1.0 } else { c });
    if factor.iter().any(|&c| c > 1.0) {
        diagnostics.report(
            "material-range",
            Verdict::Approximated,
            "base colour above 1",
            name,
            "1 is used, the largest that glTF allows",
        );
    }
    legal
}

/// Inputs of Blender's Principled BSDF that are not rendered yet, and what is shown in their place.
const UNRENDERED: [(&str, Effect, &str, &str); 1] = [(
    "subsurface",
    Effect::Subsurface,
    "subsurface scattering",
    "rendered as a diffuse surface",
)];

/// What the extension says wins over what glTF itself can say.
fn apply_sundog(
    extension: &SundogMaterial,
    options: &ImportOptions,
    owner: &str,
    material: &mut MetallicRoughness,
    diagnostics: &mut Diagnostics,
) {
    if let Some(color) = extension.base_color {
        material.base_color = color;
    }
    if let Some(specular) = extension.specular {
        material.specular = specular;
    }
    if let Some(roughness) = extension.diffuse_roughness {
        material.diffuse_roughness = roughness;
    }
    material.glossy = extension.glossy.map(|facets| match facets {
        GlossyJson::Ggx => Distribution::Ggx,
        GlossyJson::MultiscatterGgx => Distribution::MultiscatterGgx,
    });
    material.edge_tint = extension.edge_tint.unwrap_or(false);
    material.anisotropy = extension
        .anisotropy
        .as_ref()
        .map(layers::blender_anisotropy);
    let rules = material.rules;
    let simple = |bsdf| Box::new(layers::simple((bsdf, rules), owner, diagnostics));
    material.simple = extension.bsdf.as_ref().map(simple);
    material.coat = extension.coat.as_ref().map(layers::blender_coat);
    material.thin_film = extension.thin_film.as_ref().map(|f| [f.thickness, f.ior]);
    if let Some(volume) = &extension.volume {
        material.medium = Some(medium::read(volume, owner, diagnostics));
    }
    material.priority = extension.priority;
    material.sheen = extension.sheen.as_ref().map(layers::blender_sheen);
    if let Some(color) = extension.transparent_color {
        material.transparent_color = color;
    }
    // A user's choice is for what files leave open.
    if let Some(thin) = extension.thin_walled
        && options.transmission == Transmission::Auto
    {
        material.thin_walled = thin;
    }
    let mut unknown = extension.unknown.clone();
    for (key, effect, what, instead) in UNRENDERED {
        if unknown.remove(key).is_some() {
            diagnostics.report_effect(
                effect,
                "unsupported-material",
                Verdict::Lost,
                what,
                Subject::Material(material.name.clone()),
                instead,
            );
        }
    }
    extensions::report_properties("SUNDOG_material", &unknown, owner, diagnostics);
}

/// Decides between solid and thin transmission (unless it is `said` elsewhere), and reads what fills the solid.
fn volume(
    document: &Document,
    known: Option<&json::extensions::material::Material>,
    options: &ImportOptions,
    owner: &str,
    said: bool,
    material: &mut MetallicRoughness,
    diagnostics: &mut Diagnostics,
) {
    if material.transmission <= 0.0 {
        return;
    }
    let volume = known.and_then(|e| e.volume.as_ref());
    let thick = volume.is_some_and(|v| v.thickness_factor.0 > 0.0);
    material.thin_walled = match options.transmission {
        Transmission::Solid => false,
        Transmission::Thin => true,
        Transmission::Auto if thick => false,
        Transmission::Auto if said => material.thin_walled,
        Transmission::Auto if document.blender_version().is_some() => {
            diagnostics.report(
                "solid-transmission",
                Verdict::Exact,
                "transmission without a volume in a file from Blender",
                owner,
                "rendered as a solid, as Cycles does; glTF itself would mean a thin sheet",
            );
            false
        }
        Transmission::Auto => true,
    };
    if let Some(volume) = volume
        && thick
        && volume.attenuation_distance.0.is_finite()
        && volume.attenuation_color.0.iter().any(|&c| c != 1.0)
    {
        let medium = Medium::absorbing(volume.attenuation_color.0, volume.attenuation_distance.0);
        material.medium = Some(medium);
    }
}

/// Reads how the inside scatters, as far as the draft of KHR_materials_volume_scatter goes: by the colour that a thick one gives back
/// ("multiscatterColor" in older files) and the mean cosine.
fn volume_scatter(
    scatter: &Value,
    options: &ImportOptions,
    owner: &str,
    material: &mut MetallicRoughness,
    diagnostics: &mut Diagnostics,
) {
    const NAME: &str = "KHR_materials_volume_scatter";
    if !options.scatter {
        let instead =
            "the inside does not scatter; --gltf-scatter reads the draft of the extension";
        let (code, verdict) = ("unsupported-material", Verdict::Lost);
        diagnostics.report_effect(Effect::Media, code, verdict, NAME, owner, instead);
        return;
    }
    let key = ["multiscatterColorFactor", "multiscatterColor"];
    let given = key.iter().find_map(|key| scatter.get(*key)?.as_array());
    let channel = |i: usize| given.and_then(|given| given.get(i)?.as_f64());
    let color = [0, 1, 2].map(|i| channel(i).unwrap_or(0.0) as f32);
    let g = scatter.get("scatterAnisotropy").and_then(Value::as_f64);
    let g = (g.unwrap_or(0.0) as f32).clamp(-0.999, 0.999);
    if scatter.get("multiscatterColorTexture").is_some() {
        let instead = "the inside is the same everywhere, by the factor";
        let (code, verdict) = ("scatter-texture", Verdict::Lost);
        let what = "multiscatterColorTexture";
        diagnostics.report_effect(Effect::Media, code, verdict, what, owner, instead);
    }
    if let Some(medium) = material.medium.take() {
        material.medium = Some(medium.scattering_back(color, g));
    }
}

fn report_unrendered(extensions: Option<&Value>, material: &str, diagnostics: &mut Diagnostics) {
    let Some(Value::Object(extensions)) = extensions else {
        return;
    };
    for name in extensions.keys() {
        match name.as_str() {
            "KHR_materials_anisotropy"
            | "KHR_materials_clearcoat"
            | "KHR_materials_diffuse_transmission"
            | "KHR_materials_dispersion"
            | "KHR_materials_iridescence"
            | "KHR_materials_pbrSpecularGlossiness"
            | "KHR_materials_sheen"
            | "KHR_materials_emissive_strength"
            | "KHR_materials_ior"
            | "KHR_materials_specular"
            | "KHR_materials_transmission"
            | "KHR_materials_unlit"
            | "KHR_materials_volume"
            | "KHR_materials_volume_scatter"
            | "SUNDOG_material"
            | "SUNDOG_shader_graph" => {}
            _ => extensions::report_material(name, material, diagnostics),
        }
    }
}
