//! The schedule: passes, tiles, threads, when to stop.

mod adaptive;
mod catchers;
mod denoised;
mod estimate;
mod forecast;
pub mod labels;
pub mod memory;
mod merge;
mod names;
mod noise_threshold;
mod output_time;
mod prepare;
mod rehearsal;
mod replay;
mod resolve;
mod saved;
mod schedule;
mod session;
mod settings;
mod tile;
mod trace;
mod warnings;

pub use forecast::{Expected, Forecast, ForecastRow, Known};
pub use merge::merge;
pub use noise_threshold::NoiseThreshold;
pub use output_time::OutputTime;
pub use prepare::{called_for, left_out};
pub use rehearsal::Tried;
pub use replay::{Detail, Replay, TraceStep, replay};
pub use saved::{Saved, State, StateError};
pub use schedule::{render, resume};
pub use session::{Edit, EditError, Session};
pub use settings::{
    Ablation, BounceLimits, Caustics, EffectChoice, Filter, FilterKind, InstructionSet,
    LightSampling, LightShares, MAX_BRANCHES, MAX_LIGHT_SAMPLES, MAX_SIDE, Region, RenderSettings,
    Sequences, picture_size,
};

use crate::film::error::ErrorEstimate;
use crate::film::{Bands, Picture};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::time::Duration;

/// Why a render could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A setting does not fit the scene.
    #[error("{0}")]
    Setting(String),
    /// Embree failed (out of memory, unsupported processor, …).
    #[error("Embree: {0}")]
    Embree(String),
}

/// What a render tells while it runs.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The scene is going to be prepared, which takes long as so many triangles shine. Not told of usual scenes.
    Preparing {
        /// Triangles that shine, instances expanded.
        shining: u64,
        /// About so many seconds, as measured on one machine.
        seconds: f64,
    },
    /// The scene is prepared (geometry in Embree, lights and textures ready).
    Prepared {
        /// Seconds since the render was called.
        seconds: f64,
        /// Triangles, instances expanded.
        triangles: u64,
        /// Names of the effects compiled into the chosen kernel.
        effects: Vec<String>,
    },
    /// Samples were added.
    Progress {
        /// Samples a pixel so far, the mean over the picture.
        samples: u32,
        /// Samples a pixel wanted.
        of: u32,
        /// Share of the work done, 0..=1.
        fraction: f64,
        /// Seconds since the first sample.
        seconds: f64,
        /// Rays traced so far.
        rays: u64,
        /// Expected seconds until the end.
        remaining: Option<f64>,
        /// Estimated error of the picture after the last whole pass (see [`crate::film::error`]); not known
        /// before two samples a pixel.
        error: Option<ErrorEstimate>,
        /// Expected seconds until the error is the one that is wanted, if one is; with a 95 % interval.
        to_goal: Option<Expected>,
    },
    /// Once, after the first seconds: which error the picture will have after which time.
    Forecast {
        /// Samples a pixel when it was made.
        samples: f64,
        /// Errors that follow each other by halves.
        table: Vec<ForecastRow>,
    },
}

/// Listens to a render and may end it. Called from one thread at a time.
pub trait Observer: Sync {
    /// Something happened.
    fn event(&self, event: &Event);
    /// Whether the render shall stop now and keep what it has (polled at least ten times a second).
    fn cancelled(&self) -> bool;
    /// Whether a picture of what there is so far would be welcome. Polled often once every pixel has a
    /// sample.
    fn wants_picture(&self) -> bool {
        false
    }
    /// The picture so far, the region alone; each pixel has at least `samples` samples. `last`: with all
    /// passes, once, at the end whatever ended the render; before that it is the layer `Combined` alone.
    fn picture(&self, _picture: &dyn Bands, _samples: u32, _last: bool) {}
    /// A pass over the whole picture has ended. `film` has all passes. The render waits; called by a thread of
    /// its pool, while [`event`](Self::event) may be called by another.
    fn whole_pass(&self, _film: &dyn Bands, _passed: &Passed) {}
    /// With a target for the denoised picture, after whole passes: how far it would be from the truth by the two halves of its
    /// samples, whose pictures are these. `film` has all passes.
    fn denoised_error(
        &self,
        _film: &dyn Bands,
        _halves: [&dyn Bands; 2],
        _passed: &Passed,
    ) -> Option<f64> {
        None
    }
    /// With a time limit, early, and some times again where there is much time: how long it will take to write what is
    /// wanted of the picture, and to tell the error of what one sees of it (which takes `replicate`).
    fn time_for_output(&self, _film: &dyn Bands) -> OutputTime {
        OutputTime::default()
    }
    /// Whether the state would be welcome from which the render can go on; asked after each whole pass, and at
    /// the `last`. (With a time limit also once early as if at the last: how long that takes has to be known.)
    fn wants_state(&self, _last: bool) -> bool {
        false
    }
    /// The state.
    fn state(&self, _state: &State, _last: bool) {}
    /// Whether [`Rendering::picture`] shall be made (else it is empty).
    fn keeps_picture(&self) -> bool {
        true
    }
}

