//! Files that are opened by themselves: pictures, photometric profiles, volumes, colour configurations, saved states.

use super::corpus::ending;
use super::files::pictured;
use super::seeds;
use serde_json::{Value, json};
use std::fmt::Display;
use std::path::Path;
use sundog::color::{ColorConfig, Depth, DisplayTransform, SceneColors};
use sundog::measure;
use sundog::render::{Saved, merge, resume};

/// Pictures, which any program may open as light from all around.
const PICTURES: [&str; 12] = [
    "png", "jpg", "jpeg", "webp", "hdr", "exr", "gif", "bmp", "tga", "tif", "tiff", "ktx2",
];
/// Tables and gradings that a colour configuration may name.
const TABLES: [&str; 11] = [
    "cube", "spi1d", "spi3d", "spimtx", "3dl", "csp", "clf", "ctf", "cc", "ccc", "vf",
];
/// What a state may take of memory.
const STATE_BYTES: u64 = 1 << 30;

/// Whether a file of that ending is opened by itself, with nothing beside it.
pub fn is_alone(ending: &str) -> bool {
    PICTURES.contains(&ending)
        || TABLES.contains(&ending)
        || ["ies", "vdb", "state"].contains(&ending)
}

/// Whether a file of that ending is a colour configuration.
pub fn is_configuration(ending: &str) -> bool {
    ["ocio", "ocioz"].contains(&ending)
}

/// Whether OpenColorIO reads files of that ending.
pub fn is_of_colors(ending: &str) -> bool {
    TABLES.contains(&ending) || is_configuration(ending)
}

/// Opens a file by its kind, as the program would; whether it opens, or what is wrong.
pub fn open(path: &Path) -> Result<bool, String> {
    match &*ending(path) {
        "state" => state(path),
        "ocio" | "ocioz" => configuration(path),
        kind if TABLES.contains(&kind) => in_a_configuration(path),
        "ies" => within(path, &lamp(path)),
        "vdb" => within(path, &smoke(path)),
        _ => picture(path),
    }
}

/// A refusal has to be a sentence.
pub fn refused(error: &impl Display) -> Result<bool, String> {
    let sentence = error.to_string();
    if sentence.is_empty() || sentence.contains('\n') {
        return Err(format!("a refusal that is no sentence: {sentence:?}"));
    }
    Ok(false)
}

/// By all doors that pictures have: as light, and as what is compared.
fn picture(path: &Path) -> Result<bool, String> {
    for layer in [None, Some("Normal")] {
        if let Err(error) = measure::load_with_alpha(path, layer) {
            refused(&error)?;
        }
    }
    if let Err(error) = measure::metadata(path) {
        refused(&error)?;
    }
    pictured(path).map(|picture| picture.is_some())
}

/// Renders a scene that names the file, which lies beside it.
fn within(path: &Path, scene: &Value) -> Result<bool, String> {
    let beside = path.with_extension("gltf");
    std::fs::write(&beside, scene.to_string()).map_err(|error| error.to_string())?;
    let picture = pictured(&beside)?;
    // The file is left out with a word, not refused.
    Ok(picture.is_some())
}

fn name(path: &Path) -> Value {
    json!(path.file_name().unwrap_or_default().to_string_lossy())
}

/// A square under a lamp with that profile.
fn lamp(path: &Path) -> Value {
    seeds::square(json!({
        "extensions": { "EXT_lights_ies": { "lights": [{ "uri": name(path) }] } },
        "nodes": [
            { "mesh": 0 },
            { "camera": 0, "translation": [0, 0, 4] },
            { "translation": [0.3, 0.2, 2], "extensions": { "EXT_lights_ies": { "light": 0, "multiplier": 50 } } }
        ],
    }))
}

/// A square of what the file's grids fill.
fn smoke(path: &Path) -> Value {
    let grid =
        |number: u32, grid: &str| json!({ "number": number, "name": grid, "uri": name(path) });
    let grids = json!({ "grids": [grid(0, "density"), grid(1, "color")] });
    let mut scene = seeds::square(json!({
        "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 4] }],
    }));
    scene["meshes"][0]["primitives"][0]["extensions"] = json!({ "SUNDOG_mesh": grids });
    scene["extensionsUsed"] = json!(["SUNDOG_mesh"]);
    scene
}

