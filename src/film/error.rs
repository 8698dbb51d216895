//! How far a picture is from the truth, told by the picture itself.
//!
//! The error of a pixel is Σ over its channels of (x − r)² / (r² + 0.01) / 3, x its mean so far and r what it
//! would converge to; the error of the picture is √ of the mean of that: √relMSE. What of it can be known:
//!
//! - (x − r)² has the expectation of the variance of x, which two independent replicates give without bias
//!   ([`Pixel::variance`](super::pixel::Pixel::variance)). A firefly of a value far above the rest lies in one
//!   replicate alone: there the estimate is not only right in the mean but equal to the error.
//! - r² is not known, and x² is a bad stand-in: where x is a firefly, x² is large and would make the error look
//!   small. So r is x where x is certain, and what the neighbours say where it is not: Wiener's filter with local
//!   statistics (Lee, *Digital Image Enhancement and Noise Filtering by Use of Local Statistics*, 1980, eq. 6–9),
//!   x̂ = μ + S / (S + v) · (x − μ), v the variance of x, μ the mean around it, S the variance of the truth around
//!   it, that is of x without the mean of v. In these means pixels count x² / (x² + v); one that is uncertain and more
//!   than twenty times as bright as the others counts as twenty times as bright, so that fireflies do not speak for their
//!   neighbours, nor for themselves; and by how alike albedo and normal are, so that what lies beyond an edge
//!   does not speak for this side (features as guides: Rousselle, Manzi and Zwicker, *Robust Denoising using Feature
//!   and Color Information*, 2013, §4).

use super::pixel::Pixel;
use super::sum::FixedSum;
use crate::math::float::{REL_MSE_OFFSET, TWO_SIDED_95};
use glam::{DVec2, DVec3, Vec3, Vec3A};
use rayon::prelude::*;
use serde::Serialize;
use wide::f64x4;

/// Pixels to each side that count as neighbours.
pub const REACH: usize = 2;
/// Pixels to each side over which the errors that are shown are pooled: one degree of freedom tells little, 48 tell
/// the error to √(2 / 48) / 2 = 10 %.
pub const SHOWN: usize = 3;
/// The same where it is decided who gets more samples: so many that where light comes in rare bright samples, some of
/// these pixels have met some …
const WIDE: usize = 22;
/// … and so few that edges between quiet and noisy parts stay where they are.
const NEAR: usize = 6;
/// A neighbourhood counts as its mean with so many standard errors on top: where few of its pixels make most of the error, it is
/// less certain that all kinds of samples there have been met.
const DOUBTS: f64 = 1.0;
/// Pixels to each side that come down to the target together.
const SHARED: usize = 6;
/// Pixels whose features are so far apart are of different things.
const UNLIKE: f32 = 0.5;
/// A pixel brighter than the mean of its neighbours by more than this is taken for a firefly …
const FIREFLY: f64 = 20.0;
/// … if it counts less than this: a firefly has v = x² and counts 1/2.
const UNCERTAIN: f64 = 0.8;
/// Standard deviation of the error's square that comes of not knowing r, as a share of what the filter changed.
/// With half of it 560 of 592 intervals held, and few of scenes with spots of light (docs/notes/accuracy.md); with this 570.
const DOUBT: f64 = 1.0;

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noisy {
    /// Mean radiance.
    pub mean: DVec3,
    /// Estimated variance of the mean.
    pub variance: DVec3,
    /// Mean albedo and, by half, mean normal of what the camera sees.
    pub features: [Vec3; 2],
}

impl Noisy {
    /// Of a pixel; `None` as long as its variance is not known.
    pub fn of(pixel: &Pixel) -> Option<Self> {
        let samples = f64::from(pixel.samples.max(1));
        let mean = |sum: &FixedSum, factor: f64| (sum.total() * (factor / samples)).as_vec3();
        Some(Self {
            mean: pixel.mean(),
            variance: pixel.variance()?,
            features: [mean(&pixel.albedo, 1.0), mean(&pixel.normal, 0.5)],
        })
    }

    /// Its relative squared error by the lower of its two replicates, a and b: x − √v, as v is ((a − b) / 2)². What only one
    /// of them has met is no light that the pixel is known to have: a single bright sample among dark ones, of a caustic or
    /// of a light out of focus, is an error and not a brighter pixel. Where little noise is left, r comes out lower
    /// by 0.56 of its deviation. Too noisy to be told, but what adaptive sampling takes means of.
    pub fn own_error(&self) -> f32 {
        let noise = self.variance.map(f64::sqrt);
        let lower = (self.mean - noise).max(DVec3::ZERO);
        let square = lower * lower;
        finite((self.variance / (square + REL_MSE_OFFSET)).element_sum() / 3.0)
    }

