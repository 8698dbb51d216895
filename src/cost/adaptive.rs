//! What adaptive sampling costs and gives: against as many samples everywhere.

use crate::film::{Pass, Picture};
use crate::render::{RenderSettings, Rendering};
use serde::Serialize;

/// Tiles of which the worst counts: so many are as wide as the picture (as `docs/notes/cost-of-accuracy.md` has them).
const TILES_ACROSS: usize = 20;
/// Adaptive sampling begins with 32 samples everywhere: with twice as many it has something to give to those that need it.
const LEAST_SAMPLES: u32 = 64;
/// Where errors are uneven, a few pixels take many times the samples of the others.
const MOST_OF_MEAN: u32 = 64;

/// What adaptive sampling has evened out. Errors are of the full size at the tolerance that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evened {
    /// `--pixel-error`; where it was not given, what takes about as many samples as the picture has.
    pub tolerance: f64,
    /// Tolerance of the pictures that were measured.
    pub measured_tolerance: f64,
    /// Samples a pixel that it takes, mean over the picture.
    pub samples: f64,
    /// Error of the worst of the tiles of a twentieth of the picture's width.
    pub worst_tile: f64,
    /// The same with as many samples everywhere.
    pub worst_tile_without: f64,
}

/// The errors of one kind of picture over the rounds.
#[derive(Default)]
struct Tiles {
    /// Mean squared error of each tile, a sum over the rounds.
    squares: Vec<f64>,
}

impl Tiles {
    fn add(&mut self, picture: &Picture) {
        let (width, errors) = (picture.width as usize, errors(picture));
        let side = width.div_ceil(TILES_ACROSS).max(1);
        let mut sums =
            vec![[0.0, 0.0]; errors.len().div_ceil(width.max(1)).div_ceil(side) * TILES_ACROSS];
        for (i, &error) in errors.iter().enumerate() {
            let [sum, pixels] = &mut sums[i / width / side * TILES_ACROSS + i % width / side];
            *sum += f64::from(error).powi(2);
            *pixels += 1.0;
        }
        self.squares.resize(sums.len(), 0.0);
        for (square, [sum, pixels]) in self.squares.iter_mut().zip(sums) {
            *square += sum / pixels.max(1.0);
        }
    }

    fn worst(&self, rounds: u32) -> f64 {
        let largest = self.squares.iter().fold(0.0f64, |a, &b| a.max(b));
        (largest / f64::from(rounds)).sqrt()
    }
}

/// Estimated error of each pixel, 0.1 for 10 %.
fn errors(picture: &Picture) -> &[f32] {
    let name = Pass::Error.name();
    let layer = picture.layers.iter().find(|layer| layer.name == name);
    layer.map_or(&[], |layer| &layer.data)
}

/// Settings of pictures that are compared, and how to scale what is found.
pub struct Plan {
    pub adaptive: RenderSettings,
    /// As many samples everywhere; their number comes with the picture.
    uniform: RenderSettings,
    tolerance: f64,
    /// Samples that the asked tolerance takes for one of the measured one.
    pub more: f64,
}

impl Plan {
    /// `measured` is a picture without adaptive sampling, `picture` what it is; `full` says the tolerance, or else how many
    /// samples the full picture takes. To reach a mean square of t² with the fewest samples n(i), proportional to the errors
    /// e(i) of m samples each, takes Σ n = m (Σ e)² / (pixels t²) of them (Neyman 1934): where t is the mean error, as many
    /// as the measured picture. A tolerance that takes less is taken as it is.
    pub fn new(full: &RenderSettings, measured: &RenderSettings, picture: &Picture) -> Self {
        let errors = errors(picture);
        let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len().max(1) as f64;
        let by = |samples: u32| mean * (f64::from(measured.samples) / f64::from(samples)).sqrt();
        let tolerance = match full.pixel_error_target {
            0.0 => by(full.samples),
            asked => asked,
        };
        let samples = measured.samples.max(LEAST_SAMPLES);
        let measured_tolerance = tolerance.max(by(samples));
        let uniform = watched(measured);
        Self {
            adaptive: RenderSettings {
                pixel_error_target: measured_tolerance,
                samples: samples.saturating_mul(MOST_OF_MEAN),
                ..uniform.clone()
            },
            uniform,
            tolerance,
            more: (measured_tolerance / tolerance).powi(2),
        }
    }

    /// What has as many samples as an adaptive picture.
    pub fn uniform(&self, rendering: &Rendering) -> RenderSettings {
        RenderSettings {
            samples: (rendering.statistics.mean_samples.round() as u32).max(2),
            ..self.uniform.clone()
        }
    }
}

/// The same with the error of each pixel.
pub fn watched(settings: &RenderSettings) -> RenderSettings {
    RenderSettings {
        passes: settings.passes.with(Pass::Error),
        ..settings.clone()
    }
}

/// What the rounds come to.
#[derive(Default)]
pub struct Found {
    adaptive: Tiles,
    uniform: Tiles,
    samples: f64,
    rounds: u32,
}

impl Found {
    pub fn add(&mut self, adaptive: &Rendering, uniform: &Rendering) {
        self.adaptive.add(&adaptive.picture);
        self.uniform.add(&uniform.picture);
        self.samples += adaptive.statistics.mean_samples;
        self.rounds += 1;
    }

    pub fn evened(&self, plan: &Plan) -> Evened {
        let less = plan.more.sqrt();
        Evened {
            tolerance: plan.tolerance,
            measured_tolerance: plan.adaptive.pixel_error_target,
            samples: self.samples / f64::from(self.rounds) * plan.more,
            worst_tile: self.adaptive.worst(self.rounds) / less,
            worst_tile_without: self.uniform.worst(self.rounds) / less,
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/cost/adaptive.rs"]
mod tests;
