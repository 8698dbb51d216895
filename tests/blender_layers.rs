//! Blender's compositor finds all layers of an EXR file under their names, with the right values in the right place.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use sundog::film::{Layer, Picture};
use sundog::output::exr::{ExrOptions, SampleType};

/// As the Python program expects it.
const WIDTH: u32 = 8;
const HEIGHT: u32 = 6;

#[derive(Deserialize)]
struct Seen {
    #[serde(rename = "type")]
    kind: String,
    width: u32,
    height: u32,
    passes: BTreeMap<String, Vec<f32>>,
}

fn look_with_blender(python: &Path, file: &Path, folder: &Path) -> Seen {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/blender_layers.py");
    let output = Command::new(python)
        .arg(script)
        .arg(file)
        .arg(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.strip_prefix("RESULT "));
    let line = line.unwrap_or_else(|| panic!("{text}{}", String::from_utf8_lossy(&output.stderr)));
    serde_json::from_str(line).unwrap()
}

/// Values that are different in every place and exact in 16 bits.
fn layer(name: &str, channels: &[&str], first: u32) -> Layer {
    let count = (WIDTH * HEIGHT) as usize;
    let value = |pixel: usize, channel: usize| (first + 64 * channel as u32 + pixel as u32) as f32;
    Layer {
        name: name.into(),
        channels: channels.iter().map(|name| (*name).to_owned()).collect(),
        data: (0..count)
            .flat_map(|pixel| (0..channels.len()).map(move |channel| value(pixel, channel)))
            .collect(),
    }
}

#[test]
fn blender_finds_every_layer() {
    let picture = Picture {
        width: WIDTH,
        height: HEIGHT,
        layers: vec![
            layer("Combined", &["R", "G", "B", "A"], 0),
            layer("Depth", &["Z"], 256),
            layer("Normal", &["X", "Y", "Z"], 320),
            layer("Position", &["X", "Y", "Z"], 512),
            layer("Denoising Albedo", &["R", "G", "B"], 704),
            layer("Debug Sample Count", &["X"], 896),
        ],
    };
    for python in super::color::blenders() {
        for sample_type in [SampleType::Float, SampleType::Half] {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("layers.exr");
            let options = ExrOptions {
                sample_type,
                ..ExrOptions::default()
            };
            sundog::output::exr::write(
                &file,
                &picture,
                &options,
                &vec![("sundog/note".into(), "x".into())],
            )
            .unwrap();
            let seen = look_with_blender(&python, &file, folder.path());
            assert_eq!(
                (seen.kind.as_str(), seen.width, seen.height),
                ("MULTILAYER", WIDTH, HEIGHT)
            );
            for layer in &picture.layers {
                let pixels = seen.passes.get(&layer.name);
                let pixels =
                    pixels.unwrap_or_else(|| panic!("no {}: {:?}", layer.name, seen.passes.keys()));
                let channels = layer.channels.len();
                for (index, (pixel, expected)) in pixels
                    .chunks(4)
                    .zip(layer.data.chunks(channels))
                    .enumerate()
                {
                    // A single value comes out of the compositor as grey.
                    let expected: Vec<f32> = if channels == 1 {
                        vec![expected[0]; 3]
                    } else {
                        expected.to_vec()
                    };
                    assert_eq!(
                        pixel[..expected.len()],
                        expected,
                        "{} at pixel {index}",
                        layer.name
                    );
                }
            }
        }
    }
}

#[test]
fn blender_reads_a_picture_alone_as_an_image() {
    let picture = Picture {
        width: WIDTH,
        height: HEIGHT,
        layers: vec![layer("Combined", &["R", "G", "B", "A"], 0)],
    };
    for python in super::color::blenders() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plain.exr");
        sundog::output::exr::write(&file, &picture, &ExrOptions::default(), &Vec::new()).unwrap();
        let seen = look_with_blender(&python, &file, folder.path());
        assert_eq!(
            (seen.kind.as_str(), seen.width, seen.height),
            ("IMAGE", WIDTH, HEIGHT)
        );
        assert_eq!(seen.passes["Image"], picture.layers[0].data);
    }
}
