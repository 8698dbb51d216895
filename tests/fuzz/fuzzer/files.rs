//! Damaged files through the importers: glTF as text and as binary, USD as text, binary and packed, and images. No panic, no hang, no memory out of
//! proportion (who runs the fuzzer limits what the process may take), and what is read renders.

use super::build::number;
use super::corpus::ending;
use super::document::{document, picture, written};
use super::kinds::{self, is_alone, is_configuration};
use super::rng::Rng;
use glam::DVec3;
use serde_json::{Value, json};
use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};
use sundog::film::Picture;
use sundog::import::{ImportOptions, load, load_environment};
use sundog::render::{RenderSettings, Silent, render};
use sundog::scene::Scene;
use sundog::selftest::kit::camera;

/// Kinds of files.
const KINDS: [&str; 15] = [
    "gltf", "glb", "png", "jpg", "webp", "hdr", "exr", "usda", "usdc", "usdz", "gif", "bmp", "tga",
    "tif", "ktx2",
];
/// No file here takes so long, by far.
const PATIENCE: Duration = Duration::from_secs(20);

/// Draws a kind of file and what damages it.
pub fn draw(rng: &mut Rng) -> Value {
    let kind = rng.pick(&KINDS);
    let mut input = json!({ "file": kind });
    let is_gltf = kind.starts_with("gl");
    if is_gltf && rng.chance(0.6) {
        input["own"] = json!(true);
    }
    if is_gltf && rng.chance(0.85) {
        let mut places = Vec::new();
        nodes(&document(has_own(&input)).0, String::new(), &mut places);
        let changes = (0..1 + rng.below(4)).map(|_| {
            let place = &places[rng.below(places.len())];
            json!({ "at": place, "to": replacement(rng) })
        });
        input["tree"] = changes.collect();
    }
    if !is_gltf || rng.chance(0.25) {
        let changes = (0..1 + rng.below(6)).map(|_| {
            // Headers are where most goes wrong.
            let at = rng.unit() * rng.pick(&[1.0, 0.1, 0.02]);
            json!({ "at": at, "to": rng.pick(&[0, 1, 127, 128, 255, 32]) })
        });
        input["bytes"] = changes.collect();
    }
    if rng.chance(0.1) {
        input["cut"] = json!(rng.unit());
    }
    input
}

pub(super) fn replacement(rng: &mut Rng) -> Value {
    match rng.below(14) {
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
        11 => json!(rng.pick(&[5120, 5121, 5122, 5123, 5125, 5126])),
        12 => json!(rng.pick(&["SCALAR", "VEC2", "VEC3", "MAT4", "MASK", "BLEND", "spot"])),
        _ => json!(rng.below(9)),
    }
}

/// Pointers to all parts of a tree.
pub(super) fn nodes(value: &Value, at: String, found: &mut Vec<String>) {
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

/// Whether Sundog's own extensions are in a file.
fn has_own(input: &Value) -> bool {
    input["own"].as_bool() == Some(true)
}

/// The bytes of a damaged file.
pub fn damaged(input: &Value) -> Vec<u8> {
    damaged_as(input, input["file"].as_str().unwrap_or_default())
}

fn damaged_as(input: &Value, kind: &str) -> Vec<u8> {
    let mut bytes = match kind {
        "gltf" | "glb" => gltf(kind == "glb", input),
        "exr" => exr(),
        // Curves, points, instancers, subdivision, lights; a skeleton with blend shapes.
        "usda" => include_bytes!("../seeds/shapes.usda").to_vec(),
        "usdc" => include_bytes!("../seeds/shapes.usdc").to_vec(),
        "usdz" => include_bytes!("../seeds/skeleton.usdz").to_vec(),
        "ktx2" => include_bytes!("../seeds/etc1s.ktx2").to_vec(),
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
    let written = |kind: &str| -> Result<Option<Picture>, String> {
        let failed = |error: std::io::Error| format!("no file could be written: {error}");
        let folder = tempfile::tempdir().map_err(failed)?;
        let path = folder.path().join(format!("input.{kind}"));
        std::fs::write(&path, damaged_as(input, kind)).map_err(failed)?;
        pictured(&path)
    };
    let found = match written(kind) {
        Err(wrong) => return Some(wrong),
        Ok(_) if begun.elapsed() > PATIENCE => return Some("the import takes too long".into()),
        Ok(found) => found,
    };
    let other = match kind {
        "gltf" => "glb",
        "glb" => "gltf",
        _ => return None,
    };
    // Damaged bytes are damage of another kind there.
    if !input["bytes"].is_null() || !input["cut"].is_null() {
        return None;
    }
    match written(other) {
        Err(wrong) => Some(wrong),
        Ok(same) if bits(same.as_ref()) == bits(found.as_ref()) => None,
        Ok(_) => Some("another picture as text than as binary".into()),
    }
}

fn bits(picture: Option<&Picture>) -> Option<Vec<u32>> {
    let values = picture?.layers.iter().flat_map(|layer| &layer.data);
    Some(values.map(|value| value.to_bits()).collect())
}

/// Opens a file by its kind, in a folder where others may be written, and renders what is there; says what is wrong. A refusal in
/// one sentence is right.
pub fn import(path: &Path) -> Option<String> {
    let open = || {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let copy = folder.path().join(path.file_name().unwrap_or_default());
        std::fs::copy(path, &copy).map_err(|error| error.to_string())?;
        let kind = ending(&copy);
        if is_alone(&kind) || is_configuration(&kind) {
            kinds::open(&copy).map(drop)
        } else {
            pictured(&copy).map(drop)
        }
    };
    open().err()
}

/// The picture of a file; none of one that is refused or has no camera. An error is what is wrong.
pub(super) fn pictured(path: &Path) -> Result<Option<Picture>, String> {
    let scenes = ["gltf", "glb", "usda", "usdc", "usdz"];
    let is_scene = path
        .extension()
        .is_some_and(|extension| scenes.iter().any(|kind| extension == *kind));
    let scene = if is_scene {
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
            return kinds::refused(&error).map(|_| None);
        }
    };
    if scene.cameras.is_empty() {
        return Ok(None);
    }
    let settings = RenderSettings {
        width: 6,
        height: 4,
        samples: 2,
        bounces: 3,
        threads: Some(1),
        ..RenderSettings::default()
    };
    let picture = render(&scene, &settings, &Silent)
        .map_err(|error| format!("no picture: {error}"))?
        .picture;
    let all = picture.layers.iter().flat_map(|l| &l.data);
    match all.filter(|value| !value.is_finite()).count() {
        0 => Ok(Some(picture)),
        bad => Err(format!("values that are not finite: {bad}")),
    }
}

fn gltf(binary: bool, input: &Value) -> Vec<u8> {
    let (mut document, buffer) = document(has_own(input));
    for change in input["tree"].as_array().into_iter().flatten() {
        let at = change["at"].as_str().unwrap_or("/nowhere");
        if let Some(part) = document.pointer_mut(at) {
            *part = change["to"].clone();
        }
    }
    written(document, &buffer, binary)
}

fn exr() -> Vec<u8> {
    use exr::prelude::*;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5f32));
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_channels((16, 8), channels);
    let _ = image.write().to_buffered(&mut bytes);
    bytes.into_inner()
}
