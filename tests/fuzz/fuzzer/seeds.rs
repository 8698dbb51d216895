//! Small whole files of every kind that is read, to be damaged: those in `tests/fuzz/seeds`, and those that are made here.

use super::corpus::{Subject, subjects};
use super::document::{document, picture, written};
use serde_json::{Value, json};
use std::io::Cursor;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use sundog::film::{Bands, Passes};
use sundog::import::{ImportOptions, load};
use sundog::render::{Event, Observer, RenderSettings, State, resume};
use sundog::scene::Scene;

/// A folder of them, and what there is to be damaged.
pub fn all() -> std::io::Result<(tempfile::TempDir, Vec<Subject>)> {
    let folder = tempfile::tempdir()?;
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    copy(&tests.join("fuzz/seeds"), folder.path())?;
    let volumes = tests.join("unit/import/vdb/files");
    copy(&volumes, &folder.path().join("volumes"))?;
    // What the add-on's export names.
    std::fs::copy(
        volumes.join("zip.vdb"),
        folder.path().join("addon/smoke.vdb"),
    )?;
    for (name, bytes) in made() {
        std::fs::write(folder.path().join(name), bytes)?;
    }
    let all = subjects(folder.path());
    Ok((folder, all))
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let path = entry?.path();
        let to = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &to)?;
        } else {
            std::fs::copy(&path, to)?;
        }
    }
    Ok(())
}

/// Names and contents.
fn made() -> Vec<(String, Vec<u8>)> {
    let mut list: Vec<(String, Vec<u8>)> = Vec::new();
    for kind in ["png", "jpg", "webp", "hdr", "gif", "bmp", "tga", "tif"] {
        list.push((format!("picture.{kind}"), picture(kind)));
    }
    let grey = image::DynamicImage::from(image::ImageBuffer::from_fn(9, 5, |x, y| {
        image::LumaA([(x * 7000) as u16, (y * 13000) as u16])
    }));
    list.push(("deep.png".into(), encoded(&grey, image::ImageFormat::Png)));
    let floats =
        image::DynamicImage::from(image::Rgb32FImage::from_pixel(7, 5, image::Rgb([0.5; 3])));
    list.push((
        "floats.tif".into(),
        encoded(&floats, image::ImageFormat::Tiff),
    ));
    for (name, bytes) in layers() {
        list.push((format!("{name}.exr"), bytes));
    }
    for own in [false, true] {
        let (document, buffer) = document(own);
        for binary in [false, true] {
            let name = if own { "own" } else { "plain" };
            let ending = if binary { "glb" } else { "gltf" };
            let bytes = written(document.clone(), &buffer, binary);
            list.push((format!("{name}.{ending}"), bytes));
        }
    }
    list.push(("render.state".into(), state()));
    list
}

fn encoded(picture: &image::DynamicImage, format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    // An empty file is a damaged one as well.
    let _ = picture.write_to(&mut bytes, format);
    bytes.into_inner()
}

/// OpenEXR by each of its compressions that the crate writes, with two layers.
fn layers() -> Vec<(String, Vec<u8>)> {
    use exr::prelude::*;
    let mut list = Vec::new();
    for (name, compression) in [
        ("plain", Compression::Uncompressed),
        ("rle", Compression::RLE),
        ("zip", Compression::ZIP16),
        ("piz", Compression::PIZ),
        ("pxr24", Compression::PXR24),
        ("b44", Compression::B44),
    ] {
        let values =
            |by: f32| FlatSamples::F32((0..17 * 9).map(|i| (i as f32 * by).sin()).collect());
        let halves = |by: f32| {
            let value = |i: i32| f16::from_f32((i as f32 * by).cos());
            FlatSamples::F16((0..17 * 9).map(value).collect())
        };
        let channel = |name: &str, samples| AnyChannel::new(name, samples);
        let encoding = Encoding {
            compression,
            ..Encoding::default()
        };
        let layer = |name: &str, channels: Vec<AnyChannel<FlatSamples>>| {
            Layer::new(
                (17, 9),
                LayerAttributes::named(name),
                encoding,
                AnyChannels::sort(channels.into_iter().collect()),
            )
        };
        let seen = vec![
            channel("R", halves(0.1)),
            channel("G", halves(0.2)),
            channel("B", halves(0.3)),
            channel("A", values(0.4)),
        ];
        let normal = ["X", "Y", "Z"].map(|axis| channel(axis, values(0.7)));
        let image = Image::from_layers(
            ImageAttributes::new(IntegerBounds::from_dimensions((17, 9))),
            vec![layer("ViewLayer", seen), layer("Normal", normal.to_vec())],
        );
        let mut bytes = Cursor::new(Vec::new());
        let _ = image.write().to_buffered(&mut bytes);
        list.push((format!("layers-{name}"), bytes.into_inner()));
    }
    list
}

/// A square of one material before a camera, and what else a scene has.
pub fn square(mut scene: Value) -> Value {
    let corners: Vec<u8> = [
        -1.0f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0,
    ]
    .iter()
    .flat_map(|value| value.to_le_bytes())
    .chain([0u8, 1, 2, 0, 2, 3])
    .collect();
    let parts = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 6 }
        ],
    });
    for (key, value) in parts.as_object().into_iter().flatten() {
        scene[key] = value.clone();
    }
    let nodes = scene["nodes"].as_array().map_or(0, Vec::len);
    scene["scenes"][0]["nodes"] = (0..nodes).collect();
    let text = written(scene, &corners, false);
    serde_json::from_slice(&text).unwrap_or_default()
}

/// The scene and the settings of the saved state.
pub fn state_of() -> (Scene, RenderSettings) {
    let (document, buffer) = document(true);
    let scene = tempfile::tempdir().ok().and_then(|folder| {
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, written(document, &buffer, true)).ok()?;
        Some(load(&path, &ImportOptions::default()).ok()?.scene)
    });
    let settings = RenderSettings {
        width: 6,
        height: 5,
        samples: 4,
        bounces: 2,
        passes: Passes::ALL,
        threads: Some(1),
        ..RenderSettings::default()
    };
    (scene.unwrap_or_default(), settings)
}

/// The state of a render.
fn state() -> Vec<u8> {
    let (scene, mut settings) = state_of();
    // Whoever goes on with it has something to do.
    settings.samples = 2;
    let keeper = Keeper::default();
    let _ = resume(&scene, &settings, None, &keeper);
    keeper
        .0
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner)
}

/// Keeps the last state.
#[derive(Default)]
struct Keeper(Mutex<Vec<u8>>);

impl Observer for Keeper {
    fn event(&self, _event: &Event) {}

    fn cancelled(&self) -> bool {
        false
    }

    fn wants_state(&self, last: bool) -> bool {
        last
    }

    fn state(&self, state: &State, _last: bool) {
        let mut bytes = Vec::new();
        if state.write(&mut bytes).is_ok() {
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = bytes;
        }
    }

    fn picture(&self, _picture: &dyn Bands, _samples: u32, _last: bool) {}
}
