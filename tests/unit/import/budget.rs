use super::*;

#[test]
fn large_pictures_of_one_colour_are_believed_and_larger_ones_are_not() {
    let take = |file, pixels, size| Budget::for_image(file).take(pixels, size);
    // 8K of 16 bytes a pixel in the fewest bytes, and what a small file may claim.
    take(1000, 7680 * 4320, 16).unwrap();
    take(4 << 20, 16_384 * 16_384, 12).unwrap();
    assert!(take(1200, 16_384 * 16_384, 12).is_err());
    assert!(take(33_000, 16_384 * 16_384, 12).is_err());
}
