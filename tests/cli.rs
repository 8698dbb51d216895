//! The program as people and scripts call it.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use sundog::film::{Layer, Picture};

/// A folder of its own for a test, and the program run in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sundog"));
        // What the tests say must not depend on whether there is a Blender.
        command
            .args(arguments)
            .current_dir(self.0.path())
            .env("OCIO", "ocio://default");
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments)
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    /// Runs what must work, and returns the standard output.
    fn works(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must fail: with this code, one sentence on the standard error that contains all these
    /// words, nothing on the standard output, and no file that was not there before.
    fn fails(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let before = self.names();
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert!(error.starts_with("sundog: "), "{arguments:?}: {error}");
        assert_eq!(
            error.trim_end().lines().count(),
            1,
            "{arguments:?}: {error}"
        );
        for word in words {
            assert!(
                error.contains(word),
                "{arguments:?}: no {word:?} in: {error}"
            );
        }
        assert!(
            !error.contains("panicked") && !error.contains("os error"),
            "{error}"
        );
        assert_eq!(output.stdout, b"", "{arguments:?}");
        assert_eq!(self.names(), before, "{arguments:?}");
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// A white square of two metres under a lamp, seen from above: `scene.gltf`.
    fn with_scene() -> Self {
        let folder = Self::new();
        folder.write("scene.gltf", scene().to_string());
        folder
    }

    /// An EXR of a constant colour.
    fn write_exr(&self, name: &str, width: u32, height: u32, color: [f32; 3]) {
        let pixels = (width * height) as usize;
        let layer = Layer {
            name: "Combined".into(),
            channels: ["R", "G", "B"].map(String::from).to_vec(),
            data: std::iter::repeat_n(color, pixels).flatten().collect(),
        };
        let picture = Picture {
            width,
            height,
            layers: vec![layer],
        };
        sundog::output::exr::write(&self.path(name), &picture, &Default::default(), &Vec::new())
            .unwrap();
    }
}

fn scene() -> Value {
    use base64::Engine;
    let positions: [[f32; 3]; 4] = [
        [-1.0, 0.0, -1.0],
        [-1.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
    ];
    let mut bytes: Vec<u8> = positions
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    for index in [0u16, 1, 2, 0, 2, 3] {
        bytes.extend(index.to_le_bytes());
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    // Turned by -90° about X, a camera and a lamp look down.
    let down = [
        -std::f64::consts::FRAC_1_SQRT_2,
        0.0,
        0.0,
        std::f64::consts::FRAC_1_SQRT_2,
    ];
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "name": "Lamp", "type": "point", "intensity": 6830.0 }
        ] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "name": "Floor", "mesh": 0 },
            { "name": "Eye", "camera": 0, "translation": [0.0, 3.0, 0.0], "rotation": down },
            { "name": "Lamp", "translation": [0.5, 2.0, 0.5],
              "extensions": { "KHR_lights_punctual": { "light": 0 } } }
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "aspectRatio": 2.0, "znear": 0.1 } }],
        "materials": [{ "name": "White", "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0 } }],
        "meshes": [{ "name": "Square", "primitives": [{
            "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [-1.0, 0.0, -1.0], "max": [1.0, 0.0, 1.0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}") }]
    })
}

