//! Sundog's pictures of the project's scenes against Cycles', by the Python programs beside this file: they need Blender
//! as a Python module (`scripts/setup-bpy.sh`, which `make test` calls).

use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python that has `bpy`: `SUNDOG_BPY_PYTHON`, else the one that the set-up keeps in the cache folder.
pub fn python() -> PathBuf {
    python_of("5.2.3")
}

fn python_of(version: &str) -> PathBuf {
    std::env::var_os("SUNDOG_BPY_PYTHON").map_or_else(
        || cache().join(format!("bpy-{version}/bin/python")),
        PathBuf::from,
    )
}

/// The folder of what the set-up fetches.
pub fn cache() -> PathBuf {
    let folder = std::env::var_os("XDG_CACHE_HOME").map_or_else(
        || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache"),
        PathBuf::from,
    );
    folder.join("sundog")
}

/// Runs one of the Python programs of this folder.
fn run(program: &str, arguments: &[&str]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures");
    run_python(&python(), &folder.join(program), arguments);
}

/// Runs a Python program and fails with all that it said if it does.
fn run_python(python: &Path, program: &Path, arguments: &[&str]) {
    assert!(
        python.exists(),
        "{} is not there: run scripts/setup-bpy.sh 5.2.3, or name a Python that has bpy in SUNDOG_BPY_PYTHON",
        python.display()
    );
    let done = Command::new(python)
        .arg(program)
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    println!("{said}");
    assert!(
        done.status.success(),
        "{} failed:\n{said}{}",
        program.display(),
        String::from_utf8_lossy(&done.stderr)
    );
}

#[test]
fn the_measures_find_known_differences_and_no_others() {
    run("test_compare.py", &[]);
}

/// Scenes beside Cycles; all of them without names.
fn scenes_look_as_in_cycles(names: &[&str]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    let program = ["--sundog", env!("CARGO_BIN_EXE_sundog")];
    let keep = ["--keep", folder.to_str().unwrap()];
    run("compare.py", &[names, &program, &keep].concat());
}

/// One that is closed and one that is open; `long` has all scenes. Materials stand beside Cycles in the add-on's tests, one by one.
#[test]
fn some_scenes_look_as_in_cycles() {
    scenes_look_as_in_cycles(&["cornell", "foliage"]);
}

/// One light in ten of those that `long` has.
#[test]
fn lights_are_as_bright_as_in_cycles() {
    let program = ["--sundog", env!("CARGO_BIN_EXE_sundog")];
    run(
        "brightness.py",
        &[&program[..], &["--every", "10"]].concat(),
    );
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn the_experiments_can_be_made() {
        super::the_experiments_can_be_made();
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn all_scenes_look_as_in_cycles() {
        super::scenes_look_as_in_cycles(&[]);
    }

    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn every_light_is_as_bright_as_in_cycles() {
        super::run("brightness.py", &["--sundog", env!("CARGO_BIN_EXE_sundog")]);
    }
}

#[test]
fn cameras_and_passes_are_those_of_cycles() {
    run("film.py", &["--sundog", env!("CARGO_BIN_EXE_sundog")]);
}

/// Where there is no git, as on a fresh machine with an unpacked archive, the commit is not known, and that is all.
#[test]
fn what_is_measured_needs_no_git() {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    let told = Command::new(python())
        .args([
            "-c",
            "import benchmark, os; os.environ['PATH'] = ''; print('commit', benchmark.commit())",
        ])
        .env("PYTHONPATH", scripts)
        .output()
        .unwrap();
    let (said, wrong) = (
        String::from_utf8_lossy(&told.stdout),
        String::from_utf8_lossy(&told.stderr),
    );
    assert!(said.contains("commit unknown"), "{said}{wrong}");
}

/// The script that writes docs/notes/cost-of-accuracy.md works, and finds in tiny pictures what it finds in large ones.
fn the_experiments_can_be_made() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("experiments");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/experiments.py");
    let program = ["--quick", "--sundog", env!("CARGO_BIN_EXE_sundog")];
    let arguments = [&program[..], &["--out", folder.to_str().unwrap()]].concat();
    // Times are read from Cycles' log, in the words of 4.5.
    run_python(&python_of("4.5.15"), &script, &arguments);
    let errors = |experiment: &str, table: &str| -> Vec<f64> {
        let path = folder.join(format!("{experiment}.results.json"));
        let results: serde_json::Value =
            serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let rows = results["rows"][table].as_array().unwrap();
        rows.iter()
            .map(|row| row["error"].as_f64().unwrap())
            .collect()
    };
    // Pictures are the same bits everywhere, so these are either always true or never; true by a wide margin.
    let [uniform, _, lights, both] = errors("directions", "cornell 0")[..] else {
        panic!("four ways")
    };
    assert!(uniform > 2.0 * lights && uniform > 2.0 * both);
    let [one, four] = errors("light-samples", "cornell 0")[..] else {
        panic!("two numbers")
    };
    // Where light is direct alone. What is left is the places in the pixels, the same for both.
    assert!(one > 1.2 * four, "{one} {four}");
    let samples = errors("samples", "cornell 0");
    assert!(samples[0] > 3.0 * samples[4], "{samples:?}");
    let sky = errors("objects", "three-objects 0");
    assert!(sky[0] > 1.2 * sky[1], "{sky:?}");
    // The page has a table for each experiment, and the one of the objects needs nothing from elsewhere.
    let page = std::fs::read_to_string(folder.join("cost-of-accuracy.md")).unwrap();
    assert_eq!(page.matches("quick. The run took").count(), 7);
    let alone = std::fs::read_to_string(folder.join("objects.html")).unwrap();
    assert!(alone.contains("data:image/jpeg") && !alone.contains("src=\"http"));
}
