//! SSIM: Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity".
//!
//! As scikit-image computes it with `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1,
//! channel_axis=2` (which it names as the paper's own): a Gaussian window of 11 × 11 pixels, K₁ = 0.01, K₂ = 0.03, the mean
//! over the pixels whose window lies within the picture and over the channels.

use rayon::prelude::*;

/// Reach of the window: 3.5 standard deviations of 1.5 pixels, rounded.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
/// (K L)² for values of 0..=1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;
/// Rows that one piece of work covers.
const BAND: usize = 64;

/// The mean structural similarity of two pictures of display values; none if no window fits in. All sums are in f64:
/// variances are differences of squares.
pub fn ssim(
    width: usize,
    height: usize,
    pixels: &(impl Fn(usize) -> [[f32; 3]; 2] + Sync),
) -> Option<f64> {
    let (across, down) = (
        width.checked_sub(2 * RADIUS)?,
        height.checked_sub(2 * RADIUS)?,
    );
    if across == 0 || down == 0 {
        return None;
    }
    let window = window();
    let sums: Vec<f64> = (0..down.div_ceil(BAND))
        .into_par_iter()
        .map(|band| {
            let rows = band * BAND..((band + 1) * BAND).min(down);
            (0..3)
                .map(|channel| {
                    let value = |x: usize, y: usize| {
                        pixels(y * width + x).map(|pixel| f64::from(pixel[channel]))
                    };
                    band_sum(across, rows.clone(), &window, &value)
                })
                .sum()
        })
        .collect();
    Some(sums.iter().sum::<f64>() / (3 * across * down) as f64)
}

fn window() -> [f64; 2 * RADIUS + 1] {
    let weights: [f64; 2 * RADIUS + 1] = std::array::from_fn(|i| {
        let x = i as f64 - RADIUS as f64;
        (-0.5 * x * x / (SIGMA * SIGMA)).exp()
    });
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

/// The sum of the similarities of some rows of windows, of one channel.
fn band_sum(
    across: usize,
    rows: std::ops::Range<usize>,
    window: &[f64],
    value: &impl Fn(usize, usize) -> [f64; 2],
) -> f64 {
    // The weighted means of a, b, a², b² and ab along each row.
    let mut along: [Vec<f64>; 5] =
        std::array::from_fn(|_| vec![0.0; across * (rows.len() + 2 * RADIUS)]);
    let mut row: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; across + 2 * RADIUS]);
    for (index, y) in (rows.start..rows.end + 2 * RADIUS).enumerate() {
        for x in 0..across + 2 * RADIUS {
            let [a, b] = value(x, y);
            for (row, moment) in row.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                row[x] = moment;
            }
        }
        for (along, row) in along.iter_mut().zip(&row) {
            let along = &mut along[index * across..][..across];
            for (tap, weight) in window.iter().enumerate() {
                add(along, &row[tap..], *weight);
            }
        }
    }
    let mut means: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; across]);
    let mut sum = 0.0;
    for index in 0..rows.len() {
        for (mean, along) in means.iter_mut().zip(&along) {
            mean.fill(0.0);
            for (tap, weight) in window.iter().enumerate() {
                add(mean, &along[(index + tap) * across..], *weight);
            }
        }
        sum += (0..across)
            .map(|x| similarity(std::array::from_fn(|moment| means[moment][x])))
            .sum::<f64>();
    }
    sum
}

fn add(out: &mut [f64], source: &[f64], weight: f64) {
    for (out, source) in out.iter_mut().zip(source) {
        *out += weight * source;
    }
}

/// Equation 13 of the paper.
fn similarity([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    (2.0 * a * b + C1) * (2.0 * covariance + C2)
        / ((a * a + b * b + C1) * (variance_a + variance_b + C2))
}

#[cfg(test)]
#[path = "../../tests/unit/measure/ssim.rs"]
mod tests;
