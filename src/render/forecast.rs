//! What more samples will bring: error and time ahead, from the passes so far.
//!
//! Independent samples have a squared error of c·n⁻¹. Points of a net do better where a pixel's value hangs on
//! one pair of dimensions: n^-3/2 where there are edges (Mitchell, *Consequences of Stratified Sampling in
//! Graphics*, SIGGRAPH 1996); what hangs on several pairs stays at n⁻¹, for the pairs are independent of each
//! other ([`crate::sampler`]). So a picture's squared error is A/n + B·n^-3/2, more or less: a power law
//! c·n^-p locally, whose exponent lies between 1 and 3/2 and comes nearer to 1 by 1/√2 a doubling. Estimates that
//! have not met the brightest paths yet grow with them, which looks like an exponent below 1.
//! That is the prior: p = 1 with a standard deviation of [`PRIOR_SPREAD`], so that the net's best case is two of
//! them away; and beyond the last pass, p − 1 fades as above.
//!
//! The fit is least squares of ln(error²) over the passes of the last [`WINDOW`]: estimates after n and after
//! m > n samples share samples; of a mean over the first n and of one over the first m, the correlation
//! is √(n/m), which makes the errors of the estimates a chain (AR(1) in ln n) that is whitened link by link. None
//! counts as more certain than a later one: what has not met the brightest paths knows too little to say how little.
//! Those whose interval lies below that of a later one have not met what that one has, and have no say. Where
//! estimates scatter more than their intervals allow all the same, all intervals are widened until
//! they do (Birge, *The Calculation of Errors by the Method of Least Squares*, 1932).

use crate::math::float::TWO_SIDED_95;
use glam::DVec2;
use serde::Serialize;

/// Two standard deviations of the exponent reach from independent samples (1) to a net's best case (3/2).
const PRIOR_SPREAD: f64 = 0.25;
/// Passes with less than the last one's samples over this have no say: the exponent of long ago is another one.
const WINDOW: f64 = 16.0;
/// Before this, an estimate has a sample or less from each replicate.
const LEAST_SAMPLES: f64 = 4.0;
/// Forecasts end at so many times the samples there are (2^60 is beyond any render).
const HORIZON: f64 = 1.152_921_504_606_847e18;
/// Rows of a table: one that is reached or nearly so, and those ahead.
const ROWS: i32 = 5;

/// What is known after a whole pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Known {
    /// Samples a pixel, the mean over the picture.
    pub samples: f64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Rays.
    pub rays: u64,
    /// Estimated error of the picture, √relMSE.
    pub error: f64,
    /// Lower end of the estimate's 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl From<&super::Passed> for Known {
    fn from(passed: &super::Passed) -> Self {
        let [error, low, high] = match passed.error {
            Some(e) => [e.error, e.low, e.high],
            None => [f64::NAN; 3],
        };
        Self {
            samples: passed.samples,
            seconds: passed.seconds,
            rays: passed.rays,
            error,
            low,
            high,
        }
    }
}

/// A number that is not certain: what is expected, and a 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// The best guess.
    pub expected: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Expected {
    /// `45 s (38 s to 53 s)`.
    pub fn words(&self, show: impl Fn(f64) -> String) -> String {
        let [expected, low, high] = [self.expected, self.low, self.high].map(show);
        format!("{expected} ({low} to {high})")
    }

    pub(super) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            expected: f(self.expected),
            low: f(self.low),
            high: f(self.high),
        }
    }
}

/// What an error costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForecastRow {
    /// The error, √relMSE.
    pub error: f64,
    /// The picture has it already.
    pub reached: bool,
    /// Samples a pixel.
    pub samples: Expected,
    /// Seconds of tracing from the first sample on.
    pub seconds: Expected,
    /// Rays.
    pub rays: Expected,
}

/// Error and time ahead.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    passes: Vec<Known>,
    last: Known,
    /// ln(error²) at the last pass.
    level: f64,
    /// The exponent above 1 at the last pass.
    excess: f64,
    /// Covariance of the two.
    covariance: [[f64; 2]; 2],
    /// Standard deviation of one estimate of ln(error²).
    scatter: f64,
    /// Seconds a sample of every pixel, from here on.
    rate: f64,
    /// Relative standard deviation of it.
    rate_spread: f64,
    /// Rays for a sample of every pixel.
    rays: f64,
}

