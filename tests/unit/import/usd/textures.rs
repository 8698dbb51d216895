use super::*;

/// A TIFF of one directory with these tags, each a short number.
fn tiff(tags: &[(u16, u32, u16)]) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((tags.len() as u16).to_le_bytes());
    let after = 8 + 2 + 12 * tags.len() as u32 + 4;
    for (tag, count, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(3u16.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        let inside = if *count > 2 { after } else { u32::from(*value) };
        bytes.extend(inside.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes.extend([8, 0, 8, 0, 8, 0]);
    bytes
}

#[test]
fn eight_bits_of_colour_are_for_displays() {
    assert!(is_display(&tiff(&[(258, 3, 8), (277, 1, 3)])));
    assert!(!is_display(&tiff(&[(258, 1, 8), (277, 1, 1)])));
    assert!(!is_display(&tiff(&[(258, 2, 16), (277, 1, 3)])));
    assert!(is_display(&tiff(&[(258, 1, 8), (262, 1, 3)])));
    assert!(is_display(b"GIF89a"));
    assert!(!is_display(b"II*\0\xff\xff\xff\xff"));
    let mut tga = vec![0u8; 18];
    (tga[2], tga[12], tga[14], tga[16]) = (2, 1, 1, 24);
    assert!(is_display(&tga));
    (tga[2], tga[16]) = (3, 8);
    assert!(!is_display(&tga));
}
