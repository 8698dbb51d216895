/// `docs/cli.md` says what the program does; `sundog flags --markdown > docs/cli.md` renews it.
#[test]
fn the_page_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/cli.md");
    let written = std::fs::read_to_string(path).unwrap();
    assert!(
        written == super::markdown(),
        "docs/cli.md is not current: run `cargo run -- flags --markdown > docs/cli.md`"
    );
}
