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
mod tests {
    use super::*;
    use crate::sampler::hashed;

    const WIDTH: usize = 96;

    /// A normal number of mean 0 and variance 1 (Box and Muller 1958).
    fn normal(key: u32, pixel: u32) -> f64 {
        let (u, v) = (
            f64::from(hashed(key, pixel, 1)),
            f64::from(hashed(key, pixel, 2)),
        );
        (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Pixels of a truth with noise of a standard deviation, each from two replicates; and their true relMSE.
    fn picture(truth: impl Fn(usize, usize) -> f64, deviation: f64, key: u32) -> (Vec<Noisy>, f64) {
        let mut error = 0.0;
        let pixels = (0..WIDTH * WIDTH)
            .map(|i| {
                let r = truth(i % WIDTH, i / WIDTH);
                // The halves have twice the variance of their mean.
                let half = |k| r + deviation * 2f64.sqrt() * normal(key + k, i as u32);
                let (a, b) = (half(0), half(1));
                let mean = 0.5 * (a + b);
                error += (mean - r).powi(2) / (r * r + REL_MSE_OFFSET) / (WIDTH * WIDTH) as f64;
                Noisy {
                    mean: DVec3::splat(mean),
                    variance: DVec3::splat(0.25 * (a - b).powi(2)),
                    ..Noisy::default()
                }
            })
            .collect();
        (pixels, error)
    }

    /// Flat, sloped and edged pictures with normal noise: the estimate is the true error within 5 %, and 95 % of
    /// the intervals contain it (106 or less of 120 have a probability of 0.003).
    #[test]
    fn normal_noise_is_told_as_it_is() {
        type Truth = fn(usize, usize) -> f64;
        let truths: [(&str, Truth); 3] = [
            ("flat", |_, _| 0.5),
            ("slope", |x, y| 0.1 + 0.01 * (x + 2 * y) as f64),
            (
                "edges",
                |x, y| if (x / 12 + y / 9) % 2 == 0 { 0.2 } else { 1.5 },
            ),
        ];
        let mut inside = 0;
        for (name, truth) in truths {
            for deviation in [0.01, 0.05] {
                let (mut true_sum, mut told) = (0.0, 0.0);
                for key in 0..20 {
                    let (pixels, error) = picture(truth, deviation, 10 * key);
                    let (_, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
                    let estimate = sums.estimate().unwrap();
                    true_sum += error;
                    told += estimate.error.powi(2);
                    let range = estimate.low..=estimate.high;
                    inside += u32::from(range.contains(&error.sqrt()));
                }
                let ratio = (told / true_sum).sqrt();
                assert!((ratio - 1.0).abs() < 0.05, "{name} {deviation}: {ratio}");
            }
        }
        assert!(inside > 106, "{inside}");
    }

    /// A firefly is an error as large as itself, not one of 100 %, to the factor in the error to which its truth is
    /// known: neighbours of 0.5 and one of 10 in 25.
    #[test]
    fn a_firefly_is_told_as_large_as_it_is() {
        let (mut pixels, _) = picture(|_, _| 0.5, 0.01, 7);
        let spike = 400.0;
        pixels[40 * WIDTH + 30] = Noisy {
            mean: DVec3::splat(spike),
            variance: DVec3::splat(spike * spike),
            ..Noisy::default()
        };
        let (errors, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
        let expected = spike * spike / (0.25 + REL_MSE_OFFSET);
        let known = expected.sqrt() / f64::from(errors[40 * WIDTH + 30]).sqrt();
        assert!((1.0..1.8).contains(&known), "{known}");
        // It says nothing about its neighbours.
        let neighbour = f64::from(errors[40 * WIDTH + 31]);
        assert!((1e-6..0.01).contains(&neighbour), "{neighbour}");
        let whole = sums.estimate().unwrap();
        let expected = (expected / (WIDTH * WIDTH) as f64).sqrt() / known;
        assert!((whole.error / expected - 1.0).abs() < 0.01);
        // One pixel is all there is to go by.
        assert!(whole.high / whole.low > 4.0);
    }

    /// Bands with their neighbours' rows give what the whole gives.
    #[test]
    fn bands_are_parts_of_the_whole() {
        let (pixels, _) = picture(|x, y| 0.01 * (x + y) as f64, 0.03, 3);
        let (whole, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
        let (mut parts, mut joined) = (Vec::new(), ErrorSums::default());
        for (from, to) in [(0, 32), (32, 64), (64, WIDTH)] {
            let (above, below) = (from.min(REACH), (WIDTH - to).min(REACH));
            let rows = &pixels[(from - above) * WIDTH..(to + below) * WIDTH];
            let (errors, sums) = relative_errors(rows, WIDTH, above, to - from);
            parts.extend(errors);
            joined.join(&sums);
        }
        assert_eq!(parts, whole);
        let (a, b) = (joined.estimate().unwrap(), sums.estimate().unwrap());
        assert!((a.error / b.error - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_and_certainty_are_no_error() {
        assert_eq!(ErrorSums::default().estimate(), None);
        let black = vec![Noisy::default(); 30];
        let (errors, sums) = relative_errors(&black, 6, 0, 5);
        assert!(errors.iter().all(|&e| e == 0.0));
        let estimate = sums.estimate().unwrap();
        assert_eq!(
            (estimate.error, estimate.low, estimate.high),
            (0.0, 0.0, 0.0)
        );
    }

    #[test]
    fn pooling_is_a_mean_over_what_is_around() {
        let mut values = vec![0f32; 20 * 16];
        values[6 * 20 + 10] = 48.0;
        let pooled = |values: &[f32], width| super::pooled(values, width, 3);
        let means = pooled(&values, 20);
        let at = |x: usize, y: usize| means[y * 20 + x];
        assert_eq!([at(10, 6), at(13, 9), at(14, 6)], [0.0, 1.0, 0.0]);
        assert_eq!(pooled(&[3.0; 10], 5), [3.0; 10]);
        assert_eq!(pooled(&[3.0], 1), [3.0]);
    }

    /// A noisy half and a quiet one: each is told apart where all that share its target look into one of them alone, but
    /// for what the wide neighbourhood says. A firefly has no say in its own samples.
    #[test]
    fn samples_are_decided_near() {
        let side = 96;
        let mut errors: Vec<f32> = (0..side * side)
            .map(|i| if i % side < 48 { 1.0 } else { 0.0 })
            .collect();
        let at = |of: &[f32], x: usize| of[48 * side + x];
        let by_halves = deciding(&errors, side);
        assert!((at(&by_halves, 48 - NEAR - SHARED) - 1.0).abs() < 1e-6);
        let wide = pooled_of(Kind::Next, &errors, side, WIDE, DOUBTS);
        let beyond = at(&by_halves, 58);
        assert!(beyond > at(&wide, 58 + SHARED) && beyond < at(&wide, 58 - SHARED));
        assert_eq!(at(&by_halves, 48 + WIDE + SHARED), 0.0);
        errors[48 * side + 19] = 1000.0;
        let after = deciding(&errors, side);
        assert_eq!(at(&by_halves, 19), at(&after, 19));
        assert!(at(&after, 18) > at(&by_halves, 18));
    }

    /// One of the 16 pixels that these look at has all the error: a mean of 1 with a standard error of √15 / 4. Where all
    /// have the same, there is no doubt.
    #[test]
    fn a_mean_that_few_make_is_doubted() {
        let mut errors = vec![0f32; 64];
        errors[2 * 8 + 2] = 16.0;
        let with = |doubts| pooled_of(Kind::Next, &errors, 8, 8, doubts)[3 * 8 + 2];
        assert_eq!(with(0.0), 1.0);
        assert!((f64::from(with(2.0)) - (1.0 + 2.0 * 15f64.sqrt() / 4.0)).abs() < 1e-6);
        assert_eq!(pooled_of(Kind::Next, &[3.0; 64], 8, 8, 2.0), [3.0; 64]);
    }

    /// A pixel of 0.1 of which one half met a bright sample does not take that for its own light, nor is it taken
    /// for less than black.
    #[test]
    fn one_bright_sample_is_an_error() {
        let (a, b) = (8.1, 0.1);
        let pixel = Noisy {
            mean: DVec3::splat(0.5 * (a + b)),
            variance: DVec3::splat(0.25 * (a - b) * (a - b)),
            ..Noisy::default()
        };
        let expected = 16.0 / (b * b + REL_MSE_OFFSET);
        assert!((f64::from(pixel.own_error()) / expected - 1.0).abs() < 1e-6);
        let dark = Noisy {
            mean: DVec3::splat(0.01),
            variance: DVec3::splat(0.01),
            ..pixel
        };
        assert_eq!(dark.own_error(), 1.0);
    }

    /// Bands of one sample's errors 4 and 9, each as wide as a wide neighbourhood, with as many samples as they are told to
    /// have for a target of 1, come to a mean error of 1, but for what is given beyond need: the wide neighbourhood takes the bands
    /// of 4 for 6.5 at their edges, for 4 in their middle and so for 5.2 on average. That makes 4 / 5.2 of the error of
    /// half of the pixels: an eighth less of the whole.
    #[test]
    fn neighbours_share_a_target_at_least_cost() {
        let band = 2 * WIDE + 1;
        let side = 6 * band;
        let kind = |i: usize| (i % side / band).is_multiple_of(2);
        let errors: Vec<f32> = (0..side * side)
            .map(|i| if kind(i) { 4.0 } else { 9.0 })
            .collect();
        let wanted = deciding(&errors, side);
        let mut mean = 0.0;
        // Whole periods far from the ends, both kinds of columns.
        let columns = 2 * band..4 * band;
        for x in columns.clone() {
            for y in 60..62 {
                let i = y * side + x;
                mean += errors[i] / wanted[i] / (2 * columns.len()) as f32;
            }
        }
        assert!((0.875..=1.0).contains(&mean), "{mean}");
    }

    /// Each kind sees the next one alone, so that it takes four steps to come back.
    #[test]
    fn what_a_pixel_says_comes_back_after_four_steps() {
        let side = 64;
        let start = 30 * side + 30;
        let mut seen: Vec<f32> = vec![0.0; side * side];
        seen[start] = 1.0;
        for step in 1..=4 {
            seen = deciding(&seen, side);
            assert_eq!(seen[start] > 0.0, step == 4, "{step}");
        }
        let next = |values: &[f32], width| pooled_of(Kind::Next, values, width, 4, 1.0);
        assert_eq!(next(&[3.0; 35], 7), [3.0; 35]);
        assert_eq!(next(&[3.0], 1), [3.0]);
    }

    /// What lies beyond an edge of the features has no say.
    #[test]
    fn features_keep_sides_apart() {
        let (mut pixels, _) = picture(|x, _| if x < 48 { 0.05 } else { 5.0 }, 0.004, 5);
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let side = if i % WIDTH < 48 { 0.2 } else { 0.8 };
            pixel.features[0] = Vec3::splat(side);
        }
        // A spike of one half on the dark side, beside the edge.
        pixels[50 * WIDTH + 47] = Noisy {
            mean: DVec3::splat(2.0),
            variance: DVec3::splat(4.0),
            features: [Vec3::splat(0.2), Vec3::ZERO],
        };
        let (errors, _) = relative_errors(&pixels, WIDTH, 0, WIDTH);
        let (told, expected) = (
            f64::from(errors[50 * WIDTH + 47]),
            4.0 / (0.0025 + REL_MSE_OFFSET),
        );
        // Beside 0.05, its own share in the mean leaves a quarter of a doubt.
        assert!((0.4..1.1).contains(&(told / expected)), "{told} {expected}");
    }
}
