//! Overlapping triangles of a plane by a grid: a floor of a million squares needs no tree of boxes.

use super::{Flat, meet, overlap};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Sides of a cell beside the mean extent of a triangle: of even squares it holds about 18.
const SIDE: f32 = 2.0;

/// Cells along an axis.
const MOST_ACROSS: f32 = 1e6;

/// A triangle in more cells, or a cell with more triangles, and a tree is faster.
const MOST_CELLS: u32 = 64;
const MOST_IN_CELL: usize = 64;

/// Numbers of the triangles that another overlaps, as `overlapping` has them; `None` where sizes or places differ too much for a
/// grid.
pub(super) fn overlapping(
    group: &[Flat],
    may: impl Fn(usize, usize) -> bool + Sync,
) -> Option<Vec<usize>> {
    let boxes: Vec<(Vec2, Vec2)> = group.iter().map(Flat::bounds).collect();
    let entries = entries(&boxes)?;
    let cells: Vec<&[(u64, u32)]> = entries.chunk_by(|a, b| a.0 == b.0).collect();
    if cells.iter().any(|cell| cell.len() > MOST_IN_CELL) {
        return None;
    }
    let found: Vec<AtomicBool> = group.iter().map(|_| AtomicBool::new(false)).collect();
    cells.par_iter().for_each(|cell| {
        for (place, &(_, one)) in cell.iter().enumerate() {
            for &(_, other) in &cell[..place] {
                let [one, other] = [one, other].map(|number| number as usize);
                if overlap(boxes[one], boxes[other])
                    && may(one, other)
                    && meet(&group[one], &group[other])
                {
                    found[one].store(true, Ordering::Relaxed);
                    found[other].store(true, Ordering::Relaxed);
                }
            }
        }
    });
    let found = (0..group.len()).filter(|&number| found[number].load(Ordering::Relaxed));
    Some(found.collect())
}

/// The cells of each triangle, in their order.
fn entries(boxes: &[(Vec2, Vec2)]) -> Option<Vec<(u64, u32)>> {
    let sizes = boxes
        .iter()
        .map(|(low, high)| f64::from((high - low).max_element()));
    let side = SIDE * (sizes.sum::<f64>() / boxes.len() as f64) as f32;
    let low = boxes.iter().fold(Vec2::MAX, |low, b| low.min(b.0));
    let high = boxes.iter().fold(Vec2::MIN, |high, b| high.max(b.1));
    let across = (high - low) / side;
    if !across.is_finite() || across.max_element() > MOST_ACROSS {
        return None;
    }
    let mut entries = Vec::with_capacity(3 * boxes.len());
    for (number, (from, to)) in (0..).zip(boxes) {
        let [from, to] = [from, to].map(|p| ((p - low) / side).as_uvec2());
        let count = to - from + 1;
        if count.x > MOST_CELLS || count.y > MOST_CELLS || count.element_product() > MOST_CELLS {
            return None;
        }
        for y in from.y..=to.y {
            entries.extend((from.x..=to.x).map(|x| (u64::from(y) << 32 | u64::from(x), number)));
        }
    }
    entries.par_sort_unstable();
    Some(entries)
}

#[cfg(test)]
#[path = "../../../tests/unit/scene/coincident/grid.rs"]
mod tests;
