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
#[path = "../../tests/unit/cost/change.rs"]
mod tests;
