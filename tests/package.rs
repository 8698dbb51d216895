//! The package of `make addon`, by the Python program tests/addon/test_package.py: what is in it, that Blender 4.5 and
//! 5.2 take it and render with it, and that its program runs with nothing else.

use crate::pictures::python;
use std::path::Path;
use std::process::Command;

#[test]
fn the_package_is_whole_and_blender_takes_it() {
    let given = python();
    let mut command = Command::new(&given);
    command
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/addon/test_package.py"))
        .args(["--sundog", env!("CARGO_BIN_EXE_sundog")]);
    // Beside bpy-5.2.3/bin/python its sibling; scripts/test-long.sh has the others.
    let others = given.ancestors().nth(3).map_or(Vec::new(), |cache| {
        ["bpy-4.5.15"]
            .map(|name| cache.join(name).join("bin/python"))
            .into_iter()
            .filter(|python| python.exists())
            .collect()
    });
    for python in std::iter::once(&given).chain(&others) {
        command.arg("--bpy").arg(python);
    }
    let done = command.output().unwrap();
    assert!(
        done.status.success(),
        "test_package.py failed:\n{}{}",
        String::from_utf8_lossy(&done.stdout),
        String::from_utf8_lossy(&done.stderr)
    );
}
