//! A few bands of a picture, to try out what takes long.

use super::Bands;
use std::ops::Range;

/// Some bands of a picture in their order.
pub struct Extract<'a> {
    all: &'a dyn Bands,
    chosen: Vec<(usize, Range<u32>)>,
}

impl<'a> Extract<'a> {
    /// So many of these bands, evenly chosen; `None` if there are none.
    pub fn of(all: &'a dyn Bands, bands: &[usize], count: usize) -> Option<Self> {
        let rows = all.bands();
        let step = bands.len().div_ceil(count).max(1);
        let chosen = bands.iter().skip(step / 2).step_by(step);
        let chosen: Vec<_> = chosen.map(|&band| (band, rows[band].clone())).collect();
        (!chosen.is_empty()).then_some(Self { all, chosen })
    }

    /// Rows of all of them.
    pub fn rows(&self) -> u32 {
        self.chosen
            .iter()
            .map(|(_, rows)| rows.end - rows.start)
            .sum()
    }
}

impl Bands for Extract<'_> {
    fn size(&self) -> (u32, u32) {
        (self.all.size().0, self.rows())
    }

    fn layers(&self) -> Vec<(String, String)> {
        self.all.layers()
    }

    fn bands(&self) -> Vec<Range<u32>> {
        let mut from = 0;
        let mut next = |rows: &Range<u32>| {
            let to = from + rows.end - rows.start;
            std::mem::replace(&mut from, to)..to
        };
        self.chosen.iter().map(|(_, rows)| next(rows)).collect()
    }

    fn fill(&self, band: usize, layers: &mut [&mut [f32]]) {
        self.all.fill(self.chosen[band].0, layers);
    }
}
