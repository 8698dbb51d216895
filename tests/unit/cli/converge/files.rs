use super::*;

#[test]
fn names_of_files_are_plain() {
    assert_eq!(
        file_name("Cycles of Blender 4.5.15"),
        "cycles-of-blender-4.5.15"
    );
    assert_eq!(file_name("../a b/<c>"), "a-b-c");
}
