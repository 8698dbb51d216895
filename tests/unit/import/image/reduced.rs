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

fn row(channels: u32, pixels: Pixels, width: u32) -> Image {
    Image {
        name: String::new(),
        width,
        height: 1,
        channels,
        pixels,
    }
}

/// As Cycles 5.2 shows images under Simplify's texture limit: measured texel by texel.
#[test]
fn halves_are_cycles() {
    let of = |resolution: f32, size: u32| TextureLimit { resolution, size };
    for (limit, (width, height), expected) in [
        (of(1.0, 128), (256, 64), (128, 32)),
        (of(1.0, 128), (300, 200), (75, 50)),
        (of(0.5, 128), (256, 256), (128, 128)),
        (of(0.3, 128), (256, 256), (64, 64)),
        (of(0.9, u32::MAX), (200, 100), (100, 50)),
        (of(0.26, u32::MAX), (200, 100), (50, 25)),
        (of(0.4, u32::MAX), (301, 201), (75, 50)),
        (of(0.01, u32::MAX), (300, 10), (2, 1)),
        (of(1.0, u32::MAX), (300, 10), (300, 10)),
        (of(0.0, 0), (5, 3), (1, 1)),
    ] {
        let halvings = limit.halvings(width, height);
        let side = |side: u32| (side >> halvings).max(1);
        assert_eq!((side(width), side(height)), expected, "{limit:?}");
    }
    // Half a byte is rounded up, and an odd one goes.
    let found = halved(row(1, vec![1u8, 2, 9].into(), 3), 1, false);
    assert!(matches!(&found.pixels, Pixels::U8(p) if ***p == [2]));
    let column = Image {
        width: 1,
        height: 3,
        ..row(1, vec![9u8, 1, 2].into(), 3)
    };
    let found = halved(column, 1, false);
    assert!(matches!(&found.pixels, Pixels::U8(p) if ***p == [2]));
    // Rounded once.
    let found = halved(row(1, vec![0u8, 1, 0, 0].into(), 4), 2, false);
    assert!(matches!(&found.pixels, Pixels::U8(p) if ***p == [0]));
    let square = Image {
        height: 2,
        ..row(1, vec![1.0f32, 2.0, 3.0, 4.0].into(), 2)
    };
    let found = halved(square, 1, false);
    assert!(matches!(&found.pixels, Pixels::F32(p) if ***p == [2.5]));
}

#[test]
fn colours_of_halves_count_by_their_opacity() {
    let image = || row(2, vec![1.0f32, 0.0, 3.0, 0.5].into(), 2);
    let found = halved(image(), 1, true);
    assert!(matches!(&found.pixels, Pixels::F32(p) if ***p == [3.0, 0.25]));
    let found = halved(image(), 1, false);
    assert!(matches!(&found.pixels, Pixels::F32(p) if ***p == [2.0, 0.25]));
}