impl Forecast {
    /// From the passes so far, in their order; `None` before there is an estimate of an
    /// error above 0 and a time.
    pub fn of(passes: &[Known]) -> Option<Self> {
        let known: Vec<Known> = passes.iter().copied().filter(is_known).collect();
        let last = *known.last()?;
        let octaves = octaves(&known);
        let fit = Fit::of(&octaves, last.samples);
        let (rate, rate_spread) = rate(passes)?;
        Some(Self {
            last,
            level: fit.level,
            excess: fit.excess,
            covariance: fit.covariance,
            scatter: fit.scatter,
            rate,
            rate_spread,
            rays: last.rays as f64 / last.samples,
            passes: known,
        })
    }

    /// The last pass that it knows of.
    pub fn last(&self) -> Known {
        self.last
    }

    /// The exponent p of error² ∝ n^-p at the last pass.
    pub fn exponent(&self) -> Expected {
        let deviation = TWO_SIDED_95 * self.covariance[1][1].sqrt();
        let p = 1.0 + self.excess;
        Expected {
            expected: p,
            low: p - deviation,
            high: p + deviation,
        }
    }

    /// Seconds for a sample of every pixel.
    pub fn seconds_per_sample(&self) -> Expected {
        let spread = (TWO_SIDED_95 * self.rate_spread).exp();
        Expected {
            expected: self.rate,
            low: self.rate / spread,
            high: self.rate * spread,
        }
    }

    /// Rays for a sample of every pixel.
    pub fn rays_per_sample(&self) -> f64 {
        self.rays
    }

    /// ln(error²) and its standard deviation when there are e^`ahead` times the samples of the last pass.
    fn log_square(&self, ahead: f64) -> (f64, f64) {
        let u = ahead.max(0.0);
        // p − 1 fades by e^(−u/2): its integral.
        let g = 2.0 * (1.0 - (-u / 2.0).exp());
        let [[v, c], [_, w]] = self.covariance;
        // The picture that there will be has an error of its own about the expected one: what the samples
        // to come add to the chain.
        let own = self.scatter.powi(2) * (1.0 - (-u).exp());
        let variance = v - 2.0 * g * c + g * g * w + own;
        (self.level - u - self.excess * g, variance.max(0.0).sqrt())
    }

    /// The error after so many samples a pixel, not fewer than there are.
    pub fn error_at(&self, samples: f64) -> Expected {
        self.error_ahead((samples / self.last.samples).ln(), 0.0)
    }

    /// The error after so many seconds of tracing, not fewer than were spent.
    pub fn error_after(&self, seconds: f64) -> Expected {
        let more = (seconds - self.last.seconds).max(0.0) / self.rate;
        let samples = self.last.samples + more;
        let ahead = (samples / self.last.samples).ln();
        // Where all is still to come, the uncertainty of the rate is one of the samples.
        self.error_ahead(ahead, self.rate_spread * more / samples)
    }

    fn error_ahead(&self, ahead: f64, spread_of_samples: f64) -> Expected {
        let (log_square, deviation) = self.log_square(ahead);
        let deviation = DVec2::new(deviation, spread_of_samples).length();
        let at = |deviations: f64| (0.5 * (log_square + deviations * deviation)).exp();
        Expected {
            expected: at(0.0),
            low: at(-TWO_SIDED_95),
            high: at(TWO_SIDED_95),
        }
    }

