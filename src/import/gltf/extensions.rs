//! Which extensions are understood, and what is said about the others.

use serde_json::Value;

use super::container::Document;
use crate::import::ImportError;
use crate::scene::{Diagnostics, Effect, Subject, Verdict};

/// What a file may demand (`extensionsRequired`) without being refused.
///
/// The KHR_materials_* that are not rendered are allowed too: the picture is near to the one meant,
/// and a diagnostic says what is missing. Extensions that change where the data lie are not.
fn may_be_required(name: &str) -> bool {
    name.starts_with("KHR_materials_")
        || matches!(
            name,
            "KHR_lights_punctual"
                | "KHR_texture_transform"
                | "KHR_mesh_quantization"
                | "KHR_draco_mesh_compression"
                | "EXT_meshopt_compression"
                | "KHR_meshopt_compression"
                | "EXT_mesh_gpu_instancing"
                | "EXT_texture_webp"
                | "KHR_texture_basisu"
                | "KHR_node_visibility"
                | "KHR_animation_pointer"
                | "KHR_xmp"
                | "KHR_xmp_json_ld"
                | "SUNDOG_light"
                | "SUNDOG_object"
                | "SUNDOG_scene"
                | "SUNDOG_camera"
                | "SUNDOG_material"
                | "SUNDOG_mesh"
                | "SUNDOG_shader_graph"
                | "SUNDOG_sampler"
        )
}

/// Refuses a file that cannot be understood, with the way out.
pub(super) fn check_required(document: &Document) -> Result<(), ImportError> {
    for name in &document.graph.extensions_required {
        if may_be_required(name) {
            continue;
        }
        let remedy = match name.as_str() {
            "EXT_texture_avif" | "MSFT_texture_dds" => {
                "get or make a copy of the file with PNG, JPEG, WebP or KTX2 textures"
            }
            _ => {
                "get a copy of the file without it, or open the file in a program that has it and export it from there"
            }
        };
        return Err(ImportError::Unsupported {
            file: document.file.clone(),
            extension: name.clone(),
            remedy: remedy.into(),
        });
    }
    Ok(())
}

/// An extension that nobody here knows.
pub(super) fn report_unknown(diagnostics: &mut Diagnostics, name: &str, owner: impl Into<Subject>) {
    diagnostics.report(
        "unknown-extension",
        Verdict::Lost,
        name,
        owner,
        "not supported; left out",
    );
}

/// Reports a property of one of Sundog's own extensions that this version does not know.
pub(super) fn report_property(
    diagnostics: &mut Diagnostics,
    extension: &str,
    name: &str,
    owner: &str,
) {
    diagnostics.report(
        "unknown-property",
        Verdict::Lost,
        format!("\"{name}\" of {extension}"),
        owner,
        "not supported; left out",
    );
}

/// Reports all properties of one of Sundog's own extensions that this version does not know.
pub(super) fn report_properties(
    extension: &str,
    unknown: &serde_json::Map<String, Value>,
    owner: &str,
    diagnostics: &mut Diagnostics,
) {
    for name in unknown.keys() {
        report_property(diagnostics, extension, name, owner);
    }
}

/// Reports the extensions of an object (a JSON pointer such as `/nodes/3`) that `handled` does not
/// name. Extensions of materials have their own table, see [`report_material`].
pub(super) fn report_others(
    document: &Document,
    pointer: &str,
    owner: &str,
    handled: &[&str],
    diagnostics: &mut Diagnostics,
) {
    let Some(Value::Object(extensions)) = document
        .value
        .pointer(pointer)
        .and_then(|o| o.get("extensions"))
    else {
        return;
    };
    for name in extensions.keys().filter(|n| !handled.contains(&n.as_str())) {
        match name.as_str() {
            "KHR_xmp" | "KHR_xmp_json_ld" => diagnostics.report(
                "metadata",
                Verdict::Exact,
                name.clone(),
                owner,
                "metadata; has no effect on the picture",
            ),
            "KHR_materials_variants" => diagnostics.report(
                "variants",
                Verdict::Exact,
                name.clone(),
                owner,
                "the default materials are used; --variant NAME shows others",
            ),
            "MSFT_lod" => diagnostics.report(
                "level-of-detail",
                Verdict::Exact,
                name.clone(),
                owner,
                "the highest level of detail is used",
            ),
            "EXT_lights_image_based" => diagnostics.report(
                "image-based-light",
                Verdict::Lost,
                name.clone(),
                owner,
                "left out: light the scene with --environment",
            ),
            _ => report_unknown(diagnostics, name, owner),
        }
    }
}

/// Reports an extension of a material that is not rendered.
pub(super) fn report_material(
    name: &str,
    material: &str,
    diagnostics: &mut Diagnostics,
) {
    let owner = Subject::Material(material.into());
    let (effect, instead) = match name {
        "KHR_materials_volume_scatter" => (Effect::Media, "the inside does not scatter"),
        "KHR_materials_subsurface" => (
            Effect::Subsurface,
            "rendered without subsurface scattering",
        ),
        "KHR_xmp" | "KHR_xmp_json_ld" => {
            return diagnostics.report(
                "metadata",
                Verdict::Exact,
                name,
                owner,
                "metadata; has no effect on the picture",
            );
        }
        _ => return report_unknown(diagnostics, name, owner),
    };
    let (code, verdict) = ("unsupported-material", Verdict::Lost);
    diagnostics.report_effect(effect, code, verdict, name, owner, instead);
}
