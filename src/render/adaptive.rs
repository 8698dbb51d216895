//! Samples where the error is: adaptive sampling.
//!
//! After some samples everywhere, each round spends half of what has been spent so far, where it lowers the largest
//! errors most: as water fills a valley, a level is found such that bringing every pixel above it down to it costs
//! just that. So the error is even whenever the render is stopped, be it before the target is reached.
//!
//! A pixel that stops when its own samples happen to agree would be too dark on average where light comes in rare
//! bright samples, as it stops before it has met one. So a pixel's own samples have no say in how many it gets: the
//! errors of the pixels around it without its own decide ([`crate::film::error::deciding`]), whose samples are
//! independent of its own, and the mean of its samples stays unbiased but for a feedback: its error sends samples to
//! its neighbours, and what these find sends samples back, which takes four rounds. And no decision is for ever: when a
//! neighbour meets something, a pixel goes on.

use super::Stop;
use super::tile::{Samples, Tile, locked};
use crate::film::pixel::Pixel;
use rayon::prelude::*;
use std::sync::Mutex;

/// Every pixel takes so many samples before any is preferred.
pub const FIRST_SAMPLES: u32 = 32;
/// Halvings of the interval in which the level is searched: to a thousandth of a factor of 2^10.
const STEPS: u32 = 14;

/// A pixel that could take more samples.
#[derive(Clone, Copy)]
struct Candidate {
    /// Squared relative error.
    error: f32,
    samples: u32,
}

impl Candidate {
    /// Samples that it lacks to come down to a level: the squared error falls with their number. Never more than it
    /// has already, for the estimate is uncertain, and an even number, for two replicates.
    fn lacks(self, level: f64, most: u32) -> u32 {
        let excess = f64::from(self.error) / (level * level) - 1.0;
        if excess <= 0.0 {
            return 0;
        }
        let wanted = f64::from(self.samples) * excess.clamp(0.25, 1.0);
        let even = (wanted / 2.0).ceil().max(1.0) as u32 * 2;
        even.min(most - self.samples)
    }
}

fn candidate(pixel: &Pixel, error: f32, target: f64, most: u32) -> Option<Candidate> {
    let above = f64::from(error) > target * target || !error.is_finite();
    (above && pixel.samples < most).then_some(Candidate {
        error: error.min(f32::MAX),
        samples: pixel.samples,
    })
}

/// Says how many samples each pixel is to have after the next round; or why none needs more.
pub fn plan(tiles: &[Mutex<Tile>], target: f64, most: u32) -> Result<(), Stop> {
    let candidates: Vec<Candidate> = tiles
        .par_iter()
        .flat_map_iter(|tile| {
            let tile = locked(tile);
            let each = tile.pixels.iter().zip(&tile.deciding);
            each.filter_map(|(pixel, &error)| candidate(pixel, error, target, most))
                .collect::<Vec<_>>()
        })
        .collect();
    if candidates.is_empty() {
        let left = tiles.iter().any(|tile| {
            let errors = |&e: &f32| f64::from(e) > target * target;
            locked(tile).deciding.iter().any(errors)
        });
        return Err(if left {
            Stop::Samples
        } else {
            Stop::PixelError
        });
    }
    let level = level(&candidates, target, most, Samples::of(tiles).all / 2);
    for tile in tiles {
        let mut tile = locked(tile);
        let Tile {
            pixels, deciding, ..
        } = &mut *tile;
        for (pixel, &error) in pixels.iter_mut().zip(deciding.iter()) {
            let more = candidate(pixel, error, target, most).map_or(0, |c| c.lacks(level, most));
            pixel.until = pixel.samples + more;
        }
    }
    Ok(())
}

/// The lowest level, not below the target, to which all can be brought by so many samples.
fn level(candidates: &[Candidate], target: f64, most: u32, budget: u64) -> f64 {
    let cost = |level: f64| -> u64 {
        candidates
            .par_iter()
            .map(|c| u64::from(c.lacks(level, most)))
            .sum()
    };
    if cost(target) <= budget {
        return target;
    }
    let largest = candidates.iter().fold(0f32, |a, c| a.max(c.error));
    // A little below the largest error something is always lacking.
    let (mut low, mut high) = (target.ln(), 0.5 * f64::from(largest).ln());
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if cost(middle.exp()) > budget {
            low = middle;
        } else {
            high = middle;
        }
    }
    // What costs a little too much rather than nothing at all.
    low.exp()
}

#[cfg(test)]
#[path = "../../tests/unit/render/adaptive.rs"]
mod tests;
