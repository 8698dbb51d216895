//! What each effect costs and gives: the picture with and without it.
//!
//! In each of several rounds the full picture and all pictures without something are rendered with a seed of
//! that round. Let Dᵢ be a pixel's difference in round i. Both pictures of a round draw the same random numbers, so
//! that where an effect changes nothing, their noise cancels; between rounds it is independent, so that the
//! products DᵢDⱼ, i ≠ j, have the expectation of the squared difference of what the pictures converge to: the
//! change without the noise of either. Negative sums are possible and mean that nothing was found.

use super::CostError;
use super::clock::Clock;
use super::pixels;
use super::variants::{Variant, Worth};
use crate::film::Picture;
use crate::render::{Observer, RenderSettings, Rendering, Stop, render};
use crate::scene::Scene;
use serde::Serialize;

/// Keeps errors finite where the picture is black, as in `measure`.
const OFFSET: f64 = 0.01;
/// 95 % of a normal distribution lie within so many standard deviations.
const DEVIATIONS: f64 = 1.959_963_985;
/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

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
    fn of_square(square: f64, deviation: f64) -> Self {
        let root = |x: f64| x.max(0.0).sqrt();
        Self {
            value: root(square),
            low: root(square - DEVIATIONS * deviation),
            high: root(square + DEVIATIONS * deviation),
        }
    }

    /// Whether it is more than noise.
    pub fn is_found(&self) -> bool {
        self.low > 0.0
    }
}

/// Work of a picture: medians over the rounds, for the full size and all samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Work {
    /// Seconds of tracing: processor time over the threads, where the system tells it.
    pub seconds: f64,
    /// Rays.
    pub rays: f64,
    /// Nanoseconds a ray (of all threads together).
    pub nanoseconds_per_ray: f64,
}

/// What an effect costs and gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectCost {
    /// What it is.
    pub effect: String,
    /// In a few words.
    pub about: String,
    /// What it is for.
    pub worth: Worth,
    /// Work of the picture without it.
    pub without: Work,
    /// Milliseconds that it costs a picture of the full size with all samples. Negative: it saves time.
    pub milliseconds: f64,
    /// Time with it over time without it, ratio of the medians over the rounds.
    pub time_ratio: f64,
    /// The smallest and the largest such ratio of a round.
    pub time_ratios: [f64; 2],
    /// How far the picture without it is from the full one, √relMSE, noise taken out.
    pub change: Share,
    /// Noise of the picture with all samples without it, as the render estimates it: against itself.
    pub noise_without: f64,
    /// Time to the noise of the full picture without it, over the time with it.
    pub time_to_equal_noise: Option<f64>,
    /// The error that it removes: the change, or what is for less noise, noise. Negative: it adds noise.
    pub error_removed: f64,
    /// Error that it removes for a second; `None` where it costs nothing.
    pub error_removed_per_second: Option<f64>,
}

/// All of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// Samples a pixel of the full picture.
    pub samples: u32,
    /// Size of the full picture.
    pub size: [u32; 2],
    /// Samples a pixel of the pictures that were measured.
    pub measured_samples: u32,
    /// Their size.
    pub measured_size: [u32; 2],
    /// Size of the region of them that was rendered.
    #[serde(skip)]
    pub measured_region: [u32; 2],
    /// Rounds of them.
    pub rounds: u32,
    /// Work of the full picture.
    pub full: Work,
    /// Noise of the full picture with all samples.
    pub noise: f64,
    /// Most error removed for a second first.
    pub effects: Vec<EffectCost>,
    /// RGB of the full picture, and of those without something, in the order of `effects`; means over the rounds.
    #[serde(skip)]
    pub pictures: Vec<Vec<f32>>,
}

/// One kind of picture over the rounds.
#[derive(Default)]
struct Rounds {
    seconds: Vec<f64>,
    rays: Vec<f64>,
    /// Squares of the errors that the renders say they have.
    squares: Vec<f64>,
    pictures: Vec<Vec<f32>>,
}

