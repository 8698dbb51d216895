//! What denoising did to the brightness of a picture, as a whole and block by block.
//!
//! The mean of the noisy picture is right but for noise, of which the film knows the variance v of each pixel. So D − N, the mean
//! of the denoised picture without that of the noisy one, is the shift, and N's own deviation √(Σ v) / n says how far
//! the shift may be off: D − truth is D − N + (N − truth), however D follows N. The intervals are of 95 % in this sense.
//! Each v has one degree of freedom, and so v² the expectation 3 σ⁴. Where a few bright pixels make most of Σ v, it is less certain:
//! with (Σ v)² / Σ (v² / 3) − 2 degrees of freedom (Satterthwaite, *An Approximate Distribution of Estimates of Variance Components*,
//! 1946, whose (Σ σ²)² / Σ σ⁴ this has as ratio of expectations). The interval is that of Student's t.
//!
//! Where the noise of a block is large, so is its interval, and a shift inside of it says nothing.
//!
//! The noise of a block is told by the pixels of the 3 × 3 blocks about it. By its own alone it would follow the block's mean: blocks
//! that have missed rare light are darker and look less noisy than they are, and of them intervals would miss the truth too often.
//!
//! The largest shift is chosen among all blocks, and chance favours those where noise is large. Its interval is that within which all of n
//! blocks lie together in 95 of 100 pictures, each with the chance 0.95^(1/n) (Šidák, *Rectangular Confidence Regions for the Means
//! of Multivariate Normal Distributions*, 1967). There the noise is the larger of what the block's own pixels tell and those about it:
//! the chosen one may have noise that its neighbours have not.

use crate::math::LUMINANCE;
use crate::math::float::{TWO_SIDED_95, student_95, two_sided};
use serde::Serialize;

/// Edge of a block in pixels. Noise of 50 % a pixel is 3 % in the mean of a block, and features of a picture are larger.
pub const BLOCK: u32 = 16;
/// Blocks are dark below so much of the picture's mean.
pub const DARK: f64 = 0.1;
/// In so many pictures the intervals of all blocks together hold.
const ALL_HOLD: f64 = 0.95;
/// Noise of a block at which its mean is as good as known: rounding of the sums, as a share of the mean.
const ROUNDING: f64 = 1e-6;

/// A noisy picture, before it is compared with what a denoiser made of it.
pub struct Pair<'a> {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Red, green, blue and alpha of each pixel, rows from top to bottom.
    pub noisy: &'a [f32],
    /// Variance of the luminance of each pixel, if it is known.
    pub variances: Option<&'a [f32]>,
}

/// The brightness of a denoised picture without that of the noisy one. Shares are of the mean of the noisy picture; those of a
/// block are of the noisy block's, or of [`DARK`] times the picture's where the block is darker.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shift {
    /// Of the whole picture.
    pub mean: f64,
    /// Half of its 95 % interval.
    pub mean_interval: f64,
    /// The block that is farthest beyond its interval, which is as wide as the choice among all blocks makes it.
    pub largest: BlockShift,
    /// Share of the blocks that are beyond their intervals: 0.05 is what noise alone makes of a perfect denoiser.
    pub beyond: f64,
    /// Blocks.
    pub blocks: usize,
    /// Edge of a block.
    pub block_size: u32,
}

/// The same of one block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BlockShift {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// The shift …
    pub shift: f64,
    /// … and half of its interval of 95 %.
    pub interval: f64,
}

/// Means of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Block {
    /// Luminance of the noisy picture.
    pub noisy: f64,
    /// That of the denoised one.
    pub denoised: f64,
    /// Variance of `noisy`, as the pixels in and about it tell.
    pub variance: f64,
    /// The same as its own pixels tell.
    pub own_variance: f64,
    /// Pixels.
    pub pixels: f64,
}

/// Luminance of a pixel.
pub fn luminance(pixel: &[f32]) -> f64 {
    let channels = pixel.iter().zip(LUMINANCE);
    channels.map(|(v, w)| f64::from(*v) * w).sum()
}

