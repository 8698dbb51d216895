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

#[test]
fn what_is_too_much_is_told_with_what_was_taken_before() {
    let budget = Budget::for_geometry(0, 0);
    budget.take(60 << 20, 1).unwrap();
    let told = budget.take(10 << 20, 1).unwrap_err();
    assert!(
        told.contains("10 MiB of memory beside the 60 MiB") && told.contains("at most 64 MiB"),
        "{told}"
    );
}
