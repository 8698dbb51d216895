//! The pages that people read first: short sentences, links, commands that run, and files that are there.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn sentences_are_short_and_commands_run_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(crate::pictures::python())
        .arg(root().join("tests/python/pages.py"))
        .arg(env!("CARGO_BIN_EXE_sundog"))
        .arg(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(
        done.status.success() && said.contains("the pages hold"),
        "{said}{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

/// What stands between backticks in a text and is a path from the project's root.
fn paths(text: &str) -> BTreeSet<&str> {
    const FOLDERS: [&str; 8] = [
        "src/",
        "tests/",
        "docs/",
        "scripts/",
        "benches/",
        "examples/",
        "scenes/",
        "blender_addon/",
    ];
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder)))
        .filter(|word| !word.contains(' '))
        .collect()
}

#[test]
fn every_file_that_the_architecture_names_is_there() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let paths = paths(&page);
    assert!(paths.len() > 60, "only {} paths were found", paths.len());
    let gone: Vec<_> = paths
        .into_iter()
        .filter(|path| !root().join(path).exists())
        .collect();
    assert!(gone.is_empty(), "ARCHITECTURE.md names {gone:?}");
}

#[test]
fn the_architecture_answers_twenty_changes() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, rest) = page.split_once("## Where do I change …").unwrap();
    let table = rest.split("\n## ").next().unwrap();
    let rows: Vec<_> = table
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| ---"))
        .skip(1)
        .collect();
    assert!(rows.len() >= 20, "{} rows", rows.len());
    for row in rows {
        assert!(!paths(row).is_empty(), "no file in: {row}");
    }
}

/// The flags that `make build` takes for a processor with these in /proc/cpuinfo.
fn flags_of_a_build(processor: &str) -> String {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), format!("model\t: 6\nflags\t\t: {processor}\n")).unwrap();
    let script = root().join("scripts/cpu-flags.sh");
    let done = Command::new(script).arg(file.path()).output().unwrap();
    assert!(done.status.success());
    String::from_utf8(done.stdout).unwrap()
}

/// What `scripts/profile-flags.sh` says of a rustc that tells this version.
fn flags_of_a_profile(version: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let rustc = folder.path().join("rustc");
    std::fs::write(&rustc, format!("#!/bin/sh\necho '{version}'\n")).unwrap();
    std::fs::set_permissions(&rustc, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let script = root().join("scripts/profile-flags.sh");
    let done = Command::new(script).arg(&rustc).output().unwrap();
    assert!(done.status.success());
    String::from_utf8(done.stdout).unwrap()
}

/// The profile names functions as one rustc does, and another may not be able to read it.
#[test]
fn builds_take_the_profile_where_it_is_of_their_rustc() {
    let made_by = std::fs::read_to_string(root().join("scripts/profile/rustc.txt")).unwrap();
    let flags = flags_of_a_profile(made_by.trim());
    let (_, rest) = flags.split_once("-C profile-use=").unwrap();
    let file = std::fs::read(rest.split(' ').next().unwrap()).unwrap();
    // The magic number of an indexed profile.
    assert_eq!(&file[..8], b"\xfflprofi\x81");
    assert_eq!(
        flags_of_a_profile("rustc 1.88.0 (6b00bc388 2025-06-23)"),
        ""
    );
    assert_eq!(flags_of_a_profile(""), "");
}

#[test]
fn builds_take_the_newer_instructions_where_all_of_them_are_there() {
    let all = "fpu abm avx avx2 bmi1 bmi2 f16c fma movbe sse4_2";
    assert_eq!(flags_of_a_build(all), "-C target-cpu=x86-64-v3\n");
    assert_eq!(flags_of_a_build(&all.replace(" avx2 ", " ")), "");
    assert_eq!(flags_of_a_build(&all.replace("fma ", "fma4 ")), "");
    assert_eq!(flags_of_a_build(""), "");
}
