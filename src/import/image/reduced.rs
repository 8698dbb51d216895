//! Images of fewer pixels, where all of them together would take more memory than they may.

use crate::scene::{Image, Pixels};

/// By how many halvings each image gets smaller, so that all take no more than `most` bytes: the largest first. Of each its
/// width, its height and its bytes a pixel. What is left of an image is at least a pixel.
pub(crate) fn halvings(sizes: &[(u64, u64, u64)], most: u64) -> Vec<u32> {
    let bytes = |&(width, height, pixel): &(u64, u64, u64), halvings: u32| {
        (width >> halvings).max(1) * (height >> halvings).max(1) * pixel
    };
    let mut levels = vec![0u32; sizes.len()];
    let mut taken: Vec<u64> = sizes.iter().map(|size| bytes(size, 0)).collect();
    let mut total: u64 = taken.iter().sum();
    while total > most {
        let largest = (0..sizes.len()).max_by_key(|&i| taken[i]);
        let Some(i) = largest.filter(|&i| taken[i] > sizes[i].2) else {
            break;
        };
        levels[i] += 1;
        total -= taken[i];
        taken[i] = bytes(&sizes[i], levels[i]);
        total += taken[i];
    }
    levels
}

/// Which images go out of memory, so that the others take no more than `most` bytes: the largest first. The sizes as above.
pub(crate) fn to_files(sizes: &[(u64, u64, u64)], most: u64) -> Vec<bool> {
    let bytes: Vec<u64> = sizes.iter().map(|&(w, h, pixel)| w * h * pixel).collect();
    let mut left: u64 = bytes.iter().sum();
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    // Of those that are as large the first.
    order.sort_by_key(|&i| std::cmp::Reverse(bytes[i]));
    let mut gone = vec![false; sizes.len()];
    for i in order.into_iter().take_while(|&i| bytes[i] > 0) {
        if left <= most {
            break;
        }
        left -= bytes[i];
        gone[i] = true;
    }
    gone
}

/// The image with each pixel the mean of those that lie there: numbers as they are stored, as Cycles' textures limit has it.
pub(crate) fn reduced(image: Image, halvings: u32) -> Image {
    if halvings == 0 {
        return image;
    }
    let from = (image.width as usize, image.height as usize);
    let to = ((from.0 >> halvings).max(1), (from.1 >> halvings).max(1));
    let channels = image.channels.max(1) as usize;
    let places = (from, to, channels);
    let pixels = match &image.pixels {
        Pixels::U8(v) => mean(v, places, f32::from, |m| (m + 0.5) as u8).into(),
        Pixels::U16(v) => mean(v, places, f32::from, |m| (m + 0.5) as u16).into(),
        Pixels::F32(v) => mean(v, places, |c| c, |m| m).into(),
    };
    Image {
        width: to.0 as u32,
        height: to.1 as u32,
        pixels,
        ..image
    }
}

fn mean<T: Copy>(
    values: &[T],
    (from, to, channels): ((usize, usize), (usize, usize), usize),
    number: impl Fn(T) -> f32,
    stored: impl Fn(f32) -> T,
) -> Vec<T> {
    // Where a size is no multiple, the spans differ by one.
    let span = |i: usize, from: usize, to: usize| (i * from / to, (i + 1) * from / to);
    let mut result = Vec::with_capacity(to.0 * to.1 * channels);
    for y in 0..to.1 {
        let (y0, y1) = span(y, from.1, to.1);
        for x in 0..to.0 {
            let (x0, x1) = span(x, from.0, to.0);
            let count = ((x1 - x0) * (y1 - y0)) as f32;
            for channel in 0..channels {
                let mut sum = 0.0;
                for row in y0..y1 {
                    for column in x0..x1 {
                        sum += number(values[(row * from.0 + column) * channels + channel]);
                    }
                }
                result.push(stored(sum / count));
            }
        }
    }
    result
}

#[cfg(test)]
#[path = "../../../tests/unit/import/image/reduced.rs"]
mod tests;
