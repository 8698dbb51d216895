//! The program as people and scripts call it.

mod cost;
mod denoise;
mod materials;
mod nodes;
mod tev;
mod trouble;

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
        (&["render", "scene.gltf", "--frames", "."], &["--json"]),
        (
            &["render", "scene.gltf", "-o", "a.exr", "--region", "3,0,3,9"],
            &["--region", "X0 < X1"],
        ),
        (
            &[
                "render",
                "scene.gltf",
                "-o",
                "a.exr",
                "--width=24",
                "--region=0,0,25,2",
                "--quiet",
            ],
            &["--region", "24 × 12"],
        ),
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
        (
            &["info", "scene.gltf", "--cycles", "3.6"],
            &["--cycles", "4.2", "4.5"],
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
fn a_black_picture_is_told_with_its_cause_and_a_way_out() {
    let folder = Folder::with_scene();
    let warnings = |file: &str, more: &[&str]| -> Vec<String> {
        let mut arguments = vec!["render", file, "-o", "x.exr", "--json", "--samples", "2"];
        arguments.extend(["--width", "16", "--height", "8"]);
        arguments.extend(more);
        let lines = folder.works(&arguments);
        let events = lines
            .lines()
            .map(|line| serde_json::from_str::<Value>(line).unwrap());
        let warnings = events.filter(|event| event["event"] == "warning");
        warnings
            .map(|event| event["message"].as_str().unwrap().to_owned())
            .collect()
    };
    let told = |warnings: Vec<String>, words: &[&str]| {
        let [warning] = &warnings[..] else {
            panic!("{warnings:?}")
        };
        assert!(warning.contains("black"), "{warning}");
        for word in words {
            assert!(warning.contains(word), "no {word} in: {warning}");
        }
    };
    assert_eq!(warnings("scene.gltf", &[]), [""; 0]);
    // As lux and candela, a lamp that was meant without units gives next to nothing.
    let mut weak = scene();
    weak["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(1.0);
    folder.write("weak.gltf", weak.to_string());
    assert_eq!(warnings("weak.gltf", &[]), [""; 0]);
    let dark = warnings("weak.gltf", &["--light-units", "standard"]);
    told(dark, &["lamps", "--light-units unitless"]);
    let mut away = scene();
    away["nodes"][1]["rotation"] = json!([0.0, 0.0, 0.0, 1.0]);
    folder.write("away.gltf", away.to_string());
    told(warnings("away.gltf", &[]), &["camera sees nothing"]);
    let mut none = scene();
    none["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(0.0);
    folder.write("none.gltf", none.to_string());
    told(warnings("none.gltf", &[]), &["--environment-color"]);
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
fn a_file_without_a_camera_is_seen_whole_and_one_without_light_is_told() {
    let folder = Folder::new();
    let mut scene = scene();
    let nodes = scene["nodes"].as_array_mut().unwrap();
    nodes.retain(|node| node.get("camera").is_none() && node.get("extensions").is_none());
    let roots: Vec<_> = (0..nodes.len()).collect();
    scene["scenes"][0]["nodes"] = json!(roots);
    scene.as_object_mut().unwrap().remove("cameras");
    folder.write("bare.gltf", scene.to_string());
    let small = ["--width", "24", "--height", "24", "--samples", "4"];
    let render = |more: &[&str]| {
        let mut arguments = vec!["render", "bare.gltf", "-o", "x.png", "-o", "x.exr"];
        arguments.extend(small);
        arguments.extend(more);
        let output = folder.run(&arguments);
        assert!(output.status.success(), "{more:?}: {output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let dark = render(&[]);
    assert!(
        dark.contains("no camera in the file") && dark.contains("the picture is black"),
        "{dark}"
    );
    let lit = render(&["--environment-color", "1,1,1", "--transparent"]);
    assert!(
        lit.contains("no camera in the file") && !lit.contains("black"),
        "{lit}"
    );
    // The square stands in the middle and is not cut off.
    let (picture, alphas) = sundog::measure::load_with_alpha(&folder.path("x.exr"), None).unwrap();
    assert_eq!((picture.width, picture.height), (24, 24));
    let alphas = alphas.unwrap();
    let alpha = |x: usize, y: usize| alphas[y * 24 + x];
    assert_eq!(alpha(12, 12), 1.0);
    for i in 0..24 {
        assert_eq!(
            [alpha(i, 0), alpha(i, 23), alpha(0, i), alpha(23, i)],
            [0.0; 4]
        );
    }
    folder.fails(
        &["render", "bare.gltf", "-o", "y.png", "--strict", "--quiet"],
        1,
        &["no camera"],
    );
    // Nothing to look at.
    scene["nodes"] = json!([]);
    scene["scenes"][0]["nodes"] = json!([]);
    folder.write("empty.gltf", scene.to_string());
    folder.fails(
        &["render", "empty.gltf", "-o", "y.png", "--quiet"],
        1,
        &["empty.gltf", "no camera"],
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
    let effect = |name: &str| {
        let all = info["effects"].as_array().unwrap();
        all.iter().find(|found| found["effect"] == name).unwrap()
    };
    let lamps = effect("point-lights");
    assert_eq!(lamps["state"], "needed");
    assert_eq!(
        lamps["because_of"],
        json!([{ "kind": "light", "name": "Lamp" }])
    );
    assert_eq!(effect("coat")["state"], "left-out");
    assert_eq!(
        effect("coat")["reasons"],
        json!(["weight 0 in the only material"])
    );
    let page = folder.works(&["info", "scene.gltf"]);
    for expected in [
        "point-lights (point lights, with a size or without): Lamp",
        "diffuse-transmission, dispersion: weight 0 in the only material",
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
    assert!((number("mape") - 0.25 / 0.26 / 3.0).abs() < 1e-12);
    assert!((number("smape") - 0.5 / 0.77 / 3.0).abs() < 1e-12);
    assert!(number("flip") > 0.01 && number("hdr_flip") > 0.01);
    assert_eq!(answer["ssim"], Value::Null);
    let map = image::open(folder.path("map.png")).unwrap();
    assert!(map.width() >= 20 && map.height() > 10);
    let page = folder.works(&["compare", "a.exr", "a.exr"]);
    assert!(page.contains("RMSE             0.000000e0"), "{page}");
}

#[test]
fn compare_writes_a_page_and_a_table() {
    let folder = Folder::new();
    folder.write_exr("a<b>.exr", 20, 10, [0.5, 0.25, 0.125]);
    folder.write_exr("b.exr", 20, 10, [0.25, 0.25, 0.125]);
    let arguments = ["compare", "a<b>.exr", "b.exr", "--report", "page.html"];
    folder.works(&[&arguments[..], &["--csv", "numbers.csv"]].concat());
    let page = std::fs::read_to_string(folder.path("page.html")).unwrap();
    assert!(page.contains("<h1>a&lt;b&gt;.exr against b.exr</h1>"));
    assert!(
        page.contains("default-src 'none'") && !page.contains("http:") && !page.contains("https:")
    );
    for part in ["slider", "map", "plot", "sortable", "settings"] {
        assert!(page.contains(&format!("class=\"{part}\"")), "{part}");
    }
    let table = std::fs::read_to_string(folder.path("numbers.csv")).unwrap();
    let rmse = table.lines().find_map(|line| line.strip_prefix("RMSE,"));
    let rmse: f64 = rmse.unwrap().split(',').next().unwrap().parse().unwrap();
    assert!((rmse - (0.0625f64 / 3.0).sqrt()).abs() < 1e-12);
    folder.fails(
        &["compare", "b.exr", "b.exr", "--report", "page.htm"],
        2,
        &["page.htm", ".html"],
    );
}

#[test]
fn compare_measures_what_a_view_shows() {
    let folder = Folder::new();
    folder.write_exr("a.exr", 24, 16, [0.5, 0.25, 4.0]);
    folder.write_exr("b.exr", 24, 16, [0.4, 0.3, 2.0]);
    let compare = |arguments: &[&str]| -> Value {
        let text = folder.works(&[&["compare", "--json"], arguments].concat());
        serde_json::from_str(&text).unwrap()
    };
    let plain = compare(&["a.exr", "b.exr"]);
    let view: [&str; 4] = [
        "--view",
        "ACES 2.0 - SDR 100 nits (Rec.709)",
        "--exposure",
        "0.5",
    ];
    let viewed = compare(&[&["a.exr", "b.exr"], &view[..]].concat());
    for name in [
        "rmse",
        "rel_mse",
        "mape",
        "smape",
        "hdr_flip",
        "mean_luminance_a",
    ] {
        assert_eq!(plain[name], viewed[name], "{name}");
    }
    // The same as of the files that the view makes, which are rounded to 16 bits.
    for name in ["a", "b"] {
        let (from, to) = (format!("{name}.exr"), format!("{name}.png"));
        folder.works(&[&["color", "apply", &from, &to, "--depth", "16"], &view[..]].concat());
    }
    let shown = compare(&["a.png", "b.png"]);
    for name in ["flip", "ssim"] {
        let number = |answer: &Value| answer[name].as_f64().unwrap();
        assert!((number(&viewed) - number(&shown)).abs() < 1e-4, "{name}");
        assert!((number(&viewed) - number(&plain)).abs() > 1e-3, "{name}");
    }
    assert!(
        viewed["seen"]
            .as_str()
            .unwrap()
            .contains("ACES 2.0 - SDR 100 nits (Rec.709)")
    );
    folder.fails(
        &["compare", "a.png", "b.png", "--view", "Raw"],
        2,
        &["--view", "linear light"],
    );
    folder.fails(
        &["compare", "a.exr", "b.exr", "--view", "Nothing"],
        1,
        &["Nothing", "ACES 2.0 - SDR 100 nits (Rec.709)"],
    );
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
fn converge_measures_itself_and_what_lies_in_a_folder() {
    let folder = Folder::with_scene();
    let base = [
        "converge",
        "scene.gltf",
        "--width=24",
        "--samples=6",
        "--seeds=2",
        "--json",
        "--environment-color=0.2,0.3,0.4",
    ];
    let run = |more: &[&str]| -> Vec<Value> {
        let text = folder.works(&[&base[..], more].concat());
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    };
    let events = run(&[
        "-o",
        "out",
        "-o",
        "plot.svg",
        "--pictures",
        "kept",
        "--name",
        "First",
    ]);
    let points = |events: &[Value], name: &str| -> Vec<(u64, u64)> {
        let of = |event: &&Value| event["event"] == "measured" && event["renderer"] == name;
        let number = |event: &Value, key: &str| event["point"][key].as_u64().unwrap();
        events
            .iter()
            .filter(of)
            .map(|e| (number(e, "seed"), number(e, "samples")))
            .collect()
    };
    // Powers of two, and the end.
    let expected = [
        (0, 1),
        (0, 2),
        (0, 4),
        (0, 6),
        (1, 1),
        (1, 2),
        (1, 4),
        (1, 6),
    ];
    assert_eq!(points(&events, "First"), expected);
    let answer = &events.last().unwrap()["answer"];
    let rows = answer["renderers"][0]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    assert_eq!(rows[3]["seeds"], 2);
    assert!(
        answer["renderers"][0]["slopes"]["smape"]["slope"]
            .as_f64()
            .is_some()
    );
    for name in [
        "converge.html",
        "converge.json",
        "converge.csv",
        "smape-against-time.png",
    ] {
        assert!(folder.path("out").join(name).is_file(), "{name}");
    }
    let csv = std::fs::read_to_string(folder.path("out/converge.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 8);
    assert!(
        std::fs::read_to_string(folder.path("plot.svg"))
            .unwrap()
            .contains("<svg")
    );
    let page = std::fs::read_to_string(folder.path("out/converge.html")).unwrap();
    assert!(page.contains("First, 6 samples") && page.contains("reference"));

    // The kept pictures are the same renderer: equal errors, and equal pictures whatever the time. Against the same reference:
    // the seeds of both are the same.
    let events = run(&["--against", "kept"]);
    assert_eq!(points(&events, "First"), expected);
    let answer = &events.last().unwrap()["answer"];
    let errors = |renderer: usize| -> Vec<f64> {
        let rows = answer["renderers"][renderer]["rows"].as_array().unwrap();
        rows.iter()
            .map(|row| row["flip"]["mean"].as_f64().unwrap())
            .collect()
    };
    assert_eq!(errors(0), errors(1));
    assert!(errors(0)[0] > errors(0)[3]);
    assert_eq!(answer["against"][0]["renderer"], "First");
    // A reference that is the picture itself leaves no error.
    let events = run(&["--reference=kept/first-1-6.exr"]);
    let points = events.last().unwrap()["answer"]["renderers"][0]["points"].clone();
    let last = points.as_array().unwrap().last().unwrap();
    assert_eq!(
        (&last["rel_mse"], &last["flip"]),
        (&json!(0.0), &json!(0.0))
    );
    assert_eq!(
        last["ssim"].as_f64().map(|ssim| (ssim - 1.0).abs() < 1e-12),
        Some(true)
    );
}

#[test]
fn converge_refuses_before_it_renders() {
    let folder = Folder::with_scene();
    folder.write_exr("small.exr", 3, 2, [0.5; 3]);
    std::fs::create_dir(folder.path("empty")).unwrap();
    std::fs::create_dir(folder.path("broken")).unwrap();
    folder.write("broken/times.json", "{");
    std::fs::create_dir(folder.path("sizes")).unwrap();
    folder.write_exr("sizes/a.exr", 3, 2, [0.5; 3]);
    let times =
        json!({ "renderer": "A", "pictures": [{ "file": "a.exr", "samples": 1, "seconds": 1 }] });
    folder.write("sizes/times.json", times.to_string());
    for (arguments, code, words) in [
        (&["--against", "no"][..], 1, &["no: ", "no such folder"][..]),
        (
            &["--against", "empty"],
            1,
            &["times.json", "docs/converge.md"],
        ),
        (
            &["--against", "broken"],
            1,
            &["broken/times.json", "docs/converge.md"],
        ),
        (&["--against", "sizes"], 1, &["a.exr", "3 × 2", "24 × 12"]),
        (&["--reference", "no.exr"], 1, &["no.exr", "no such file"]),
        (
            &["--reference", "small.exr"],
            1,
            &["small.exr", "3 × 2", "--width"],
        ),
        (&["-o", "a.tif"], 2, &["a.tif", ".html"]),
        (&["-o", "scene.gltf/out"], 1, &["scene.gltf/out", "file"]),
        (&["--seed", "2147483648"], 2, &["--seed", "reference"]),
    ] {
        let all = [
            &[
                "converge",
                "scene.gltf",
                "--quiet",
                "--width=24",
                "--samples=1",
            ],
            arguments,
        ]
        .concat();
        folder.fails(&all, code, words);
    }
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
        version.contains(env!("CARGO_PKG_VERSION"))
            && version.contains("OpenColorIO 2.")
            && version.contains("Embree 4.")
            && version.contains(" (avx2)\n") | version.contains(" (sse4.2)\n"),
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

/// The arguments of a quick render of `scene.gltf`.
const QUICK: [&str; 7] = [
    "render",
    "scene.gltf",
    "--width=24",
    "--samples=4",
    "--seed=3",
    "--threads=2",
    "--quiet",
];

impl Folder {
    /// Renders quickly with further arguments.
    fn renders(&self, more: &[&str]) -> String {
        let arguments: Vec<_> = QUICK.iter().chain(more).copied().collect();
        self.works(&arguments)
    }

    fn floats(&self, name: &str) -> sundog::measure::RgbImage {
        sundog::measure::load(&self.path(name), None).unwrap()
    }
}

#[test]
fn all_formats_hold_the_same_picture() {
    let folder = Folder::with_scene();
    let view = [
        "--ocio",
        "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1",
        "--display",
        "sRGB - Display",
        "--view",
        "Raw",
    ];
    let mut arguments = vec![
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "-o",
        "a.jpeg",
        "--quality=100",
    ];
    arguments.extend(view);
    assert_eq!(folder.renders(&arguments), "");
    let linear = folder.floats("a.exr");
    // 24 pixels wide; the camera's aspect is 2.
    assert_eq!((linear.width, linear.height), (24, 12));
    assert!(
        linear.pixels.iter().any(|pixel| pixel[0] > 0.1),
        "the lamp lights nothing"
    );
    // "Raw" shows the numbers as they are, so that the PNG holds the EXR's, rounded.
    let png = image::open(folder.path("a.png")).unwrap().into_rgb8();
    let expected: Vec<u8> = linear
        .pixels
        .iter()
        .flatten()
        .map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
        .collect();
    let difference = png
        .as_raw()
        .iter()
        .zip(&expected)
        .map(|(a, b)| a.abs_diff(*b))
        .max();
    // One code value, because OpenColorIO's arithmetic may round a tie to the other side.
    assert!(difference <= Some(1), "{difference:?}");
    let jpeg = image::open(folder.path("a.jpeg")).unwrap().into_rgb8();
    assert_eq!(jpeg.dimensions(), (24, 12));
    let mean =
        |image: &image::RgbImage| image.as_raw().iter().map(|v| f64::from(*v)).sum::<f64>() / 864.0;
    assert!((mean(&jpeg) - mean(&png)).abs() < 2.0);
    assert_eq!(folder.names(), ["a.exr", "a.jpeg", "a.png", "scene.gltf"]);
}

#[test]
fn settings_of_files_are_heeded() {
    let folder = Folder::with_scene();
    folder.renders(&[
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "--depth=16",
        "--exr-type=half",
        "--exr-compression=piz",
    ]);
    assert_eq!(
        image::open(folder.path("a.png")).unwrap().color(),
        image::ColorType::Rgb16
    );
    folder.renders(&[
        "-o",
        "b.exr",
        "--exr-layers=combined",
        "--exr-compression=none",
    ]);
    let header = |name: &str| {
        exr::meta::MetaData::read_from_file(folder.path(name), true)
            .unwrap()
            .headers
            .swap_remove(0)
    };
    let channels = |name: &str| -> Vec<(String, exr::meta::attribute::SampleType)> {
        header(name)
            .channels
            .list
            .iter()
            .map(|c| (c.name.to_string(), c.sample_type))
            .collect()
    };
    use exr::meta::attribute::SampleType::{F16, F32};
    let expected = [
        ("A", F16),
        ("B", F16),
        ("Debug Sample Count.X", F32),
        ("Depth.Z", F32),
        ("Error.X", F32),
        ("G", F16),
        ("Normal.X", F16),
        ("Normal.Y", F16),
        ("Normal.Z", F16),
        ("Position.X", F32),
        ("Position.Y", F32),
        ("Position.Z", F32),
        ("R", F16),
    ];
    assert_eq!(
        channels("a.exr"),
        expected.map(|(name, kind)| (name.to_owned(), kind))
    );
    assert_eq!(
        channels("b.exr"),
        ["A", "B", "G", "R"].map(|name| (name.to_owned(), F32))
    );
    assert_eq!(
        header("a.exr").compression,
        exr::compression::Compression::PIZ
    );
    assert_eq!(
        header("b.exr").compression,
        exr::compression::Compression::Uncompressed
    );
    // 16 bits have 11 significant ones.
    let (half, float) = (folder.floats("a.exr"), folder.floats("b.exr"));
    for (half, float) in half
        .pixels
        .iter()
        .flatten()
        .zip(float.pixels.iter().flatten())
    {
        assert!(
            (half - float).abs() <= float.abs() / 2048.0 + 3e-8,
            "{half} {float}"
        );
    }
}

/// Parts by other instructions of the processor are other pictures: named everywhere, and never mixed.
#[test]
fn instructions_are_named_and_not_mixed() {
    let folder = Folder::with_scene();
    const SMALL: [&str; 6] = [
        "render",
        "scene.gltf",
        "-q",
        "--width=24",
        "--height=16",
        "--threads=2",
    ];
    let part = |set: &str, range: &str, file: &str| {
        let more = [
            "--instruction-set",
            set,
            "--sample-range",
            range,
            "--checkpoint",
            file,
        ];
        folder.works(&[&SMALL[..], &more].concat());
    };
    part("sse4.2", "0..2", "a.state");
    part("sse4.2", "2..4", "b.state");
    folder.works(&["merge", "a.state", "b.state", "-o", "a.exr"]);
    let header = exr::meta::MetaData::read_from_file(folder.path("a.exr"), true)
        .unwrap()
        .headers
        .swap_remove(0);
    let other = &header.own_attributes.other;
    let name = exr::meta::attribute::Text::from("sundog/version/embree");
    let Some(exr::meta::attribute::AttributeValue::Text(embree)) = other.get(&name) else {
        panic!("no version of Embree")
    };
    assert!(embree.to_string().ends_with(" (sse4.2)"), "{embree}");
    let version = |set: &str| {
        let mut command = folder.command(&["--version"]);
        let output = command.env("SUNDOG_INSTRUCTION_SET", set).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(version("sse4.2").contains(" (sse4.2)\n"));
    assert!(version("mmx").contains("expected avx2 or sse4.2"));
    if !sundog::render::InstructionSet::Avx2.is_here() {
        let asked = [&SMALL[..], &["-o", "b.exr", "--instruction-set=avx2"]].concat();
        folder.fails(&asked, 1, &["this processor lacks", "ask for sse4.2"]);
        return;
    }
    part("avx2", "2..4", "c.state");
    let mixed = ["merge", "a.state", "c.state", "-o", "b.exr"];
    let words = [
        "a.state and c.state",
        "sse4.2, the second with avx2",
        "--instruction-set sse4.2",
    ];
    folder.fails(&mixed, 1, &words);
    let goes_on = |set| {
        let more = [
            "--sample-range",
            "0..3",
            "--checkpoint",
            "a.state",
            "--instruction-set",
            set,
        ];
        [&SMALL[..], &more].concat()
    };
    folder.fails(&goes_on("avx2"), 1, &["give --instruction-set sse4.2"]);
    let state = std::fs::read(folder.path("a.state")).unwrap();
    folder.works(&goes_on("sse4.2"));
    assert!(std::fs::read(folder.path("a.state")).unwrap() != state);
}

#[test]
fn a_picture_says_how_it_was_made() {
    let folder = Folder::with_scene();
    folder.renders(&[
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "--view=Raw",
        "--exposure=-1.5",
        "--effects=suns,gloss",
    ]);
    let header = exr::meta::MetaData::read_from_file(folder.path("a.exr"), true)
        .unwrap()
        .headers
        .swap_remove(0);
    let text = |name: &str| match header
        .own_attributes
        .other
        .get(&exr::meta::attribute::Text::from(name))
    {
        Some(exr::meta::attribute::AttributeValue::Text(text)) => text.to_string(),
        other => panic!("{name}: {other:?}"),
    };
    let info: Value =
        serde_json::from_str(&folder.works(&["info", "scene.gltf", "--json"])).unwrap();
    assert_eq!(text("sundog/scene-hash"), info["hash"].as_str().unwrap());
    assert_eq!(text("sundog/scene"), "scene.gltf");
    assert_eq!(text("sundog/samples"), "4");
    assert_eq!(text("sundog/version/sundog"), env!("CARGO_PKG_VERSION"));
    assert!(text("sundog/version/embree").starts_with("4."));
    assert!(text("sundog/version/opencolorio").starts_with("2."));
    let settings: Value = serde_json::from_str(&text("sundog/settings")).unwrap();
    assert_eq!(
        (&settings["width"], &settings["seed"]),
        (&json!(24), &json!(3))
    );
    let statistics: Value = serde_json::from_str(&text("sundog/statistics")).unwrap();
    assert!(statistics["rays"].as_u64().unwrap() > 0);
    assert_eq!(statistics["left_out"], json!(["point-lights"]));
    assert_eq!(text("sundog/effects/left-out"), "point-lights");
    assert!(text("sundog/effects").contains("gloss"));

    let decoder = png::Decoder::new(std::io::BufReader::new(
        std::fs::File::open(folder.path("a.png")).unwrap(),
    ));
    let reader = decoder.read_info().unwrap();
    let chunk = |name: &str| {
        let chunk = reader
            .info()
            .utf8_text
            .iter()
            .find(|chunk| chunk.keyword == name);
        chunk
            .map(|chunk| chunk.get_text().unwrap())
            .unwrap_or_default()
    };
    assert_eq!(
        (
            chunk("sundog/view").as_str(),
            chunk("sundog/exposure").as_str()
        ),
        ("Raw", "-1.5")
    );
    assert_eq!(chunk("sundog/look"), "None");
    assert!(chunk("sundog/config").starts_with("ocio://default"));
    for name in ["sundog/scene-hash", "sundog/effects/left-out"] {
        assert_eq!(chunk(name), text(name));
    }
}

#[test]
fn the_picture_depends_on_the_seed_and_not_on_the_threads() {
    let folder = Folder::with_scene();
    let render = |name: &str, threads: &str, seed: &str| {
        folder.works(&[
            "render",
            "scene.gltf",
            "-o",
            name,
            "--width=24",
            "--samples=4",
            "--quiet",
            threads,
            seed,
        ]);
        folder.floats(name)
    };
    let one = render("a.exr", "--threads=1", "--seed=0");
    assert_eq!(one, render("b.exr", "--threads=3", "--seed=0"));
    assert_ne!(one, render("c.exr", "--threads=1", "--seed=1"));
}

#[test]
fn each_event_is_a_line_of_json() {
    let folder = Folder::with_scene();
    let output = folder.run(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "--width=24",
        "--samples=4",
        "--json",
    ]);
    assert!(output.status.success());
    assert_eq!(output.stderr, b"");
    let text = String::from_utf8(output.stdout).unwrap();
    let events: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let names: Vec<_> = events
        .iter()
        .map(|event| event["event"].as_str().unwrap())
        .collect();
    let first_progress = names.iter().position(|name| *name == "progress").unwrap();
    assert!(
        names[..first_progress].contains(&"scene") && names[..first_progress].contains(&"prepared"),
        "{names:?}"
    );
    assert_eq!(names[names.len() - 3..], ["written", "written", "finished"]);
    let fractions: Vec<_> = events
        .iter()
        .filter(|e| e["event"] == "progress")
        .map(|e| e["fraction"].as_f64().unwrap())
        .collect();
    assert!(
        fractions.is_sorted() && fractions.last() == Some(&1.0),
        "{fractions:?}"
    );
    let finished = events.last().unwrap();
    assert_eq!(finished["statistics"]["stop"], "samples");
    assert_eq!(finished["statistics"]["samples"], 4);
    assert_eq!(finished["statistics"]["non_finite"], 0);
    assert_eq!(finished["written"], json!(["a.exr", "a.png"]));
}

/// What is lost is told with its cause and how to see it; and seeing it tells the same.
#[test]
fn samples_that_are_not_finite_are_told_and_can_be_replayed() {
    let folder = Folder::new();
    // A sky of two colours, as one of one colour has no light samples: it is their density that the light is too bright for.
    let mut scene = scene();
    scene["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(0.0);
    folder.write("scene.gltf", scene.to_string());
    let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
    let rows = [[[255u8; 4]; 4], [[200, 200, 200, 255]; 4]];
    folder.write(
        "sky.hdr",
        [&head[..], rows.as_flattened().as_flattened()].concat(),
    );
    let flags = [
        "render",
        "scene.gltf",
        "--width",
        "16",
        "--samples",
        "2",
        "--seed",
        "3",
        "--environment",
        "sky.hdr",
        "--json",
    ];
    let parse = |text: String| -> Vec<Value> {
        let lines = text.lines();
        lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    };
    let events = parse(folder.works(&[&flags[..], &["-o", "a.exr"]].concat()));
    let statistics = &events.last().unwrap()["statistics"];
    let count = statistics["non_finite"].as_u64().unwrap();
    let causes = statistics["non_finite_causes"].as_object().unwrap();
    let sum: u64 = causes.values().map(|count| count.as_u64().unwrap()).sum();
    assert!(count > 0 && sum == count, "{statistics}");
    let place = &statistics["non_finite_examples"][0];
    let place = format!("{},{},{}", place[0], place[1], place[2]);
    let warning = events.iter().find(|e| e["event"] == "warning").unwrap();
    let message = warning["message"].as_str().unwrap();
    assert!(message.contains(&format!("--replay {place}")), "{message}");
    assert!(message.contains("the environment"), "{message}");

    let events = parse(folder.works(&[&flags[..], &["--replay", &place]].concat()));
    let replay = &events.last().unwrap()["replay"];
    assert!(
        causes.contains_key(replay["cause"].as_str().unwrap()),
        "{replay}"
    );
    assert_eq!(replay["steps"][0]["step"], "ray");
    assert_eq!(replay["same_bits"], true);
    let text = folder.works(&["render", "scene.gltf", "--width", "16", "--replay", "8,4,0"]);
    for word in ["pixel 8, 4, sample 0", "ray ", "end ", "radiance "] {
        assert!(text.contains(word), "no {word:?} in: {text}");
    }
    folder.fails(
        &[
            "render",
            "scene.gltf",
            "--width",
            "16",
            "--replay",
            "16,0,0",
            "-q",
        ],
        1,
        &["scene.gltf", "16, 0", "outside"],
    );
}

#[test]
fn people_read_the_standard_error() {
    let folder = Folder::with_scene();
    let output = folder.run(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "--width=24",
        "--samples=1",
        "--view=Raw",
    ]);
    assert!(output.status.success());
    assert_eq!(output.stdout, b"");
    let text = String::from_utf8(output.stderr).unwrap();
    for expected in [
        "2 triangles",
        "1 light,",
        "a.exr written",
        "24 × 12 pixels, 1 sample a pixel,",
        "--view does nothing",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // No bar where nobody watches.
    assert!(!text.contains('\r') && !text.contains('█'), "{text}");
    let listed = folder.run(&[
        "render",
        "scene.gltf",
        "-o",
        "b.exr",
        "--width=8",
        "--samples=1",
        "--effects=suns",
    ]);
    let text = String::from_utf8(listed.stderr).unwrap();
    assert!(
        text.contains("the scene calls for gloss, point-lights, which --effects leaves out"),
        "{text}"
    );
    assert!(
        folder
            .floats("b.exr")
            .pixels
            .iter()
            .flatten()
            .all(|value| *value == 0.0)
    );
    folder.fails(
        &[
            "render",
            "scene.gltf",
            "-o",
            "c.exr",
            "--effects=fog",
            "--quiet",
        ],
        1,
        &["fog", "lamps"],
    );
}

#[test]
fn a_constant_environment_lights_the_background() {
    let folder = Folder::with_scene();
    folder.renders(&[
        "-o",
        "a.exr",
        "--environment-color=0.25,0.5,1",
        "--environment-strength=2",
        "--filter=box",
    ]);
    // The camera's upper left corner looks past the square of two metres: at a distance of 3 m the
    // picture is 2 · 3 · tan(0.25) = 1.53 m high and 3.06 m wide.
    let corner = folder.floats("a.exr").pixels[0];
    for (value, expected) in corner.iter().zip([0.5, 1.0, 2.0]) {
        assert!((value - expected).abs() < 1e-6, "{corner:?}");
    }
}

#[test]
fn the_time_ends_a_render() {
    let folder = Folder::with_scene();
    let text = folder.works(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "--width=24",
        "--time=300ms",
        "--json",
    ]);
    let finished: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert_eq!(finished["statistics"]["stop"], "time");
    assert!(finished["statistics"]["samples"].as_u64().unwrap() >= 1);
    assert!(folder.path("a.exr").exists());
}

#[test]
fn a_region_is_cut_from_the_full_picture_bit_for_bit() {
    let folder = Folder::with_scene();
    let render = |more: &[&str]| {
        let plain = [
            "render",
            "scene.gltf",
            "--width=24",
            "--samples=4",
            "--quiet",
        ];
        let arguments: Vec<_> = plain.iter().chain(more).copied().collect();
        folder.works(&arguments);
    };
    render(&["-o", "full.exr", "--threads=1"]);
    render(&["-o", "part.exr", "--region=5,3,21,10", "--threads=3"]);
    for layer in [None, Some("Depth"), Some("Normal"), Some("Position")] {
        let load = |name| sundog::measure::load(&folder.path(name), layer).unwrap();
        let (full, part) = (load("full.exr"), load("part.exr"));
        assert_eq!((part.width, part.height), (16, 7));
        for y in 0..7 {
            for x in 0..16 {
                assert_eq!(part.pixels[y * 16 + x], full.pixels[(y + 3) * 24 + x + 5]);
            }
        }
    }
}

#[test]
fn clamping_takes_light_away_and_says_how_much() {
    let folder = Folder::with_scene();
    let mean = |name: &str| {
        let picture = folder.floats(name);
        let luminance = |p: &[f32; 3]| f64::from(0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]);
        picture.pixels.iter().map(luminance).sum::<f64>() / picture.pixels.len() as f64
    };
    let clamped = |flags: &[&str], name: &str| {
        let mut arguments = vec![
            "render",
            "scene.gltf",
            "--width=24",
            "--samples=4",
            "--json",
        ];
        arguments.extend(["-o", name]);
        arguments.extend(flags);
        let text = folder.works(&arguments);
        let finished: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        finished["statistics"]["clamped"].clone()
    };
    assert_eq!(clamped(&[], "free.exr"), Value::Null);
    // The lamp lights the square directly and nothing else: indirect clamping finds nothing.
    let none = clamped(&["--clamp-indirect=0.001"], "indirect.exr");
    assert_eq!(none, json!({ "direct": 0.0, "indirect": 0.0 }));
    assert_eq!(folder.floats("free.exr"), folder.floats("indirect.exr"));
    let brightest = folder
        .floats("free.exr")
        .pixels
        .iter()
        .fold(0f32, |m, p| m.max(p[0]));
    let limit = format!("--clamp-direct={}", 0.5 * brightest);
    let taken = clamped(&[&limit], "direct.exr");
    let share = 1.0 - mean("direct.exr") / mean("free.exr");
    assert!(share > 0.05, "{share}");
    assert!(
        (taken["direct"].as_f64().unwrap() - share).abs() < 1e-5,
        "{taken} {share}"
    );
    assert_eq!(taken["indirect"], 0.0);
}

/// The passes of a frame file by name, as its event describes them.
fn frame_passes(folder: &Folder, event: &Value) -> Vec<(String, Vec<f32>)> {
    let bytes = std::fs::read(folder.path("frames").join(event["file"].as_str().unwrap())).unwrap();
    let region: Vec<u64> = event["region"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_u64().unwrap())
        .collect();
    let pixels = ((region[2] - region[0]) * (region[3] - region[1])) as usize;
    let mut end = 0;
    let passes = event["passes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pass| {
            let offset = pass["offset"].as_u64().unwrap() as usize;
            assert_eq!(offset, end);
            end = offset + 4 * pixels * pass["channels"].as_str().unwrap().len();
            let floats = bytes[offset..end]
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
                .collect();
            (pass["name"].as_str().unwrap().to_owned(), floats)
        })
        .collect();
    assert_eq!(end, bytes.len());
    passes
}

#[test]
fn the_last_frame_is_the_picture() {
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("frames")).unwrap();
    let text = folder.works(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "--frames=frames",
        "--width=24",
        "--region=4,2,20,9",
        "--samples=4",
        "--json",
    ]);
    let events: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let last = events.iter().rfind(|e| e["event"] == "frame").unwrap();
    assert_eq!(last["final"], true);
    assert_eq!(
        (
            &last["width"],
            &last["height"],
            &last["region"],
            &last["samples"]
        ),
        (&json!(24), &json!(12), &json!([4, 2, 20, 9]), &json!(4))
    );
    let passes = frame_passes(&folder, last);
    let names: Vec<_> = passes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "Combined",
            "Depth",
            "Normal",
            "Position",
            "Debug Sample Count",
            "Error"
        ]
    );
    let picture = folder.floats("a.exr");
    let combined = &passes[0].1;
    for y in 0..7 {
        for x in 0..16 {
            let pixel = &combined[4 * ((6 - y) * 16 + x)..][..4];
            assert_eq!(pixel[..3], picture.pixels[y * 16 + x]);
            assert_eq!(pixel[3], 1.0);
        }
    }
    let progress = events.iter().rfind(|e| e["event"] == "progress").unwrap();
    assert!(
        progress["error"]["error"].as_f64().unwrap() > 0.0,
        "{progress}"
    );
    let output = folder.run(&["render", "scene.gltf", "--frames=missing", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        line["message"]
            .as_str()
            .unwrap()
            .contains("there is no folder missing"),
        "{line}"
    );
    // What cannot be understood is told in JSON too.
    let output = folder.run(&["render", "scene.gltf", "--json", "--sample", "1"]);
    assert_eq!(output.status.code(), Some(2));
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["event"], "error");
}

/// Frames come while the render goes on, no more than two lie unread, and an interrupt brings the last one.
#[cfg(unix)]
#[test]
fn frames_come_while_the_picture_grows() {
    use std::io::BufRead;
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("frames")).unwrap();
    let mut child = folder
        .command(&[
            "render",
            "scene.gltf",
            "--frames=frames",
            "--width=24",
            "--time=10m",
            "--json",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut events = std::io::BufReader::new(child.stdout.take().unwrap())
        .lines()
        .map(|line| serde_json::from_str::<Value>(&line.unwrap()).unwrap());
    let lying = || std::fs::read_dir(folder.path("frames")).unwrap().count();
    let mut next = || events.find(|e| e["event"] == "frame").unwrap();
    // Two are left unread: no third one comes before one of them is removed.
    let (first, second) = (next(), next());
    assert_eq!(first["final"], false);
    let passes = frame_passes(&folder, &first);
    assert_eq!((passes.len(), passes[0].0.as_str()), (1, "Combined"));
    assert!(
        passes[0]
            .1
            .iter()
            .any(|value| *value > 0.1 && *value != 1.0)
    );
    assert_ne!(first["file"], second["file"]);
    let waited = events
        .by_ref()
        .take_while(|e| e["event"] == "progress")
        .take(4)
        .count();
    assert_eq!((waited, lying()), (4, 2));
    std::fs::remove_file(folder.path("frames").join(first["file"].as_str().unwrap())).unwrap();
    let third = events.find(|e| e["event"] == "frame").unwrap();
    assert_eq!((&third["final"], lying()), (&json!(false), 2));
    interrupt(&child);
    let rest: Vec<Value> = events.collect();
    let last = rest.iter().find(|e| e["event"] == "frame").unwrap();
    assert_eq!(last["final"], true);
    assert_eq!(frame_passes(&folder, last).len(), 6);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(rest.last().unwrap()["event"], "error");
}

/// Presses Ctrl-C.
#[cfg(unix)]
fn interrupt(child: &std::process::Child) {
    // The shell's own kill: a small system has no program of that name.
    let sent = Command::new("sh")
        .args(["-c", &format!("kill -INT {}", child.id())])
        .status()
        .unwrap();
    assert!(sent.success());
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_picture() {
    use std::io::BufRead;
    let folder = Folder::with_scene();
    let mut child = folder
        .command(&[
            "render",
            "scene.gltf",
            "-o",
            "a.exr",
            "-o",
            "a.png",
            "--width=24",
            "--time=10m",
            "--json",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    let progressed = lines
        .by_ref()
        .map(|line| serde_json::from_str::<Value>(&line.unwrap()).unwrap());
    let mut progressed =
        progressed.skip_while(|e| e["event"] != "progress" || e["samples"].as_u64() < Some(2));
    assert!(progressed.next().is_some());
    interrupt(&child);
    let last = progressed.last().unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("interrupted; a.exr, a.png written with the"),
        "{message}"
    );
    // The events end with what was interrupted.
    assert_eq!(last["event"], "error");
    assert!(
        folder
            .floats("a.exr")
            .pixels
            .iter()
            .any(|pixel| pixel[0] > 0.0)
    );
    assert_eq!(image::open(folder.path("a.png")).unwrap().width(), 24);
    assert_eq!(folder.names(), ["a.exr", "a.png", "scene.gltf"]);
}

#[cfg(unix)]
#[test]
fn a_picture_that_cannot_be_kept_leaves_the_old_one() {
    // The folder goes away while the picture is rendered: nothing is left, and the sentence names the file.
    use std::io::BufRead;
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("out")).unwrap();
    let mut child = folder
        .command(&[
            "render",
            "scene.gltf",
            "-o",
            "out/a.exr",
            "--width=24",
            "--time=10m",
            "--json",
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("\"progress\"")));
    // (Moved, as the time of the output may be tried out in it just now.)
    std::fs::rename(folder.path("out"), folder.path("elsewhere")).unwrap();
    interrupt(&child);
    let rest: Vec<_> = lines.map(|line| line.unwrap()).collect();
    assert!(rest.last().unwrap().contains("\"error\""), "{rest:?}");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("out/a.exr") && message.trim_end().lines().count() == 1,
        "{message}"
    );
}

/// SIGTERM does what Ctrl-C does; a render whose reader has gone stops by itself, long before its time.
#[cfg(unix)]
#[test]
fn a_render_ends_when_it_is_told_to_and_when_nobody_watches() {
    use std::io::BufRead;
    for reader_goes in [false, true] {
        let folder = Folder::with_scene();
        std::fs::create_dir(folder.path("frames")).unwrap();
        let mut child = folder
            .command(&[
                "render",
                "scene.gltf",
                "--frames=frames",
                "-o",
                "a.exr",
                "--width=24",
                "--time=5m",
                "--json",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
        let progressed = |line: &str| line.contains("\"progress\"");
        assert!(lines.by_ref().any(|line| progressed(&line.unwrap())));
        if reader_goes {
            drop(lines);
        } else {
            let sent = Command::new("sh")
                .args(["-c", &format!("kill -TERM {}", child.id())])
                .status()
                .unwrap();
            assert!(sent.success());
            assert!(lines.any(|line| line.unwrap().contains("\"final\":true")));
        }
        assert_eq!(child.wait().unwrap().code(), Some(130), "{reader_goes}");
        assert!(folder.path("a.exr").exists(), "what there was is kept");
    }
}

/// A camera that sees beyond the square, a film without the world, and passes by name.
#[test]
fn passes_and_alpha_are_as_asked() {
    let folder = Folder::new();
    let mut scene = scene();
    scene["cameras"][0]["perspective"]["yfov"] = json!(2.5);
    folder.write("scene.gltf", scene.to_string());
    folder.works(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "-o",
        "a.png",
        "--width=25",
        "--height=25",
        "--samples=8",
        "--environment-color=1,1,1",
        "--transparent",
        "--passes=Env,Debug Sample Count, DiffCol",
    ]);
    let picture = image::open(folder.path("a.png")).unwrap().into_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0, [0; 4]);
    assert_eq!(picture.get_pixel(12, 12).0[3], 255);
    let image = exr::prelude::read_all_flat_layers_from_file(folder.path("a.exr")).unwrap();
    let mut names: Vec<String> = image.layer_data[0]
        .channel_data
        .list
        .iter()
        .map(|channel| channel.name.to_string())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "A",
            "B",
            "Debug Sample Count.X",
            "DiffCol.B",
            "DiffCol.G",
            "DiffCol.R",
            "Env.B",
            "Env.G",
            "Env.R",
            "G",
            "R"
        ]
    );
    folder.fails(
        &["render", "scene.gltf", "-o", "b.exr", "--passes", "Fog"],
        2,
        &["--passes", "no pass 'Fog'", "TransInd"],
    );
}

/// What the scene wishes holds where no flag says otherwise; a configuration that is not there is told.
#[test]
fn the_scene_says_how_it_wants_to_be_seen() {
    let folder = Folder::new();
    let mut scene = scene();
    scene["scenes"][0]["extensions"] = json!({ "SUNDOG_scene": {
        "color_management": { "view": "Un-tone-mapped", "config": "missing.ocio", "exposure": 1.0 },
        "render": { "width": 20, "height": 10, "filter_width": 2.0, "transparent": true, "film_exposure": 0.5 }
    } });
    folder.write("scene.gltf", scene.to_string());
    let said = folder.works(&[
        "render",
        "scene.gltf",
        "-o",
        "a.png",
        "--samples=1",
        "--json",
    ]);
    let events: Vec<Value> = said
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let event = |kind: &str| events.iter().find(|e| e["event"] == kind).unwrap();
    let warning = event("warning")["message"].as_str().unwrap();
    assert!(
        warning.contains("missing.ocio") && warning.contains("named by the scene"),
        "{warning}"
    );
    let settings = &event("scene")["settings"];
    assert_eq!(
        (&settings["width"], &settings["height"]),
        (&json!(20), &json!(10))
    );
    assert_eq!(settings["filter"]["width"], 2.0);
    assert_eq!(settings["transparent_film"], true);
    assert_eq!(settings["film_exposure"], 0.5);
    assert_eq!(
        settings["caustics"],
        json!({ "reflective": true, "refractive": true })
    );
    let flags = ["render", "scene.gltf", "-o", "b.png", "--samples=1"];
    folder.works(&[&flags[..], &["--width=40"]].concat());
    assert_eq!(image::image_dimensions(folder.path("b.png")).unwrap().0, 40);
    folder.write(
        "other.gltf",
        scene.to_string().replace("Un-tone-mapped", "Nowhere"),
    );
    let output = folder.run(&["render", "other.gltf", "-o", "c.png", "--quiet"]);
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("no view 'Nowhere'") && error.contains("Un-tone-mapped"),
        "{error}"
    );
}

#[test]
fn an_error_target_is_a_reason_to_end() {
    let folder = Folder::with_scene();
    let said = folder.works(&[
        "render",
        "scene.gltf",
        "-o",
        "a.exr",
        "--width=24",
        "--error=90%",
        "--json",
    ]);
    let last: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    assert_eq!(last["statistics"]["stop"], "error");
    assert!(last["statistics"]["error"]["error"].as_f64().unwrap() <= 0.9);
}
