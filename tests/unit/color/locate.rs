use super::*;
use std::fs;

fn put_config(folder: &Path) -> PathBuf {
    let folder = folder.join("datafiles/colormanagement");
    fs::create_dir_all(&folder).unwrap();
    let config = folder.join("config.ocio");
    fs::write(&config, "ocio_profile_version: 2\n").unwrap();
    config
}

fn nowhere(root: &Path) -> SearchPlaces {
    SearchPlaces {
        root: root.to_owned(),
        ..SearchPlaces::default()
    }
}

#[test]
fn what_a_person_names_stands_alone() {
    let temporary = tempfile::tempdir().unwrap();
    put_config(&temporary.path().join("usr/share/blender/4.5"));
    let mut places = nowhere(temporary.path());
    places.ocio = Some("from-environment.ocio".into());
    assert_eq!(
        places.candidates(Some(Path::new("flag.ocio"))),
        [ConfigOrigin::Flag("flag.ocio".into())]
    );
    assert_eq!(
        places.candidates(None),
        [ConfigOrigin::Environment("from-environment.ocio".into())]
    );
    places.ocio = Some("".into());
    assert!(matches!(
        places.candidates(None)[0],
        ConfigOrigin::Blender(_)
    ));
}

#[test]
fn with_nothing_there_the_built_in_one_remains() {
    let temporary = tempfile::tempdir().unwrap();
    assert_eq!(
        nowhere(temporary.path()).candidates(None),
        [ConfigOrigin::BuiltIn(BUILT_IN.into())]
    );
}

#[test]
fn blenders_come_before_bpys_and_new_before_old() {
    let temporary = tempfile::tempdir().unwrap();
    let root = temporary.path();
    let home = root.join("home/someone");
    let mut places = nowhere(root);
    places.home = Some(home.clone());
    places.cache = Some(home.join(".cache"));
    places.virtual_env = Some(root.join("venv"));
    places.path = Some(root.join("bin").into());

    let old = put_config(&root.join("usr/share/blender/4.2"));
    let debian = put_config(&root.join("usr/share/blender"));
    let new = put_config(&home.join("blender-5.0.1-linux-x64/5.0"));
    let middle = put_config(&root.join("opt/blender/4.10"));
    let cached =
        put_config(&home.join(".cache/sundog/bpy-5.0.1/lib/python3.11/site-packages/bpy/5.0"));
    let cached_old =
        put_config(&home.join(".cache/sundog/bpy-4.5.15/lib/python3.11/site-packages/bpy/4.5"));
    let active = put_config(&root.join("venv/lib/python3.13/site-packages/bpy/4.4"));
    put_config(&root.join("opt/other/4.5"));
    let in_path = put_config(&root.join("somewhere/4.1"));
    fs::write(root.join("somewhere/blender"), "").unwrap();
    fs::create_dir(root.join("bin")).unwrap();
    std::os::unix::fs::symlink(root.join("somewhere/blender"), root.join("bin/blender")).unwrap();

    let found = places.candidates(None);
    let in_path = in_path.canonicalize().unwrap();
    assert_eq!(
        found,
        [
            ConfigOrigin::Blender(in_path),
            ConfigOrigin::Blender(new),
            ConfigOrigin::Blender(middle),
            ConfigOrigin::Blender(old),
            ConfigOrigin::Blender(debian),
            ConfigOrigin::Bpy(active),
            ConfigOrigin::Bpy(cached),
            ConfigOrigin::Bpy(cached_old),
            ConfigOrigin::BuiltIn(BUILT_IN.into()),
        ]
    );
    let package = |version, python| {
        let folder = format!(".cache/sundog/bpy-{version}/lib/python{python}/site-packages/bpy");
        home.join(folder)
    };
    assert_eq!(
        places.blenders(),
        [
            root.join("somewhere").canonicalize().unwrap(),
            home.join("blender-5.0.1-linux-x64"),
            root.join("opt/blender"),
            root.join("usr/share/blender"),
            root.join("venv/lib/python3.13/site-packages/bpy"),
            package("5.0.1", "3.11"),
            package("4.5.15", "3.11"),
        ]
    );
}

#[test]
fn the_origin_says_who_named_it() {
    assert_eq!(
        ConfigOrigin::Environment("a.ocio".into()).to_string(),
        "a.ocio (named by $OCIO)"
    );
    assert!(is_built_in_name(Path::new("ocio://default")));
    assert!(!is_built_in_name(Path::new("ocio/default")));
}
