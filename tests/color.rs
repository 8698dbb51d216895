//! The colours are those that Blender shows: every view of every display, with looks, exposures and gammas, against the files
//! that Blender itself saves from the same EXR.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use sundog::color::{ColorConfig, Depth, DisplaySamples, DisplayTransform, SceneColors};

const WIDTH: usize = 192;
const HEIGHT: usize = 112;

/// Pythons that can import `bpy`: the one of the test run (5.2's), and Blender 4.5's where it is installed.
///
/// Without the first one this fails; `SUNDOG_SKIP_BPY=1` says that one knows and wants the other tests only.
pub(crate) fn blenders() -> Vec<PathBuf> {
    let home = std::env::var_os("HOME")
        .map(PathBuf::from)
        .unwrap_or_default();
    let cache = std::env::var_os("XDG_CACHE_HOME")
        .map_or_else(|| home.join(".cache"), PathBuf::from)
        .join("sundog");
    let named = std::env::var_os("SUNDOG_BPY_PYTHON")
        .filter(|path| !path.is_empty())
        .map(PathBuf::from);
    let first = named.unwrap_or_else(|| cache.join("bpy-5.2.3/bin/python"));
    if !first.is_file() {
        if std::env::var_os("SUNDOG_SKIP_BPY").is_some_and(|value| value == "1") {
            eprintln!(
                "skipped: no bpy at {} and SUNDOG_SKIP_BPY=1",
                first.display()
            );
            return Vec::new();
        }
        panic!(
            "no bpy at {}: `scripts/setup-bpy.sh 5.2.3` installs it, SUNDOG_BPY_PYTHON names another Python that has it, SUNDOG_SKIP_BPY=1 leaves these tests out",
            first.display()
        );
    }
    let second = cache.join("bpy-4.5.15/bin/python");
    let mut all = vec![first];
    if second.is_file() && !all.contains(&second) {
        all.push(second);
    }
    all
}

/// A fixed sequence of numbers in 0..1 (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// From 1e-6 to 1e4, evenly in the logarithm.
    fn light(&mut self) -> f32 {
        10.0_f32.powf(self.next() * 10.0 - 6.0)
    }
}

/// Ramps from 1e-6 to 1e4 in grey and in colours, the range of a display in fine steps, and random light; some of it
/// negative, as wide colours in Rec.709 are.
fn light() -> Vec<[f32; 3]> {
    let mut random = Random(1);
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let across = column as f32 / (WIDTH - 1) as f32;
            let ramp = 10.0_f32.powf(across * 10.0 - 6.0);
            pixels.push(match row {
                0 => [ramp; 3],
                1 => [-ramp; 3],
                2..8 => [(across + (row - 2) as f32 / (6 * WIDTH) as f32) * 1.01; 3],
                8..32 => {
                    // Hues around the circle, with full and with half saturation.
                    let hue = ((row - 8) / 2) as f32 / 2.0;
                    let floor = if row % 2 == 0 { 0.0 } else { 0.3 };
                    let channel = |centre: f32| {
                        let apart = (hue - centre).abs();
                        (2.0 - apart.min(6.0 - apart)).clamp(0.0, 1.0) * (1.0 - floor) + floor
                    };
                    [
                        channel(0.0) * ramp,
                        channel(2.0) * ramp,
                        channel(4.0) * ramp,
                    ]
                }
                32..38 => {
                    // Outside of Rec.709: one channel below zero.
                    let mut pixel = [ramp; 3];
                    pixel[row % 3] *= if row < 35 { -0.05 } else { -0.7 };
                    pixel
                }
                38..60 => std::array::from_fn(|_| random.light()),
                60..80 => std::array::from_fn(|_| random.next() * 1.2 - 0.1),
                80..96 => {
                    let level = random.light();
                    std::array::from_fn(|_| level * (0.5 + random.next()))
                }
                _ => std::array::from_fn(|_| {
                    if random.next() < 0.2 {
                        -random.light()
                    } else {
                        random.light()
                    }
                }),
            });
        }
    }
    pixels
}

/// Light with associated alpha of every amount, none (pure emission) and all of it.
fn light_with_alpha() -> Vec<[f32; 4]> {
    let mut random = Random(2);
    let with_alpha = |colour: [f32; 3]| {
        let alpha = match (random.next() * 8.0) as u32 {
            0 => 0.0,
            1 => 1.0,
            2 => random.next() * 0.01,
            _ => random.next(),
        };
        let [r, g, b] = if alpha == 0.0 {
            colour
        } else {
            colour.map(|value| value * alpha)
        };
        [r, g, b, alpha]
    };
    light().into_iter().map(with_alpha).collect()
}

