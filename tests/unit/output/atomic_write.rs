use super::*;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_failing_write_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "old").unwrap();
    let result = atomic_write(&path, |file| {
        file.write_all(b"half").unwrap();
        file.flush().unwrap();
        Err("no more ink")
    });
    assert_eq!(
        result.unwrap_err().to_string(),
        format!("cannot write {}: no more ink", path.display())
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[test]
fn a_complete_write_replaces_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "old").unwrap();
    atomic_write(&path, |file| file.write_all(b"new")).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (
        folder.path().join("real.exr"),
        folder.path().join("link.exr"),
    );
    std::fs::write(&real, "old").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    atomic_write(&link, |file| file.write_all(b"new")).unwrap();
    assert_eq!(std::fs::read_to_string(&real).unwrap(), "new");
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(
        check_writable(Path::new("/dev/null"))
            .unwrap_err()
            .to_string()
            .contains("not a regular file")
    );
}

#[test]
fn names_of_one_place_are_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a"), "").unwrap();
    std::fs::create_dir(path("b")).unwrap();
    std::fs::hard_link(path("a"), path("hard")).unwrap();
    std::os::unix::fs::symlink("a", path("soft")).unwrap();
    std::os::unix::fs::symlink("b", path("folder")).unwrap();
    for other in ["./a", "b/../a", "soft", "folder/../a"] {
        assert!(same_place(&path("a"), &path(other)), "{other}");
        assert!(same_file(&path("a"), &path(other)), "{other}");
    }
    // A hard link is a place of its own: writing there leaves the other name's file as it is.
    assert!(!same_place(&path("a"), &path("hard")));
    assert!(same_file(&path("a"), &path("hard")));
    assert!(same_place(&path("new"), &path("b/../new")));
    assert!(same_place(&path("b/new"), &path("folder/new")));
    assert!(!same_file(&path("new"), &path("new")) && !same_place(&path("new"), &path("a")));
}

#[test]
fn a_name_that_is_too_long_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let long = folder.path().join("a".repeat(300));
    let refused = check_writable(&long).unwrap_err().to_string();
    assert!(
        refused.ends_with("the name is too long; give a shorter one"),
        "{refused}"
    );
    check_writable(&folder.path().join("a".repeat(255))).unwrap();
    assert!(names(folder.path()).is_empty());
}

#[test]
fn checking_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    check_writable(&folder.path().join("a.exr")).unwrap();
    assert!(names(folder.path()).is_empty());
    let missing = check_writable(&folder.path().join("no/a.exr"))
        .unwrap_err()
        .to_string();
    assert!(missing.ends_with("create it first"), "{missing}");
    assert!(
        check_writable(folder.path())
            .unwrap_err()
            .to_string()
            .contains("it is a folder")
    );
}