    /// How far ahead (ln of the factor of samples) ln(error²) plus so many deviations falls to a goal; 0 where it is
    /// there already.
    fn ahead(&self, log_goal: f64, deviations: f64) -> f64 {
        let above = |u: f64| {
            let (log_square, deviation) = self.log_square(u);
            log_square + deviations * deviation > log_goal
        };
        let (mut near, mut far) = (0.0, HORIZON.ln());
        if !above(near) {
            return near;
        }
        // 2⁻⁶⁰ of the horizon: below the last digit of what comes out.
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if above(middle) {
                near = middle;
            } else {
                far = middle;
            }
        }
        far
    }

    /// Samples and seconds until the error is `goal` (√relMSE, above 0).
    pub fn row(&self, goal: f64) -> ForecastRow {
        let log_goal = 2.0 * goal.ln();
        let now = self.last.samples;
        let ahead = |deviations: f64| now * self.ahead(log_goal, deviations).exp();
        let (expected, low, high) = (ahead(0.0), ahead(-TWO_SIDED_95), ahead(TWO_SIDED_95));
        let reached = expected <= now;
        let samples = Expected {
            expected: if reached {
                self.was(goal, |p| p.error)
            } else {
                expected
            },
            low: if low <= now {
                self.was(goal, |p| p.low)
            } else {
                low
            },
            high: if high <= now {
                self.was(goal, |p| p.high)
            } else {
                high
            },
        };
        // Of estimates that jump, the order is not given.
        let samples = Expected {
            low: samples.low.min(samples.expected),
            high: samples.high.max(samples.expected),
            ..samples
        };
        ForecastRow {
            error: goal,
            reached,
            samples,
            seconds: self.seconds(samples),
            rays: samples.map(|n| n * self.rays),
        }
    }

    /// Seconds until the error is `goal`, counted from the first sample.
    pub fn seconds_to(&self, goal: f64) -> Expected {
        self.row(goal).seconds
    }

    /// After how many samples what `of` takes from the passes fell to a goal for good.
    fn was(&self, goal: f64, of: impl Fn(&Known) -> f64) -> f64 {
        let Some(above) = self.passes.iter().rposition(|p| of(p) > goal) else {
            return self.passes[0].samples;
        };
        let before = &self.passes[above];
        let Some(after) = self.passes.get(above + 1) else {
            return before.samples;
        };
        let (n, m) = (before.samples, after.samples);
        let share = (of(before) / goal).ln() / (of(before) / of(after)).ln();
        n * (m / n).powf(share.clamp(0.0, 1.0))
    }

    /// The seconds of tracing that so many samples a pixel take.
    pub fn seconds_at(&self, samples: f64) -> Expected {
        self.seconds(Expected {
            expected: samples,
            low: samples,
            high: samples,
        })
    }

    /// The seconds that samples take.
    fn seconds(&self, samples: Expected) -> Expected {
        let expected = self.seconds_for(samples.expected);
        let now = self.last.samples;
        let spread = (TWO_SIDED_95 * self.rate_spread).exp();
        let by_rate = (samples.expected - now).max(0.0) * self.rate;
        let below = DVec2::new(
            expected - self.seconds_for(samples.low),
            by_rate * (1.0 - 1.0 / spread),
        )
        .length();
        let above = DVec2::new(
            self.seconds_for(samples.high) - expected,
            by_rate * (spread - 1.0),
        )
        .length();
        Expected {
            expected,
            // What was spent is certain.
            low: (expected - below).max(expected.min(self.seconds_for(samples.low.min(now)))),
            high: expected + above,
        }
    }

    fn seconds_for(&self, samples: f64) -> f64 {
        let now = self.last.samples;
        if samples >= now {
            return self.last.seconds + (samples - now) * self.rate;
        }
        let after = self.passes.iter().position(|p| p.samples >= samples);
        let (before, after) = match after {
            Some(0) | None => ((0.0, 0.0), &self.passes[0]),
            Some(i) => {
                let before = &self.passes[i - 1];
                ((before.samples, before.seconds), &self.passes[i])
            }
        };
        let share = (samples - before.0) / (after.samples - before.0);
        before.1 + share.clamp(0.0, 1.0) * (after.seconds - before.1)
    }

    /// The errors that follow each other by halves (…, 8 %, 4 %, 2 %, 1 %, …) from the one that the picture has
    /// or nearly has.
    pub fn table(&self) -> Vec<ForecastRow> {
        let now = self.error_at(self.last.samples).expected;
        let first = (100.0 * now).log2().ceil() as i32;
        (0..ROWS)
            .map(|row| self.row(0.01 * 2f64.powi(first - row)))
            .collect()
    }
}

/// Whether a pass has an estimate that can be fitted.
fn is_known(pass: &Known) -> bool {
    pass.samples > 0.0
        && pass.error > 0.0
        && pass.error.is_finite()
        && pass.high.is_finite()
        && pass.high >= pass.error
        && pass.low <= pass.error
}

/// Standard deviation of ln(error²) by the interval of the error.
fn deviation(pass: &Known) -> f64 {
    let above = (pass.high / pass.error).ln();
    // An interval that reaches down to nothing says nothing of the lower side.
    let below = if pass.low > 0.0 {
        (pass.error / pass.low).ln()
    } else {
        above
    };
    (above + below) / TWO_SIDED_95
}

/// The last pass, the last one with not more than half its samples, and so on within the window; not beyond one whose
/// interval lies below one taken so far.
fn octaves(passes: &[Known]) -> Vec<Known> {
    let last = passes.last().map_or(0.0, |pass| pass.samples);
    let mut taken: Vec<Known> = Vec::new();
    for pass in passes.iter().rev() {
        let too_few = !taken.is_empty() && pass.samples < LEAST_SAMPLES;
        let surpassed = taken.iter().any(|later| pass.high < later.low);
        if pass.samples * WINDOW < last || too_few || surpassed {
            break;
        }
        let halved = |later: &Known| 2.0 * pass.samples <= later.samples;
        if taken.last().is_none_or(halved) {
            taken.push(*pass);
        }
    }
    taken.reverse();
    taken
}