/// What no picture should have, in all combinations.
fn odd_pixels() -> Vec<[f32; 4]> {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        1e-45,
        -0.0,
    ];
    let count = odd.len();
    let pixel = |index: usize| {
        std::array::from_fn(|channel| odd[index / count.pow(channel as u32) % count])
    };
    (0..count.pow(4)).map(pixel).collect()
}

fn write_exr(path: &Path, pixel: impl Fn(usize) -> [f32; 4] + Sync, alpha: bool) {
    use exr::prelude::*;
    if alpha {
        let get = |at: Vec2<usize>| {
            let [r, g, b, a] = pixel(at.y() * WIDTH + at.x());
            (r, g, b, a)
        };
        write_rgba_file(path, WIDTH, HEIGHT, |x, y| get(Vec2(x, y))).unwrap();
    } else {
        let get = |at: Vec2<usize>| {
            let [r, g, b, _] = pixel(at.y() * WIDTH + at.x());
            (r, g, b)
        };
        write_rgb_file(path, WIDTH, HEIGHT, |x, y| get(Vec2(x, y))).unwrap();
    }
}

#[derive(Debug, Deserialize)]
struct Shown {
    blender: String,
    config: PathBuf,
    /// `display|view`: the looks that Blender lets go with it.
    looks: BTreeMap<String, Vec<String>>,
    cases: Vec<Case>,
}

#[derive(Debug, Deserialize)]
struct Case {
    file: String,
    picture: String,
    mode: String,
    depth: u32,
    display: String,
    view: String,
    look: Option<String>,
    exposure: f64,
    gamma: f64,
}

/// Lets a Blender save the two pictures in all ways.
fn show_with_blender(
    python: &Path,
    folder: &Path,
    opaque: &[[f32; 3]],
    alpha: &[[f32; 4]],
) -> Shown {
    write_exr(
        &folder.join("opaque.exr"),
        |at| [opaque[at][0], opaque[at][1], opaque[at][2], 1.0],
        false,
    );
    write_exr(&folder.join("alpha.exr"), |at| alpha[at], true);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/blender_colors.py");
    let output = Command::new(python)
        .arg(script)
        .arg(folder)
        // Blender would take the user's configuration for its own.
        .env_remove("OCIO")
        .env_remove("PYTHONPATH")
        .output()
        .unwrap_or_else(|error| panic!("{} does not start: {error}", python.display()));
    let cases = folder.join("cases.json");
    assert!(
        output.status.success() && cases.is_file(),
        "{} failed to show the pictures: {}",
        python.display(),
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&std::fs::read(cases).unwrap()).unwrap()
}

/// The code values of a PNG file, as they are.
fn read_png(path: &Path, case: &Case) -> Vec<u32> {
    let picture = image::open(path).unwrap();
    assert_eq!(
        (picture.width() as usize, picture.height() as usize),
        (WIDTH, HEIGHT),
        "{case:?}"
    );
    match (picture, case.mode.as_str(), case.depth) {
        (image::DynamicImage::ImageRgb8(picture), "RGB", 8) => {
            picture.into_raw().into_iter().map(u32::from).collect()
        }
        (image::DynamicImage::ImageRgba8(picture), "RGBA", 8) => {
            picture.into_raw().into_iter().map(u32::from).collect()
        }
        (image::DynamicImage::ImageRgb16(picture), "RGB", 16) => {
            picture.into_raw().into_iter().map(u32::from).collect()
        }
        (image::DynamicImage::ImageRgba16(picture), "RGBA", 16) => {
            picture.into_raw().into_iter().map(u32::from).collect()
        }
        (other, ..) => panic!("Blender saved {:?} for {case:?}", other.color()),
    }
}

fn transform(case: &Case) -> DisplayTransform {
    DisplayTransform {
        display: Some(case.display.clone()),
        view: Some(case.view.clone()),
        look: case.look.clone(),
        exposure: case.exposure,
        gamma: case.gamma,
    }
}

