use super::*;

#[test]
fn all_names_are_found_in_both_kinds_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"{ "buffers": [{ "uri": "a%20b.bin" }, { "uri": "data:,x" }],
            "images": [{ "uri": "c.png" }], "extensions": { "X": { "image": "sky.exr" } } }"#;
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, text).unwrap();
    let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    glb.extend((text.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(text.as_bytes());
    let binary = folder.path().join("a.glb");
    std::fs::write(&binary, glb).unwrap();
    for path in [path, binary] {
        let mut names: Vec<_> = named_files(&path)
            .into_iter()
            .map(|file| {
                file.strip_prefix(folder.path())
                    .unwrap()
                    .display()
                    .to_string()
            })
            .collect();
        names.sort();
        assert_eq!(names, ["a b.bin", "a%20b.bin", "c.png", "sky.exr"]);
    }
    assert!(named_files(folder.path()).is_empty());
    assert!(named_files(&folder.path().join("none")).is_empty());
}
