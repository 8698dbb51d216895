//! KHR_materials_variants: sets of materials of which one is shown.

use ::gltf::json::Index;
use serde::Deserialize;
use serde_json::Value;

use super::container::Document;
use crate::import::ImportError;

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct VariantJson {
    name: String,
}

#[derive(Deserialize)]
struct MappingJson {
    material: usize,
    variants: Vec<usize>,
}

/// The names of a file's variants.
///
/// # Errors
/// They are not as the format has them.
pub(super) fn names(document: &Document) -> Result<Vec<String>, ImportError> {
    let Some(list) = document.value.pointer("/extensions/KHR_materials_variants") else {
        return Ok(Vec::new());
    };
    let list = list.get("variants").unwrap_or(&Value::Null);
    let variants = <Vec<VariantJson>>::deserialize(list).map_err(|problem| {
        let problem = format!("its variants cannot be read: {problem}");
        ImportError::malformed(&document.file, NAME, problem)
    })?;
    Ok(variants.into_iter().map(|variant| variant.name).collect())
}

/// Gives each primitive the material of a variant, where it has one for that.
///
/// # Errors
/// There is no such variant, or its materials are not as the format has them.
pub(super) fn choose(
    document: &mut Document,
    names: &[String],
    wanted: &str,
) -> Result<(), ImportError> {
    let Some(variant) = names.iter().position(|name| name == wanted) else {
        let there = match names {
            [] => "the file has no variants".into(),
            _ => format!("there are: {}", names.join(", ")),
        };
        return Err(ImportError::malformed(
            &document.file,
            format!("variant \"{wanted}\""),
            format!("there is no such variant; {there}"),
        ));
    };
    let (file, value) = (&document.file, &document.value);
    for (index, mesh) in document.core.meshes.iter_mut().enumerate() {
        for (number, primitive) in mesh.primitives.iter_mut().enumerate() {
            let place = format!("/meshes/{index}/primitives/{number}/extensions/{NAME}/mappings");
            let Some(mappings) = value.pointer(&place) else {
                continue;
            };
            let mappings = <Vec<MappingJson>>::deserialize(mappings).map_err(|problem| {
                let problem = format!("its {NAME} cannot be read: {problem}");
                ImportError::malformed(file, format!("mesh {index}"), problem)
            })?;
            let mut fitting = mappings.iter().filter(|m| m.variants.contains(&variant));
            if let Some(mapping) = fitting.next() {
                let material = u32::try_from(mapping.material).unwrap_or(u32::MAX);
                primitive.material = Some(Index::new(material));
            }
        }
    }
    Ok(())
}
