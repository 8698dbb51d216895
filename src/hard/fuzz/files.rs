//! Damaged files through the importers: glTF as text and as binary, and images. No panic, no hang, no memory out of
//! proportion (who runs the fuzzer limits what the process may take), and what is read renders.

use super::build::number;
use super::dice::Dice;
use crate::hard::kit::camera;
use crate::import::{ImportOptions, load, load_environment};
use crate::render::{RenderSettings, Silent, render};
use crate::scene::Scene;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::{Value, json};
use std::io::{Cursor, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// Kinds of files.
const KINDS: [&str; 6] = ["gltf", "glb", "png", "jpg", "hdr", "exr"];
/// No file here takes so long, by far.
const PATIENCE: Duration = Duration::from_secs(20);

/// Draws a kind of file and what damages it.
pub fn draw(dice: &mut Dice) -> Value {
    let kind = dice.pick(&KINDS);
    let mut input = json!({ "file": kind });
    let is_gltf = kind.starts_with("gl");
    if is_gltf && dice.chance(0.85) {
        let mut places = Vec::new();
        nodes(&document(&[]), String::new(), &mut places);
        let changes = (0..1 + dice.below(4)).map(|_| {
            let place = &places[dice.below(places.len())];
            json!({ "at": place, "to": replacement(dice) })
        });
        input["tree"] = changes.collect();
    }
    if !is_gltf || dice.chance(0.25) {
        let changes = (0..1 + dice.below(6)).map(|_| {
            // Headers are where most goes wrong.
            let at = dice.unit() * dice.pick(&[1.0, 0.1, 0.02]);
            json!({ "at": at, "to": dice.pick(&[0, 1, 127, 128, 255, 32]) })
        });
        input["bytes"] = changes.collect();
    }
    if dice.chance(0.1) {
        input["cut"] = json!(dice.unit());
    }
    input
}

fn replacement(dice: &mut Dice) -> Value {
    match dice.below(14) {
        0 => Value::Null,
        1 => json!([]),
        2 => json!({}),
        3 => json!("x"),
        4 => json!(-1),
        5 => json!(0),
        6 => json!(4_294_967_295u64),
        7 => json!(u64::MAX),
        8 => json!(1e39),
        9 => json!(-1e39),
        10 => json!(1e-45),
        11 => json!(dice.pick(&[5120, 5121, 5122, 5123, 5125, 5126])),
        12 => json!(dice.pick(&["SCALAR", "VEC2", "VEC3", "MAT4", "MASK", "BLEND", "spot"])),
        _ => json!(dice.below(9)),
    }
}

/// Pointers to all parts of a tree.
fn nodes(value: &Value, at: String, found: &mut Vec<String>) {
    match value {
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                nodes(item, format!("{at}/{i}"), found);
            }
        }
        Value::Object(map) => {
            for (key, item) in map {
                nodes(item, format!("{at}/{key}"), found);
            }
        }
        _ => {}
    }
    found.push(at);
}

/// The bytes of a damaged file.
pub fn damaged(input: &Value) -> Vec<u8> {
    let kind = input["file"].as_str().unwrap_or_default();
    let mut bytes = match kind {
        "gltf" | "glb" => gltf(kind == "glb", &input["tree"]),
        "exr" => exr(),
        _ => picture(kind),
    };
    for change in input["bytes"].as_array().into_iter().flatten() {
        let at = number(&change["at"]).unwrap_or(0.0) * bytes.len() as f64;
        if let Some(byte) = bytes.get_mut(at as usize) {
            *byte = number(&change["to"]).unwrap_or(0.0) as u8;
        }
    }
    if let Some(cut) = number(&input["cut"]) {
        bytes.truncate((cut * bytes.len() as f64) as usize);
    }
    bytes
}

/// The name under which a damaged file is kept.
pub fn kept_name(input: &Value, name: &str) -> Option<String> {
    let kind = input.get("file")?.as_str()?;
    Some(format!("{name}.{kind}"))
}

