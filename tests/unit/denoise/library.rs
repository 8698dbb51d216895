use super::*;

#[test]
fn without_a_library_one_sentence_says_what_to_do() {
    let places = Places {
        folders: vec![PathBuf::from("/nowhere")],
        ..Places::default()
    };
    let said = places.open().err().unwrap().to_string();
    assert_eq!(
        said,
        "Open Image Denoise is not on this machine: run `make setup`, install a Blender, set OIDN_DIR to the folder of libOpenImageDenoise.so.2, or leave --denoise out"
    );
}

#[test]
fn what_a_person_names_stands_alone() {
    let places = Places {
        named: Some(PathBuf::from("/nowhere")),
        folders: vec![PathBuf::from(OF_SETUP)],
        system: false,
    };
    let said = places.open().err().unwrap().to_string();
    assert!(
        said.starts_with("OIDN_DIR is /nowhere, and there is no libOpenImageDenoise.so.2 in it")
    );
}

#[test]
fn a_broken_library_is_told_and_the_next_one_taken() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(FILE), "not a library").unwrap();
    let mut places = Places {
        folders: vec![folder.path().to_owned()],
        ..Places::default()
    };
    let said = places.open().err().unwrap().to_string();
    let broken = format!("{}/{FILE} can't be opened: ", folder.path().display());
    assert!(said.contains(&broken), "{said}");
    places.folders.push(PathBuf::from(OF_SETUP));
    assert_eq!(places.open().unwrap().version(), "2.5.1");
    places.named = Some(folder.path().to_owned());
    let said = places.open().err().unwrap().to_string();
    assert!(
        said.starts_with("OIDN_DIR names a library that can't be used: "),
        "{said}"
    );
}

#[test]
fn the_folder_of_a_prefix_is_enough() {
    let places = Places {
        named: Path::new(OF_SETUP).parent().map(Path::to_owned),
        ..Places::default()
    };
    assert_eq!(places.open().unwrap().version(), "2.5.1");
}
