//! Sundog's pictures of the project's scenes against Cycles', by the Python programs beside this file: they need Blender
//! as a Python module (`scripts/setup-bpy.sh`, which `make test` calls).

use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python that has `bpy`: `SUNDOG_BPY_PYTHON`, else the one that the set-up keeps in the cache folder.
pub fn python() -> PathBuf {
    if let Some(python) = std::env::var_os("SUNDOG_BPY_PYTHON") {
        return python.into();
    }
    cache().join("bpy-4.5.15/bin/python")
}

/// The folder of what the set-up fetches.
pub fn cache() -> PathBuf {
    let folder = std::env::var_os("XDG_CACHE_HOME").map_or_else(
        || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache"),
        PathBuf::from,
    );
    folder.join("sundog")
}

/// Runs one of the Python programs and fails with all that it said if it does.
fn run(program: &str, arguments: &[&str]) {
    let python = python();
    assert!(
        python.exists(),
        "{} is not there: run scripts/setup-bpy.sh 4.5.15, or name a Python that has bpy in SUNDOG_BPY_PYTHON",
        python.display()
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures");
    let done = Command::new(python)
        .arg(folder.join(program))
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    println!("{said}");
    assert!(
        done.status.success(),
        "{program} failed:\n{said}{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

#[test]
fn the_measures_find_known_differences_and_no_others() {
    run("test_compare.py", &[]);
}

#[test]
fn the_scenes_look_as_in_cycles() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    run(
        "compare.py",
        &[
            "--sundog",
            env!("CARGO_BIN_EXE_sundog"),
            "--keep",
            folder.to_str().unwrap(),
        ],
    );
}

#[test]
fn every_light_is_as_bright_as_in_cycles() {
    run("brightness.py", &["--sundog", env!("CARGO_BIN_EXE_sundog")]);
}

#[test]
fn cameras_and_passes_are_those_of_cycles() {
    run("film.py", &["--sundog", env!("CARGO_BIN_EXE_sundog")]);
}