impl Pair<'_> {
    /// Blocks a row, and rows of them. Those at the right and lower edge may be smaller.
    pub fn blocks_across(&self) -> (usize, usize) {
        let count = |side: u32| side.div_ceil(BLOCK) as usize;
        (count(self.size.0), count(self.size.1))
    }

    /// The blocks, row by row.
    pub fn blocks(&self, denoised: &[f32]) -> Vec<Block> {
        let (across, down) = self.blocks_across();
        let mut blocks = vec![Block::default(); across * down];
        let width = self.size.0 as usize;
        let pixels = self.noisy.chunks_exact(4).zip(denoised.chunks_exact(4));
        for (index, (noisy, denoised)) in pixels.enumerate() {
            let (x, y) = (index % width, index / width);
            let block = &mut blocks[y / BLOCK as usize * across + x / BLOCK as usize];
            block.noisy += luminance(noisy);
            block.denoised += luminance(denoised);
            block.own_variance += self.variances.map_or(0.0, |all| f64::from(all[index]));
            block.pixels += 1.0;
        }
        let around = sums_around(&blocks, across);
        for (block, (variance, pixels)) in blocks.iter_mut().zip(around) {
            block.noisy /= block.pixels;
            block.denoised /= block.pixels;
            block.own_variance /= block.pixels * block.pixels;
            block.variance = variance / (pixels * block.pixels);
        }
        blocks
    }

    /// What a denoised picture has lost or won; `None` if the noise is not known, or the picture is black.
    pub fn shift(&self, denoised: &[f32]) -> Option<Shift> {
        let variances = self.variances?;
        let blocks = self.blocks(denoised);
        let weighted = |value: fn(&Block) -> f64| -> f64 { blocks.iter().map(value).sum() };
        let pixels = weighted(|b| b.pixels);
        let noisy = weighted(|b| b.noisy * b.pixels) / pixels;
        if noisy <= 0.0 {
            return None;
        }
        let denoised = weighted(|b| b.denoised * b.pixels) / pixels;
        let variance = weighted(|b| b.own_variance * b.pixels * b.pixels) / (pixels * pixels);
        let squares: f64 = variances.iter().map(|&v| f64::from(v).powi(2)).sum();
        let sum = variance * pixels * pixels;
        let degrees = if squares > 0.0 {
            3.0 * sum * sum / squares - 2.0
        } else {
            f64::MAX
        };
        let (across, _) = self.blocks_across();
        let level = |block: &Block| block.noisy.max(DARK * noisy);
        let moved = |block: &Block| (block.denoised - block.noisy).abs();
        let beyond = blocks.iter().filter(|block| {
            let noise = block.variance.sqrt().max(ROUNDING * level(block));
            moved(block) > TWO_SIDED_95 * noise
        });
        let beyond = beyond.count();
        let of_all = two_sided(-f64::exp_m1(ALL_HOLD.ln() / blocks.len() as f64));
        let shifts = blocks.iter().enumerate().map(|(index, block)| {
            let level = level(block);
            let variance = block.variance.max(block.own_variance);
            BlockShift {
                x: (index % across) as u32 * BLOCK,
                y: (index / across) as u32 * BLOCK,
                shift: (block.denoised - block.noisy) / level,
                interval: of_all * variance.sqrt().max(ROUNDING * level) / level,
            }
        });
        let excess = |of: &BlockShift| of.shift.abs() - of.interval;
        let largest = shifts.max_by(|a, b| excess(a).total_cmp(&excess(b)))?;
        Some(Shift {
            mean: (denoised - noisy) / noisy,
            mean_interval: student_95(degrees) * variance.sqrt() / noisy,
            largest,
            beyond: beyond as f64 / blocks.len() as f64,
            blocks: blocks.len(),
            block_size: BLOCK,
        })
    }
}

/// Of each block the sums of variances and of pixels over itself and those that it touches.
fn sums_around(blocks: &[Block], across: usize) -> Vec<(f64, f64)> {
    let down = blocks.len() / across.max(1);
    let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    let around = |index: usize| {
        let (x, y) = (index % across, index / across);
        let rows = near(y, down).flat_map(|y| near(x, across).map(move |x| y * across + x));
        rows.fold((0.0, 0.0), |(variance, pixels), i| {
            (variance + blocks[i].own_variance, pixels + blocks[i].pixels)
        })
    };
    (0..blocks.len()).map(around).collect()
}

impl Shift {
    /// As a part of a sentence.
    pub fn words(&self) -> String {
        // Of zeros without their sign.
        let percent = |share: f64| format!("{:.2} %", (1e4 * share).round() / 100.0 + 0.0);
        format!(
            "brightness shift {} ± {}, largest block {} ± {}",
            percent(self.mean),
            percent(self.mean_interval),
            percent(self.largest.shift),
            percent(self.largest.interval)
        )
    }
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/shift.rs"]
mod tests;