    /// How much it tells of its neighbours as far as noise goes. One number for all channels: they are noisy
    /// together, and black ones say nothing.
    fn certainty(&self) -> f64 {
        let (level, noise) = (self.level(), self.variance.element_sum() / 3.0);
        if noise > 0.0 {
            level * level / (level * level + noise)
        } else {
            1.0
        }
    }

    /// Mean of its channels.
    fn level(&self) -> f64 {
        self.mean.element_sum() / 3.0
    }
}

/// A pixel as those around it look at it: each does so 25 times.
struct Neighbor {
    mean: f64x4,
    variance: f64x4,
    level: f64,
    certainty: f64,
    features: [Vec3A; 2],
}

impl Neighbor {
    fn new(pixel: &Noisy) -> Self {
        let four = |v: DVec3| f64x4::from([v.x, v.y, v.z, 0.0]);
        Self {
            mean: four(pixel.mean),
            variance: four(pixel.variance),
            level: pixel.level(),
            certainty: pixel.certainty(),
            features: pixel.features.map(Vec3A::from),
        }
    }

    /// How much another pixel tells about this one: all if their features are the same, nothing if they differ by
    /// [`UNLIKE`].
    #[inline]
    fn likeness(&self, other: &Self) -> f64 {
        let between = |i: usize| self.features[i].distance_squared(other.features[i]);
        (1.0 - (between(0) + between(1)) / (UNLIKE * UNLIKE))
            .max(0.0)
            .into()
    }
}

/// Error of a picture: root of its relMSE.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// Estimated error; 0.02 is 2 %.
    pub error: f64,
    /// The error of this picture lies above this …
    pub low: f64,
    /// … and below this, in 95 of 100 renders.
    pub high: f64,
}

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSums {
    pixels: f64,
    errors: f64,
    squares: f64,
    /// Of the errors that x² would give for r².
    plain: f64,
}

impl ErrorSums {
    /// Both together.
    pub fn join(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.errors += other.errors;
        self.squares += other.squares;
        self.plain += other.plain;
    }

    /// What they say; `None` without pixels.
    ///
    /// With e the estimate of a pixel, from ν = 1 degree of freedom, and d its error: e = v χ²(ν) / ν and
    /// d = v χ²(1) for normal x, independent of each other, so var(d − e) = 2 v² (ν + 1) / ν = E(e²) · 2 (ν + 1) /
    /// (ν + 2). The interval is symmetric in the logarithm, as both are positive.
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        if self.pixels == 0.0 {
            return None;
        }
        let error = (self.errors / self.pixels).sqrt();
        if self.errors == 0.0 {
            return Some(ErrorEstimate {
                error,
                low: 0.0,
                high: 0.0,
            });
        }
        let by_chance = self.squares * (4.0 / 3.0) / (self.errors * self.errors);
        let by_reference = DOUBT * (1.0 - self.plain / self.errors);
        // Half, as of a root.
        let deviation = 0.5 * (by_chance + by_reference * by_reference).sqrt();
        let factor = (TWO_SIDED_95 * deviation).exp();
        Some(ErrorEstimate {
            error,
            low: error / factor,
            high: error * factor,
        })
    }
}

/// Greater errors of a pixel are told as this one (10^15 of its radiance), so that products with numbers of samples
/// and sums of them stay finite in f32: a single sample of 1e38 beside black has 1e78.
const MOST: f64 = 1e30;

fn finite(error: f64) -> f32 {
    error.min(MOST) as f32
}

/// Relative squared errors of some rows of a picture: `rows` are these with [`REACH`] more above and below as far
/// as there are any, `width` pixels each; `skip` of them stand before the first one wanted. Gives an error for
/// each pixel of `count` rows, and their sums.
pub fn relative_errors(
    rows: &[Noisy],
    width: usize,
    skip: usize,
    count: usize,
) -> (Vec<f32>, ErrorSums) {
    let height = rows.len() / width.max(1);
    let neighbors: Vec<Neighbor> = rows.iter().map(Neighbor::new).collect();
    let mut sums = ErrorSums::default();
    let mut errors = Vec::with_capacity(width * count);
    for y in skip..skip + count {
        let window = y.saturating_sub(REACH)..(y + REACH + 1).min(height);
        for x in 0..width {
            let pixel = &rows[y * width + x];
            let middle = &neighbors[y * width + x];
            let columns = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
            let mut around = Window::default();
            for row in window.clone() {
                for other in &neighbors[row * width..][columns.clone()] {
                    around.add(other, middle.likeness(other));
                }
            }
            let reference = around.moments().filtered(pixel);
            let error = |r: DVec3| (pixel.variance / (r * r + REL_MSE_OFFSET)).element_sum() / 3.0;
            let e = error(reference);
            sums.pixels += 1.0;
            sums.errors += e;
            sums.squares += e * e;
            sums.plain += error(pixel.mean).min(e);
            errors.push(finite(e));
        }
    }
    (errors, sums)
}