/// Makes a quarter of a configuration's views and inputs, others for other bytes of the file: inverting tables takes time.
fn configuration(path: &Path) -> Result<bool, String> {
    // OpenColorIO keeps tables by their names: each time they have to have others.
    let fresh = tempfile::tempdir().map_err(|error| error.to_string())?;
    for entry in path.parent().into_iter().flat_map(std::fs::read_dir) {
        for file in entry.filter_map(|entry| Some(entry.ok()?.path())) {
            if let (true, Some(name)) = (file.is_file(), file.file_name()) {
                std::fs::copy(&file, fresh.path().join(name)).map_err(|error| error.to_string())?;
            }
        }
    }
    let path = fresh.path().join(path.file_name().unwrap_or_default());
    let turn = sum_of_bytes(&path)?;
    let config = match ColorConfig::read_named_by_scene(&path) {
        Ok(config) => config,
        Err(error) => return refused(&error),
    };
    let mut all_well = true;
    let mut tell = |failed: Result<(), String>| failed.map(|()| all_well = false);
    let told = |error: sundog::color::ColorError| refused(&error).map(drop);
    let displays = match config.displays() {
        Ok(displays) => displays,
        Err(error) => return refused(&error),
    };
    for display in displays.iter().take(3) {
        for view in display
            .views
            .iter()
            .skip(turn % 4 % display.views.len().max(1))
            .step_by(4)
            .take(4)
        {
            let look = view
                .looks
                .first()
                .filter(|_| view.name.len().is_multiple_of(2));
            let wanted = DisplayTransform {
                display: Some(display.name.clone()),
                view: Some(view.name.clone()),
                look: look.cloned(),
                ..DisplayTransform::default()
            };
            let colors = [[0.18, 0.0, -1.0], [1e30, f32::NAN, 0.5], [1.0; 3]];
            let shown = config.processor(&wanted).and_then(|processor| {
                processor.show(SceneColors::Rgb(&colors), Depth::Eight)?;
                processor.show_in_place(&mut colors.clone())
            });
            if let Err(error) = shown {
                tell(told(error))?;
            }
        }
    }
    let spaces = config.colour_spaces().unwrap_or_default();
    let inputs = if spaces.len() > 4 {
        &spaces[turn / 4 % 4..]
    } else {
        &[][..]
    };
    for space in inputs.iter().step_by(4).take(4) {
        let read = config
            .input_processor(space, "Linear Rec.709")
            .and_then(|processor| processor.apply(&mut [[0.5, 1e30, f32::NAN, 1.0]]));
        if let Err(error) = read {
            tell(told(error))?;
        }
    }
    Ok(all_well)
}

fn sum_of_bytes(path: &Path) -> Result<usize, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    Ok(bytes.iter().map(|&byte| usize::from(byte)).sum())
}

/// A table in a configuration of one view; inverted in some, by its bytes.
fn in_a_configuration(path: &Path) -> Result<bool, String> {
    let direction = if sum_of_bytes(path)?.is_multiple_of(4) {
        "inverse"
    } else {
        "forward"
    };
    let text = format!(
        "ocio_profile_version: 2\nsearch_path: \".\"\n\
         roles: {{default: linear, scene_linear: linear, aces_interchange: linear}}\n\
         displays:\n  sRGB:\n    - !<View> {{name: Table, colorspace: table}}\n\
         colorspaces:\n  - !<ColorSpace> {{name: linear}}\n\
         \x20 - !<ColorSpace> {{name: table, from_scene_reference: \
         !<FileTransform> {{src: {}, interpolation: best, direction: {direction}}}}}\n",
        name(path)
    );
    let config = path.with_extension("ocio");
    std::fs::write(&config, text).map_err(|error| error.to_string())?;
    configuration(&config)
}

/// Reads a state, joins it, makes its picture, writes it again, and goes on with it.
fn state(path: &Path) -> Result<bool, String> {
    let read = || Saved::read_within(path, STATE_BYTES);
    let saved = match read() {
        Ok(saved) => saved,
        Err(error) => return refused(&error),
    };
    if let Err(error) = merge([
        Ok(("a".to_owned(), saved.clone())),
        read().map(|b| ("b".to_owned(), b)),
    ]) {
        refused(&error)?;
    }
    match merge([Ok(("a".to_owned(), saved.clone()))]) {
        Ok(merged) => {
            drop(merged.rendering());
            let written = merged.state().write(&mut Vec::new());
            written.map_err(|error| error.to_string())?;
        }
        Err(error) => drop(refused(&error)?),
    }
    let (scene, settings) = seeds::state_of();
    if let Err(error) = resume(&scene, &settings, Some(&saved), &sundog::render::Silent) {
        return refused(&error);
    }
    Ok(true)
}
