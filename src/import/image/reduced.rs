//! Images of fewer pixels: where all of them together would take more memory than they may, or where Blender's Simplify limits them.

use crate::scene::{Image, Pixels};
use std::ops::Range;

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
    // Where a size is no multiple, the spans differ by one.
    let spans = [image.width, image.height].map(|from| {
        let (from, to) = (from as usize, (from as usize >> halvings).max(1));
        let span = move |i| i * from / to..(i + 1) * from / to;
        (0..to).map(span).collect()
    });
    with_means(image, spans, false)
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
    // No side gets shorter than a pixel. Rows are from the top.
    let spans = [(image.width, false), (image.height, true)].map(|(from, from_its_end)| {
        let side = 1usize << halvings.min(from.max(1).ilog2());
        let from = from as usize;
        let first = if from_its_end { from % side } else { 0 };
        (0..from / side)
            .map(|i| first + i * side..first + (i + 1) * side)
            .collect()
    });
    with_means(image, spans, weighted)
}

/// Columns or rows that make one.
type Spans = Vec<Range<usize>>;

/// The image with each pixel the mean of those in some columns and rows.
fn with_means(image: Image, spans: [Spans; 2], weighted: bool) -> Image {
    let places = (image.width as usize, image.channels.max(1) as usize);
    let pixels = match &image.pixels {
        Pixels::U8(v) => means(v, places, &spans, weighted, f32::from, |m| (m + 0.5) as u8).into(),
        Pixels::U16(v) => {
            means(v, places, &spans, weighted, f32::from, |m| (m + 0.5) as u16).into()
        }
        Pixels::F32(v) => means(v, places, &spans, weighted, |c| c, |m| m).into(),
    };
    Image {
        width: spans[0].len() as u32,
        height: spans[1].len() as u32,
        pixels,
        ..image
    }
}

fn means<T: Copy>(
    values: &[T],
    (width, channels): (usize, usize),
    [columns, rows]: &[Spans; 2],
    weighted: bool,
    number: impl Fn(T) -> f32,
    stored: impl Fn(f32) -> T,
) -> Vec<T> {
    let opacity = (weighted && channels.is_multiple_of(2)).then_some(channels - 1);
    let mut result = Vec::with_capacity(columns.len() * rows.len() * channels);
    for rows in rows {
        for columns in columns {
            let pixels = || {
                let at = rows
                    .clone()
                    .flat_map(|row| columns.clone().map(move |column| row * width + column));
                at.map(|at| &values[at * channels..(at + 1) * channels])
            };
            let count = (rows.len() * columns.len()) as f32;
            let weights: f32 = opacity.map_or(0.0, |alpha| {
                pixels().map(|pixel| number(pixel[alpha])).sum()
            });
            for channel in 0..channels {
                let by_opacity = opacity.filter(|&alpha| channel != alpha && weights > 0.0);
                result.push(stored(match by_opacity {
                    Some(alpha) => {
                        let weighted = |pixel: &[T]| number(pixel[alpha]) * number(pixel[channel]);
                        pixels().map(weighted).sum::<f32>() / weights
                    }
                    None => pixels().map(|pixel| number(pixel[channel])).sum::<f32>() / count,
                }));
            }
        }
    }
    result
}

#[cfg(test)]
#[path = "../../../tests/unit/import/image/reduced.rs"]
mod tests;
