use super::super::tile::tiles;
use super::*;
use crate::film::objects::Label;
use crate::film::pixel::FirstHit;
use crate::film::{Pass, Passes};
use crate::scene::ColorManagement;
use glam::Vec3;
use serde_json::{Value, json};

const REGION: Region = Region {
    x0: 1,
    y0: 2,
    x1: 41,
    y1: 37,
};

/// The state of a render whose pixels have four samples, with all sums.
fn written(instructions: &str) -> Vec<u8> {
    let passes = ["Combined", "DiffDir", "Debug Cost"].map(String::from);
    let passes = Passes::parse(passes.iter().map(String::as_str)).unwrap_or(Passes::ALL);
    let header: Header = serde_json::from_value(json!({
        "program": "0.1.0", "embree": "4.4.0", "instruction_set": instructions, "scene": "abc",
        "settings": { "seed": 0 }, "size": [50, 40], "region": REGION,
        "passes": passes.iter().map(Pass::name).collect::<Vec<_>>(),
        "axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "ranges": [[3, 7]], "whole": true,
        "apart": passes.need_light_passes(), "features": passes.need_features(), "costs": passes.has(Pass::Cost), "halves": true,
        "objects": passes.need_objects(), "labels": [Label::new(["a", "b", "c"], [1.0, 2.0])], "light_groups": ["key", "fill"],
        "aovs": [{ "name": "a", "is_color": true }, { "name": "b", "is_color": false }], "vectors": passes.has(Pass::Vector), "clamped": [0.5, 0.0],
        "left_out": ["coat"], "color_management": ColorManagement::default(),
        "traced": {
            "samples": 5600, "rays": 12000, "seconds": 1.5, "non_finite": 2,
            "non_finite_examples": [[1, 2, 3], [49, 39, 6]], "non_finite_causes": { "a lobe": 2 },
        },
    }))
    .unwrap();
    let tiles = tiles(REGION, header.kept());
    for tile in &tiles {
        for (index, sum) in (1..).zip(&mut locked(tile).groups) {
            *sum = DVec3::splat(f64::from(index));
        }
        for (number, sum) in (0u32..).zip(&mut locked(tile).aovs) {
            *sum = f64::from(number);
        }
        for objects in &mut locked(tile).objects {
            objects.set_middle(Some(0));
        }
        for (index, pixel) in (1..).zip(&mut locked(tile).pixels) {
            for number in 3..7 {
                pixel.add(
                    number % 2 == 1,
                    Vec3::splat(index as f32 / 7.0),
                    &FirstHit::default(),
                );
            }
            pixel.until = 4;
        }
    }
    let mut bytes = Vec::new();
    State::of(header, &tiles).write(&mut bytes).unwrap();
    bytes
}

/// The header and what follows it but the checksum.
fn taken_apart(bytes: &[u8]) -> (Value, Vec<u8>) {
    let start = FIRST_LINE.len() + 8;
    let length = u64::from_le_bytes(bytes[start - 8..start].try_into().unwrap()) as usize;
    let header = serde_json::from_slice(&bytes[start..start + length]).unwrap();
    let end = bytes.len() - CHECKSUM as usize;
    (header, bytes[start + length..end].to_vec())
}

/// A file of them, with the right checksum.
fn sealed(header: &[u8], body: &[u8]) -> tempfile::NamedTempFile {
    let length = (header.len() as u64).to_le_bytes();
    let mut bytes = [FIRST_LINE, &length, header, body].concat();
    bytes.extend_from_slice(&Sha256::digest(&bytes));
    in_file(&bytes)
}

fn in_file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    file
}

fn refused(header: &Value, body: &[u8]) -> String {
    let file = sealed(&serde_json::to_vec(header).unwrap(), body);
    let error = Saved::read_within(file.path(), 1 << 30).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with(&file.path().display().to_string()));
    assert!(!text.contains(char::is_control), "{text:?}");
    text
}

#[test]
fn what_is_written_is_read_and_is_smaller() {
    for set in ["avx2", "sse4.2"] {
        let bytes = written(set);
        let file = in_file(&bytes);
        let saved = Saved::read(file.path()).unwrap();
        assert_eq!(saved.header.instruction_set.name(), set);
        assert_eq!((saved.pixels.len(), saved.samples()), (40 * 35, 4));
        let tiles = tiles(REGION, saved.header.kept());
        saved.restore(&tiles, u32::MAX);
        let mut again = Vec::new();
        State::of(saved.header.clone(), &tiles)
            .write(&mut again)
            .unwrap();
        assert!(again == bytes);
        assert!(3 * bytes.len() < 40 * 35 * saved.header.pixel_bytes());
    }
}

