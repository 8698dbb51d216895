//! What each effect costs and gives: the picture with and without it.
//!
//! In each of several rounds the full picture and all pictures without something are rendered with a seed of
//! that round. Let Dᵢ be a pixel's difference in round i. Both pictures of a round draw the same random numbers, so
//! that where an effect changes nothing, their noise cancels; between rounds it is independent, so that the
//! products DᵢDⱼ, i ≠ j, have the expectation of the squared difference of what the pictures converge to: the
//! change without the noise of either. Negative sums are possible and mean that nothing was found.

use super::CostError;
use super::adaptive::{self, Evened};
use super::change::{Share, change_square, weights};
use super::clock::Clock;
use super::price::{Price, Scatter};
use super::variants::{Variant, Worth};
use super::{pixels, reduced};
use crate::film::Picture;
use crate::render::{Observer, RenderSettings, Rendering, Stop, render};
use crate::scene::{Effect, Scene};
use serde::Serialize;
use std::time::Duration;

/// Samples of the picture that tells how many samples the others may have.
const PILOT_SAMPLES: u32 = 8;

/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

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
    /// Rays that the full picture takes with it, over those without it.
    pub rays_ratio: f64,
    /// What it costs a picture of the full size with all samples.
    #[serde(flatten)]
    pub price: Price,
    /// Time with it over time without it, ratio of the medians over the rounds.
    pub time_ratio: f64,
    /// The smallest and the largest such ratio of a round.
    pub time_ratios: [f64; 2],
    /// How far the picture without it is from the full one, √relMSE, noise taken out.
    pub change: Share,
    /// Noise of the picture with all samples without it, as the render estimates it: against itself.
    pub noise_without: f64,
    /// Time to the noise of the full picture without it, over the time with it. Of adaptive sampling: to the error of
    /// its worst tile.
    pub time_to_equal_noise: Option<f64>,
    /// The error that it removes: the change, or what is for less noise, noise. Negative: it adds noise.
    pub error_removed: f64,
    /// Error that it removes for a second; `None` where what it costs is not told from nothing.
    pub error_removed_per_second: Option<f64>,
    /// The same if it costs as much as it may by the interval of its price; `None` where it costs nothing.
    pub error_removed_per_second_at_least: Option<f64>,
    /// Of adaptive sampling alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evened: Option<Evened>,
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

/// Settings of the pictures that are measured: small ones, with as many samples as fit into a time.
///
/// # Errors
/// The scene cannot be rendered, or the observer has said stop.
pub fn measured_settings(
    scene: &Scene,
    full: &RenderSettings,
    longer_side: u32,
    time: Duration,
    observer: &dyn Observer,
) -> Result<RenderSettings, CostError> {
    let small = RenderSettings {
        // All samples of all pixels; what adaptive sampling does is measured apart.
        error_target: 0.0,
        pixel_error_target: 0.0,
        noise_threshold: None,
        ..reduced(full, longer_side)
    };
    let pilot = RenderSettings {
        samples: PILOT_SAMPLES.min(small.samples),
        ..small.clone()
    };
    let clock = Clock::new(observer);
    let statistics = render(scene, &pilot, &clock)?.statistics;
    if observer.cancelled() {
        return Err(CostError::Cancelled);
    }
    let seconds = clock.seconds(statistics.trace, statistics.threads);
    let a_sample = seconds / f64::from(statistics.samples.max(1));
    // `as` saturates; powers of two are where the points of a pixel are most even.
    let fit = (time.as_secs_f64() / a_sample) as u32;
    let samples = 1 << fit.clamp(PILOT_SAMPLES, 1 << 20).ilog2();
    Ok(RenderSettings {
        samples: samples.min(small.samples),
        ..small
    })
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

    /// √relMSE of one of them by chance.
    fn noise(&self) -> f64 {
        (self.squares.iter().sum::<f64>() / self.squares.len() as f64).sqrt()
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
    let mut taking = Taking {
        scene,
        observer,
        step,
        done: 0,
        all: rounds as usize * (variants.len() + 3),
    };
    let mut with = Rounds::default();
    let mut without: Vec<Rounds> = variants.iter().map(|_| Rounds::default()).collect();
    let watched = adaptive::watched(measured);
    let mut plan = None;
    for round in 0..rounds {
        let rendering = taking.take(&watched, round, "", &mut with)?;
        plan.get_or_insert_with(|| adaptive::Plan::new(full, measured, &rendering.picture));
        for (variant, into) in variants.iter().zip(&mut without) {
            taking.take(&variant.settings, round, &variant.name, into)?;
        }
    }
    let scatter = Scatter::of(
        without
            .iter()
            .map(|less| (&with.seconds[..], &less.seconds[..])),
    );
    let scale = Scale {
        work: pixels(full) * f64::from(full.samples)
            / (pixels(measured) * f64::from(measured.samples)),
        // Independent samples: noise goes with 1/√n.
        noise: (f64::from(measured.samples) / f64::from(full.samples)).sqrt(),
        scatter,
    };
    let weights = weights(&with.pictures);
    let mut effects: Vec<(EffectCost, Vec<f32>)> = variants
        .iter()
        .zip(&without)
        .map(|(variant, rounds)| {
            let (square, deviation) = change_square(&with.pictures, &rounds.pictures, &weights);
            let change = Share::of_square(square, deviation);
            (
                compared(variant, (&with, rounds), &scale, change),
                rounds.mean(),
            )
        })
        .collect();
    if let Some(plan) = plan {
        let pixels = pixels(full) / pixels(measured);
        effects.push(taking.adaptive(plan, pixels, rounds, scatter)?);
    }
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
        full: with.work(scale.work),
        noise: scale.noise * with.noise(),
        effects,
        pictures,
    })
}

