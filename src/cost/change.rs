//! How far two kinds of pictures are from each other, without the noise of either.

use crate::math::float::{REL_MSE_OFFSET, TWO_SIDED_95};
use serde::Serialize;

/// √relMSE that is known up to its noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// The estimate; 0 where its square came out below 0.
    pub value: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Share {
    /// From the estimate of its square and that one's standard deviation.
    pub(super) fn of_square(square: f64, deviation: f64) -> Self {
        let root = |x: f64| x.max(0.0).sqrt();
        Self {
            value: root(square),
            low: root(square - TWO_SIDED_95 * deviation),
            high: root(square + TWO_SIDED_95 * deviation),
        }
    }

    /// Whether it is more than noise.
    pub fn is_found(&self) -> bool {
        self.low > 0.0
    }
}

/// What each value counts in relMSE: 1 over the square of the full picture, the mean over the rounds.
pub(super) fn weights(pictures: &[Vec<f32>]) -> Vec<f64> {
    let values = pictures.first().map_or(0, Vec::len);
    (0..values)
        .map(|i| {
            let sum: f64 = pictures.iter().map(|picture| f64::from(picture[i])).sum();
            let mean = sum / pictures.len() as f64;
            1.0 / (mean * mean + REL_MSE_OFFSET)
        })
        .collect()
}

/// relMSE of what one picture converges to against the other, and the standard deviation of the estimate.
///
/// Of n differences with the mean δ and the variance σ², the mean of the products of two has the variance
/// 4 δ² σ² / n + 2 σ⁴ / (n (n − 1)). The estimates stand for δ² and σ² here; those of σ⁴ are too large
/// on average (2 σ⁴ of three rounds), which errs to the safe side. Channels are noisy together, pixels are not.
pub(super) fn change_square(
    with: &[Vec<f32>],
    without: &[Vec<f32>],
    weights: &[f64],
) -> (f64, f64) {
    let n = with.len() as f64;
    let (mut sum, mut variance) = (0.0, 0.0);
    for (pixel, weights) in weights.chunks_exact(3).enumerate() {
        let mut deviation = 0.0;
        for (channel, weight) in weights.iter().enumerate() {
            let i = 3 * pixel + channel;
            let (mut total, mut own) = (0.0, 0.0);
            for (a, b) in with.iter().zip(without) {
                let difference = f64::from(b[i]) - f64::from(a[i]);
                total += difference;
                own += difference * difference;
            }
            let square = (total * total - own) / (n * (n - 1.0));
            let scatter = ((own - total * total / n) / (n - 1.0)).max(0.0);
            let of_square =
                4.0 * square.max(0.0) * scatter / n + 2.0 * scatter * scatter / (n * (n - 1.0));
            sum += weight * square;
            deviation += weight * of_square.sqrt();
        }
        variance += deviation * deviation;
    }
    let values = weights.len() as f64;
    (sum / values, variance.sqrt() / values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hashed;

    /// Pictures of one value in each pixel with noise of the standard deviation √(1/12) (uniform numbers).
    fn pictures(value: f32, seed: u32) -> Vec<Vec<f32>> {
        (0..3)
            .map(|round| {
                (0..3 * 4000)
                    .map(|i| value - 0.5 + hashed(seed, round, i))
                    .collect()
            })
            .collect()
    }

    /// Differences of independent pictures: their noise is 1/6 in the square, the change that is looked for 0, 1/10
    /// or 1/2. The interval holds it in 95 of 100 trials; of 100 trials that is 95 ± 2.2, so at least 86. It is
    /// not much too wide either: more than half as long again would make that 99.7, and more.
    #[test]
    fn a_change_is_found_below_its_noise() {
        for (change, seed) in [(0.0f32, 0), (0.1, 1000), (0.5, 2000)] {
            let truth = f64::from(change) * f64::from(change);
            let (mut held, mut sum, mut spread) = (0, 0.0, 0.0);
            for trial in 0..100 {
                let with = pictures(1.0, seed + 2 * trial);
                let without = pictures(1.0 + change, seed + 2 * trial + 1);
                let flat = vec![1.0; with[0].len()];
                let (square, deviation) = change_square(&with, &without, &flat);
                held += u32::from((square - truth).abs() < TWO_SIDED_95 * deviation);
                sum += square / 100.0;
                spread += deviation / 100.0;
            }
            assert!(held >= 86, "{change}: {held}");
            // The mean of 100 trials: without bias.
            assert!(
                (sum - truth).abs() < 0.4 * spread,
                "{change}: {sum} {spread}"
            );
            assert!(spread < 0.01, "{spread}");
        }
    }

    #[test]
    fn weights_are_those_of_rel_mse() {
        let weights = weights(&[vec![2.0; 3], vec![4.0; 3]]);
        assert!((weights[0] - 1.0 / 9.01).abs() < 1e-12);
    }
}