/// What the file says of its pass under way does not make a render go farther than it is told to.
#[test]
fn no_more_samples_are_taken_than_are_asked_for() {
    let (header, _) = taken_apart(&written("avx2"));
    let tiles_of = tiles(
        REGION,
        serde_json::from_value::<Header>(header.clone())
            .unwrap()
            .kept(),
    );
    for tile in &tiles_of {
        for pixel in &mut locked(tile).pixels {
            pixel.until = u32::MAX;
        }
    }
    let mut bytes = Vec::new();
    let header = serde_json::from_value(header).unwrap();
    State::of(header, &tiles_of).write(&mut bytes).unwrap();
    let saved = Saved::read(in_file(&bytes).path()).unwrap();
    saved.restore(&tiles_of, 64);
    let until = |tile: &Mutex<Tile>| locked(tile).pixels.iter().all(|pixel| pixel.until == 64);
    assert!(tiles_of.iter().all(until));
}

#[test]
fn older_states_are_refused_by_name() {
    let bytes = written("avx2");
    let old = [OLD_FIRST_LINE, &bytes[FIRST_LINE.len()..]].concat();
    let text = Saved::read(in_file(&old).path()).unwrap_err().to_string();
    assert!(
        text.contains("an older Sundog") && text.contains("instructions"),
        "{text}"
    );
    let newer = [&b"sundog state 9\n"[..], &bytes[FIRST_LINE.len()..]].concat();
    let text = Saved::read(in_file(&newer).path()).unwrap_err().to_string();
    assert!(text.contains("another version"), "{text}");
}

/// Each field of the header set to what no render has written, with the right checksum.
#[test]
fn hostile_headers_are_refused() {
    let (good, body) = taken_apart(&written("avx2"));
    let with = |path: &str, value: Value| {
        let mut header = good.clone();
        *header.pointer_mut(path).unwrap() = value;
        header
    };
    let most = u32::MAX;
    let path = sealed(&serde_json::to_vec(&good).unwrap(), &body);
    Saved::read(path.path()).unwrap();
    for (path, value, words) in [
        (
            "/region",
            json!({ "x0": 41, "y0": 2, "x1": 1, "y1": 37 }),
            "region",
        ),
        (
            "/region",
            json!({ "x0": 1, "y0": 2, "x1": most, "y1": 37 }),
            "region",
        ),
        (
            "/region",
            json!({ "x0": 1, "y0": 2, "x1": 1, "y1": 2 }),
            "region",
        ),
        (
            "/region",
            json!({ "x0": -1, "y0": 2, "x1": 41, "y1": 37 }),
            "header",
        ),
        (
            "/region",
            json!({ "x0": 1, "y0": 2, "x1": 40, "y1": 37 }),
            "length",
        ),
        (
            "/region",
            json!({ "x0": 1, "y0": 2, "x1": 42, "y1": 37 }),
            "fewer pixels",
        ),
        ("/size", json!([most, most]), "too large"),
        ("/size", json!([0, 0]), "region"),
        ("/size", json!([40.5, 40]), "header"),
        ("/instruction_set", json!("avx512"), "header"),
        ("/embree", json!("4.4\u{1b}[2J"), "control characters"),
        ("/scene", json!("\u{9b}31m"), "control characters"),
        ("/settings", json!({ "a\n": 1 }), "control characters"),
        ("/settings", json!(7), "header"),
        ("/passes", json!(["Depth of the sea"]), "passes"),
        ("/passes", json!(["Combined"]), "passes"),
        ("/passes", json!([]), "passes"),
        ("/apart", json!(false), "passes"),
        ("/costs", json!(false), "passes"),
        ("/axes/1/1", json!(null), "header"),
        ("/ranges", json!([]), "samples"),
        ("/ranges", json!([[7, 3]]), "samples"),
        ("/ranges", json!([[0, 4], [3, 7]]), "samples"),
        ("/ranges", json!([[4, 7], [0, 3]]), "samples"),
        ("/ranges", json!([[0, most], [1, most]]), "samples"),
        ("/ranges", json!([[3, 6]]), "pixels"),
        ("/ranges", json!([[3, u64::MAX]]), "header"),
        ("/clamped/0", json!(f64::INFINITY), "header"),
        ("/traced/seconds", json!(-1.0), "time"),
        ("/traced/seconds", json!(1e300), "time"),
        ("/traced/seconds", json!("NaN"), "header"),
        ("/traced/samples", json!(u64::MAX), "counts"),
        ("/traced/rays", json!(u64::MAX), "counts"),
        ("/traced/rays", json!(-1), "header"),
        ("/traced/non_finite", json!(u64::MAX), "counts"),
        ("/traced/non_finite", json!(1), "not finite"),
        (
            "/traced/non_finite_examples/0",
            json!([50, 0, 0]),
            "not finite",
        ),
        (
            "/traced/non_finite_causes",
            json!({ "a": u64::MAX }),
            "counts",
        ),
        (
            "/traced/non_finite_causes",
            json!({ "a\r": 1 }),
            "control characters",
        ),
        ("/left_out/0", json!("\u{7}"), "control characters"),
    ] {
        let text = refused(&with(path, value.clone()), &body);
        assert!(text.contains(words), "{path} {value}: {text}");
    }
    // Without a field, and as something else altogether.
    for name in good.as_object().unwrap().keys() {
        // Without these there are no shadow catchers.
        if !["left_out", "catchers", "transparent"].contains(&name.as_str()) {
            let mut header = good.clone();
            header.as_object_mut().unwrap().remove(name);
            refused(&header, &body);
        }
        // These two take any object.
        if !["settings", "color_management"].contains(&name.as_str()) {
            refused(&with(&format!("/{name}"), json!({ "x": [[[]]] })), &body);
        }
    }
    for text in ["", "{", "null", "[]", &"[".repeat(100_000)] {
        let file = sealed(text.as_bytes(), &body);
        let error = Saved::read(file.path()).unwrap_err().to_string();
        assert!(error.contains("header does not say"), "{error}");
    }
    let mut long = [FIRST_LINE, &u64::MAX.to_le_bytes(), b"{}"].concat();
    long.extend_from_slice(&[0; 64]);
    let error = Saved::read(in_file(&long).path()).unwrap_err().to_string();
    assert!(error.contains("header is too long"), "{error}");
}

