//! The arrows between the rooms, and who may do what: ARCHITECTURE.md, held true.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Which rooms a room may import, besides itself. The order is that of the data's way, backwards.
const ARROWS: &[(&str, &[&str])] = &[
    ("ffi", &[]),
    ("math", &[]),
    ("nodes", &[]),
    ("color", &["ffi"]),
    // Constants are folded by what nodes compute.
    // Images may lie in mapped files.
    ("scene", &["nodes", "math", "ffi"]),
    ("import", &["scene", "nodes", "color", "math"]),
    ("sampler", &["math"]),
    // It compiles the scene's shader graphs, and reads the scene's images.
    ("shading", &["scene", "math", "color", "sampler"]),
    // Lights are made of what a scene says of them; rays find many lamps by a hierarchy of Embree's.
    ("light", &["scene", "ffi", "math", "sampler"]),
    ("medium", &["math", "color", "sampler"]),
    ("camera", &["math", "color", "sampler"]),
    ("film", &["math", "sampler"]),
    // Installed Blenders bring the denoiser, and are looked for by whoever looks for their colours.
    ("denoise", &["film", "color", "ffi", "math"]),
    ("effects", &["scene", "math"]),
    (
        "world",
        &[
            "scene", "effects", "shading", "light", "medium", "camera", "ffi", "math", "sampler",
        ],
    ),
    (
        "integrator",
        &[
            "world", "effects", "shading", "light", "medium", "camera", "film", "sampler", "math",
        ],
    ),
    (
        "render",
        &[
            "integrator",
            "film",
            "world",
            "effects",
            "camera",
            "sampler",
            "scene",
            "math",
        ],
    ),
    ("report", &[]),
    // Costs and comparisons say what they found as tables and pages.
    (
        "cost",
        &["report", "math", "render", "effects", "film", "scene"],
    ),
    // EXR files name the primaries that their numbers are amounts of.
    ("output", &["film", "color", "math"]),
    // Pictures are read by the scenes' decoder, under the same budget.
    ("measure", &["report", "output", "import", "math"]),
];

/// Rooms that may import all others.
const ROOFS: &[&str] = &["cli", "selftest"];

/// Files outside `src/ffi` in which `unsafe` is allowed, each a hot spot where a measurement has shown the gain.
const UNSAFE_HOT_SPOTS: &[&str] = &[];

/// All files of Rust below a folder.
fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            walk(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

fn sources() -> Vec<PathBuf> {
    let mut files = Vec::new();
    walk(&root().join("src"), &mut files);
    files.sort();
    files
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn name(path: &Path) -> String {
    path.strip_prefix(root()).unwrap().display().to_string()
}

/// The program in a file: without comments, and without the tests that stand at its end.
fn program(text: &str) -> String {
    let inside = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let text = inside
        .split("#[cfg(test)]\n#[path")
        .next()
        .unwrap_or_default();
    text.lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

/// The room of a file: the folder or file below `src`.
fn room(path: &Path) -> String {
    let inner = path.strip_prefix(root().join("src")).unwrap();
    let first = inner
        .components()
        .next()
        .unwrap()
        .as_os_str()
        .to_string_lossy()
        .into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// All names that follow `crate::` in a program, `crate::{a, b::c}` included.
fn imported(program: &str) -> BTreeSet<String> {
    let identifier = |text: &str| -> String {
        text.trim_start()
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '_')
            .collect()
    };
    let mut rooms = BTreeSet::new();
    for rest in program.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            None => {
                rooms.insert(identifier(rest));
            }
            Some(list) => {
                let mut depth = 0;
                let mut start = true;
                for (index, symbol) in list.char_indices() {
                    if depth == 0 && start && !symbol.is_whitespace() {
                        rooms.insert(identifier(&list[index..]));
                        start = false;
                    }
                    match symbol {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        _ => {}
                    }
                }
            }
        }
    }
    rooms.remove("");
    rooms
}

fn words(program: &str) -> impl Iterator<Item = &str> {
    program
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '!')
        .filter(|word| !word.is_empty())
}

