use super::*;

/// Bytes of a mapping that are the process's own (`proc_pid_smaps(5)`, Rss).
fn resident(start: usize) -> u64 {
    let told = std::fs::read_to_string("/proc/self/smaps").unwrap();
    let begins = format!("{start:08x}-");
    let mut lines = told.lines().skip_while(|line| !line.starts_with(&begins));
    let rss = lines.find_map(|line| line.strip_prefix("Rss:")).unwrap();
    let kib: u64 = rss.trim().trim_end_matches(" kB").parse().unwrap();
    kib << 10
}

#[test]
fn what_is_mapped_is_taken_off_and_comes_back() {
    const BYTES: usize = 64 << 20;
    const PAGE: usize = 4096;
    let scratch = Scratch::new(BYTES).unwrap();
    let start = scratch.start().addr().get();
    // SAFETY: the bytes of a mapping that nobody else has.
    let bytes = unsafe { std::slice::from_raw_parts_mut(scratch.start().as_ptr(), BYTES) };
    for (number, page) in bytes.chunks_mut(PAGE).enumerate() {
        page[7] = number as u8;
    }
    keep_mapped_below(0);
    // As long as it takes, which is some milliseconds; another test's pages may be taken off meanwhile, to no harm.
    while resident(start) > BYTES as u64 / 8 {
        std::thread::sleep(LOOK);
    }
    keep_mapped_below(u64::MAX);
    for (number, page) in bytes.chunks(PAGE).enumerate() {
        assert_eq!((page[6], page[7], page[8]), (0, number as u8, 0));
    }
    drop(scratch);
    assert!(!mapped().maps.iter().any(|map| map.as_ptr().addr() == start));
}

#[test]
fn a_file_beyond_all_disks_is_refused() {
    assert!(Scratch::new(1 << 50).is_err());
}
