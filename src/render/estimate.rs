//! The error of the picture so far, from the tiles.

use super::Region;
use super::tile::{TILE, Tile, across, locked};
use crate::film::error::{
    ErrorEstimate, ErrorSums, Noisy, REACH, SHOWN, deciding, pooled, relative_errors,
};
use crate::sampler::Sequences;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Estimates the error of each pixel, which the tiles then have, and of the picture. `None`, and nothing is
/// changed, while a pixel has less than a sample of each replicate, and when nobody waits any more. With a target for
/// each pixel (0 for none) the tiles get what adaptive sampling decides by, too.
/// Bands are summed in their order, so that the numbers do not depend on the threads.
///
/// Halves of one sequence tell an error that is too large by an unknown factor: its interval begins at 0.
pub fn estimate(
    tiles: &[Mutex<Tile>],
    region: Region,
    pixel_target: f64,
    sequences: Sequences,
    given_up: &AtomicBool,
) -> Option<ErrorEstimate> {
    let width = region.width() as usize;
    let bands: Option<Vec<Band>> = (0..region.height().div_ceil(TILE))
        .into_par_iter()
        .map(|band| {
            if given_up.load(Ordering::Relaxed) {
                return None;
            }
            let first = band * TILE;
            let end = (first + TILE).min(region.height());
            let from = first.saturating_sub(REACH as u32);
            let to = (end + REACH as u32).min(region.height());
            let rows = gather(tiles, region, from..to)?;
            let (skip, count) = ((first - from) as usize, (end - first) as usize);
            let (shown, sums) = relative_errors(&rows, width, skip, count);
            let wanted = &rows[skip * width..(skip + count) * width];
            let deciding = if pixel_target > 0.0 {
                wanted.iter().map(Noisy::own_error).collect()
            } else {
                Vec::new()
            };
            Some(Band {
                shown,
                deciding,
                sums,
            })
        })
        .collect();
    let mut all = Band::default();
    for band in bands? {
        all.shown.extend(band.shown);
        all.deciding.extend(band.deciding);
        all.sums.join(&band.sums);
    }
    let sums = all.sums;
    hand_out(tiles, region, all);
    sums.estimate().map(|estimate| match sequences {
        Sequences::Two => estimate,
        Sequences::One { .. } => ErrorEstimate {
            low: 0.0,
            ..estimate
        },
    })
}

/// Squared errors of the pixels of some rows.
#[derive(Default)]
struct Band {
    /// What is shown.
    shown: Vec<f32>,
    /// What adaptive sampling decides by, if anything is to be decided.
    deciding: Vec<f32>,
    sums: ErrorSums,
}

/// Rows of pixels, counted from the region's first one.
fn gather(tiles: &[Mutex<Tile>], region: Region, rows: std::ops::Range<u32>) -> Option<Vec<Noisy>> {
    let width = region.width() as usize;
    let mut noisy = vec![Noisy::default(); width * rows.len()];
    let bands = (rows.start / TILE) as usize..=((rows.end - 1) / TILE) as usize;
    for tile in &tiles[bands.start() * across(region)..(bands.end() + 1) * across(region)] {
        let tile = locked(tile);
        let (column, top) = ((tile.x - region.x0) as usize, tile.y - region.y0);
        for (row, pixels) in (top..).zip(tile.pixels.chunks(tile.width as usize)) {
            if !rows.contains(&row) {
                continue;
            }
            let start = (row - rows.start) as usize * width + column;
            for (place, pixel) in noisy[start..].iter_mut().zip(pixels) {
                *place = Noisy::of(pixel)?;
            }
        }
    }
    Some(noisy)
}

/// Gives each pixel the error that its neighbours let expect: what they say of one sample is pooled, for they may
/// have more samples or less.
fn hand_out(tiles: &[Mutex<Tile>], region: Region, errors: Band) {
    let width = region.width() as usize;
    let shown = pooled(&of_one_sample(tiles, region, errors.shown), width, SHOWN);
    for tile in tiles {
        let mut tile = locked(tile);
        tile.errors = of_all_samples(&tile, region, &shown);
    }
    if !errors.deciding.is_empty() {
        let deciding = deciding(&of_one_sample(tiles, region, errors.deciding), width);
        for tile in tiles {
            let mut tile = locked(tile);
            tile.deciding = of_all_samples(&tile, region, &deciding);
        }
    }
}

/// Squared errors of the region's pixels times their samples.
fn of_one_sample(tiles: &[Mutex<Tile>], region: Region, mut errors: Vec<f32>) -> Vec<f32> {
    for tile in tiles {
        let tile = locked(tile);
        for (row, pixels) in tile.pixels.chunks(tile.width as usize).enumerate() {
            let start = tile.first_of_row(region, row);
            for (error, pixel) in errors[start..].iter_mut().zip(pixels) {
                *error *= pixel.samples as f32;
            }
        }
    }
    errors
}

/// The other way round, for the pixels of a tile.
fn of_all_samples(tile: &Tile, region: Region, errors: &[f32]) -> Vec<f32> {
    let rows = tile.pixels.chunks(tile.width as usize).enumerate();
    rows.flat_map(|(row, pixels)| {
        let errors = errors[tile.first_of_row(region, row)..].iter();
        errors.zip(pixels).map(|(e, p)| e / p.samples as f32)
    })
    .collect()
}
