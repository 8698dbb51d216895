//! The schedule: passes, tiles, threads, when to stop.

mod develop;
mod forecast;
mod schedule;
mod settings;

pub use forecast::{Expected, Forecast, Known, Row};
pub use schedule::render;
pub use settings::{
    BounceLimits, EffectChoice, Filter, FilterKind, LightSampling, MAX_LIGHT_SAMPLES, Region,
    RenderSettings,
};

use crate::film::{Bands, Picture};
use serde::Serialize;
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
        /// Samples a pixel so far (all pixels have at least this many).
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
        /// Estimated error of the picture so far, the root of its relMSE, from the samples
        /// (see [`crate::film::pixel::Pixel::relative_square_error`]); not known before two samples a pixel.
        noise: Option<f64>,
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
    /// A pass over the whole picture has ended: each pixel has that many samples, `seconds` were spent on
    /// tracing alone. Passes end after 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 … samples. The render waits; called by
    /// a thread of its pool, while [`event`](Self::event) may be called by another.
    fn whole_pass(&self, _film: &dyn Bands, _samples: u32, _seconds: f64) {}
    /// Whether [`Rendering::picture`] shall be made (else it is empty).
    fn keeps_picture(&self) -> bool {
        true
    }
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
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// All samples are there.
    Samples,
    /// The time was up.
    Time,
    /// The noise estimate is below the target.
    Noise,
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
    /// Time to prepare the scene.
    pub prepare: Duration,
    /// Time to trace.
    pub trace: Duration,
    /// Camera, bounce and shadow rays.
    pub rays: u64,
    /// Paths whose contribution was not finite: left out and counted. 0 in a healthy render.
    pub non_finite: u64,
    /// The first of them, as pixel x, pixel y, sample index.
    pub non_finite_examples: Vec<(u32, u32, u32)>,
    /// Estimated error of the picture, the root of its relMSE; not known of a single sample a pixel.
    pub noise: Option<f64>,
    /// What clamping took away; `None` if nothing was clamped by the settings.
    pub clamped: Option<Clamped>,
    /// Names of the effects compiled into the kernel that ran.
    pub effects: Vec<String>,
    /// Threads used.
    pub threads: usize,
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
    /// Counts and times.
    pub statistics: Statistics,
}
