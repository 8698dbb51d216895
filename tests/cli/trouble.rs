//! Interrupts, full disks, odd names, and files that are in each other's way.

use super::{Folder, interrupt, scene};
use serde_json::{Value, json};
use std::io::BufRead;
use std::process::Stdio;
use std::time::Duration;

/// A scene that takes Embree a while: a sheet of so many squares a side.
fn sheet(side: u32) -> Value {
    use base64::Engine;
    let mut bytes = Vec::new();
    let points = side + 1;
    for z in 0..points {
        for x in 0..points {
            let height = (0.3 * x as f32).sin() * (0.2 * z as f32).cos();
            for value in [x as f32 / side as f32, 0.1 * height, z as f32 / side as f32] {
                bytes.extend(value.to_le_bytes());
            }
        }
    }
    let vertices = bytes.len();
    for z in 0..side {
        for x in 0..side {
            let [a, b] = [z * points + x, (z + 1) * points + x];
            for index in [a, b, b + 1, a, b + 1, a + 1] {
                bytes.extend(index.to_le_bytes());
            }
        }
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let mut scene = scene();
    scene["accessors"] = json!([
        { "bufferView": 0, "componentType": 5126, "count": points * points, "type": "VEC3",
          "min": [0.0, -0.1, 0.0], "max": [1.0, 0.1, 1.0] },
        { "bufferView": 1, "componentType": 5125, "count": 6 * side * side, "type": "SCALAR" }
    ]);
    scene["bufferViews"] = json!([
        { "buffer": 0, "byteLength": vertices },
        { "buffer": 0, "byteOffset": vertices, "byteLength": bytes.len() - vertices }
    ]);
    scene["buffers"] = json!([{ "byteLength": bytes.len(),
        "uri": format!("data:application/octet-stream;base64,{data}") }]);
    scene
}

/// Whenever Ctrl-C comes, the process ends by itself and leaves nothing half done.
#[test]
fn an_interrupt_while_the_scene_is_prepared_is_no_crash() {
    let folder = Folder::new();
    folder.write("scene.gltf", sheet(200).to_string());
    for delay in 0..16 {
        let mut child = folder
            .command(&[
                "render",
                "scene.gltf",
                "-o",
                "a.png",
                "--width=16",
                "--samples=1",
            ])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(10 * delay));
        interrupt(&child);
        let status = child.wait().unwrap();
        // Before the program listens to it, Ctrl-C ends it as any other.
        use std::os::unix::process::ExitStatusExt;
        let by_itself = status.code() == Some(130) || status.success();
        assert!(
            by_itself || status.signal() == Some(2),
            "after {delay}0 ms: {status}"
        );
        let names = folder.names();
        assert!(
            names
                .iter()
                .all(|name| name == "a.png" || name == "scene.gltf"),
            "{names:?}"
        );
    }
}

/// A folder goes away while the picture is rendered: the picture is written elsewhere all the same.
#[test]
fn a_state_or_a_frame_that_cannot_be_written_takes_nothing_from_the_picture() {
    for (flag, value, file) in [
        ("--checkpoint", "gone/a.state", "gone/a.state"),
        ("--frames", "gone", "gone/frame-"),
    ] {
        let folder = Folder::with_scene();
        std::fs::create_dir(folder.path("gone")).unwrap();
        let mut child = folder
            .command(&[
                "render",
                "scene.gltf",
                "-o",
                "a.exr",
                "--width=24",
                "--time=10m",
                "--checkpoint-interval=0.01s",
                "--json",
                flag,
                value,
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().contains("\"progress\"")));
        std::fs::rename(folder.path("gone"), folder.path("elsewhere")).unwrap();
        let mut warnings = 0;
        for line in lines.by_ref() {
            let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
            if line["event"] == "warning" {
                assert!(line["message"].as_str().unwrap().contains(file), "{line}");
                warnings += 1;
                break;
            }
        }
        interrupt(&child);
        let rest: Vec<Value> = lines
            .map(|line| serde_json::from_str(&line.unwrap()).unwrap())
            .collect();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{flag}");
        warnings += rest
            .iter()
            .filter(|line| line["event"] == "warning")
            .count();
        assert_eq!(warnings, 1, "{flag}: once");
        assert!(rest.iter().any(|line| line["event"] == "written"), "{flag}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(
            message.contains(file) && message.contains("; a.exr is written"),
            "{message}"
        );
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert_eq!(folder.floats("a.exr").width, 24, "{flag}");
    }
}