/// What a render has come to after a whole pass. Passes end after 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 …
/// samples (with a target for each pixel only as far as 32, with a noise threshold as far as its first look).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Passed {
    /// Samples a pixel, the mean over the picture.
    pub samples: f64,
    /// Samples that each pixel has at least.
    pub least: u32,
    /// Rays traced.
    pub rays: u64,
    /// Seconds of tracing alone: what comes between the passes is not counted.
    pub seconds: f64,
    /// Estimated error of the picture; not known before two samples a pixel.
    pub error: Option<ErrorEstimate>,
}

/// An observer for those who don't watch.
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Event) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// All samples are there.
    Samples,
    /// The time was up.
    Time,
    /// The estimated error of the picture is below the target.
    Error,
    /// The estimated error of every pixel is below the target.
    PixelError,
    /// Every pixel is below the noise threshold.
    NoiseThreshold,
    /// The estimated error of the denoised picture is below the target.
    DenoisedError,
    /// The observer said so.
    Cancelled,
}

/// Counts and times of a render.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    /// Why it ended.
    pub stop: Stop,
    /// Samples a pixel (the smallest over the picture).
    pub samples: u32,
    /// The same, mean over the picture.
    pub mean_samples: f64,
    /// Time to prepare the scene.
    pub prepare: Duration,
    /// Time to trace.
    pub trace: Duration,
    /// Camera, bounce and shadow rays.
    pub rays: u64,
    /// Lobes that surfaces went without, as they have more than are kept at a hit. 0 of all but the largest node trees.
    pub lobes_left_out: u64,
    /// Paths whose contribution was not finite: left out and counted. 0 in a healthy render.
    pub non_finite: u64,
    /// The first of them, as pixel x, pixel y, sample index.
    pub non_finite_examples: Vec<(u32, u32, u32)>,
    /// How many there are by what was not finite first.
    pub non_finite_causes: BTreeMap<String, u64>,
    /// Estimated error of the picture; not known of a single sample a pixel.
    pub error: Option<ErrorEstimate>,
    /// What clamping took away; `None` if nothing was clamped by the settings.
    pub clamped: Option<Clamped>,
    /// Names of the effects compiled into the kernel that ran.
    pub effects: Vec<String>,
    /// Names of those that the scene calls for and the settings leave out.
    pub left_out: Vec<String>,
    /// Threads used.
    pub threads: usize,
    /// The version of Embree, by which rays meet surfaces …
    pub embree: String,
    /// … and the instructions that it took: the last bits depend on both.
    pub instruction_set: InstructionSet,
}

/// Light that clamping took away, as shares of the mean luminance that the picture would have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clamped {
    /// Direct light and what the camera sees itself, 0..=1.
    pub direct: f64,
    /// Indirect light, 0..=1.
    pub indirect: f64,
}

/// A finished (or ended) render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Layers of floats, scene-linear; the region alone.
    pub picture: Picture,
    /// The picture of one of the replicates alone: it differs from `picture` as much as `picture` differs from the
    /// truth. `None` where the error is not known.
    pub replicate: Option<Picture>,
    /// Estimated variance of each pixel's luminance, rows from top to bottom: what a denoised picture is judged by. There if
    /// [`Pass::NoisyImage`](crate::film::Pass) is, and the error is known.
    pub luminance_variances: Option<Vec<f32>>,
    /// Counts and times.
    pub statistics: Statistics,
    /// The scene's [`fingerprint`](crate::scene::fingerprint()), if the render has needed it already.
    pub scene_hash: OnceLock<String>,
}