/// Says what is wrong with the import of a damaged file.
pub fn check(input: &Value) -> Option<String> {
    let kind = input["file"].as_str().unwrap_or_default();
    let begun = Instant::now();
    let wrong = || -> std::io::Result<Option<String>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join(format!("input.{kind}"));
        std::fs::File::create(&path)?.write_all(&damaged(input))?;
        Ok(import(&path))
    };
    match wrong() {
        Ok(Some(wrong)) => Some(wrong),
        Ok(None) if begun.elapsed() > PATIENCE => Some("the import takes too long".into()),
        Ok(None) => None,
        Err(error) => Some(format!("no file could be written: {error}")),
    }
}

/// Imports a file by its kind and renders what is there; says what is wrong. A refusal in one sentence is right.
pub fn import(path: &Path) -> Option<String> {
    let is_gltf = path
        .extension()
        .is_some_and(|extension| extension == "gltf" || extension == "glb");
    let scene = if is_gltf {
        load(path, &ImportOptions::default()).map(|imported| imported.scene)
    } else {
        let mut scene = Scene {
            cameras: vec![camera(DVec3::ZERO, 1.0)],
            ..Scene::default()
        };
        load_environment(&mut scene, path, 1.0, 30.0).map(|_| scene)
    };
    let scene = match scene {
        Ok(scene) => scene,
        Err(error) => {
            let sentence = error.to_string();
            let bad = sentence.is_empty() || sentence.contains('\n');
            return bad.then(|| format!("a refusal that is no sentence: {sentence:?}"));
        }
    };
    if scene.cameras.is_empty() {
        return None;
    }
    let settings = RenderSettings {
        width: 6,
        height: 4,
        samples: 2,
        bounces: 3,
        threads: Some(1),
        ..RenderSettings::default()
    };
    match render(&scene, &settings, &Silent) {
        Err(error) => Some(format!("no picture: {error}")),
        Ok(rendering) => {
            let all = rendering.picture.layers.iter().flat_map(|l| &l.data);
            let bad = all.filter(|value| !value.is_finite()).count();
            (bad > 0).then(|| format!("values that are not finite: {bad}"))
        }
    }
}

fn gltf(binary: bool, changes: &Value) -> Vec<u8> {
    let (mut buffer, png) = (buffer(), picture("png"));
    let image = [buffer.len(), png.len()];
    buffer.extend(&png);
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let mut document = document(&image);
    document["buffers"] = if binary {
        json!([{ "byteLength": buffer.len() }])
    } else {
        let data = STANDARD.encode(&buffer);
        json!([{ "byteLength": buffer.len(), "uri": format!("data:application/octet-stream;base64,{data}") }])
    };
    for change in changes.as_array().into_iter().flatten() {
        let at = change["at"].as_str().unwrap_or("/nowhere");
        if let Some(part) = document.pointer_mut(at) {
            *part = change["to"].clone();
        }
    }
    let mut text = document.to_string().into_bytes();
    if !binary {
        return text;
    }
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(word(12 + 8 + text.len() + 8 + buffer.len()));
    bytes.extend(word(text.len()));
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(word(buffer.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

/// Positions, normals, coordinates, colours, corners, places of instances, and a pose.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut floats = |values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    floats(&[
        -1.0, 0.0, -1.0, -1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, -1.0,
    ]);
    floats(&[0.0, 1.0, 0.0].repeat(4));
    floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    floats(&[1.0, 0.5, 0.5, 1.0].repeat(4));
    floats(&[0.0, 0.5, 0.0, 0.5, 1.0, 0.5]);
    floats(&[0.0, 0.1, 0.0].repeat(4));
    bytes.extend([0u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes));
    bytes
}

