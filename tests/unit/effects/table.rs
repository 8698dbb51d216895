use super::*;

/// `UPDATE=1 cargo test --release --lib the_page_has_the_table` writes it anew.
#[test]
fn the_page_has_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/effects.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (begin, end) = ("<!-- table -->\n", "<!-- end -->");
    let (before, rest) = page.split_once(begin).unwrap();
    let (there, after) = rest.split_once(end).unwrap();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(path, format!("{before}{begin}{}{end}{after}", markdown())).unwrap();
    } else {
        assert!(there == markdown(), "run this test with UPDATE=1");
    }
}

#[test]
fn each_effect_stands_in_its_place_and_no_group_has_its_name() {
    let mut names: Vec<_> = TABLE.iter().map(|row| row.effect.id()).collect();
    names.extend(sets::GROUPS.map(|(_, name)| name));
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
    for (i, row) in TABLE.iter().enumerate() {
        assert_eq!(row.effect as usize, i, "{}", row.effect.id());
        let compiled = row.decided == Decided::Kernels;
        assert_eq!(
            sets::PATHS.contains(row.effect),
            compiled,
            "{}",
            row.effect.id()
        );
    }
}
