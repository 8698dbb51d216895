//! The hard cases of numerics, each group as a test (see docs/hard-cases.md); and the command that runs them.

use sundog::selftest::{Effort, GROUPS};

/// Runs all cases of a group and tells all that do not hold.
fn group(name: &str) {
    let group = GROUPS.iter().find(|group| group.name == name).unwrap();
    let mut wrong = Vec::new();
    for case in group.cases {
        let outcome = case.outcome(Effort::Thorough);
        println!("{}: {:.1} s", case.name, outcome.time.as_secs_f64());
        if !outcome.holds() {
            wrong.push(format!("{}: {:#?}", case.name, outcome.findings));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A test for each group; a group that is not here fails `every_group_is_tested`.
macro_rules! groups {
    ($($test:ident: $name:literal,)*) => {
        $(#[test] fn $test() { group($name); })*

        #[test]
        fn every_group_is_tested() {
            let names: Vec<&str> = GROUPS.iter().map(|group| group.name).collect();
            assert_eq!(names, [$($name),*]);
        }
    };
}

groups! {
    place_and_scale: "place and scale",
    self_intersection_and_gaps: "self-intersection and gaps",
    triangles: "triangles",
    camera: "camera",
    directions: "directions",
    materials: "materials",
    lights: "lights",
    kernels_in_f64: "kernels in f64",
    sampling_and_sums: "sampling and sums",
    nan_and_infinity: "NaN and infinity",
}

/// Each case has its place in the documentation.
#[test]
fn every_case_is_explained() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/hard-cases.md");
    let page = std::fs::read_to_string(page).unwrap();
    for case in GROUPS.iter().flat_map(|group| group.cases) {
        let name = format!("`{}`", case.name);
        assert!(
            page.contains(&name),
            "docs/hard-cases.md does not explain {name}"
        );
    }
}

#[test]
fn selftest_tells_of_each_case_in_a_table() {
    let run = |arguments: &[&str]| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_sundog"));
        let output = program.arg("selftest").args(arguments).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap(),
        )
    };
    let (code, table) = run(&["--case", "order-of-samples"]);
    let words = [
        "case",
        "verdict",
        "order-of-samples",
        "sums that differ in parts",
        "holds",
    ];
    for word in words {
        assert!(table.contains(word), "no {word:?} in: {table}");
    }
    assert_eq!(code, Some(0));
    let (_, listed) = run(&["--list"]);
    assert_eq!(
        listed.lines().filter(|line| line.starts_with("  ")).count(),
        GROUPS.iter().map(|group| group.cases.len()).sum::<usize>()
    );
    let (code, told) = run(&["--case", "many-samples", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!((code, &told["holds"]), (Some(0), &true.into()));
    assert_eq!(told["cases"][0]["findings"][0]["quantity"], "mean radiance");
    assert_eq!(run(&["--case", "no-such-case"]).0, Some(2));
}
