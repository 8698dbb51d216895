//! Folders with pictures of other renderers.

use std::path::Path;
use sundog::measure::convergence::Peer;

fn sentence(files: &[(&str, &str)]) -> String {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    match Peer::read_all(folder.path()) {
        Ok(peers) => format!("{} peers", peers.len()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn bad_folders_are_one_sentence() {
    let no_folder = Peer::read_all(Path::new("no/such"))
        .unwrap_err()
        .to_string();
    assert!(no_folder.contains("no such folder"), "{no_folder}");
    for (files, words) in [
        (&[][..], "neither a times.json"),
        (&[("times.json", "{")], "docs/converge.md"),
        (&[("times.json", "{\"renderer\": \"A\"}")], "pictures"),
        (
            &[("times.json", "{\"renderer\": \"A\", \"pictures\": []}")],
            "no pictures",
        ),
        (
            &[(
                "a.times.json",
                "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 1}]}",
            )],
            "a.exr, which is not there",
        ),
        (
            &[
                (
                    "times.json",
                    "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 0}]}",
                ),
                ("a.exr", ""),
            ],
            "greater than 0",
        ),
        (
            &[
                (
                    "b.times.json",
                    "{\"renderer\": \"A\", \"pictures\": [{\"file\": \"a.exr\", \"samples\": 1, \"seconds\": 2}]}",
                ),
                ("a.exr", ""),
                ("other.json", "broken"),
            ],
            "1 peers",
        ),
    ] {
        let said = sentence(files);
        assert!(said.contains(words), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn names_are_distinct() {
    let others = ["Cycles", "Cycles (2)"];
    assert_eq!(
        Peer::distinct_name("Cycles", others.into_iter()),
        "Cycles (3)"
    );
    assert_eq!(Peer::distinct_name("Sundog", others.into_iter()), "Sundog");
}
