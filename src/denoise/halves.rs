//! How far a denoised picture is from the truth, told by the two halves of its samples.
//!
//! Both halves are denoised, each by itself. With a and b the noisy halves, which are independent and unbiased, and A and B what
//! the denoiser makes of them, the squared error of A has the expectation of (A − b)² without the variance of b, for A knows
//! nothing of b; a wrong guess counts as noise does. With (a − b)² / 2 for that variance, and the same the other way round, a
//! pixel tells (A² + B²) / 2 − A b − B a + a b: so noisy, and of either sign, that it is good for means over many pixels alone.
//! (Dual buffers: Rousselle, Knaus and Zwicker, *Adaptive Rendering with Non-Local Means Filtering*, 2012, §5.)

use super::shift::BLOCK;
use crate::film::Picture;
use crate::math::float::REL_MSE_OFFSET;
use serde::Serialize;

/// What both halves say of each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HalvesError {
    /// relMSE of a denoised half, its wrong guesses counted; below 0 where noise makes it so.
    pub half: f64,
    /// Standard deviation of it, by how blocks of the picture differ.
    pub deviation: f64,
    /// Half of the relMSE between the denoised halves: the error of one of them without what both guess wrong.
    pub noise: f64,
    /// FLIP between the denoised halves as they are shown.
    pub flip: Option<f64>,
    /// Mean samples a pixel.
    pub samples: f64,
}

/// Compares the noisy halves with the denoised ones; pictures whose first layer is RGBA. `None` of an empty picture.
pub fn compare(noisy: [&Picture; 2], denoised: [&Picture; 2]) -> Option<HalvesError> {
    let (width, height) = (noisy[0].width as usize, noisy[0].height as usize);
    let block = BLOCK as usize;
    let across = width.div_ceil(block);
    let mut blocks = vec![[0.0; 3]; across * height.div_ceil(block)];
    let layers = [noisy[0], noisy[1], denoised[0], denoised[1]].map(Picture::colors);
    let [a, b, c, d] = layers;
    for (index, (((a, b), c), d)) in a.zip(b).zip(c).zip(d).enumerate() {
        let place = index / width / block * across + index % width / block;
        let sums = &mut blocks[place];
        for channel in 0..3 {
            let of = |pixel: [f32; 4]| f64::from(pixel[channel]);
            let (a, b, c, d) = (of(a), of(b), of(c), of(d));
            let mean = (c + d) / 2.0;
            let scale = 1.0 / (3.0 * (mean * mean + REL_MSE_OFFSET));
            sums[0] += scale * ((c * c + d * d) / 2.0 - c * b - d * a + a * b);
            sums[1] += scale * (c - d) * (c - d) / 2.0;
        }
        sums[2] += 1.0;
    }
    let pixels: f64 = blocks.iter().map(|block| block[2]).sum();
    if pixels == 0.0 {
        return None;
    }
    let mean = |i: usize| blocks.iter().map(|block| block[i]).sum::<f64>() / pixels;
    let half = mean(0);
    // Of sums over blocks that count as much as they have pixels.
    let count = blocks.len() as f64;
    let spread = blocks
        .iter()
        .map(|block| (block[0] - half * block[2]).powi(2))
        .sum::<f64>();
    let deviation = (spread * count / (count - 1.0).max(1.0)).sqrt() / pixels;
    Some(HalvesError {
        half,
        deviation,
        noise: mean(1),
        flip: None,
        samples: 0.0,
    })
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/halves.rs"]
mod tests;
