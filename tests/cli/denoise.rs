//! `sundog render --denoise` as people and scripts call it.

use super::Folder;
use serde_json::Value;

const SMALL: [&str; 8] = [
    "render",
    "scene.gltf",
    "--width",
    "48",
    "--samples",
    "4",
    "-o",
    "a.exr",
];

fn arguments<'a>(more: &[&'a str]) -> Vec<&'a str> {
    SMALL.iter().chain(more).copied().collect()
}

fn events(text: &str) -> Vec<Value> {
    let lines = text.lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn of_kind<'a>(events: &'a [Value], kind: &str) -> &'a Value {
    events.iter().find(|event| event["event"] == kind).unwrap()
}

fn layer(folder: &Folder, file: &str, layer: Option<&str>) -> Vec<[f32; 3]> {
    let image = sundog::measure::load(&folder.path(file), layer).unwrap();
    image.pixels
}

#[test]
fn the_noisy_picture_stays_in_the_file_and_the_shift_is_told() {
    let folder = Folder::with_scene();
    folder.works(&arguments(&["--quiet"]));
    std::fs::rename(folder.path("a.exr"), folder.path("plain.exr")).unwrap();
    let said = folder.works(&arguments(&["--denoise", "--json"]));
    let events = events(&said);
    let denoised = &of_kind(&events, "finished")["denoised"];
    assert_eq!(denoised["prefilter"], "accurate");
    assert_eq!(denoised["guides"], "albedo_normal");
    assert_eq!(denoised["quality"], "high");
    assert_eq!(denoised["keep_energy"], false);
    assert_eq!(denoised["shift"]["block_size"], 16);
    assert!(denoised["shift"]["mean"].as_f64().unwrap().abs() < 0.05);
    assert!(denoised["shift"]["mean_interval"].as_f64().unwrap() > 0.0);
    of_kind(&events, "denoising");
    let plain = layer(&folder, "plain.exr", None);
    assert_eq!(layer(&folder, "a.exr", Some("Noisy Image")), plain);
    assert_ne!(layer(&folder, "a.exr", None), plain);
    let meta = exr::meta::MetaData::read_from_file(folder.path("a.exr"), false).unwrap();
    let other = &meta.headers[0].own_attributes.other;
    let stated = other.iter().find(|(name, _)| *name == "sundog/denoised");
    let Some((_, exr::meta::attribute::AttributeValue::Text(text))) = stated else {
        panic!("{other:?}");
    };
    let stated: Value = serde_json::from_str(&text.to_string()).unwrap();
    assert_eq!(&stated, denoised);
}

#[test]
fn the_summary_says_whose_error_it_tells() {
    let folder = Folder::with_scene();
    let output = folder.run(&arguments(&["--denoise", "--denoise-keep-energy"]));
    let said = String::from_utf8(output.stderr).unwrap();
    for words in [
        "Open Image Denoise 2.",
        "error of the noisy picture ",
        "denoised in ",
        "brightness shift 0.00 % ± ",
        "largest block ",
    ] {
        assert!(said.contains(words), "no {words:?} in: {said}");
    }
}

/// The last frame is the denoised picture, those before it are not; the noisy one comes with it.
#[test]
fn the_last_frame_is_denoised() {
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("frames")).unwrap();
    let said = folder.works(&arguments(&["--denoise", "--json", "--frames", "frames"]));
    let events = events(&said);
    let frames: Vec<_> = events.iter().filter(|e| e["event"] == "frame").collect();
    let last = frames.last().unwrap();
    assert_eq!(last["final"], true);
    assert_eq!(
        frames.iter().filter(|frame| frame["final"] == true).count(),
        1
    );
    let file = folder.path("frames").join(last["file"].as_str().unwrap());
    let bytes = std::fs::read(file).unwrap();
    let pixel = |name: &str| {
        let passes = last["passes"].as_array().unwrap();
        let pass = passes.iter().find(|pass| pass["name"] == name).unwrap();
        let offset = pass["offset"].as_u64().unwrap() as usize;
        let float = |i: usize| f32::from_le_bytes(bytes[offset + 4 * i..][..4].try_into().unwrap());
        // Frames are from bottom to top: the first pixel of the last row.
        let first = 4 * 48 * 23;
        [0, 1, 2].map(|i| float(first + i))
    };
    assert_eq!(pixel("Combined"), layer(&folder, "a.exr", None)[0]);
    let noisy = layer(&folder, "a.exr", Some("Noisy Image"))[0];
    assert_eq!(pixel("Noisy Image"), noisy);
}

#[test]
fn a_missing_library_is_told_before_anything_is_rendered() {
    let folder = Folder::with_scene();
    let here = folder.path("");
    let run = |more: &[&str]| {
        let mut command = folder.command(&arguments(more));
        command.env("OIDN_DIR", &here).output().unwrap()
    };
    let failed = run(&["--denoise"]);
    assert_eq!(failed.status.code(), Some(1));
    let said = String::from_utf8(failed.stderr).unwrap();
    assert!(
        said.starts_with("sundog: OIDN_DIR is ") && said.trim_end().lines().count() == 1,
        "{said}"
    );
    assert!(!folder.path("a.exr").exists());
    let noisy = run(&["--denoise", "--denoise-optional", "--json"]);
    assert!(noisy.status.success());
    let events = events(&String::from_utf8(noisy.stdout).unwrap());
    let warning = of_kind(&events, "warning")["message"].as_str().unwrap();
    assert!(
        warning.starts_with("the picture stays noisy: OIDN_DIR is "),
        "{warning}"
    );
    assert_eq!(of_kind(&events, "finished")["denoised"], Value::Null);
    assert!(folder.path("a.exr").exists());
}

#[test]
fn what_says_how_needs_the_denoiser() {
    let folder = Folder::with_scene();
    for flag in [
        &["--denoise-keep-energy"][..],
        &["--denoise-quality", "fast"],
    ] {
        folder.fails(&arguments(flag), 2, &["--denoise"]);
    }
    folder.works(&arguments(&["--quiet"]));
}

/// Parts that were rendered with `--denoise` are denoised when they are joined: the picture of one render, to the bit.
#[test]
fn joined_parts_are_denoised() {
    let folder = Folder::with_scene();
    folder.works(&arguments(&["--denoise", "--quiet"]));
    for (range, state) in [("0..2", "a.state"), ("2..4", "b.state")] {
        let mut part = vec![
            "render",
            "scene.gltf",
            "--width",
            "48",
            "--quiet",
            "--denoise",
        ];
        part.extend(["--sample-range", range, "--checkpoint", state]);
        folder.works(&part);
    }
    let join = [
        "merge",
        "a.state",
        "b.state",
        "--denoise",
        "--quiet",
        "-o",
        "b.exr",
    ];
    folder.works(&join);
    for name in [None, Some("Noisy Image"), Some("Denoising Albedo")] {
        assert_eq!(layer(&folder, "b.exr", name), layer(&folder, "a.exr", name));
    }
    let mut part = vec!["render", "scene.gltf", "--width", "48", "--quiet"];
    part.extend(["--samples", "2", "--checkpoint", "c.state"]);
    folder.works(&part);
    folder.fails(
        &["merge", "c.state", "--denoise", "--quiet", "-o", "c.exr"],
        1,
        &["Denoising Albedo", "render each of them with --denoise"],
    );
}
