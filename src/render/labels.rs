//! What passes tell of objects, and the names behind the numbers of Cryptomatte.

use super::names::objects;
use crate::film::objects::{Label, Matte, hash};
use crate::film::{Pass, Passes};
use crate::scene::Scene;
use serde_json::{Map, Value};

/// What Cycles calls the material of a surface without one.
const NO_MATERIAL: &str = "default_surface";

/// Names of an object, its material and its asset, and the pass indices of the first two.
fn told(scene: &Scene, instance: u32) -> Option<([&str; 3], [f32; 2])> {
    let instance = scene.instances.get(instance as usize)?;
    let mesh = scene.meshes.get(instance.mesh.0 as usize)?;
    let name = instance.name.as_str();
    let material = mesh.material_label.name.as_deref().unwrap_or(NO_MATERIAL);
    let asset = instance.info.asset.as_deref().unwrap_or(name);
    let indices = [instance.info.index, mesh.material_label.index];
    Some(([name, material, asset], indices))
}

/// What is known of objects, by the numbers that the world gives them; nothing if no pass asks.
pub(super) fn of(scene: &Scene, passes: Passes) -> Vec<Label> {
    if !passes.need_objects() {
        return Vec::new();
    }
    let label = |&instance: &u32| {
        told(scene, instance).map_or(Label::default(), |(names, indices)| {
            Label::new(names, indices)
        })
    };
    objects(scene).iter().map(label).collect()
}

/// What EXR files say of the mattes that are among their passes, as Cryptomatte's specification has it.
pub fn manifests(scene: &Scene, passes: Passes) -> Vec<(String, String)> {
    let kinds = [
        (Pass::CryptoObject00, Matte::Object, "CryptoObject"),
        (Pass::CryptoMaterial00, Matte::Material, "CryptoMaterial"),
        (Pass::CryptoAsset00, Matte::Asset, "CryptoAsset"),
    ];
    let mut entries = Vec::new();
    for (pass, kind, layer) in kinds {
        if !passes.has(pass) {
            continue;
        }
        let mut names = Map::new();
        for instance in objects(scene) {
            if let Some((told, _)) = told(scene, instance) {
                let name = told[kind as usize];
                names.insert(name.into(), Value::String(format!("{:08x}", hash(name))));
            }
        }
        let key = format!("{:08x}", hash(layer));
        let mut tell = |what: &str, value: String| {
            entries.push((format!("cryptomatte/{}/{what}", &key[..7]), value));
        };
        tell("name", layer.into());
        tell("hash", "MurmurHash3_32".into());
        tell("conversion", "uint32_to_float32".into());
        tell("manifest", Value::Object(names).to_string());
    }
    entries
}
