use super::*;

/// A file with one section that claims so many things.
fn file(name: &[u8], claimed: u64, size: u64) -> Vec<u8> {
    let mut bytes = b"PXR-USDC\0\x08\0\0\0\0\0\0".to_vec();
    let contents = 88 + size;
    bytes.extend(contents.to_le_bytes());
    bytes.resize(88, 0);
    bytes.extend(claimed.to_le_bytes());
    bytes.resize(contents as usize, 0);
    bytes.extend(1u64.to_le_bytes());
    let mut label = name.to_vec();
    label.resize(16, 0);
    bytes.extend(label);
    bytes.extend(88u64.to_le_bytes());
    bytes.extend(size.to_le_bytes());
    bytes
}

#[test]
fn what_can_be_in_it_is_read() {
    assert_eq!(fault(&file(b"STRINGS", 2, 64)), None);
    assert_eq!(fault(&file(b"TOKENS", 2, 64)), None);
}

#[test]
fn what_cannot_be_in_it_is_a_fault() {
    for name in [
        b"STRINGS".as_slice(),
        b"TOKENS",
        b"PATHS",
        b"SPECS",
        b"FIELDSETS",
    ] {
        assert!(fault(&file(name, 1 << 40, 64)).is_some());
    }
}

#[test]
fn every_cut_is_a_fault() {
    let whole = file(b"STRINGS", 2, 64);
    for end in 0..whole.len() {
        assert!(fault(&whole[..end]).is_some(), "{end}");
    }
}

#[test]
fn old_files_are_told_apart() {
    let mut old = file(b"STRINGS", 2, 64);
    old[9] = 3;
    assert!(fault(&old).unwrap().contains("USD 0.8"));
}