/// Pixels that are not what the header says, with the right checksum.
#[test]
fn hostile_pixels_are_refused() {
    let (good, body) = taken_apart(&written("avx2"));
    for body in [&b""[..], &b"not packed at all"[..], &body[..body.len() - 3]] {
        refused(&good, body);
    }
    let text = refused(&good, &[&body[..], &b"more"[..]].concat());
    assert!(text.contains("length"), "{text}");
    let plain = zstd::decode_all(&body[..]).unwrap();
    let packed = |plain: &[u8]| zstd::encode_all(plain, LEVEL).unwrap();
    let text = refused(&good, &packed(&[&plain[..], &[0]].concat()));
    assert!(text.contains("length"), "{text}");
    let text = refused(&good, &packed(&plain[..plain.len() - 1]));
    assert!(text.contains("fewer"), "{text}");
    // Any byte of the first pixel's sums and counts set to its largest value: refused, or harmless.
    let each = size_of::<Pixel>();
    let apart = 40 * 35 * each;
    let all = apart..apart + size_of::<PixelPasses>();
    let features = apart + 40 * 35 * size_of::<PixelPasses>();
    let features = features..features + size_of::<PixelFeatures>();
    for first in (0..each).chain(all).chain(features).step_by(4) {
        let mut strange = plain.clone();
        strange[first..first + 4].fill(0xff);
        let file = sealed(&serde_json::to_vec(&good).unwrap(), &packed(&strange));
        if let Ok(saved) = Saved::read(file.path()) {
            let part = || Ok((String::from("a"), saved.clone()));
            let merged = super::super::merge([part()]).unwrap();
            merged.rendering();
            assert!(super::super::merge([part(), part()]).is_err());
        }
    }
    let mut strange = plain.clone();
    strange[..8].copy_from_slice(&f64::NAN.to_le_bytes());
    let text = refused(&good, &packed(&strange));
    assert!(text.contains("none of a render"), "{text}");
}

/// A small file of a large picture takes neither memory nor time.
#[test]
fn a_picture_that_does_not_fit_is_refused() {
    let (mut header, body) = taken_apart(&written("avx2"));
    header["size"] = json!([1 << 20, 1 << 20]);
    header["region"] = json!({ "x0": 0, "y0": 0, "x1": 1 << 20, "y1": 1 << 20 });
    let text = refused(&header, &body);
    assert!(text.contains("are free"), "{text}");
    // And where nobody says how much is free, it ends with the pixels.
    header["region"]["y1"] = json!(1 << 10);
    let file = sealed(&serde_json::to_vec(&header).unwrap(), &body);
    let text = Saved::read(file.path()).unwrap_err().to_string();
    assert!(
        text.contains("fewer pixels") || text.contains("memory"),
        "{text}"
    );
    assert!(
        Saved::read(Path::new("/dev/zero"))
            .unwrap_err()
            .to_string()
            .contains("no file")
    );
}
