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
mod tests {
    use super::*;
    use crate::sampler::hashed;

    /// Times with a scatter of `spread` either way, evenly.
    fn times(mean: f64, spread: f64, key: u32) -> Vec<f64> {
        let at = |round| mean * (1.0 + spread * (2.0 * f64::from(hashed(key, round, 7)) - 1.0));
        (0..3).map(at).collect()
    }

    fn median(mut times: Vec<f64>) -> f64 {
        times.sort_by(f64::total_cmp);
        times[1]
    }

    /// Of 300 pairs that differ by 2 % with times that scatter by 5 %, evenly (deviation 0.029, of a ratio 0.041): the
    /// interval holds the truth in 95 % or, as the median of three numbers is nearer to their mean than √(π/2), more. A
    /// share of 0.95 has a deviation of 0.0126 in 300: 0.91 is three of them below.
    #[test]
    fn the_interval_of_a_cost_holds_it() {
        let pairs: Vec<_> = (0..300)
            .map(|i| (times(1.02, 0.05, 2 * i), times(1.0, 0.05, 2 * i + 1)))
            .collect();
        let scatter = Scatter::of(pairs.iter().map(|(a, b)| (&a[..], &b[..])));
        assert!((scatter.0 - 0.041).abs() < 0.003, "{scatter:?}");
        let (mut held, mut told) = (0, 0);
        for (with, without) in &pairs {
            let (with, without) = (median(with.clone()), median(without.clone()));
            let price = Price::new(with, without, 3, scatter);
            let [low, high] = price.milliseconds_interval;
            held += i32::from((low..=high).contains(&(1000.0 * with * (1.0 - 1.0 / 1.02))));
            told += i32::from(price.per_second(0.1).is_some());
        }
        assert!((273..=300).contains(&held), "{held}");
        // 0.02 of a deviation of 0.041 / √3 and the width above: 0.7 of what is called certain.
        assert!(told < 90, "{told}");
    }

    #[test]
    fn what_costs_nothing_has_no_rate() {
        let scatter = Scatter::of([(&[1.0, 1.01, 0.99][..], &[1.0; 3][..])].into_iter());
        let clear = Price::new(2.0, 1.0, 3, scatter);
        assert!(
            clear
                .per_second(0.5)
                .is_some_and(|rate| (rate - 0.5).abs() < 1e-12)
        );
        assert!(
            clear
                .per_second_at_least(0.5)
                .is_some_and(|rate| rate > 0.48 && rate < 0.5)
        );
        let doubtful = Price::new(1.001, 1.0, 3, scatter);
        assert_eq!(doubtful.per_second(0.5), None);
        assert!(
            doubtful
                .per_second_at_least(0.5)
                .is_some_and(|rate| rate < 50.0)
        );
        let saves = Price::new(1.0, 2.0, 3, scatter);
        assert_eq!(
            (saves.per_second(0.5), saves.per_second_at_least(0.5)),
            (None, None)
        );
    }
}