/// The pixels around one, but for the brightest, which stands apart.
#[derive(Default)]
struct Window<'a> {
    others: Moments,
    /// Sum of levels, and of likenesses.
    levels: (f64, f64),
    brightest: Option<Weighted<'a>>,
}

/// A pixel in a window.
struct Weighted<'a> {
    pixel: &'a Neighbor,
    likeness: f64,
}

impl Weighted<'_> {
    #[inline]
    fn weight(&self) -> f64 {
        self.pixel.certainty * self.likeness
    }
}

impl<'a> Window<'a> {
    #[inline]
    fn add(&mut self, pixel: &'a Neighbor, likeness: f64) {
        if likeness <= 0.0 {
            return;
        }
        let mut next = Weighted { pixel, likeness };
        let Some(brightest) = &mut self.brightest else {
            self.brightest = Some(next);
            return;
        };
        if next.pixel.level > brightest.pixel.level {
            std::mem::swap(brightest, &mut next);
        }
        self.levels.0 += next.likeness * next.pixel.level;
        self.levels.1 += next.likeness;
        self.others.add(next.pixel, next.weight(), 1.0);
    }

    fn moments(mut self) -> Moments {
        if let Some(brightest) = &self.brightest {
            let (pixel, limit) = (brightest.pixel, FIREFLY * self.levels.0 / self.levels.1);
            let firefly = pixel.certainty < UNCERTAIN && pixel.level > limit;
            let scale = if firefly { limit / pixel.level } else { 1.0 };
            self.others.add(pixel, brightest.weight(), scale);
        }
        self.others
    }
}

/// Weighted moments of pixels, of each channel in its lane.
#[derive(Clone, Copy, Default)]
struct Moments {
    weight: f64,
    mean: f64x4,
    square: f64x4,
    variance: f64x4,
}

fn channels(lanes: f64x4) -> DVec3 {
    let [x, y, z, _] = lanes.to_array();
    DVec3::new(x, y, z)
}

impl Moments {
    /// Adds a pixel as if it were `scale` times as bright.
    #[inline(always)]
    fn add(&mut self, pixel: &Neighbor, weight: f64, scale: f64) {
        let square = f64x4::splat(weight * scale * scale);
        self.weight += weight;
        self.mean += f64x4::splat(weight * scale) * pixel.mean;
        self.square += square * pixel.mean * pixel.mean;
        self.variance += square * pixel.variance;
    }

    /// The pixel without its noise, as far as the pixels around tell.
    fn filtered(&self, pixel: &Noisy) -> DVec3 {
        if self.weight <= 0.0 {
            return pixel.mean;
        }
        let mean = channels(self.mean) / self.weight;
        // E(x²) − μ² cancels where the truth varies little against its mean, down to 2^-52 μ²: far below any v
        // that matters.
        let (square, variance) = (channels(self.square), channels(self.variance));
        let spread = (square / self.weight - mean * mean - variance / self.weight).max(DVec3::ZERO);
        let trust = spread / (spread + pixel.variance);
        let trusted = |i: usize| if trust[i].is_finite() { trust[i] } else { 1.0 };
        let trust = DVec3::new(trusted(0), trusted(1), trusted(2));
        mean + trust * (pixel.mean - mean)
    }
}

/// The squared errors of one sample that adaptive sampling decides by, from those of each pixel
/// ([`Noisy::own_error`] times its samples): a pixel with n samples is good enough where this / n is.
///
/// What matters is the mean error of a neighbourhood, and it costs fewest samples if each pixel of it has samples in
/// proportion to the root of its error: Σ q / n is least, at a given Σ n, for n ∝ √q (Neyman, *On the Two Different
/// Aspects of the Representative Method*, 1934). To come down to a mean error of e, they are n = √q · mean(√q) / e.
///
/// A near neighbourhood says q. A wide one says the least that it can be, lest a pixel is given up before
/// the rare bright samples there are have been met: one that comes late stays in the picture, as a pixel's own samples have no say, and
/// it is the larger the fewer samples there are beside it. Both say it with their standard error.
pub fn deciding(errors: &[f32], width: usize) -> Vec<f32> {
    let wide = pooled_of(Kind::Next, errors, width, WIDE, DOUBTS);
    let near = pooled_of(Kind::Next, errors, width, NEAR, DOUBTS);
    let both = near.iter().zip(&wide);
    let roots: Vec<f32> = both.map(|(n, w)| n.max(*w).sqrt()).collect();
    // Those of the same kind have all looked at the next one alone, and so do their means.
    let around = pooled_of(Kind::Same, &roots, width, SHARED, 0.0);
    roots.iter().zip(&around).map(|(r, a)| r * a).collect()
}