#[test]
fn every_arrow_between_rooms_is_one_that_the_design_allows() {
    let allowed: BTreeMap<_, _> = ARROWS.iter().copied().collect();
    let mut wrong = Vec::new();
    let mut seen = 0;
    for path in sources() {
        let from = room(&path);
        if from == "lib" || from == "main" || ROOFS.contains(&from.as_str()) {
            continue;
        }
        let Some(targets) = allowed.get(from.as_str()) else {
            wrong.push(format!(
                "{} is in a room that ARROWS does not know",
                name(&path)
            ));
            continue;
        };
        for to in imported(&program(&std::fs::read_to_string(&path).unwrap())) {
            seen += 1;
            if to != from && !targets.contains(&to.as_str()) {
                wrong.push(format!("{}: {from} may not import {to}", name(&path)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        seen > 20,
        "the test has read almost nothing: {seen} imports"
    );
}

#[test]
fn the_table_has_no_way_back() {
    // Each room imports only rooms that stand above it in the table, so that there are no circles.
    for (index, (from, targets)) in ARROWS.iter().enumerate() {
        for to in *targets {
            assert!(
                ARROWS[..index].iter().any(|(room, _)| room == to),
                "{from} imports {to}, which comes later"
            );
        }
    }
}

#[test]
fn the_page_knows_every_room() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for (room, _) in ARROWS {
        assert!(
            page.contains(&format!("`{room}/`")),
            "ARCHITECTURE.md does not know the room {room}"
        );
        assert!(
            root().join("src").join(room).is_dir(),
            "the room {room} is not there any more"
        );
    }
}

#[test]
fn files_are_read_at_one_sitting() {
    const MOST_LINES: usize = 700;
    let long: Vec<String> = sources()
        .iter()
        .map(|path| {
            let text = std::fs::read_to_string(path).unwrap();
            (name(path), text.lines().count())
        })
        .filter(|(_, lines)| *lines > MOST_LINES)
        .map(|(name, lines)| format!("{name}: {lines} lines"))
        .collect();
    assert!(long.is_empty(), "more than {MOST_LINES}: {long:?}");
}

#[test]
fn unsafe_is_in_ffi_alone() {
    let mut found = false;
    for path in sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        let here = words(&program(&text)).any(|word| word == "unsafe");
        found |= here;
        let allowed = room(&path) == "ffi" || UNSAFE_HOT_SPOTS.contains(&name(&path).as_str());
        assert!(
            !here || allowed,
            "{}: `unsafe` belongs into src/ffi",
            name(&path)
        );
    }
    assert!(found, "the test has not even found src/ffi's");
}

#[test]
fn only_the_command_line_prints() {
    for path in sources() {
        if matches!(room(&path).as_str(), "cli" | "main") {
            continue;
        }
        let text = program(&std::fs::read_to_string(&path).unwrap());
        for macro_name in ["print!", "println!", "eprint!", "eprintln!", "dbg!"] {
            assert!(
                !words(&text).any(|word| word == macro_name),
                "{} prints",
                name(&path)
            );
        }
        for stream in ["stdout()", "stderr()"] {
            assert!(!text.contains(stream), "{} writes to {stream}", name(&path));
        }
    }
}

#[test]
fn the_reader_of_imports_reads_them() {
    let text =
        "use crate::a::B;\nuse crate::{c::{D, e}, f};\nlet x = crate::g::h();\n// crate::comment\n";
    let names: Vec<_> = imported(&program(text)).into_iter().collect();
    assert_eq!(names, ["a", "c", "f", "g"]);
}

/// Exit handlers take from threads what they work with: `cli::leave` is the only way out.
#[test]
fn nobody_leaves_through_exit_handlers() {
    for path in sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        let program = program(&text);
        for way in ["process::exit", "ExitCode::from", "-> ExitCode"] {
            assert!(!program.contains(way), "{}: {way}", name(&path));
        }
    }
}

/// A file's unit tests are found by its own path.
#[test]
fn unit_tests_are_at_the_path_of_their_file() {
    let mut units = BTreeSet::new();
    for path in sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        let Some((_, rest)) = text.split_once("#[cfg(test)]\n#[path = \"") else {
            continue;
        };
        let given = path.parent().unwrap().join(rest.split('"').next().unwrap());
        let source = path.strip_prefix(root().join("src")).unwrap();
        let unit = root().join("tests/unit").join(source);
        assert_eq!(given.canonicalize().unwrap(), unit, "{}", name(&path));
        units.insert(unit);
    }
    let mut files = Vec::new();
    walk(&root().join("tests/unit"), &mut files);
    assert_eq!(files.into_iter().collect::<BTreeSet<_>>(), units);
}
