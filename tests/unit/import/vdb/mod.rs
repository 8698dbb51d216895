use super::*;
use std::path::PathBuf;

fn open(path: &Path, name: &str) -> Result<Grid, VdbError> {
    read(path, name, &Budget::for_grids(None))
}

/// Two grids that OpenVDB 10 wrote by each of its packings, of 32 bits and of halves.
const FILES: [&str; 3] = ["zip", "blosc", "blosc-half"];

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/unit/import/vdb/files/{name}.vdb"))
}

/// What the program that wrote the files set there.
fn density(p: IVec3) -> f32 {
    let inside = p.cmpge(IVec3::new(-6, -3, 0)).all() && p.cmplt(IVec3::new(10, 5, 12)).all();
    if p.cmpge(IVec3::new(64, 0, 0)).all() && p.cmple(IVec3::new(71, 7, 7)).all() {
        2.0
    } else if inside && p.element_sum() % 3 != 0 {
        p.as_vec3().dot(Vec3::new(0.5, 0.25, 0.125))
    } else {
        0.25
    }
}

use glam::{IVec3, Vec3};

#[test]
fn all_packings_give_what_was_written() {
    for file in FILES {
        let grid = open(&path(file), "density").expect(file);
        assert_eq!(grid.channels(), 1, "{file}");
        assert_eq!(
            grid.active,
            Some((IVec3::new(-6, -3, 0), IVec3::new(71, 7, 11))),
            "{file}"
        );
        for x in -9..75 {
            for y in -9..9 {
                for z in -9..14 {
                    let p = IVec3::new(x, y, z);
                    assert_eq!(grid.value(p).x, density(p), "{file}: {p}");
                }
            }
        }
        let place = grid
            .object_from_index
            .transform_point3(DVec3::new(2.0, 4.0, -2.0));
        assert_eq!(place, DVec3::new(2.0, 4.0, 2.0), "{file}");
    }
}

#[test]
fn vectors_and_sheared_grids() {
    for file in FILES {
        let grid = open(&path(file), "color").expect(file);
        assert_eq!(grid.channels(), 3, "{file}");
        let value = grid.value(IVec3::new(3, 1, 2)).truncate();
        assert_eq!(value, Vec3::new(3.0, 1.0, 1.0), "{file}");
        let place = grid
            .object_from_index
            .transform_point3(DVec3::new(2.0, 4.0, 8.0));
        assert!(
            place.distance(DVec3::new(2.0, 3.2, 4.0)) < 1e-12,
            "{file}: {place}"
        );
    }
}

#[test]
fn words_for_what_is_not_there() {
    let words = open(&path("zip"), "heat")
        .expect_err("no such grid")
        .to_string();
    assert_eq!(words, "it has no grid \"heat\"; there are: density, color");
    let words = open(&path("nothing"), "heat")
        .expect_err("no such file")
        .to_string();
    assert!(words.starts_with("it cannot be read: "), "{words}");
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let words = open(&here, "heat").expect_err("another file").to_string();
    assert_eq!(words, "it is no OpenVDB file");
}

#[test]
fn cut_and_changed_files_end_in_a_sentence() {
    let whole = std::fs::read(path("blosc")).expect("a file of the tests");
    let folder = tempfile::tempdir().expect("a folder");
    let there = folder.path().join("broken.vdb");
    for cut in (0..whole.len()).step_by(1733) {
        std::fs::write(&there, &whole[..cut]).expect("a file");
        assert!(open(&there, "density").is_err(), "{cut}");
    }
    change(200);
}

/// Whatever a changed byte makes of a file: no panic, and no memory out of proportion.
fn change(times: u32) {
    let whole = std::fs::read(path("blosc")).expect("a file of the tests");
    let folder = tempfile::tempdir().expect("a folder");
    let there = folder.path().join("changed.vdb");
    for n in 0..times {
        let at =
            (n.wrapping_mul(2_654_435_761) as usize) % if n % 2 == 0 { 900 } else { whole.len() };
        let mut changed = whole.clone();
        changed[at] ^= 1 << (n % 8);
        // Near the first, or anywhere.
        let other = if n % 3 == 0 { at + 4 } else { at * 7 };
        changed[other % whole.len()] = (n >> 3) as u8;
        std::fs::write(&there, &changed).expect("a file");
        if let Ok(grid) = open(&there, "density") {
            assert!(grid.bytes() < 64 << 20, "{n}: {} bytes", grid.bytes());
        }
    }
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn files_changed_in_six_thousand_ways_end_in_a_sentence() {
        super::change(6000);
    }
}

#[test]
fn grids_stay_within_what_is_allowed() {
    let whole = open(&path("zip"), "density").expect("a grid");
    let needed = whole.bytes_of_leaves();
    let budget = Budget::for_grids(Some(needed + needed / 2));
    assert!(read(&path("zip"), "density", &budget).is_ok());
    // The second one would take more than is left.
    let words = read(&path("zip"), "density", &budget).expect_err("too much");
    let words = words.to_string();
    assert!(words.contains("\"density\" takes"), "{words}");
    assert!(words.ends_with("(--max-memory)"), "{words}");
}
