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
mod tests {
    use super::*;
    use crate::film::Layer;

    /// 40 × 4 pixels, whose tiles are 2 × 2.
    fn picture(error: impl Fn(usize, usize) -> f32) -> Picture {
        let pixels = (0..160).map(|i| error(i % 40, i / 40));
        Picture {
            width: 40,
            height: 4,
            layers: vec![Layer {
                name: Pass::Error.name().into(),
                channels: vec!["X".into()],
                data: pixels.collect(),
            }],
        }
    }

    #[test]
    fn the_worst_tile_is_that_of_all_rounds() {
        let mut tiles = Tiles::default();
        // One pixel of four in the second tile of the lower row, then all of the last one.
        tiles.add(&picture(|x, y| if (x, y) == (2, 2) { 0.4 } else { 0.0 }));
        assert!((tiles.worst(1) - 0.2).abs() < 1e-6);
        tiles.add(&picture(|x, y| if x > 37 && y > 1 { 0.3 } else { 0.0 }));
        assert!((tiles.worst(2) - (0.09f64 / 2.0).sqrt()).abs() < 1e-6);
    }

    #[test]
    fn a_tolerance_that_is_out_of_reach_is_measured_where_it_is_not() {
        let of = |samples, pixel_error_target| RenderSettings {
            samples,
            pixel_error_target,
            ..RenderSettings::default()
        };
        // The mean error is 20 % after 256 samples.
        let (measured, picture) = (of(256, 0.0), picture(|x, _| if x < 20 { 0.1 } else { 0.3 }));
        let plan = |full| {
            let plan = Plan::new(&full, &measured, &picture);
            (plan.tolerance, plan.adaptive.pixel_error_target, plan.more)
        };
        let near = |a: (f64, f64, f64), b: (f64, f64, f64)| {
            let off = |a: f64, b: f64| (a / b - 1.0).abs();
            assert!(
                off(a.0, b.0) + off(a.1, b.1) + off(a.2, b.2) < 1e-6,
                "{a:?} {b:?}"
            );
        };
        near(plan(of(1024, 0.05)), (0.05, 0.2, 16.0));
        near(plan(of(1024, 0.5)), (0.5, 0.5, 1.0));
        // Not asked for: half of the error by four times the samples.
        near(plan(of(1024, 0.0)), (0.1, 0.2, 4.0));
        // Few samples were measured: adaptive sampling takes 64, with half of their error.
        let few = Plan::new(&of(1024, 0.05), &of(16, 0.0), &picture);
        near(
            (few.tolerance, few.adaptive.pixel_error_target, few.more),
            (0.05, 0.1, 4.0),
        );
    }
}