#[test]
fn what_cannot_be_understood_is_a_usage_error() {
    let folder = Folder::with_scene();
    for (arguments, words) in [
        (&["rendr"][..], &["rendr"][..]),
        (&["render", "scene.gltf"], &["--output"]),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--width", "0"],
            &["--width", "0", "from 1 to"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--samples", "many"],
            &["--samples", "many"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--time", "soon"],
            &["--time", "30s"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--filter", "sinc"],
            &["--filter", "gauss"],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "a.exr",
                "--exr-type",
                "double",
            ],
            &["--exr-type", "half"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--sample", "1"],
            &["--samples"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.tif"],
            &["a.tif", ".exr", ".png", ".jpg"],
        ),
        (&["render", "scene.gltf", "-o", "a"], &["cannot write a:"]),
        (
            &["render", "scene.gltf", "-o", "a.exr", "-o", "a.exr"],
            &["a.exr", "twice"],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "a.exr",
                "--environment",
                "b.hdr",
                "--environment-color",
                "1,1,1",
            ],
            &["--environment", "--environment-color", "exclude"],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "a.exr",
                "--environment-strength",
                "2",
            ],
            &["--environment FILE"],
        ),
        (&["compare", "a.exr"], &["<B>"]),
        (&["completions", "tcsh"], &["tcsh", "bash"]),
    ] {
        folder.fails(arguments, 2, words);
    }
}

#[test]
fn what_cannot_be_done_is_one_sentence_before_any_work() {
    let folder = Folder::with_scene();
    folder.write("broken.gltf", "{ \"asset\": ");
    folder.write("empty.glb", "");
    folder.write("folder-file", "");
    std::fs::create_dir(folder.path("folder.exr")).unwrap();
    for (arguments, words) in [
        (
            &["render", "missing.glb", "-o", "a.exr"][..],
            &["missing.glb", "no such file"][..],
        ),
        (&["render", "broken.gltf", "-o", "a.exr"], &["broken.gltf"]),
        (&["render", "empty.glb", "-o", "a.exr"], &["empty.glb"]),
        (&["render", ".", "-o", "a.exr"], &["it is a folder"]),
        (
            &["render", "scene.gltf", "-o", "no/such/a.exr"],
            &["no/such/a.exr", "no folder", "create it"],
        ),
        (
            &["render", "scene.gltf", "-o", "folder-file/a.exr"],
            &["folder-file", "not a folder"],
        ),
        (
            &["render", "scene.gltf", "-o", "folder.exr"],
            &["folder.exr", "it is a folder"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.png", "--view", "Nowhere"],
            &["Nowhere", "there are:"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.png", "--display", "Lamp"],
            &["Lamp", "there are:"],
        ),
        (
            &["render", "scene.gltf", "-o", "a.png", "--ocio", "none.ocio"],
            &["none.ocio"],
        ),
        (&["info", "missing.glb"], &["missing.glb", "no such file"]),
        (
            &["compare", "a.exr", "b.exr"],
            &["cannot read a.exr", "no such file"],
        ),
    ] {
        folder.fails(arguments, 1, words);
    }
    #[cfg(unix)]
    folder.fails(
        &["render", "scene.gltf", "-o", "/dev/full.exr/a.exr"],
        1,
        &["/dev/full.exr"],
    );
}

#[test]
fn errors_about_the_scene_name_what_there_is() {
    let folder = Folder::with_scene();
    let render = ["render", "scene.gltf", "-o", "a.exr", "--quiet"];
    let with = |more: &[&'static str]| {
        render
            .iter()
            .copied()
            .chain(more.iter().copied())
            .collect::<Vec<_>>()
    };
    folder.fails(
        &with(&["--camera", "Nose"]),
        1,
        &["scene.gltf", "Nose", "0 \"Eye\""],
    );
    folder.fails(&with(&["--camera", "1"]), 1, &["0 \"Eye\""]);
    folder.fails(
        &with(&["--environment", "sky.hdr"]),
        1,
        &["sky.hdr", "no such file"],
    );
    folder.fails(
        &with(&["--width", "65536", "--height", "65536"]),
        1,
        &["65536 × 65536", "GiB"],
    );
}

#[test]
fn strict_refuses_what_is_not_exact() {
    let folder = Folder::new();
    let mut scene = scene();
    scene["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_sheen"]);
    scene["materials"][0]["extensions"] =
        json!({ "KHR_materials_sheen": { "sheenColorFactor": [1.0, 1.0, 1.0] } });
    folder.write("scene.gltf", scene.to_string());
    folder.fails(
        &["render", "scene.gltf", "-o", "a.exr", "--strict", "--quiet"],
        1,
        &["--strict", "KHR_materials_sheen"],
    );
    let info: Value =
        serde_json::from_str(&folder.works(&["info", "scene.gltf", "--json"])).unwrap();
    let features: Vec<_> = info["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["feature"].as_str().unwrap())
        .collect();
    assert_eq!(
        features
            .iter()
            .filter(|feature| feature.contains("KHR_materials_sheen"))
            .count(),
        1,
        "{features:?}"
    );
}

#[test]
fn an_error_is_a_line_of_json_too() {
    let folder = Folder::new();
    let output = folder.run(&["render", "missing.glb", "-o", "a.exr", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["event"], "error");
    let message = line["message"].as_str().unwrap();
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        format!("sundog: {message}\n")
    );
}

#[test]
fn info_tells_what_is_there() {
    let folder = Folder::with_scene();
    let info: Value =
        serde_json::from_str(&folder.works(&["info", "scene.gltf", "--json"])).unwrap();
    assert_eq!(info["triangles"], 2);
    assert_eq!(info["vertices"], 4);
    assert_eq!(info["instances"], 1);
    assert_eq!(info["cameras"][0]["name"], "Eye");
    assert!(
        (info["cameras"][0]["field_of_view"].as_f64().unwrap() - 0.5f64.to_degrees()).abs() < 1e-4
    );
    assert_eq!(info["lights"][0]["name"], "Lamp");
    assert_eq!(info["lights"][0]["kind"], "point");
    // 683 lm are a watt: 6830 cd are 10 W/sr.
    assert!((info["lights"][0]["strength"].as_f64().unwrap() - 10.0).abs() < 1e-5);
    assert_eq!(info["materials"][0]["name"], "White");
    assert_eq!(
        info["bounds"],
        json!({ "low": [-1.0, 0.0, -1.0], "high": [1.0, 0.0, 1.0] })
    );
    // Four positions of 12 bytes and two triangles of 12 at least.
    assert!(info["memory"]["geometry"].as_u64().unwrap() >= 72);
    let page = folder.works(&["info", "scene.gltf"]);
    for expected in [
        "\"Eye\"",
        "\"Lamp\" point 10 W/sr",
        "2 triangles",
        "\"White\"",
    ] {
        assert!(page.contains(expected), "{expected}: {page}");
    }
}

#[test]
fn info_follows_the_units_it_is_told() {
    let folder = Folder::with_scene();
    let strength = |units: &str| {
        let text = folder.works(&["info", "scene.gltf", "--json", "--light-units", units]);
        serde_json::from_str::<Value>(&text).unwrap()["lights"][0]["strength"]
            .as_f64()
            .unwrap()
    };
    assert!((strength("unitless") - 6830.0).abs() < 1e-3);
    // Raw: watts over the whole sphere.
    assert!((strength("raw") - 6830.0 / (4.0 * std::f64::consts::PI)).abs() < 1e-3);
}

#[test]
fn compare_says_what_the_library_measures() {
    let folder = Folder::new();
    folder.write_exr("a.exr", 20, 10, [0.5, 0.25, 0.125]);
    folder.write_exr("b.exr", 20, 10, [0.25, 0.25, 0.125]);
    let text = folder.works(&[
        "compare",
        "a.exr",
        "b.exr",
        "--json",
        "--difference-map",
        "map.png",
    ]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    let number = |name: &str| answer[name].as_f64().unwrap();
    // (0.25², 0, 0) / 3 and (0.25² / (0.25² + 0.01)) / 3.
    assert!((number("rmse") - (0.0625f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((number("rel_mse") - 0.0625 / 0.0725 / 3.0).abs() < 1e-12);
    let luminance = |r: f64| 0.2126 * r + 0.7152 * 0.25 + 0.0722 * 0.125;
    assert!((number("luminance_ratio") - luminance(0.5) / luminance(0.25)).abs() < 1e-12);
    assert!(number("flip") > 0.01);
    let map = image::open(folder.path("map.png")).unwrap();
    assert!(map.width() >= 20 && map.height() > 10);
    let page = folder.works(&["compare", "a.exr", "a.exr"]);
    assert!(page.contains("RMSE             0.000000e0"), "{page}");
}

#[test]
fn compare_refuses_what_cannot_be_compared() {
    let folder = Folder::new();
    folder.write_exr("a.exr", 2, 2, [0.5; 3]);
    folder.write_exr("wide.exr", 3, 2, [0.5; 3]);
    folder.write("text.exr", "not a picture");
    image::RgbImage::new(2, 2)
        .save(folder.path("a.png"))
        .unwrap();
    folder.fails(
        &["compare", "a.exr", "wide.exr"],
        1,
        &["a.exr", "wide.exr", "2 × 2", "3 × 2"],
    );
    folder.fails(
        &["compare", "a.exr", "a.png"],
        1,
        &["linear light", "display values"],
    );
    folder.fails(
        &["compare", "a.exr", "text.exr"],
        1,
        &["text.exr", "neither EXR, HDR, PNG nor JPEG"],
    );
    folder.fails(
        &["compare", "a.exr", "a.exr", "--layer", "Depth"],
        1,
        &["no layer Depth", "Combined"],
    );
    folder.fails(
        &["compare", "a.exr", "a.exr", "--difference-map", "map.exr"],
        2,
        &["map.exr", ".png"],
    );
    folder.fails(
        &[
            "compare",
            "a.exr",
            "a.exr",
            "--difference-map",
            "no/map.png",
        ],
        1,
        &["no/map.png", "no folder"],
    );
}

#[test]
fn the_program_describes_itself() {
    let folder = Folder::new();
    let flags: Value = serde_json::from_str(&folder.works(&["flags", "--json"])).unwrap();
    let render = flags["commands"]
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["name"] == "render")
        .unwrap();
    let arguments = render["groups"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|g| g["arguments"].as_array().unwrap());
    let samples = arguments.clone().find(|a| a["name"] == "samples").unwrap();
    assert_eq!(
        (&samples["type"], &samples["default"], &samples["min"]),
        (&json!("integer"), &json!("256"), &json!(1))
    );
    // What help shows is what the list says.
    let help = folder.works(&["render", "--help"]);
    for argument in arguments {
        let shown = match argument["positional"].as_bool() {
            Some(true) => format!("<{}>", argument["placeholder"].as_str().unwrap()),
            _ => format!("--{}", argument["name"].as_str().unwrap()),
        };
        assert!(help.contains(&shown), "{shown}");
    }
    let version = folder.works(&["--version"]);
    assert!(
        version.contains(env!("CARGO_PKG_VERSION")) && version.contains("OpenColorIO 2."),
        "{version}"
    );
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = folder.works(&["completions", shell]);
        assert!(script.contains("environment-rotation"), "{shell}");
    }
    assert!(folder.works(&["flags", "--man"]).starts_with(".ie"));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::with_scene();
    let mut child = folder
        .command(&["flags", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(output.stderr, b"");
}

#[test]
fn file_names_need_not_be_unicode() {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        let folder = Folder::with_scene();
        let name = Path::new(std::ffi::OsStr::from_bytes(b"sc\xffne.gltf"));
        std::fs::rename(folder.path("scene.gltf"), folder.0.path().join(name)).unwrap();
        let output = folder
            .command(&["info", "--json"])
            .arg(name)
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
    }
}