/// The displays, views and looks that are listed are those that Blender offers.
fn check_lists(config: &ColorConfig, shown: &Shown) {
    let mut listed = BTreeMap::new();
    for display in config.displays().unwrap() {
        for view in display.views {
            listed.insert(format!("{}|{}", display.name, view.name), view.looks);
        }
    }
    assert_eq!(listed, shown.looks, "Blender {}", shown.blender);
}

#[derive(Default)]
struct Difference {
    cases: usize,
    values: usize,
    off: usize,
    most: u32,
    worst: String,
}

#[test]
fn colours_are_those_of_blender() {
    let (opaque, alpha) = (light(), light_with_alpha());
    let odd = odd_pixels();
    let mut failures = Vec::new();
    for python in blenders() {
        let folder = tempfile::tempdir().unwrap();
        let shown = show_with_blender(&python, folder.path(), &opaque, &alpha);
        let config = ColorConfig::locate(Some(&shown.config)).unwrap();
        let mut table: BTreeMap<String, Difference> = BTreeMap::new();
        for case in &shown.cases {
            // What a look made is taken back to scene-linear light before Raw by Blender 5.2, and not by 4.5 and 5.0, as by us
            // (docs/color.md): those two are asked for it.
            if shown.blender.starts_with("5.2") && case.view == "Raw" && case.look.is_some() {
                continue;
            }
            let processor = config.processor(&transform(case)).unwrap();
            let colours = match (case.picture.as_str(), case.mode.as_str()) {
                ("opaque", "RGB") => SceneColors::Rgb(&opaque),
                ("alpha", "RGBA") => SceneColors::Rgba(&alpha),
                ("alpha", "RGB") => SceneColors::RgbaOnBlack(&alpha),
                _ => panic!("{case:?}"),
            };
            let depth = if case.depth == 8 {
                Depth::Eight
            } else {
                Depth::Sixteen
            };
            let ours: Vec<u32> = match processor.show(colours, depth).unwrap().samples {
                DisplaySamples::Eight(values) => values.into_iter().map(u32::from).collect(),
                DisplaySamples::Sixteen(values) => values.into_iter().map(u32::from).collect(),
            };
            // Whatever a pixel is, it does no harm.
            processor.show(SceneColors::Rgba(&odd), depth).unwrap();
            let theirs = read_png(&folder.path().join(&case.file), case);
            assert_eq!(ours.len(), theirs.len());
            let row = table
                .entry(format!(
                    "{:2} {:4} {:13} {}",
                    case.depth, case.mode, case.display, case.view
                ))
                .or_default();
            row.cases += 1;
            row.values += ours.len();
            let channels = case.mode.len();
            for (index, (&a, &b)) in ours.iter().zip(&theirs).enumerate() {
                let apart = a.abs_diff(b);
                row.off += usize::from(apart > 0);
                if apart > row.most {
                    row.most = apart;
                    let at = index / channels;
                    let pixel: &[f32] = if case.picture == "alpha" {
                        &alpha[at]
                    } else {
                        &opaque[at]
                    };
                    row.worst = format!(
                        "{a} for {b} of {pixel:?}, channel {}, {case:?}",
                        index % channels
                    );
                }
            }
        }
        check_lists(&config, &shown);
        println!("Blender {} with {} cases", shown.blender, shown.cases.len());
        for (name, row) in &table {
            println!(
                "{name:45} {:3} cases, at most {:5} off, {:6} of {} values off; {}",
                row.cases, row.most, row.off, row.values, row.worst
            );
            // 16 bits: a quarter of a step of 8 bits.
            let allowed = if name.starts_with(" 8") { 1 } else { 64 };
            if row.most > allowed {
                failures.push(format!("Blender {}, {name}: {}", shown.blender, row.worst));
            }
        }
        assert!(shown.cases.len() > 100, "only {} cases", shown.cases.len());
    }
    assert!(
        failures.is_empty(),
        "too far apart:\n{}",
        failures.join("\n")
    );
}

/// The program, with nothing in its environment that names a configuration.
fn sundog(arguments: &[&str], folder: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_sundog"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("OCIO")
        .output()
        .unwrap()
}

const BUILT_IN: &str = "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3";

/// Files that the two test pictures were written to.
fn folder_with_pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (opaque, alpha) = (light(), light_with_alpha());
    write_exr(
        &folder.path().join("opaque.exr"),
        |at| [opaque[at][0], opaque[at][1], opaque[at][2], 1.0],
        false,
    );
    write_exr(&folder.path().join("alpha.exr"), |at| alpha[at], true);
    folder
}