#[test]
fn names_in_files_do_not_reach_the_terminal_as_commands() {
    let evil = "\u{1b}]0;owned\u{7}\r\nsundog: all is well \u{9b}31m\u{202e}gpj";
    let folder = Folder::new();
    let mut scene = scene();
    for (list, name) in [
        ("materials", "White"),
        ("nodes", "Floor"),
        ("meshes", "Square"),
    ] {
        scene[list][0]["name"] = json!(format!("{name}{evil}"));
    }
    scene["nodes"][1]["name"] = json!(format!("Eye{evil}"));
    scene["asset"]["generator"] = json!(evil);
    scene["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_sheen"]);
    scene["materials"][0]["extensions"] =
        json!({ "KHR_materials_sheen": { "sheenColorFactor": [1.0, 1.0, 1.0] } });
    folder.write("scene.gltf", scene.to_string());
    let no_camera = format!("Nose{evil}");
    for arguments in [
        &["info", "scene.gltf"][..],
        &["info", "scene.gltf", "--json"],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--width=8",
            "--samples=1",
        ],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--width=8",
            "--samples=1",
            "--json",
        ],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--camera",
            &no_camera,
        ],
        &["render", "scene.gltf", "-o", "a.png", "--strict"],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--width=8",
            "--replay=1,1,0",
        ],
        &["info", &no_camera],
        &["rendr", &no_camera],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--samples",
            &no_camera,
        ],
    ] {
        let output = folder.run(arguments);
        for bytes in [output.stdout, output.stderr] {
            let text = String::from_utf8(bytes).unwrap();
            assert!(
                !text
                    .contains(|symbol: char| symbol != '\n'
                        && (symbol.is_control() || symbol == '\u{202e}')),
                "{arguments:?}: {text:?}"
            );
            assert!(
                !text
                    .lines()
                    .any(|line| line.starts_with("sundog: all is well")),
                "{arguments:?}: {text:?}"
            );
        }
    }
    let info = folder.works(&["info", "scene.gltf"]);
    assert!(info.contains("\"White\\u{1b}]0;owned"), "{info}");
    // A program that reads JSON gets the name as it is.
    let info: Value =
        serde_json::from_str(&folder.works(&["info", "scene.gltf", "--json"])).unwrap();
    assert_eq!(info["materials"][0]["name"], format!("White{evil}"));
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_takes_nothing_is_an_error() {
    let folder = Folder::with_scene();
    folder.write_exr("a.exr", 16, 16, [0.5; 3]);
    for arguments in [
        &["info", "scene.gltf"][..],
        &["info", "scene.gltf", "--json"],
        &["flags"],
        &["flags", "--markdown"],
        &["completions", "bash"],
        &["color", "list"],
        &["compare", "a.exr", "a.exr"],
        &["selftest", "--list"],
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.png",
            "--width=8",
            "--samples=1",
            "--json",
        ],
        &["--version"],
    ] {
        let full = std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = folder.command(arguments).stdout(full).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert_eq!(
            message, "sundog: cannot write to the standard output: the disk is full\n",
            "{arguments:?}"
        );
    }
    assert!(
        folder.path("a.png").exists(),
        "the picture is there all the same"
    );
}

