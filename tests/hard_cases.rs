//! The hard cases of numerics, each group as a test (see docs/hard-cases.md); and the command that runs some of them.

mod camera;
mod directions;
mod distributions;
mod environments;
mod interfaces;
mod lights;
mod materials;
mod not_finite;
mod oracle;
mod transforms;
mod triangles;

use sundog::selftest::{Case, Effort, Finding, GROUPS, kit};

/// Those that `sundog selftest` does not run: long ones, and those of parts that no machine changes.
const ONLY_HERE: [(&str, &[Case]); 10] = [
    ("transforms", transforms::CASES),
    ("interfaces", interfaces::CASES),
    ("triangles", triangles::CASES),
    ("camera", camera::CASES),
    ("directions", directions::CASES),
    ("limits of materials", materials::CASES),
    ("lights", lights::CASES),
    ("kernels in f64", oracle::CASES),
    ("distributions", distributions::CASES),
    ("NaN and infinity", not_finite::CASES),
];

/// The cases of a group.
fn cases(name: &str) -> &'static [Case] {
    let named = |group: &&(&str, &'static [Case])| group.0 == name;
    match ONLY_HERE.iter().find(named) {
        Some((_, cases)) => cases,
        None => {
            GROUPS
                .iter()
                .find(|group| group.name == name)
                .unwrap()
                .cases
        }
    }
}

/// Runs cases and tells all that do not hold.
fn run(cases: &[Case], effort: Effort) {
    let mut wrong = Vec::new();
    for case in cases {
        let outcome = case.outcome(effort);
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
        $(#[test] fn $test() { run(cases($name), Effort::Thorough); })*

        #[test]
        fn every_group_is_tested() {
            let shipped = GROUPS.iter().map(|group| group.name);
            let names: Vec<&str> = shipped.chain(ONLY_HERE.map(|(name, _)| name)).collect();
            assert_eq!(names, [$($name),*]);
        }
    };
}

groups! {
    place_and_scale: "place and scale",
    self_intersection_and_gaps: "self-intersection and gaps",
    materials: "materials",
    media: "media",
    strands: "strands",
    sampling_and_sums: "sampling and sums",
    transforms: "transforms",
    interfaces: "interfaces",
    triangles: "triangles",
    camera: "camera",
    directions: "directions",
    limits_of_materials: "limits of materials",
    lights: "lights",
    kernels_in_f64: "kernels in f64",
    distributions: "distributions",
    nan_and_infinity: "NaN and infinity",
}

/// What `make test-long` runs.
mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn cases_with_all_their_work() {
        for (_, cases) in super::ONLY_HERE {
            super::run(cases, super::Effort::Long);
        }
    }
}

/// Names are those of the command line: words with hyphens, and each once.
#[test]
fn names_are_words_and_differ() {
    let shipped = GROUPS.iter().map(|group| group.cases);
    let mut names = std::collections::BTreeSet::new();
    for case in shipped.chain(ONLY_HERE.map(|(_, cases)| cases)).flatten() {
        let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(case.name.chars().all(word), "{}", case.name);
        assert!(case.about.ends_with('.'), "{}", case.name);
        assert!(names.insert(case.name), "{} stands twice", case.name);
    }
}

/// Each case has its place in the documentation.
#[test]
fn every_case_is_explained() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/hard-cases.md");
    let page = std::fs::read_to_string(page).unwrap();
    let shipped = GROUPS.iter().map(|group| group.cases);
    for case in shipped.chain(ONLY_HERE.map(|(_, cases)| cases)).flatten() {
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