impl Rounds {
    fn add(&mut self, rendering: &Rendering, seconds: f64) {
        self.seconds.push(seconds);
        self.rays.push(rendering.statistics.rays as f64);
        let error = rendering.statistics.error.map_or(f64::NAN, |e| e.error);
        self.squares.push(error * error);
        self.pictures.push(colors(&rendering.picture));
    }

    /// relMSE of one of them by chance.
    fn noise_square(&self) -> f64 {
        self.squares.iter().sum::<f64>() / self.squares.len() as f64
    }

    /// All of them together.
    fn mean(&self) -> Vec<f32> {
        let values = self.pictures.first().map_or(0, Vec::len);
        let sum = |i: usize| self.pictures.iter().map(|p| f64::from(p[i])).sum::<f64>();
        let count = self.pictures.len() as f64;
        (0..values).map(|i| (sum(i) / count) as f32).collect()
    }

    /// For a picture of `scale` times the pixel samples.
    fn work(&self, scale: f64) -> Work {
        let (seconds, rays) = (median(&self.seconds), median(&self.rays));
        Work {
            seconds: seconds * scale,
            rays: rays * scale,
            nanoseconds_per_ray: if rays > 0.0 {
                NANOSECONDS * seconds / rays
            } else {
                0.0
            },
        }
    }
}

/// Red, green, blue of each pixel.
fn colors(picture: &Picture) -> Vec<f32> {
    let Some(layer) = picture.layers.first() else {
        return Vec::new();
    };
    layer
        .data
        .chunks_exact(layer.channels.len().max(1))
        .flat_map(|pixel| pixel.iter().take(3).copied())
        .collect()
}

/// Of an even number, the mean of the two in the middle.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// Renders all pictures and compares them. `measured` are settings of the pictures that are measured, of which
/// `variants` were made; `full` is what the numbers are for. `step` is told before each picture: how many are
/// done, of how many, and what the next one is without.
///
/// # Errors
/// A picture cannot be rendered, or the observer has said stop.
pub fn study(
    scene: &Scene,
    full: &RenderSettings,
    measured: &RenderSettings,
    variants: &[Variant],
    rounds: u32,
    observer: &dyn Observer,
    step: &dyn Fn(usize, usize, &str),
) -> Result<Study, CostError> {
    let all = rounds as usize * (variants.len() + 1);
    let mut done = 0;
    let mut with = Rounds::default();
    let mut without: Vec<Rounds> = variants.iter().map(|_| Rounds::default()).collect();
    for round in 0..rounds {
        let mut take = |settings: &RenderSettings, name: &str, into: &mut Rounds| {
            step(done, all, name);
            let settings = RenderSettings {
                seed: settings.seed.wrapping_add(round),
                ..settings.clone()
            };
            let clock = Clock::new(observer);
            let rendering = render(scene, &settings, &clock)?;
            let statistics = &rendering.statistics;
            if statistics.stop == Stop::Cancelled || observer.cancelled() {
                return Err(CostError::Cancelled);
            }
            let seconds = clock.seconds(statistics.trace, statistics.threads);
            into.add(&rendering, seconds);
            done += 1;
            Ok(())
        };
        take(measured, "", &mut with)?;
        for (variant, into) in variants.iter().zip(&mut without) {
            take(&variant.settings, &variant.name, into)?;
        }
    }
    let scale =
        pixels(full) * f64::from(full.samples) / (pixels(measured) * f64::from(measured.samples));
    let weights = weights(&with.pictures);
    let more_samples = f64::from(measured.samples) / f64::from(full.samples);
    // Independent samples: noise goes with 1/√n.
    let noise = |rounds: &Rounds| (rounds.noise_square() * more_samples).sqrt();
    let (work, full_noise) = (with.work(scale), noise(&with));
    let mut effects: Vec<(EffectCost, Vec<f32>)> = variants
        .iter()
        .zip(&without)
        .map(|(variant, rounds)| {
            let (square, deviation) = change_square(&with.pictures, &rounds.pictures, &weights);
            let cost = compared(
                variant,
                (&with, rounds),
                scale,
                Share::of_square(square, deviation),
                (full_noise, noise(rounds)),
            );
            (cost, rounds.mean())
        })
        .collect();
    effects.sort_by(|(a, _), (b, _)| {
        let order = rank(b).partial_cmp(&rank(a));
        order.unwrap_or(std::cmp::Ordering::Equal)
    });
    let (effects, less): (Vec<_>, Vec<_>) = effects.into_iter().unzip();
    let pictures = std::iter::once(with.mean()).chain(less).collect();
    Ok(Study {
        samples: full.samples,
        size: [full.width, full.height],
        measured_samples: measured.samples,
        measured_size: [measured.width, measured.height],
        measured_region: [measured.region().width(), measured.region().height()],
        rounds,
        full: work,
        noise: full_noise,
        effects,
        pictures,
    })
}