/// Pixels are of four kinds, by whether their column and their row are even.
#[derive(Clone, Copy)]
enum Kind {
    /// Each looks at its own, itself among them.
    Same,
    /// Each looks at the next one: what a pixel has met can come back to it by way of the three others only.
    Next,
}

impl Kind {
    /// Whether the columns and the rows that a pixel looks at are odd.
    fn seen_from(self, column: usize, row: usize) -> (usize, usize) {
        match (self, column % 2, row % 2) {
            (Self::Same, column, row) => (column, row),
            (Self::Next, 0, 0) => (1, 0),
            (Self::Next, 1, 0) => (1, 1),
            (Self::Next, 1, 1) => (0, 1),
            (Self::Next, ..) => (0, 0),
        }
    }
}

/// Means, and so many of their standard errors on top, over squares of `reach` to each side, as far as there are any, of the
/// pixels that each looks at; its own value where there are none.
fn pooled_of(kind: Kind, values: &[f32], width: usize, reach: usize, doubts: f64) -> Vec<f32> {
    let around = |at: usize, length: usize, odd: usize| {
        let from = at.saturating_sub(reach);
        (from + (from + odd) % 2..(at + reach + 1).min(length)).step_by(2)
    };
    // Sums of the values and of their squares, of the even and of the odd columns around each.
    let across = |row: &[f32]| -> Vec<[DVec2; 2]> {
        let both = |at: usize| f64::from(row[at]) * DVec2::new(1.0, f64::from(row[at]));
        let sum = |x, odd| around(x, width, odd).map(both).sum();
        (0..width).map(|x| [0, 1].map(|odd| sum(x, odd))).collect()
    };
    let rows: Vec<Vec<[DVec2; 2]>> = values.par_chunks(width.max(1)).map(across).collect();
    let down = |y: usize| {
        let (rows, own) = (&rows, &values[y * width..(y + 1) * width]);
        (0..width).map(move |x| {
            let (column, row) = kind.seen_from(x, y);
            let near = around(y, rows.len(), row);
            let others = near.len() * around(x, width, column).len();
            if others == 0 {
                return own[x];
            }
            let sums: DVec2 = near.map(|at| rows[at][x][column]).sum();
            let count = others as f64;
            let [mean, square] = (sums / count).to_array();
            // Cancels down to 2^-52 of the mean's square: a standard error of 2^-26 of the mean, which says nothing.
            let spread = (square - mean * mean).max(0.0).sqrt();
            (mean + doubts * spread / count.sqrt()) as f32
        })
    };
    let all = (0..rows.len()).into_par_iter();
    all.flat_map_iter(down).collect()
}

/// Mean of the values around each, over squares of `reach` to each side as far as there are any, without its own
/// (but where it is alone); by the threads of the current pool.
pub fn pooled(values: &[f32], width: usize, reach: usize) -> Vec<f32> {
    let around = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length);
    let across = |row: &[f32]| -> Vec<f64> {
        let sum = |x| row[around(x, width)].iter().map(|&v| f64::from(v)).sum();
        (0..width).map(sum).collect()
    };
    let rows: Vec<Vec<f64>> = values.par_chunks(width.max(1)).map(across).collect();
    let down = |y: usize| {
        let near = around(y, rows.len());
        let (rows, own) = (&rows, &values[y * width..(y + 1) * width]);
        (0..width).map(move |x| {
            let others = near.len() * around(x, width).len() - 1;
            if others == 0 {
                return own[x];
            }
            // The sum of squares may lose what is 2^-52 of a firefly beside it, which no longer matters there.
            let sum: f64 = rows[near.clone()].iter().map(|row| row[x]).sum();
            ((sum - f64::from(own[x])) / others as f64).max(0.0) as f32
        })
    };
    (0..rows.len())
        .into_par_iter()
        .flat_map_iter(down)
        .collect()
}

#[cfg(test)]
#[path = "../../tests/unit/film/error.rs"]
mod tests;
