//! What of a difference of two times is more than the scatter of times.

use crate::math::float::TWO_SIDED_95;
use serde::Serialize;

/// The standard deviation of a median of normal numbers is larger than that of their mean by √(π/2), or less if they are few.
const OF_A_MEDIAN: f64 = 1.253_314_137;

/// How much the ratio of two times of one round is by chance: the standard deviation of its logarithm.
#[derive(Clone, Copy, Debug)]
pub struct Scatter(f64);

impl Scatter {
    /// From the ratios of all rounds, for several pairs of pictures: what differs between rounds of a pair is
    /// chance, and all pairs are taken together, as one alone has two degrees of freedom in three rounds.
    pub fn of<'a>(pairs: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> Self {
        let (mut squares, mut freedom) = (0.0, 0usize);
        for (with, without) in pairs {
            let logs: Vec<f64> = with
                .iter()
                .zip(without)
                .map(|(a, b)| (a / b).ln())
                .filter(|log| log.is_finite())
                .collect();
            let mean = logs.iter().sum::<f64>() / logs.len() as f64;
            squares += logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>();
            freedom += logs.len().saturating_sub(1);
        }
        Self((squares / freedom.max(1) as f64).sqrt())
    }
}

/// What something costs in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Price {
    /// Milliseconds: the time with it less the time without it. Negative: it saves time.
    pub milliseconds: f64,
    /// Ends of the 95 % interval of that, by the scatter of all times that were taken.
    pub milliseconds_interval: [f64; 2],
}

impl Price {
    /// Of the seconds with it and without it, medians of so many rounds.
    pub fn new(with: f64, without: f64, rounds: usize, scatter: Scatter) -> Self {
        let reach = TWO_SIDED_95 * OF_A_MEDIAN * scatter.0 / (rounds as f64).sqrt();
        let at = |log: f64| 1000.0 * with * (1.0 - (-log).exp());
        let log = (with / without).ln();
        Self {
            milliseconds: 1000.0 * (with - without),
            milliseconds_interval: [at(log - reach), at(log + reach)],
        }
    }

    /// What is had for a second of it; `None` where it is not told from none.
    pub fn per_second(&self, had: f64) -> Option<f64> {
        (self.milliseconds_interval[0] > 0.0).then(|| 1000.0 * had / self.milliseconds)
    }

    /// What is had for a second of it if it costs as much as it may; `None` where it costs nothing.
    pub fn per_second_at_least(&self, had: f64) -> Option<f64> {
        let most = self.milliseconds_interval[1];
        (most > 0.0).then(|| 1000.0 * had / most)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/cost/price.rs"]
mod tests;