/// Seconds a sample of the passes within the window, and the relative standard deviation of a pass's about
/// it: a machine that others use goes on being used.
fn rate(passes: &[Known]) -> Option<(f64, f64)> {
    let last = passes.last().map_or(1.0, |pass| pass.samples);
    let zero = Known {
        samples: 0.0,
        seconds: 0.0,
        rays: 0,
        error: f64::NAN,
        low: f64::NAN,
        high: f64::NAN,
    };
    let mut before = zero;
    let mut steps = Vec::new();
    for pass in passes {
        if pass.samples > before.samples {
            steps.push((
                pass.samples - before.samples,
                pass.seconds - before.seconds,
                pass.samples,
            ));
        }
        before = *pass;
    }
    steps.retain(|(.., end)| *end * WINDOW >= last);
    let samples: f64 = steps.iter().map(|(n, ..)| n).sum();
    let seconds: f64 = steps.iter().map(|(_, s, _)| s).sum();
    if samples <= 0.0 || seconds <= 0.0 {
        return None;
    }
    let rate = seconds / samples;
    let variance: f64 = steps
        .iter()
        .map(|(n, s, _)| n / samples * (s / n / rate - 1.0).powi(2))
        .sum();
    Some((rate, variance.sqrt()))
}

/// Level and exponent, by weighted least squares with the prior.
struct Fit {
    level: f64,
    excess: f64,
    covariance: [[f64; 2]; 2],
    /// Standard deviation of an estimate of ln(error²).
    scatter: f64,
}

impl Fit {
    /// From passes in their order; `now` is the last one's number of samples.
    fn of(passes: &[Known], now: f64) -> Self {
        // Estimates that claim to be exact are as good as the numbers they are made of.
        let least = f64::from(f32::EPSILON);
        let mut deviations: Vec<f64> = passes.iter().rev().map(deviation).collect();
        for i in 0..deviations.len() {
            deviations[i] = deviations[i].max(if i > 0 { deviations[i - 1] } else { least });
        }
        deviations.reverse();
        // Rows (1, −u) · (level, excess) = ln(error²) + u, with u = ln(n / now), each whitened.
        let mut rows: Vec<[f64; 3]> = Vec::new();
        let mut before: Option<(f64, [f64; 3])> = None;
        for (pass, deviation) in passes.iter().zip(&deviations) {
            let u = (pass.samples / now).ln();
            let row = [1.0, -u, 2.0 * pass.error.ln() + u].map(|x| x / deviation);
            rows.push(match before {
                None => row,
                Some((m, previous)) => {
                    let correlation = (m / pass.samples).sqrt();
                    let rest = (1.0 - correlation * correlation).sqrt();
                    std::array::from_fn(|i| (row[i] - correlation * previous[i]) / rest)
                }
            });
            before = Some((pass.samples, row));
        }
        let last = deviations.last().copied().unwrap_or(least);
        let first = Self::solve(&rows, 1.0, last);
        let chi_square: f64 = rows
            .iter()
            .map(|r| (r[2] - r[0] * first.level - r[1] * first.excess).powi(2))
            .sum::<f64>()
            + (first.excess / PRIOR_SPREAD).powi(2);
        // As many rows (the prior is one more) as there are degrees of freedom above the two unknowns.
        let freedom = rows.len() as f64 + 1.0 - 2.0;
        if freedom > 0.0 && chi_square > freedom {
            return Self::solve(&rows, (chi_square / freedom).sqrt(), last);
        }
        first
    }

    /// Least squares where all deviations are multiplied by `scale`; `last` is the last pass's.
    fn solve(rows: &[[f64; 3]], scale: f64, last: f64) -> Self {
        let weight = 1.0 / (scale * scale);
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 1.0 / (PRIOR_SPREAD * PRIOR_SPREAD));
        let (mut ay, mut by) = (0.0, 0.0);
        for [a, b, y] in rows {
            aa += weight * a * a;
            ab += weight * a * b;
            bb += weight * b * b;
            ay += weight * a * y;
            by += weight * b * y;
        }
        let determinant = aa * bb - ab * ab;
        Self {
            level: (bb * ay - ab * by) / determinant,
            excess: (aa * by - ab * ay) / determinant,
            covariance: [
                [bb / determinant, -ab / determinant],
                [-ab / determinant, aa / determinant],
            ],
            scatter: scale * last,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/render/forecast.rs"]
mod tests;
