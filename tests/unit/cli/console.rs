use super::*;

#[test]
fn names_do_not_command_the_terminal() {
    let evil =
        "a\u{1b}]0;owned\u{7}\r\nsundog: all is well\u{9b}31m\u{7f}\t\u{202e}gpj.exe\u{2066}";
    let line = one_line(evil);
    assert_eq!(
        line,
        "a\\u{1b}]0;owned\\u{7}\\r\\nsundog: all is well\\u{9b}31m\\u{7f}\\t\\u{202e}gpj.exe\\u{2066}"
    );
    let plain = "Käse 🧀 日本 עברית – \\ \"";
    assert_eq!(one_line(plain), plain);
    let json = serde_json::to_string(evil).unwrap();
    let json = escaped_json(&json);
    assert!(!json.chars().any(is_unseen), "{json}");
    assert_eq!(serde_json::from_str::<String>(&json).unwrap(), evil);
}
