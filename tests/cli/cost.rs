//! `sundog cost` as people and scripts call it.

use super::{Folder, scene};
use serde_json::Value;
use std::fs;

/// The scene with light from all around, so small that a probe takes no time.
fn tiny() -> Folder {
    let folder = Folder::new();
    folder.write("scene.gltf", scene().to_string());
    folder
}

const SMALL: [&str; 6] = [
    "--width",
    "24",
    "--environment-color",
    "1,0.9,0.8",
    "--threads",
    "1",
];

fn ask(folder: &Folder, more: &[&str]) -> String {
    let arguments: Vec<&str> = ["cost", "scene.gltf"]
        .iter()
        .chain(&SMALL)
        .chain(more)
        .copied()
        .collect();
    folder.works(&arguments)
}

fn event(text: &str, kind: &str) -> Value {
    let mut events = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    events.find(|event| event["event"] == kind).unwrap()
}

#[test]
fn a_forecast_answers_both_ways() {
    let folder = tiny();
    let more = [
        "--probe",
        "0.2s",
        "--error",
        "1%",
        "--time",
        "1h",
        "--samples",
        "100000",
        "--json",
        "-o",
        "cost.json",
        "-o",
        "cost.csv",
        "--report",
        "cost.html",
    ];
    let forecast = event(&ask(&folder, &more), "forecast");
    let rows = forecast["table"].as_array().unwrap();
    assert_eq!(rows.len(), 5);
    let number = |value: &Value| value.as_f64().unwrap();
    for pair in rows.windows(2) {
        assert!((number(&pair[0]["error"]) / number(&pair[1]["error"]) - 2.0).abs() < 1e-9);
        for what in ["samples", "seconds", "rays"] {
            assert!(number(&pair[0][what]["expected"]) <= number(&pair[1][what]["expected"]));
        }
    }
    for row in rows {
        let time = &row["seconds"];
        assert!(number(&time["low"]) <= number(&time["expected"]));
        assert!(number(&time["expected"]) <= number(&time["high"]));
    }
    let answers = forecast["answers"].as_array().unwrap();
    let questions: Vec<_> = answers
        .iter()
        .map(|a| a["question"].as_str().unwrap())
        .collect();
    assert_eq!(questions, ["error", "time", "samples"]);
    let written: Value =
        serde_json::from_str(&fs::read_to_string(folder.path("cost.json")).unwrap()).unwrap();
    assert_eq!(written["table"], forecast["table"]);
    let table = fs::read_to_string(folder.path("cost.csv")).unwrap();
    assert_eq!(table.lines().count(), 6, "{table}");
    let page = fs::read_to_string(folder.path("cost.html")).unwrap();
    assert!(page.contains("1.0 % needs") && page.contains("Error against time"));
    let people = ask(&folder, &["--probe", "0.1s", "--error", "1%"]);
    assert!(people.contains("1.0 % needs "), "{people}");
}

#[test]
fn effects_are_listed_with_what_they_cost() {
    let folder = tiny();
    let more = [
        "--effects",
        "--probe",
        "0.01s",
        "--bounces",
        "2",
        "--clamp-indirect",
        "10",
        "--json",
        "-o",
        "cost.csv",
        "--report",
        "cost.html",
    ];
    let text = ask(&folder, &more);
    let study = event(&text, "effects");
    let effects = study["effects"].as_array().unwrap();
    let find = |name: &str| {
        let found = effects.iter().find(|effect| effect["effect"] == name);
        found.unwrap_or_else(|| panic!("no {name} in {effects:?}"))
    };
    // Without the sky there is less light.
    assert!(
        find("constant-environment")["change"]["low"]
            .as_f64()
            .unwrap()
            > 0.01
    );
    for name in [
        "bounces beyond 0",
        "bounces beyond 1",
        "clamp-indirect",
        "sampling lights",
    ] {
        assert!(find(name)["without"]["rays"].as_f64().unwrap() > 0.0);
    }
    let steps = text
        .lines()
        .filter(|line| line.contains("\"measuring\""))
        .count();
    // The full picture and one without each; adaptive sampling is against another one.
    assert_eq!(steps, 3 * (effects.len() + 2));
    let table = fs::read_to_string(folder.path("cost.csv")).unwrap();
    assert_eq!(table.lines().count(), effects.len() + 1);
    let page = fs::read_to_string(folder.path("cost.html")).unwrap();
    assert!(page.contains("With and without") && page.contains("without constant-environment"));
}

/// What the table names, the study has: adaptive sampling against as many samples everywhere, and all else without it.
#[test]
fn adaptive_sampling_is_an_effect() {
    let folder = tiny();
    let more = [
        "--effects",
        "--probe",
        "0.01s",
        "--bounces",
        "1",
        "--pixel-error",
        "4%",
    ];
    let people = ask(&folder, &more);
    assert!(people.contains("Adaptive sampling at 4.0 %: "), "{people}");
    let study = event(&ask(&folder, &[&more[..], &["--json"]].concat()), "effects");
    let effects = study["effects"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    for effect in effects {
        let interval = &effect["milliseconds_interval"];
        let cost = number(&effect["milliseconds"]);
        assert!(number(&interval[0]) <= cost && cost <= number(&interval[1]));
        let evened = &effect["evened"];
        if effect["effect"] == "adaptive-sampling" {
            assert_eq!(number(&evened["tolerance"]), 0.04);
            // It ends when nothing is worse, but for the tiles that are smaller than what is pooled.
            let worst = number(&evened["worst_tile"]);
            assert!(worst > 0.0 && worst < 0.08, "{evened}");
            assert!(number(&evened["samples"]) >= 32.0, "{evened}");
        } else {
            assert!(evened.is_null());
        }
    }
    assert!(
        effects
            .iter()
            .any(|effect| effect["effect"] == "adaptive-sampling")
    );
}

#[test]
fn what_cannot_be_asked_is_one_sentence() {
    let folder = tiny();
    folder.fails(
        &["cost", "scene.gltf", "-o", "a.txt"],
        2,
        &["a.txt", ".json or .csv"],
    );
    folder.fails(
        &["cost", "scene.gltf", "--report", "a.txt"],
        2,
        &["a.txt", ".html"],
    );
    folder.fails(
        &["cost", "scene.gltf", "--rounds", "2"],
        2,
        &["rounds", "3"],
    );
    folder.fails(
        &["cost", "scene.gltf", "--pixel-error", "5%"],
        2,
        &["--effects"],
    );
    folder.fails(&["cost", "nothing.gltf"], 1, &["nothing.gltf"]);
}
