//! Gives a denoised picture its brightness back.
//!
//! Two things are restored, both by factors on the light of the denoised picture, which change no contrast between neighbours:
//! 1. The luminance of each block, as far as it is certainly off: of the difference d between the noisy and the denoised mean,
//!    the share 1 − v / d² (not below 0) is given back, v being the variance of the noisy mean (the share of d² that is no
//!    noise). Between the middles of the blocks the factors are interpolated, so that blocks leave no edges; they stay within
//!    ½ to 2.
//! 2. The mean of each channel over the whole picture, exactly but for rounding: the noisy mean is right but for its noise, which
//!    is far smaller than that of any pixel.

use super::shift::{BLOCK, Block, Pair};

/// Least and greatest factor of a block.
const FACTORS: (f64, f64) = (0.5, 2.0);

/// Restores the brightness of a denoised picture.
pub fn give_back(pair: &Pair, denoised: &mut [f32]) {
    let factors: Vec<f64> = pair.blocks(denoised).iter().map(factor).collect();
    let (across, down) = pair.blocks_across();
    let width = pair.size.0 as usize;
    for (index, pixel) in denoised.chunks_exact_mut(4).enumerate() {
        let (x0, x1, u) = between(index % width, across);
        let (y0, y1, v) = between(index / width, down);
        let row = |y: usize| factors[y * across + x0] * (1.0 - u) + factors[y * across + x1] * u;
        let factor = row(y0) * (1.0 - v) + row(y1) * v;
        for value in &mut pixel[..3] {
            *value = (f64::from(*value) * factor) as f32;
        }
    }
    give_back_means(pair.noisy, denoised, 4);
}

/// Restores the mean of each of the first three of so many channels.
pub fn give_back_means(noisy: &[f32], denoised: &mut [f32], channels: usize) {
    for channel in 0..channels.min(3) {
        let mean = |data: &[f32]| -> f64 {
            data.iter()
                .skip(channel)
                .step_by(channels)
                .map(|&v| f64::from(v))
                .sum()
        };
        let (wanted, is) = (mean(noisy), mean(denoised));
        if wanted > 0.0 && is > 0.0 {
            for value in denoised.iter_mut().skip(channel).step_by(channels) {
                *value = (f64::from(*value) * (wanted / is)) as f32;
            }
        }
    }
}

/// What the light of a block is multiplied by.
fn factor(block: &Block) -> f64 {
    let difference = block.noisy - block.denoised;
    if difference == 0.0 || block.denoised <= 0.0 {
        return 1.0;
    }
    let certain = (1.0 - block.variance / (difference * difference)).max(0.0);
    let factor = 1.0 + certain * difference / block.denoised;
    factor.clamp(FACTORS.0, FACTORS.1)
}

/// The blocks on both sides of a pixel, and how far it is from the first one's middle to the other's.
fn between(pixel: usize, blocks: usize) -> (usize, usize, f64) {
    let place = (pixel as f64 + 0.5) / f64::from(BLOCK) - 0.5;
    let place = place.clamp(0.0, blocks as f64 - 1.0);
    let first = place.floor();
    let first_index = first as usize;
    (
        first_index,
        (first_index + 1).min(blocks - 1),
        place - first,
    )
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/energy.rs"]
mod tests;
