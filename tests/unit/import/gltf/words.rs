use super::*;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[allow(dead_code)]
struct Sample {
    number: f32,
    #[serde(default)]
    list: Vec<f32>,
    #[serde(default)]
    three: [f32; 3],
}

fn told(text: &str) -> String {
    plain(&serde_json::from_value::<Sample>(serde_json::from_str(text).unwrap()).unwrap_err())
}

#[test]
fn messages_know_no_types_of_programs() {
    for (text, words) in [
        ("{}", "\"number\" is missing"),
        (
            r#"{"number": "x"}"#,
            "there is the text \"x\" where a number belongs",
        ),
        (
            r#"{"number": 1, "list": {}}"#,
            "there is an object where a list belongs",
        ),
        (
            r#"{"number": 1, "list": true}"#,
            "there is true where a list belongs",
        ),
        (
            r#"{"number": 1, "three": [1, 2]}"#,
            "there is a list of 2 where a list of 3 belongs",
        ),
        (
            r#"{"number": 1, "three": 4}"#,
            "there is the number 4 where a list of 3 belongs",
        ),
        ("[]", "there is a list of 0 where an object belongs"),
    ] {
        assert_eq!(told(text), words);
    }
}

#[test]
fn what_else_was_downloaded_is_named() {
    assert!(mistaken(b"\n<!DOCTYPE html><p>404").is_some_and(|why| why.contains("web page")));
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0";
    assert!(mistaken(pointer).is_some_and(|why| why.contains("git lfs pull")));
    assert_eq!(mistaken(b"{\"asset\": {}}"), None);
    assert_eq!(mistaken(b""), None);
}
