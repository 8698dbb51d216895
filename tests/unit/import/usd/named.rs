use super::*;

fn names_of(path: &Path) -> Vec<String> {
    let folder = path.parent().unwrap();
    let mut names: Vec<_> = named_files(path)
        .into_iter()
        .filter(|file| file.is_file())
        .map(|file| file.components().collect::<PathBuf>())
        .map(|file| file.strip_prefix(folder).unwrap().display().to_string())
        .collect();
    names.sort();
    names.dedup();
    names
}

/// What is in variants, layers below, tiles and clips is found, whether it is read this time or not.
#[test]
fn layers_and_images_are_found_in_all_layers() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    let root = file(
        "root.usda",
        "#usda 1.0\n(\n subLayers = [@./under.usda@]\n)\ndef \"a\" (\n variants = { string v = \"one\" }\n)\n{\n variantSet \"v\" = { \"two\" ( payload = @parts/part.usda@ ) { } }\n}\n",
    );
    file(
        "under.usda",
        "#usda 1.0\ndef \"b\" ( references = @root.usda@ ) {\n asset t = @tex.<UDIM>.png@\n asset templateAssetPath = @clip.###.usda@\n}\n",
    );
    file(
        "parts/part.usda",
        "#usda 1.0\ndef Shader \"s\" { asset inputs:file = @./wood.png@ }\n",
    );
    for name in [
        "parts/wood.png",
        "tex.1001.png",
        "tex.1002.png",
        "clip.001.usda",
        "not-named.png",
    ] {
        file(name, "");
    }
    assert_eq!(
        names_of(&root),
        [
            "clip.001.usda",
            "parts/part.usda",
            "parts/wood.png",
            "root.usda",
            "tex.1001.png",
            "tex.1002.png",
            "under.usda"
        ]
    );
    assert!(named_files(folder.path()).is_empty());
    assert!(named_files(&folder.path().join("none.usda")).is_empty());
}

/// Paths in binary layers are among their packed words.
#[test]
fn binary_layers_are_read() {
    let text = "tex.png\0word\0";
    let packed = lz4_flex::block::compress(text.as_bytes());
    let mut bytes = b"PXR-USDC\0\x08\0\0\0\0\0\0".to_vec();
    let contents = 88 + 24 + 1 + packed.len() as u64;
    bytes.extend(contents.to_le_bytes());
    bytes.resize(88, 0);
    bytes.extend(2u64.to_le_bytes());
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend((packed.len() as u64 + 1).to_le_bytes());
    bytes.push(0);
    bytes.extend(&packed);
    bytes.extend(1u64.to_le_bytes());
    let mut name = [0; 16];
    name[..6].copy_from_slice(b"TOKENS");
    bytes.extend(name);
    bytes.extend(88u64.to_le_bytes());
    bytes.extend((contents - 88).to_le_bytes());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usdc");
    std::fs::write(&path, &bytes).unwrap();
    std::fs::write(folder.path().join("tex.png"), "").unwrap();
    assert_eq!(names_of(&path), ["tex.png"]);
    std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    assert!(names_of(&path).is_empty());
}