/// Something of all that importers read; the image's place and length in the buffer.
fn document(image: &[usize]) -> Value {
    let (offset, length) = (image.first().unwrap_or(&0), image.get(1).unwrap_or(&0));
    let down = [
        -std::f64::consts::FRAC_1_SQRT_2,
        0.0,
        0.0,
        std::f64::consts::FRAC_1_SQRT_2,
    ];
    let texture = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": {
        "offset": [0.1, 0.2], "rotation": 0.3, "scale": [2.0, 1.0] } } });
    let accessor = |view: u32, kind: &str| {
        json!({ "bufferView": view, "byteOffset": 0, "componentType": 5126, "count": 4, "type": kind,
            "min": [-1, -1, -1], "max": [1, 1, 1] })
    };
    json!({
        "asset": { "version": "2.0", "generator": "fuzzer" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior",
            "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_emissive_strength",
            "EXT_mesh_gpu_instancing"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "name": "Lamp", "type": "point", "intensity": 683.0, "color": [1, 0.9, 0.8], "range": 9 },
            { "name": "Spot", "type": "spot", "intensity": 683.0, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } },
            { "name": "Sun", "type": "directional", "intensity": 683.0 }
        ] } },
        "scene": 0,
        "scenes": [{ "name": "Scene", "nodes": [0, 1, 2, 3, 4, 5] }],
        "nodes": [
            { "name": "Floor", "mesh": 0, "scale": [1, 1, 1], "children": [6], "weights": [0.5] },
            { "name": "Eye", "camera": 0, "translation": [0, 3, 0], "rotation": down },
            { "name": "Lamp", "translation": [0.5, 2, 0.5], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "Spot", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,2,0,1], "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "name": "Sun", "rotation": down, "extensions": { "KHR_lights_punctual": { "light": 2 } } },
            { "name": "Many", "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 4 } } } },
            { "name": "Child", "mesh": 0, "translation": [0, 0.2, 0], "scale": [0.1, 0.1, 0.1] }
        ],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.9, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 10 } }
        ],
        "materials": [{
            "name": "Material", "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true,
            "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0.2, "roughnessFactor": 0.5,
                "baseColorTexture": texture, "metallicRoughnessTexture": texture },
            "normalTexture": { "index": 0, "scale": 0.5 },
            "emissiveFactor": [0.1, 0.1, 0], "emissiveTexture": texture,
            "extensions": {
                "KHR_materials_ior": { "ior": 1.4 },
                "KHR_materials_emissive_strength": { "emissiveStrength": 2 },
                "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 1, 1] },
                "KHR_materials_transmission": { "transmissionFactor": 0.3 },
                "KHR_materials_volume": { "thicknessFactor": 0.1, "attenuationDistance": 1, "attenuationColor": [1, 1, 1] }
            }
        }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 33071 }],
        "images": [{ "bufferView": 7, "mimeType": "image/png", "name": "Image" }],
        "meshes": [{ "name": "Square", "weights": [0.2], "primitives": [{ "mode": 4, "indices": 6, "material": 0,
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 },
            "targets": [{ "POSITION": 5 }] }] }],
        "accessors": [
            accessor(0, "VEC3"), accessor(1, "VEC3"), accessor(2, "VEC2"), accessor(3, "VEC4"),
            { "bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3" },
            accessor(5, "VEC3"),
            { "bufferView": 6, "componentType": 5123, "count": 6, "type": "SCALAR",
              "sparse": { "count": 1, "indices": { "bufferView": 6, "componentType": 5123 }, "values": { "bufferView": 6 } } }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48, "byteStride": 12 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 128, "byteLength": 64 },
            { "buffer": 0, "byteOffset": 192, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 216, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 264, "byteLength": 12 },
            { "buffer": 0, "byteOffset": offset, "byteLength": length }
        ]
    })
}

/// A small picture of a kind that the crate `image` writes.
fn picture(kind: &str) -> Vec<u8> {
    let (format, picture) = match kind {
        "hdr" => (
            image::ImageFormat::Hdr,
            image::Rgb32FImage::from_fn(16, 8, |x, y| image::Rgb([x as f32, y as f32, 0.5])).into(),
        ),
        "jpg" => (image::ImageFormat::Jpeg, rgb()),
        _ => (image::ImageFormat::Png, rgb()),
    };
    let mut bytes = Cursor::new(Vec::new());
    // An empty file is a damaged one as well.
    let _ = picture.write_to(&mut bytes, format);
    bytes.into_inner()
}

fn rgb() -> image::DynamicImage {
    image::RgbImage::from_fn(16, 8, |x, y| {
        image::Rgb([(16 * x) as u8, (32 * y) as u8, 90])
    })
    .into()
}

fn exr() -> Vec<u8> {
    use exr::prelude::*;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5f32));
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((16, 8), channels);
    let _ = image.write().to_buffered(&mut bytes);
    bytes.into_inner()
}
