//! How far a denoised picture looks from the truth, told by the two halves of its samples.
//!
//! Both halves are denoised, each by itself, with the guides of the whole. FLIP between them, as they are shown, is in proportion
//! to FLIP between the denoised picture and the truth: the one has the noise that the denoiser leaves of two pictures with half of
//! the samples, the other what it leaves of one with all of them, and what it guesses wrong. The factor is measured
//! (docs/notes/accuracy.md). A wrong guess that both halves share is in none of their differences.

use crate::math::float::TWO_SIDED_95;
use serde::Serialize;

/// FLIP of a denoised picture over FLIP between its denoised halves: the geometric mean over scenes, samples and seeds …
const OF_HALVES: f64 = 0.85;
/// … and the standard deviation of its logarithm.
const DEVIATION: f64 = 0.15;

/// The estimated error of a denoised picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HalvesError {
    /// Mean FLIP between the denoised picture and the truth, as they are shown.
    pub flip: f64,
    /// It lies above this …
    pub low: f64,
    /// … and below this, in 95 of 100 pictures.
    pub high: f64,
    /// FLIP between the denoised halves.
    pub between_halves: f64,
    /// Mean samples a pixel when they were looked at.
    pub samples: f64,
}

impl HalvesError {
    /// From FLIP between the denoised halves of a picture with so many samples.
    pub fn new(between_halves: f64, samples: f64) -> Self {
        let flip = OF_HALVES * between_halves;
        let factor = (TWO_SIDED_95 * DEVIATION).exp();
        Self {
            flip,
            low: flip / factor,
            high: (flip * factor).min(1.0),
            between_halves,
            samples,
        }
    }

    /// As a part of a sentence.
    pub fn words(&self) -> String {
        let Self {
            flip, low, high, ..
        } = self;
        format!("as shown FLIP of the denoised picture {flip:.4} ({low:.4} to {high:.4})")
    }
}

#[cfg(test)]
#[path = "../../tests/unit/denoise/halves.rs"]
mod tests;
