//! Filter importance sampling: where in and around the pixel a sample goes
//! (Ernst, Stamminger, Greiner, *Filter Importance Sampling*, 2006). Each sample counts 1 in its
//! own pixel alone, so that pixels need no neighbours and no locks.

use glam::{DVec2, Vec2};

/// Points of the tabulated inverse; between them it is linear.
const STEPS: usize = 1024;
/// Cells of the tabulated shape. The middle of one stands for it: an error of its width squared, in half widths of the filter
/// 4e-9.
const CELLS: usize = 16 * STEPS;

/// A separable, symmetric filter ready to be sampled.
#[derive(Clone, Debug)]
pub struct FilterTable {
    /// The distance from the pixel's centre that is exceeded with probability (k/STEPS)²: the
    /// square gives the long thin tails of the windows their share of the points.
    inverse: Vec<f32>,
}

impl FilterTable {
    /// From the one-dimensional shape, even in its argument, over a support of `width` pixels about 0: its values in the
    /// middles of cells, from the rim to the centre.
    fn new(width: f64, shape: impl Iterator<Item = f64>) -> Self {
        let cells = CELLS;
        let at = |i: usize| 0.5 * width * (1.0 - i as f64 / cells as f64);
        // Sums from the rim to the centre: the tail's small numbers come first and keep their digits.
        let mut total = 0f64;
        let mut sums = vec![total; cells + 1];
        for (sum, value) in sums.iter_mut().skip(1).zip(shape) {
            total += value.max(0.0);
            *sum = total;
        }
        let mut cell = 0;
        let inverse = (0..=STEPS)
            .map(|k| {
                let wanted = total * (k as f64 / STEPS as f64).powi(2);
                while cell + 1 < cells && sums[cell + 1] < wanted {
                    cell += 1;
                }
                let span = sums[cell + 1] - sums[cell];
                let t = if span > 0.0 {
                    ((wanted - sums[cell]) / span).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                (at(cell) * (1.0 - t) + at(cell + 1) * t) as f32
            })
            .collect();
        Self { inverse }
    }

    /// One pixel wide, all the same.
    pub fn box_filter() -> Self {
        Self::new(1.0, std::iter::repeat(1.0))
    }

    /// The four-term window of Blackman and Harris (Harris 1978, table 1, 92 dB). `width` is what
    /// Blender calls the filter's width: half of the window, which is near 0 over its outer half.
    pub fn blackman_harris(width: f64) -> Self {
        let cell = std::f64::consts::PI / CELLS as f64;
        let turn = DVec2::from_angle(cell);
        let angles = std::iter::successors(Some(DVec2::from_angle(0.5 * cell)), |at| {
            Some(turn.rotate(*at))
        });
        let window = angles.map(|DVec2 { x: c, .. }| {
            // Cosines of t, 2t and 3t, the latter two as polynomials in the first.
            let (c2, c3) = (2.0 * c * c - 1.0, (4.0 * c * c - 3.0) * c);
            0.35875 - 0.48829 * c + 0.14128 * c2 - 0.01168 * c3
        });
        Self::new(2.0 * width, window)
    }

    /// A Gaussian of standard deviation `width`/4, cut at six of them, as Blender's filter of that
    /// width: exp(−2 (2x/width)²) over three times the width.
    pub fn gauss(width: f64) -> Self {
        let middle = |i| 3.0 * (1.0 - (f64::from(i) + 0.5) / CELLS as f64);
        let shape = (0..CELLS as u32).map(|i| (-2.0 * f64::powi(middle(i), 2)).exp());
        Self::new(3.0 * width, shape)
    }

    /// Offset from the pixel's centre in pixels.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let one = |u: f32| {
            let (beyond, side) = if u < 0.5 {
                (2.0 * u, -1.0)
            } else {
                (2.0 - 2.0 * u, 1.0)
            };
            let x = beyond.sqrt() * STEPS as f32;
            let i = (x as usize).min(STEPS - 1);
            let t = x - i as f32;
            side * (self.inverse[i] * (1.0 - t) + self.inverse[i + 1] * t)
        };
        Vec2::new(one(u.x), one(u.y))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/filter.rs"]
mod tests;
