//! The error of the picture so far, from the tiles.

use super::Region;
use super::tile::{TILE, Tile, across, locked};
use crate::film::error::{
    ErrorEstimate, ErrorSums, Noisy, REACH, SHOWN, deciding, pooled, relative_errors,
};
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Estimates the error of each pixel, which the tiles then have, and of the picture. `None`, and nothing is
/// changed, while a pixel has less than a sample of each replicate, and when nobody waits any more. With a target for
/// each pixel (0 for none) the tiles get what adaptive sampling decides by, too.
/// Bands are summed in their order, so that the numbers do not depend on the threads.
pub fn estimate(
    tiles: &[Mutex<Tile>],
    region: Region,
    pixel_target: f64,
    given_up: &AtomicBool,
) -> Option<ErrorEstimate> {
    let width = region.width() as usize;
    let bands: Option<Vec<(Vec<f32>, ErrorSums)>> = (0..region.height().div_ceil(TILE))
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
            Some(relative_errors(&rows, width, skip, count))
        })
        .collect();
    let mut sums = ErrorSums::default();
    let mut errors = Vec::with_capacity(width * region.height() as usize);
    for (band, of_band) in bands? {
        errors.extend(band);
        sums.join(&of_band);
    }
    hand_out(tiles, region, errors, pixel_target);
    sums.estimate()
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
fn hand_out(tiles: &[Mutex<Tile>], region: Region, mut errors: Vec<f32>, pixel_target: f64) {
    let width = region.width() as usize;
    for tile in tiles {
        let tile = locked(tile);
        let column = (tile.x - region.x0) as usize;
        for (row, pixels) in tile.pixels.chunks(tile.width as usize).enumerate() {
            let start = ((tile.y - region.y0) as usize + row) * width + column;
            for (error, pixel) in errors[start..].iter_mut().zip(pixels) {
                *error *= pixel.samples as f32;
            }
        }
    }
    let shown = pooled(&errors, width, SHOWN);
    let of = |tile: &Tile, errors: &[f32]| -> Vec<f32> {
        let column = (tile.x - region.x0) as usize;
        let (top, across) = ((tile.y - region.y0) as usize, tile.width as usize);
        let rows = tile.pixels.chunks(across).zip(top..);
        rows.flat_map(|(pixels, row)| {
            let start = row * width + column;
            let errors = errors[start..start + across].iter();
            errors.zip(pixels).map(|(e, p)| e / p.samples as f32)
        })
        .collect()
    };
    for tile in tiles {
        let mut tile = locked(tile);
        tile.errors = of(&tile, &shown);
    }
    if pixel_target > 0.0 {
        let above = |e: &f32| f64::from(*e) > pixel_target * pixel_target;
        for deciding in deciding(&errors, width) {
            let mut any = false;
            for tile in tiles {
                let mut tile = locked(tile);
                tile.deciding = of(&tile, &deciding);
                any |= tile.deciding.iter().any(above);
            }
            if any {
                break;
            }
        }
    }
}
