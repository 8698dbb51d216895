use super::*;

fn unpacked(packed: &[u8], size: usize) -> Result<Vec<u8>, &'static str> {
    let mut into = vec![0; size];
    unpack(packed, &mut into, &mut Vec::new()).map(|()| into)
}

fn header(flags: u8, width: u8, bytes: u32, block: u32) -> Vec<u8> {
    let mut packed = vec![2, 1, flags, width];
    for number in [bytes, block, 0] {
        packed.extend(number.to_le_bytes());
    }
    packed
}

#[test]
fn plain_blocks_are_copied() {
    let mut packed = header(2, 4, 5, 5);
    packed.extend(b"abcde");
    assert_eq!(unpacked(&packed, 5).expect("a plain block"), b"abcde");
    assert!(unpacked(&packed, 6).is_err());
    assert!(unpacked(&packed[..19], 5).is_err());
}

#[test]
fn shuffled_numbers_are_put_together() {
    // One piece that packing did not shorten: the first bytes of all numbers, then the second ones.
    let mut packed = header(1 | 1 << 5, 2, 5, 5);
    packed.extend(20u32.to_le_bytes());
    packed.extend(5u32.to_le_bytes());
    packed.extend(b"acbde");
    assert_eq!(unpacked(&packed, 5).expect("a shuffled block"), b"abcde");
}

#[test]
fn a_block_without_size_is_no_endless_loop() {
    assert!(unpacked(&header(1, 4, 8, 0), 8).is_err());
}