/// Puts together what is known of a picture without an effect.
fn compared(
    variant: &Variant,
    (with, without): (&Rounds, &Rounds),
    scale: f64,
    change: Share,
    (noise, noise_without): (f64, f64),
) -> EffectCost {
    let (full, less) = (with.work(scale), without.work(scale));
    let ratios = || {
        with.seconds
            .iter()
            .zip(&without.seconds)
            .map(|(a, b)| a / b)
    };
    let squares = noise_without.powi(2) - noise.powi(2);
    let error_removed = match variant.worth {
        Worth::Picture => change.value,
        Worth::Noise => squares.signum() * squares.abs().sqrt(),
    };
    let seconds = full.seconds - less.seconds;
    EffectCost {
        effect: variant.name.clone(),
        about: variant.about.clone(),
        worth: variant.worth,
        without: less,
        milliseconds: 1000.0 * seconds,
        time_ratio: full.seconds / less.seconds,
        time_ratios: [
            ratios().fold(f64::INFINITY, f64::min),
            ratios().fold(0.0, f64::max),
        ],
        change,
        noise_without,
        time_to_equal_noise: (noise > 0.0 && variant.worth == Worth::Noise)
            .then(|| (noise_without / noise).powi(2) * less.seconds / full.seconds),
        error_removed,
        error_removed_per_second: (seconds > 0.0).then(|| error_removed / seconds),
    }
}

/// Error removed for a second, as a number to sort by: what removes nothing that could be found last, what
/// costs nothing first.
fn rank(cost: &EffectCost) -> (bool, f64) {
    let found = match cost.worth {
        Worth::Picture => cost.change.is_found(),
        Worth::Noise => cost.error_removed > 0.0,
    };
    (
        found,
        cost.error_removed_per_second.unwrap_or(f64::INFINITY),
    )
}

/// What each value counts in relMSE: 1 over the square of the full picture, the mean over the rounds.
fn weights(pictures: &[Vec<f32>]) -> Vec<f64> {
    let values = pictures.first().map_or(0, Vec::len);
    (0..values)
        .map(|i| {
            let sum: f64 = pictures.iter().map(|picture| f64::from(picture[i])).sum();
            let mean = sum / pictures.len() as f64;
            1.0 / (mean * mean + OFFSET)
        })
        .collect()
}

/// relMSE of what one picture converges to against the other, and the standard deviation of the estimate.
///
/// Of n differences with the mean δ and the variance σ², the mean of the products of two has the variance
/// 4 δ² σ² / n + 2 σ⁴ / (n (n − 1)). The estimates stand for δ² and σ² here; those of σ⁴ are too large
/// on average (2 σ⁴ of three rounds), which errs to the safe side. Channels are noisy together, pixels are not.
fn change_square(with: &[Vec<f32>], without: &[Vec<f32>], weights: &[f64]) -> (f64, f64) {
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
                held += u32::from((square - truth).abs() < DEVIATIONS * deviation);
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

    #[test]
    fn medians() {
        assert!((median(&[3.0, 1.0, 2.0]) - 2.0).abs() < 1e-12);
        assert!((median(&[4.0, 1.0, 2.0, 3.0]) - 2.5).abs() < 1e-12);
        assert!(median(&[]).is_nan());
    }
}