#[test]
fn the_program_writes_what_the_library_shows() {
    let folder = folder_with_pictures();
    let config = ColorConfig::locate(Some(Path::new(BUILT_IN))).unwrap();
    let transform = DisplayTransform {
        display: Some("sRGB - Display".to_owned()),
        view: Some("ACES 1.0 - SDR Video".to_owned()),
        exposure: -0.5,
        gamma: 1.25,
        ..DisplayTransform::default()
    };
    let processor = config.processor(&transform).unwrap();
    let (opaque, alpha) = (light(), light_with_alpha());
    let flags = [
        "--ocio",
        BUILT_IN,
        "--display",
        "sRGB - Display",
        "--view",
        "ACES 1.0 - SDR Video",
    ];
    let more = ["--exposure", "-0.5", "--gamma", "1.25"];
    for (from, to, depth, colours) in [
        ("opaque.exr", "a.png", "8", SceneColors::Rgb(&opaque)),
        ("opaque.exr", "b.png", "16", SceneColors::Rgb(&opaque)),
        ("alpha.exr", "c.png", "8", SceneColors::Rgba(&alpha)),
        ("alpha.exr", "d.png", "16", SceneColors::Rgba(&alpha)),
        ("alpha.exr", "e.jpg", "8", SceneColors::RgbaOnBlack(&alpha)),
    ] {
        let mut arguments = vec!["color", "apply", from, to, "--depth", depth];
        arguments.extend(flags);
        arguments.extend(more);
        let output = sundog(&arguments, folder.path());
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let wanted = processor
            .show(
                colours,
                if depth == "8" {
                    Depth::Eight
                } else {
                    Depth::Sixteen
                },
            )
            .unwrap();
        let picture = image::open(folder.path().join(to)).unwrap();
        assert_eq!(
            (picture.width() as usize, picture.height() as usize),
            (WIDTH, HEIGHT)
        );
        assert_eq!(
            usize::from(picture.color().channel_count()),
            wanted.channels,
            "{to}"
        );
        match wanted.samples {
            _ if to == "e.jpg" => assert_eq!(picture.color(), image::ColorType::Rgb8),
            DisplaySamples::Eight(values) => assert_eq!(picture.as_bytes(), values, "{to}"),
            DisplaySamples::Sixteen(values) => {
                let bytes: Vec<u8> = values
                    .iter()
                    .flat_map(|value| value.to_ne_bytes())
                    .collect();
                assert_eq!(picture.as_bytes(), bytes, "{to}");
            }
        }
    }
}

#[test]
fn what_the_program_cannot_show_is_one_sentence_and_no_file() {
    let folder = folder_with_pictures();
    std::fs::write(
        folder.path().join("broken.ocio"),
        "ocio_profile_version: [2\n",
    )
    .unwrap();
    std::fs::write(folder.path().join("broken.exr"), "v/1\x01 but nothing more").unwrap();
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for (arguments, expected) in [
        (
            &[
                "opaque.exr",
                "a.png",
                "--ocio",
                BUILT_IN,
                "--view",
                "Filmic",
            ][..],
            "'Filmic'",
        ),
        (
            &[
                "opaque.exr",
                "a.png",
                "--ocio",
                BUILT_IN,
                "--view",
                "Filmic",
            ],
            "Un-tone-mapped",
        ),
        (
            &[
                "opaque.exr",
                "a.png",
                "--ocio",
                BUILT_IN,
                "--look",
                "Punchy",
            ],
            "there are: ACES 1.3",
        ),
        (
            &[
                "opaque.exr",
                "a.png",
                "--ocio",
                BUILT_IN,
                "--display",
                "LCD",
            ],
            "sRGB - Display",
        ),
        (
            &["opaque.exr", "a.png", "--ocio", "broken.ocio"],
            "broken.ocio",
        ),
        (
            &["opaque.exr", "a.png", "--ocio", "missing.ocio"],
            "missing.ocio",
        ),
        (&["opaque.exr", "a.exr", "--ocio", BUILT_IN], "a.exr"),
        (
            &["opaque.exr", "a.jpg", "--ocio", BUILT_IN, "--depth", "16"],
            "a.jpg",
        ),
        (&["broken.exr", "a.png", "--ocio", BUILT_IN], "broken.exr"),
        (&["missing.exr", "a.png", "--ocio", BUILT_IN], "missing.exr"),
        (&["opaque.exr", "no/a.png", "--ocio", BUILT_IN], "no/a.png"),
        (
            &["opaque.exr", "a.png", "--ocio", BUILT_IN, "--gamma", "0"],
            "--gamma",
        ),
    ] {
        let output = sundog(
            &[&["color", "apply"][..], arguments].concat(),
            folder.path(),
        );
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && output.status.code().is_some(),
            "{arguments:?}: {text}"
        );
        assert!(
            text.contains(expected) && text.trim_end().lines().count() == 1,
            "{arguments:?}: {text}"
        );
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            before,
            "{arguments:?}"
        );
    }
}