#[test]
fn what_is_read_is_not_written_over() {
    let folder = Folder::with_scene();
    let mut named = scene();
    named["images"] = json!([{ "uri": "white%20wall.png" }]);
    named["buffers"][0]["uri"] = json!("scene.exr");
    folder.write("named.gltf", named.to_string());
    folder.write("white wall.png", "");
    folder.write("scene.exr", "");
    folder.write("a.state", "");
    folder.write_exr("sky.exr", 4, 2, [1.0; 3]);
    for name in ["a.exr", "b.exr"] {
        folder.write_exr(name, 16, 16, [0.5; 3]);
    }
    std::fs::write(folder.path("p.png"), "").unwrap();
    std::fs::create_dir(folder.path("folder")).unwrap();
    std::fs::hard_link(folder.path("p.png"), folder.path("hard.png")).unwrap();
    std::os::unix::fs::symlink("p.png", folder.path("soft.png")).unwrap();
    let before: Vec<_> = folder.names();
    for (arguments, words) in [
        (
            &["render", "scene.gltf", "--checkpoint", "scene.gltf"][..],
            &["--checkpoint scene.gltf", "which is read"][..],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "./sky.exr",
                "--environment",
                "folder/../sky.exr",
            ],
            &["./sky.exr", "--environment"],
        ),
        (
            &["render", "named.gltf", "-o", "white wall.png"],
            &["white wall.png", "which the scene named.gltf needs"],
        ),
        (
            &["render", "named.gltf", "-o", "folder/../scene.exr"],
            &["scene.exr", "needs"],
        ),
        (
            &["render", "scene.gltf", "-o", "c.exr", "-o", "./c.exr"],
            &["c.exr", "./c.exr", "the same file"],
        ),
        (
            &["render", "scene.gltf", "-o", "p.png", "-o", "soft.png"],
            &["soft.png", "the same file"],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "c.exr",
                "--checkpoint",
                "folder/../c.exr",
            ],
            &["--checkpoint", "the same file"],
        ),
        (
            &["compare", "p.png", "b.exr", "--difference-map", "p.png"],
            &["p.png", "which is read"],
        ),
        (
            &["compare", "soft.png", "b.exr", "--difference-map", "p.png"],
            &["soft.png", "which is read"],
        ),
        (
            &["compare", "hard.png", "b.exr", "--difference-map", "p.png"],
            &["hard.png", "which is read"],
        ),
        (
            &[
                "compare", "a.exr", "b.exr", "--report", "r.html", "--csv", "./r.html",
            ],
            &["r.html", "the same file"],
        ),
        (
            &["color", "apply", "p.png", "./p.png"],
            &["./p.png", "which is read"],
        ),
        (
            &["merge", "a.state", "--checkpoint", "./a.state"],
            &["./a.state", "which is read"],
        ),
        (
            &["cost", "scene.gltf", "-o", "c.json", "-o", "./c.json"],
            &["c.json", "the same file"],
        ),
        (
            &[
                "converge",
                "scene.gltf",
                "-o",
                "folder",
                "-o",
                "folder/../folder/converge.json",
            ],
            &["converge.json", "the same file"],
        ),
    ] {
        folder.fails(arguments, 2, words);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn a_name_that_cannot_be_is_refused_before_the_render() {
    let folder = Folder::with_scene();
    let long = format!("{}.exr", "a".repeat(300));
    folder.fails(
        &["render", "scene.gltf", "-o", &long, "--time=10m"],
        1,
        &["aaa.exr", "the name is too long"],
    );
    folder.fails(
        &[
            "render",
            "scene.gltf",
            "-o",
            "a.exr",
            "--checkpoint",
            &long,
            "--time=10m",
        ],
        1,
        &["aaa.exr", "the name is too long"],
    );
}

/// Pictures that are small in their files and would take gigabytes.
#[test]
fn memory_out_of_proportion_is_not_taken() {
    use exr::prelude::*;
    let folder = Folder::new();
    let channels = SpecificChannels::rgb(|_| (0.5_f32, 0.5_f32, 0.5_f32));
    let layer = Layer::new(
        Vec2(1, 1),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        channels,
    );
    let window = IntegerBounds::new(Vec2(0, 0), Vec2(16_384, 16_384));
    let image = Image::from_layer(layer);
    let image = Image {
        attributes: ImageAttributes::new(window),
        ..image
    };
    image.write().to_file(folder.path("window.exr")).unwrap();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16_384, 16_384);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![0; 16_384 * 2048]).unwrap();
    writer.finish().unwrap();
    folder.write("bits.png", &bytes);
    for (arguments, words) in [
        (&["compare", "window.exr", "window.exr"][..], "window.exr"),
        (&["compare", "bits.png", "bits.png"], "bits.png"),
        (&["color", "apply", "window.exr", "a.png"], "window.exr"),
    ] {
        folder.fails(arguments, 1, &[words, "out of proportion"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_memory_is_a_sentence() {
    let folder = Folder::new();
    folder.write("scene.gltf", sheet(300).to_string());
    let within = |kibibytes: u32, arguments: &str| {
        let program = env!("CARGO_BIN_EXE_sundog");
        let output = std::process::Command::new("sh")
            .args([
                "-c",
                &format!("ulimit -v {kibibytes}; exec {program} {arguments}"),
            ])
            .current_dir(folder.path(""))
            .env("OCIO", "ocio://default")
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), message)
    };
    let sentence = |message: &str| {
        assert!(message.starts_with("sundog: "), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(!message.contains("this processor"), "{message}");
    };
    // Large pictures are refused before the work …
    for kibibytes in [800_000, 1_000_000] {
        let (code, message) = within(kibibytes, "render scene.gltf -o a.exr --width 8000 --quiet");
        assert_eq!(code, Some(1), "{message}");
        sentence(&message);
        assert!(
            message.contains("8000 × 4000") && message.contains("(ulimit -v) leaves"),
            "{message}"
        );
    }
    // … and what cannot be foreseen ends with a sentence, too. (The libraries alone take so much.)
    let begin = (1..100)
        .map(|step| step * 10_000)
        .find(|&kibibytes| within(kibibytes, "flags").0 == Some(0))
        .unwrap();
    let mut refused = 0;
    for step in 0..8 {
        let (code, message) = within(begin + step * 5_000, "info scene.gltf");
        match code {
            Some(0) => {}
            Some(1) => {
                sentence(&message);
                assert!(message.contains("memory"), "{message}");
                refused += 1;
            }
            _ => panic!("{code:?}: {message}"),
        }
    }
    assert!(refused > 0);
    assert_eq!(folder.names(), ["scene.gltf"]);
}
