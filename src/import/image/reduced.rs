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

/// Blender's Simplify: how large images may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextureLimit {
    /// The share of the pixels along each side that is asked for.
    pub resolution: f32,
    /// The most pixels along a side.
    pub size: u32,
}

impl TextureLimit {
    /// By how many halvings an image gets that small.
    pub fn halvings(&self, width: u32, height: u32) -> u32 {
        let mut halvings = 0;
        let is_too_large = |halvings: u32| {
            let share = 0.5_f32.powi(halvings as i32);
            width.max(height) >> halvings > self.size.max(1) || share > self.resolution
        };
        while width.max(height) >> halvings > 1 && is_too_large(halvings) {
            halvings += 1;
        }
        halvings
    }
}

/// The image halved so often, as Cycles does it: each pixel is the mean of a square, and of odd sizes the upper rows and the right columns
/// go. `weighted`: colours count by their opacity.
pub(crate) fn halved(image: Image, halvings: u32, weighted: bool) -> Image {
    if halvings == 0 {
        return image;
    }
    // No side gets shorter than a pixel.
    let square = [image.width, image.height].map(|side| 1 << halvings.min(side.max(1).ilog2()));
    let from = [image.width as usize, image.height as usize];
    let places = (from, square, image.channels.max(1) as usize);
    let pixels = match &image.pixels {
        Pixels::U8(v) => means(v, places, weighted, f32::from, |m| (m + 0.5) as u8).into(),
        Pixels::U16(v) => means(v, places, weighted, f32::from, |m| (m + 0.5) as u16).into(),
        Pixels::F32(v) => means(v, places, weighted, |c| c, |m| m).into(),
    };
    Image {
        width: image.width / square[0],
        height: image.height / square[1],
        pixels,
        ..image
    }
}

fn means<T: Copy>(
    values: &[T],
    (from, square, channels): ([usize; 2], [u32; 2], usize),
    weighted: bool,
    number: impl Fn(T) -> f32,
    stored: impl Fn(f32) -> T,
) -> Vec<T> {
    let [across, up] = square.map(|side| side as usize);
    // Rows are from the top.
    let top = from[1] % up;
    let opacity = (weighted && channels.is_multiple_of(2)).then_some(channels - 1);
    let mut result = Vec::with_capacity(values.len() / (across * up) + channels);
    let mut sums = vec![0.0; channels];
    for y in (top..from[1]).step_by(up) {
        for x in (0..from[0] - from[0] % across).step_by(across) {
            let (mut plain, mut weights) = (vec![0.0; channels], 0.0);
            sums.fill(0.0);
            for row in y..y + up {
                for column in x..x + across {
                    let at = (row * from[0] + column) * channels;
                    let pixel = &values[at..at + channels];
                    let weight = opacity.map_or(1.0, |alpha| number(pixel[alpha]));
                    weights += weight;
                    for (channel, &value) in pixel.iter().enumerate() {
                        sums[channel] += weight * number(value);
                        plain[channel] += number(value);
                    }
                }
            }
            for channel in 0..channels {
                let counts = opacity.is_some_and(|alpha| channel != alpha) && weights > 0.0;
                result.push(stored(if counts {
                    sums[channel] / weights
                } else {
                    plain[channel] / (across * up) as f32
                }));
            }
        }
    }
    result
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