#[test]
fn the_program_lists_what_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let output = sundog(
        &["color", "list", "--json", "--ocio", BUILT_IN],
        folder.path(),
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let listing: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(listing["config"], BUILT_IN);
    assert_eq!(listing["found"], "given with --ocio");
    assert_eq!(listing["roles"]["scene_linear"], "ACEScg");
    let display = &listing["displays"][0];
    assert_eq!(display["name"], listing["default_display"]);
    // For people the same names.
    let output = sundog(&["color", "list", "--ocio", BUILT_IN], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    for view in display["views"].as_array().unwrap() {
        assert!(text.contains(view["name"].as_str().unwrap()));
    }
    assert!(
        text.contains("ACES 1.3 Reference Gamut Compression"),
        "{text}"
    );
    // What goes wrong is an object too.
    let output = sundog(
        &["color", "list", "--json", "--ocio", "missing.ocio"],
        folder.path(),
    );
    assert!(!output.status.success());
    let error: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(error["message"].as_str().unwrap().contains("missing.ocio"));
    // $OCIO counts where there is no flag.
    let output = Command::new(env!("CARGO_BIN_EXE_sundog"))
        .args(["color", "list", "--json"])
        .env("OCIO", BUILT_IN)
        .output()
        .unwrap();
    let listing: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&listing["config"], &listing["found"]),
        (&BUILT_IN.into(), &"named by $OCIO".into())
    );
}

/// A device or a pipe as a table of colours would be read for ever: it is refused before OpenColorIO opens it, wherever the
/// configuration names it.
#[test]
fn tables_that_are_no_files_are_refused_before_they_are_opened() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.cube");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    std::fs::create_dir(folder.path().join("tables")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("tables/zero.spi3d")).unwrap();
    std::fs::write(folder.path().join("tables/whole.spi1d"), "Version 1\n").unwrap();
    let config = |search: &str, space: &str, look: &str| {
        format!(
            "ocio_profile_version: 2\nsearch_path: {search}\nroles:\n  default: raw\n  scene_linear: raw\n\
             displays:\n  sRGB:\n    - !<View> {{name: Raw, colorspace: raw}}\n\
             looks:\n  - !<Look> {{name: l, process_space: raw, transform: {look}}}\n\
             colorspaces:\n  - !<ColorSpace> {{name: raw, isdata: true}}\n\
             \x20 - !<ColorSpace> {{name: other, to_scene_reference: {space}}}\n"
        )
    };
    let plain = "!<MatrixTransform> {offset: [0, 0, 0, 0]}";
    let read = |text: &str| {
        let path = folder.path().join("config.ocio");
        std::fs::write(&path, text).unwrap();
        ColorConfig::locate_in(Some(&path), &sundog::color::SearchPlaces::default())
    };
    let file = |name: &str| format!("!<FileTransform> {{src: {name}}}");
    let group = |name: &str| format!("!<GroupTransform> {{children: [{plain}, {}]}}", file(name));
    for (text, named) in [
        (config("tables", &file("zero.spi3d"), plain), "zero.spi3d"),
        (config("\"\"", &file("/dev/zero"), plain), "/dev/zero"),
        (config("tables:.", plain, &group("pipe.cube")), "pipe.cube"),
        (config("/dev", &group("zero"), plain), "/dev/zero"),
    ] {
        let error = read(&text).unwrap_err().to_string();
        assert!(
            error.contains(named) && error.contains("not a regular file"),
            "{named}: {error}"
        );
    }
    // One that is a file, or is not there, is looked at when it is needed.
    for name in ["whole.spi1d", "missing.spi1d"] {
        read(&config("tables", &file(name), plain)).unwrap();
    }
    let error = ColorConfig::read_named_by_scene(&pipe).unwrap_err();
    assert!(error.to_string().contains("not a regular file"), "{error}");
}
