use super::*;

/// A root with these files.
fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    root
}

const MOUNTS: &str = "22 1 8:1 / / rw - ext4 /dev/sda rw\n\
        30 22 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw\n";

#[test]
fn the_group_that_leaves_least_decides() {
    let stat = "anon 5\nfile 900\ninactive_file 300\nactive_file 100\n";
    let root = root(&[
        ("proc/self/cgroup", "0::/user/shell\n"),
        ("proc/self/mountinfo", MOUNTS),
        ("sys/fs/cgroup/user/shell/memory.max", "max\n"),
        ("sys/fs/cgroup/user/shell/memory.current", "700\n"),
        ("sys/fs/cgroup/user/shell/memory.stat", stat),
        ("sys/fs/cgroup/user/memory.max", "1000\n"),
        ("sys/fs/cgroup/user/memory.current", "800\n"),
        ("sys/fs/cgroup/user/memory.stat", stat),
    ]);
    // 800 of 1000 are taken, 400 of them by files.
    assert_eq!(group(root.path()), Some(600));
}

#[test]
fn a_group_without_a_limit_leaves_everything() {
    let root = root(&[
        ("proc/self/cgroup", "0::/\n"),
        ("proc/self/mountinfo", MOUNTS),
    ]);
    assert_eq!(group(root.path()), None);
    assert_eq!(group(Path::new("/no/such/root")), None);
}

#[test]
fn version_1_and_a_container_that_sees_the_path_of_its_host() {
    let mounts = "40 30 0:30 /docker/abc /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n";
    let files = [
        ("sys/fs/cgroup/memory/memory.limit_in_bytes", "5000\n"),
        ("sys/fs/cgroup/memory/memory.usage_in_bytes", "4000\n"),
        (
            "sys/fs/cgroup/memory/memory.stat",
            "total_inactive_file 500\ntotal_active_file 0\n",
        ),
        ("proc/self/mountinfo", mounts),
    ];
    for path in ["/docker/abc", "/elsewhere"] {
        let groups = format!("5:cpu,cpuacct:/docker/abc\n4:memory:{path}\n0::/docker/abc\n");
        let root = root(&[&files[..], &[("proc/self/cgroup", groups.as_str())]].concat());
        assert_eq!(group(root.path()), Some(1500), "{path}");
    }
}

#[test]
fn what_is_more_than_any_machine_has_is_refused() {
    let refused = check(u64::MAX, "a picture", "choose a smaller one").unwrap_err();
    assert!(
        refused
            .0
            .starts_with("a picture needs about 16777216.0 TiB, and "),
        "{}",
        refused.0
    );
    check(1, "a picture", "").unwrap();
}