/// Renders the pictures, one after another.
struct Taking<'a> {
    scene: &'a Scene,
    observer: &'a dyn Observer,
    step: &'a dyn Fn(usize, usize, &str),
    done: usize,
    all: usize,
}

impl Taking<'_> {
    /// One picture of a round, without something.
    fn take(
        &mut self,
        settings: &RenderSettings,
        round: u32,
        name: &str,
        into: &mut Rounds,
    ) -> Result<Rendering, CostError> {
        (self.step)(self.done, self.all, name);
        let settings = RenderSettings {
            seed: settings.seed.wrapping_add(round),
            ..settings.clone()
        };
        let clock = Clock::new(self.observer);
        let rendering = render(self.scene, &settings, &clock)?;
        let statistics = &rendering.statistics;
        if statistics.stop == Stop::Cancelled || self.observer.cancelled() {
            return Err(CostError::Cancelled);
        }
        let seconds = clock.seconds(statistics.trace, statistics.threads);
        into.add(&rendering, seconds);
        self.done += 1;
        Ok(rendering)
    }

    /// Adaptive sampling against as many samples everywhere, and the picture of those. The full picture has so many times the
    /// pixels of the measured ones.
    fn adaptive(
        &mut self,
        plan: adaptive::Plan,
        pixels: f64,
        rounds: u32,
        scatter: Scatter,
    ) -> Result<(EffectCost, Vec<f32>), CostError> {
        let name = Effect::AdaptiveSampling.id();
        let (mut with, mut without) = (Rounds::default(), Rounds::default());
        let mut found = adaptive::Found::default();
        for round in 0..rounds {
            let adaptive = self.take(&plan.adaptive, round, "", &mut with)?;
            let uniform = self.take(&plan.uniform(&adaptive), round, name, &mut without)?;
            found.add(&adaptive, &uniform);
        }
        let scale = Scale {
            work: pixels * plan.more,
            noise: plan.more.sqrt().recip(),
            scatter,
        };
        let evened = found.evened(&plan);
        let variant = Variant {
            name: name.into(),
            about: "samples where the error is, against as many everywhere".into(),
            worth: Worth::Noise,
            settings: plan.adaptive,
        };
        // Both converge to the same picture.
        let cost = compared(
            &variant,
            (&with, &without),
            &scale,
            Share::of_square(0.0, 0.0),
        );
        Ok((cost.with_evened(evened), without.mean()))
    }
}

/// From the pictures that are measured to the full one.
struct Scale {
    /// Of times and rays.
    work: f64,
    /// Of errors by chance.
    noise: f64,
    scatter: Scatter,
}

/// Puts together what is known of a picture without an effect.
fn compared(
    variant: &Variant,
    (with, without): (&Rounds, &Rounds),
    scale: &Scale,
    change: Share,
) -> EffectCost {
    let (full, less) = (with.work(scale.work), without.work(scale.work));
    let (noise, noise_without) = (scale.noise * with.noise(), scale.noise * without.noise());
    let ratios = || {
        with.seconds
            .iter()
            .zip(&without.seconds)
            .map(|(a, b)| a / b)
    };
    let rounds = with.seconds.len();
    let cost = EffectCost {
        effect: variant.name.clone(),
        about: variant.about.clone(),
        worth: variant.worth,
        without: less,
        rays_ratio: full.rays / less.rays,
        price: Price::new(full.seconds, less.seconds, rounds, scale.scatter),
        time_ratio: full.seconds / less.seconds,
        time_ratios: [
            ratios().fold(f64::INFINITY, f64::min),
            ratios().fold(0.0, f64::max),
        ],
        change,
        noise_without,
        time_to_equal_noise: (noise > 0.0 && variant.worth == Worth::Noise)
            .then(|| (noise_without / noise).powi(2) * less.seconds / full.seconds),
        error_removed: 0.0,
        error_removed_per_second: None,
        error_removed_per_second_at_least: None,
        evened: None,
    };
    cost.removing(match variant.worth {
        Worth::Picture => change.value,
        Worth::Noise => less_noise(noise_without, noise),
    })
}

/// The error that is taken from `without` to come to `with`; negative if it is added.
fn less_noise(without: f64, with: f64) -> f64 {
    let squares = without.powi(2) - with.powi(2);
    squares.signum() * squares.abs().sqrt()
}

impl EffectCost {
    fn removing(self, error_removed: f64) -> Self {
        Self {
            error_removed,
            error_removed_per_second: self.price.per_second(error_removed),
            error_removed_per_second_at_least: self.price.per_second_at_least(error_removed),
            ..self
        }
    }

    /// Of adaptive sampling it is the worst tile's error that counts.
    fn with_evened(self, evened: Evened) -> Self {
        let (with, without) = (evened.worst_tile, evened.worst_tile_without);
        Self {
            evened: Some(evened),
            time_to_equal_noise: (with > 0.0).then(|| (without / with).powi(2) / self.time_ratio),
            ..self.removing(less_noise(without, with))
        }
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
        cost.error_removed_per_second
            .or(cost.error_removed_per_second_at_least)
            .unwrap_or(f64::INFINITY),
    )
}

#[cfg(test)]
#[path = "../../tests/unit/cost/effects.rs"]
mod tests;
