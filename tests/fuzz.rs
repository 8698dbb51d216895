//! Random inputs: all that the fuzzer has found and that is mended, and some fresh ones.

use std::path::Path;
use sundog::hard::fuzz;

/// What is kept in tests/fuzz: recipes of scenes as JSON, and damaged files.
#[test]
fn what_was_found_stays_mended() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let mut wrong = Vec::new();
    for path in &files {
        let finding = if path
            .extension()
            .is_some_and(|extension| extension == "json")
        {
            let text = std::fs::read_to_string(path).unwrap();
            fuzz::check(&serde_json::from_str(&text).unwrap())
        } else {
            fuzz::import(path)
        };
        if let Some(finding) = finding {
            wrong.push(format!("{}: {finding}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn random_inputs_hold() {
    for seed in 1_000_000..1_000_040 {
        let input = fuzz::draw(seed);
        let finding = fuzz::check(&input);
        assert_eq!(finding, None, "seed {seed}: {input:#}");
    }
}
