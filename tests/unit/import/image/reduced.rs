use super::*;

#[test]
fn the_largest_give_way_first() {
    let sizes = [(1024, 1024, 4), (256, 256, 4), (16, 16, 4)];
    assert_eq!(halvings(&sizes, u64::MAX), [0, 0, 0]);
    // 4 MiB, 256 KiB and 1 KiB.
    assert_eq!(halvings(&sizes, 2 << 20), [1, 0, 0]);
    assert_eq!(halvings(&sizes, 600 << 10), [2, 0, 0]);
    assert_eq!(halvings(&sizes, 300 << 10), [3, 1, 0]);
    // No image gets smaller than a pixel.
    let all = halvings(&sizes, 0);
    assert_eq!(all, [10, 8, 4]);
    assert_eq!(halvings(&[], 0), Vec::<u32>::new());
}

#[test]
fn a_pixel_is_the_mean_of_those_that_it_was() {
    let image = |width: u32, height: u32, pixels: Pixels| Image {
        name: String::new(),
        width,
        height,
        channels: 1,
        pixels,
    };
    let found = reduced(
        image(4, 2, vec![0u8, 2, 100, 100, 4, 6, 100, 101].into()),
        1,
    );
    assert_eq!((found.width, found.height), (2, 1));
    assert!(matches!(&found.pixels, Pixels::U8(p) if ***p == [3, 100]));
    // Five are two and three.
    let found = reduced(image(5, 1, vec![1.0f32, 3.0, 5.0, 6.0, 7.0].into()), 1);
    assert!(matches!(&found.pixels, Pixels::F32(p) if ***p == [2.0, 6.0]));
    let found = reduced(image(3, 3, vec![9u16; 9].into()), 5);
    assert_eq!((found.width, found.height), (1, 1));
    assert!(matches!(&found.pixels, Pixels::U16(p) if ***p == [9]));
}

#[test]
fn the_largest_go_out_of_memory_until_the_others_fit() {
    let sizes = [
        (10, 10, 1),
        (100, 100, 1),
        (10, 10, 3),
        (0, 0, 0),
        (100, 50, 2),
    ];
    assert_eq!(to_files(&sizes, u64::MAX), [false; 5]);
    assert_eq!(to_files(&sizes, 10_400), [false, true, false, false, false]);
    assert_eq!(to_files(&sizes, 10_399), [false, true, false, false, true]);
    assert_eq!(to_files(&sizes, 0), [true, true, true, false, true]);
}
