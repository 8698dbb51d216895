use super::*;

#[test]
fn objects_become_members() {
    let mut texts = BTreeMap::new();
    flatten(
        "settings",
        r#"{"samples":64,"film":{"filter":"box"}}"#,
        &mut texts,
    );
    flatten("samples", "64", &mut texts);
    flatten("scene", "{broken", &mut texts);
    let expected = [
        ("samples", "64"),
        ("scene", "{broken"),
        ("settings.film.filter", "box"),
        ("settings.samples", "64"),
    ];
    let texts: Vec<_> = texts
        .iter()
        .map(|(a, b)| (a.as_str(), b.as_str()))
        .collect();
    assert_eq!(texts, expected);
}
