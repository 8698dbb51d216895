//! Which extensions are understood, and what is said about the others.

use serde_json::Value;

use super::container::Document;
use crate::import::ImportError;
use crate::scene::{Diagnostics, Effect, Subject, Verdict};

/// What a file may demand (`extensionsRequired`) without being refused.
///
/// The KHR_materials_* that are not rendered are allowed too, and kinds of images that are not read: the picture is near to
/// the one meant, and a diagnostic says what is missing. Extensions that change where the data lie are not.
fn may_be_required(name: &str) -> bool {
    name.starts_with("KHR_materials_")
        || changes_no_picture(name)
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
                | "EXT_texture_avif"
                | "MSFT_texture_dds"
                | "MSFT_lod"
                | "EXT_lights_image_based"
                | "EXT_lights_ies"
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

/// Extensions that tell of anything but what is seen: metadata, physics, sound, what may be clicked.
fn changes_no_picture(name: &str) -> bool {
    const STARTS: [&str; 5] = ["OMI_", "VRMC_", "KHR_physics", "KHR_audio", "MSFT_packing"];
    STARTS.iter().any(|start| name.starts_with(start))
        || matches!(
            name,
            "KHR_xmp"
                | "FB_ngon_encoding"
                | "KHR_xmp_json_ld"
                | "KHR_interactivity"
                | "KHR_implicit_shapes"
                | "KHR_node_selectability"
                | "KHR_node_hoverability"
                | "KHR_node_grabbability"
                | "EXT_structural_metadata"
                | "EXT_feature_metadata"
                | "EXT_mesh_features"
                | "EXT_instance_features"
                | "EXT_mesh_manifold"
                | "AGI_articulations"
                | "AGI_stk_metadata"
                | "CESIUM_primitive_outline"
                | "FB_geometry_metadata"
                | "GODOT_single_root"
                | "VRM"
        )
}

/// Refuses a file that cannot be understood, with the way out.
pub(super) fn check_required(document: &Document) -> Result<(), ImportError> {
    for name in &document.graph.extensions_required {
        if may_be_required(name) {
            continue;
        }
        let remedy = "get a copy of the file without it, or open the file in a program that has it and export it from there";
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
            name if changes_no_picture(name) => diagnostics.report(
                "metadata",
                Verdict::Exact,
                name,
                owner,
                "has no effect on the picture",
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
            _ => report_unknown(diagnostics, name, owner),
        }
    }
}

/// Reports an extension of a material that is not rendered.
pub(super) fn report_material(name: &str, material: &str, diagnostics: &mut Diagnostics) {
    let owner = Subject::Material(material.into());
    let (effect, instead) = match name {
        "KHR_materials_subsurface" => {
            (Effect::Subsurface, "rendered without subsurface scattering")
        }
        name if changes_no_picture(name) => {
            let instead = "has no effect on the picture";
            return diagnostics.report("metadata", Verdict::Exact, name, owner, instead);
        }
        _ => return report_unknown(diagnostics, name, owner),
    };
    let (code, verdict) = ("unsupported-material", Verdict::Lost);
    diagnostics.report_effect(effect, code, verdict, name, owner, instead);
}
