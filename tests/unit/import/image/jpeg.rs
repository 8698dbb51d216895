use super::*;
use crate::scene::Pixels;

fn read(file: &[u8]) -> Result<Image, ImageFailure> {
    decode(file, "a", Place::Memory)
}

/// A baseline JPEG of 32 × 32 pixels with half the rows and columns of colour: blocks of one value each, so that what
/// they become is known. The components together in one scan, or in one scan each.
pub(crate) fn blocks(apart: bool) -> Vec<u8> {
    let mut file = vec![0xff, 0xd8];
    let mut segment = |marker: u8, body: &[u8]| {
        file.extend([0xff, marker]);
        file.extend((body.len() as u16 + 2).to_be_bytes());
        file.extend(body);
    };
    // Quantisation by 8 throughout: a DC difference of one is one level.
    segment(0xdb, &[&[0u8][..], &[8; 64]].concat());
    segment(
        0xc0,
        &[8, 0, 32, 0, 32, 3, 1, 0x22, 0, 2, 0x11, 0, 3, 0x11, 0],
    );
    // DC: categories 0 to 11, by four bits each. AC: the end of the block, by one bit.
    let mut lengths = [0u8; 16];
    lengths[3] = 12;
    let categories: Vec<u8> = (0..12).collect();
    segment(0xc4, &[&[0x00][..], &lengths, &categories].concat());
    let mut lengths = [0u8; 16];
    lengths[0] = 1;
    segment(0xc4, &[&[0x10][..], &lengths, &[0]].concat());

    // Levels of luminance by 8 × 8 pixels; of colour by 16 × 16 pixels.
    let luminance = |x: usize, y: usize| (8 * (x + 4 * y)) as i32 - 60;
    let colors = [-30, 40];
    let mut scan = |components: &[u8], order: &[(usize, i32)]| {
        let mut bits = Vec::new();
        let mut before = [0i32; 3];
        for &(component, value) in order {
            let difference = value - before[component];
            before[component] = value;
            let category = 32 - difference.unsigned_abs().leading_zeros();
            let code = if difference < 0 {
                difference + (1 << category) - 1
            } else {
                difference
            };
            bits.extend((0..4).rev().map(|b| category >> b & 1));
            bits.extend((0..category).rev().map(|b| code as u32 >> b & 1));
            bits.push(0);
        }
        let mut header = vec![components.len() as u8];
        components.iter().for_each(|&c| header.extend([c, 0]));
        header.extend([0, 63, 0]);
        file.extend([0xff, 0xda]);
        file.extend((header.len() as u16 + 2).to_be_bytes());
        file.extend(header);
        for byte in bits.chunks(8) {
            let byte = (0..8).fold(0u8, |all, i| {
                all << 1 | byte.get(i).copied().unwrap_or(1) as u8
            });
            file.push(byte);
            if byte == 0xff {
                file.push(0);
            }
        }
    };
    if apart {
        let all: Vec<_> = (0..16).map(|i| (0, luminance(i % 4, i / 4))).collect();
        scan(&[1], &all);
        scan(&[2], &[(1, colors[0]); 4]);
        scan(&[3], &[(2, colors[1]); 4]);
    } else {
        let mut order = Vec::new();
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                order.push((0, luminance(2 * x + dx, 2 * y + dy)));
            }
            order.extend([(1, colors[0]), (2, colors[1])]);
        }
        scan(&[1, 2, 3], &order);
    }
    file.extend([0xff, 0xd9]);
    file
}

fn values(image: &Image) -> &[u8] {
    match &image.pixels {
        Pixels::U8(values) => values,
        _ => panic!("not 8 bit"),
    }
}

#[test]
fn components_in_scans_of_their_own_are_the_same_picture() {
    let (together, apart) = (read(&blocks(false)), read(&blocks(true)));
    let (together, apart) = (together.unwrap(), apart.unwrap());
    assert_eq!((apart.width, apart.height, apart.channels), (32, 32, 3));
    for (i, (a, b)) in values(&together).iter().zip(values(&apart)).enumerate() {
        // Y = 128 + level, Cb = 98, Cr = 168: JFIF's matrix.
        let (x, y) = (i / 3 % 32 / 8, i / 96 / 8);
        let level = 68.0 + 8.0 * (x + 4 * y) as f32;
        let exact = level
            + [
                1.402 * 40.0,
                0.344_136 * 30.0 - 0.714_136 * 40.0,
                -1.772 * 30.0,
            ][i % 3];
        let exact = exact.clamp(0.0, 255.0);
        assert!(
            (f32::from(*a) - exact).abs() <= 2.0,
            "together, {i}: {a} {exact}"
        );
        assert!(
            (f32::from(*b) - exact).abs() <= 2.0,
            "apart, {i}: {b} {exact}"
        );
    }
}

#[test]
fn what_is_cut_off_is_refused() {
    for apart in [false, true] {
        let file = blocks(apart);
        assert!(read(&file).is_ok());
        for length in 4..file.len() {
            assert!(read(&file[..length]).is_err(), "{length}");
        }
    }
}
