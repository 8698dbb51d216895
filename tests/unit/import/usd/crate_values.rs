use super::*;

const VERSION: &[u8] = &[0, 8, 0];

/// What stands at byte 8 of a file, and whether a value of a kind there fits.
fn fits(kind: u64, flags: u64, rest: &[u64]) -> bool {
    let mut bytes = vec![0; 8];
    bytes.extend(rest.iter().flat_map(|word| word.to_le_bytes()));
    bytes.resize(256, 0);
    Values::new(&bytes, VERSION).fits(flags << 61 | kind << 48 | 8)
}

const LIST: u64 = 0b100;
const PACKED_LIST: u64 = 0b101;

#[test]
fn lists_are_as_long_as_there_is_room() {
    // Three numbers of 3 floats each; then as many as nowhere.
    assert!(fits(24, LIST, &[3]));
    assert!(!fits(24, LIST, &[1 << 40]));
    // Packed integers: how many, bytes of the block.
    assert!(fits(3, PACKED_LIST, &[1000, 40]));
    assert!(!fits(3, PACKED_LIST, &[1 << 40, 40]));
    assert!(!fits(3, PACKED_LIST, &[1000, 1 << 40]));
    // Packed floats as integers, and by a table.
    assert!(!fits(8, PACKED_LIST, &[1000, 0xffff_ffff_ffff_ff69]));
    assert!(!fits(8, PACKED_LIST, &[1000, 0x0000_ffff_ffff_ff74]));
}

#[test]
fn values_in_a_circle_end() {
    // A dictionary of one thing: its name, and a jump to a word that refers to the dictionary itself.
    let name_and_jump = (8u64 << 32) | 5;
    let itself = (31u64 << 48) | 8;
    // The jump stands 4 bytes in, and counts from itself.
    let mut bytes = vec![0; 8];
    bytes.extend(1u64.to_le_bytes());
    bytes.extend(name_and_jump.to_le_bytes());
    bytes.extend(0u32.to_le_bytes());
    bytes.extend(itself.to_le_bytes());
    bytes.resize(256, 0);
    assert!(!Values::new(&bytes, VERSION).fits(itself));
    let samples = (46u64 << 48) | 8;
    // Times that are the samples themselves.
    assert!(!fits(46, 0, &[8, samples, 8, 1, samples]));
}

#[test]
fn operations_are_looked_at_one_by_one() {
    // Two lists of integers, the second longer than the file.
    let mut bytes = vec![0; 8];
    bytes.push(0b110);
    bytes.extend(1u64.to_le_bytes());
    bytes.extend(7u32.to_le_bytes());
    bytes.extend((1u64 << 40).to_le_bytes());
    bytes.resize(256, 0);
    assert!(!Values::new(&bytes, VERSION).fits((36 << 48) | 8));
    bytes[8] = 0b10;
    assert!(Values::new(&bytes, VERSION).fits((36 << 48) | 8));
}

#[test]
fn what_ends_early_is_for_the_parser() {
    assert!(Values::new(&[0; 20], VERSION).fits((31 << 48) | 16));
    assert!(Values::new(&[], VERSION).fits(u64::MAX));
}
