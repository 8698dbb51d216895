//! A short render that tells what a long one will cost.

use super::{CostError, pixels, reduced};
use crate::film::Bands;
use crate::render::{Event, Forecast, Known, Observer, Passed, RenderSettings, Statistics, render};
use crate::scene::Scene;
use serde::Serialize;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// With fewer samples than this at the full size, a reduced one tells more: the exponent needs octaves.
const LEAST_SAMPLES: f64 = 16.0;
/// So many samples shall fit into the probe at the reduced size.
const REDUCED_SAMPLES: f64 = 32.0;
/// Smaller pictures tell nothing of the larger one.
const LEAST_SIDE: f64 = 32.0;
/// A probe has no end but its time.
const MOST_SAMPLES: u32 = 1 << 20;

/// What a probe has found.
#[derive(Clone, Debug, Serialize)]
pub struct Probe {
    /// Size of the picture that was rendered.
    pub size: [u32; 2],
    /// Passes of it; seconds, rays and errors are scaled to the full size.
    pub passes: Vec<Known>,
    /// Seconds of tracing that the probe took.
    pub seconds: f64,
    /// Seconds to prepare the scene.
    pub prepare: f64,
    /// What follows; `None` if there is no error that could be forecast (a black picture, or one without noise).
    #[serde(skip)]
    pub forecast: Option<Forecast>,
    /// Whether the last pass had no error at all.
    pub exact: bool,
}

/// Keeps the passes, and ends the render some time after its first sample.
struct Passes<'a> {
    inner: &'a dyn Observer,
    time: Duration,
    begun: Mutex<Option<Instant>>,
    known: Mutex<Vec<Passed>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Observer for Passes<'_> {
    fn event(&self, event: &Event) {
        if matches!(event, Event::Prepared { .. }) {
            *locked(&self.begun) = Some(Instant::now());
        }
        self.inner.event(event);
    }

    fn cancelled(&self) -> bool {
        let over = |begun: Instant| begun.elapsed() >= self.time;
        self.inner.cancelled() || locked(&self.begun).is_some_and(over)
    }

    fn whole_pass(&self, _: &dyn Bands, passed: &Passed) {
        locked(&self.known).push(*passed);
    }

    fn keeps_picture(&self) -> bool {
        false
    }
}

/// What such a render has come to.
struct Run {
    passes: Vec<Passed>,
    statistics: Statistics,
}

fn run(
    scene: &Scene,
    settings: &RenderSettings,
    time: Duration,
    observer: &dyn Observer,
) -> Result<Run, CostError> {
    let passes = Passes {
        inner: observer,
        time,
        begun: Mutex::default(),
        known: Mutex::default(),
    };
    let settings = RenderSettings {
        samples: MOST_SAMPLES,
        ..settings.clone()
    };
    let statistics = render(scene, &settings, &passes)?.statistics;
    if observer.cancelled() {
        return Err(CostError::Cancelled);
    }
    Ok(Run {
        passes: passes
            .known
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner),
        statistics,
    })
}

/// Renders the picture of the settings for about `time`, and once more so long at a reduced size if that is too
/// short for it.
///
/// # Errors
/// It cannot be rendered, or the observer has said stop.
pub fn probe(
    scene: &Scene,
    settings: &RenderSettings,
    time: Duration,
    observer: &dyn Observer,
) -> Result<Probe, CostError> {
    let full = run(scene, settings, time, observer)?;
    let prepare = full.statistics.prepare.as_secs_f64();
    let last = full.passes.last().copied();
    let mut seconds = full.statistics.trace.as_secs_f64();
    if last.is_some_and(|pass| pass.samples >= LEAST_SAMPLES) {
        let scale = Scale {
            work: 1.0,
            time: 1.0,
            error: 1.0,
        };
        return Ok(finished(settings, &full.passes, scale, seconds, prepare));
    }
    let done = full.statistics.mean_samples.max(f64::MIN_POSITIVE);
    let factor = (time.as_secs_f64() * done / (seconds * REDUCED_SAMPLES)).min(1.0);
    let longest = f64::from(settings.width.max(settings.height));
    let side = (longest * factor.sqrt()).max(LEAST_SIDE.min(longest)) as u32;
    let small = reduced(settings, side);
    let less = run(scene, &small, time, observer)?;
    seconds += less.statistics.trace.as_secs_f64();
    let scale = Scale::of(
        &full.passes,
        &less.passes,
        pixels(settings) / pixels(&small),
    );
    Ok(finished(&small, &less.passes, scale, seconds, prepare))
}

/// From a reduced size to the full one.
#[derive(Clone, Copy)]
struct Scale {
    work: f64,
    time: f64,
    error: f64,
}

impl Scale {
    /// A pixel of the full size need not take as long as one of the reduced, and where there are many edges it has
    /// less of an error: what both have passed says so. Estimates from few samples are not to be relied on, but they
    /// err alike.
    fn of(full: &[Passed], reduced: &[Passed], pixels: f64) -> Self {
        let both = full.iter().rev().find_map(|pass| {
            let other = reduced.iter().find(|other| other.samples == pass.samples)?;
            Some((pass, other))
        });
        let error = |pass: &Passed| pass.error.map(|e| e.error).filter(|e| *e > 0.0);
        let time = both.map(|(a, b)| a.seconds / (b.seconds * pixels));
        let errors = both.and_then(|(a, b)| Some(error(a)? / error(b)?));
        Self {
            work: pixels,
            time: pixels * time.filter(|t| t.is_finite() && *t > 0.0).unwrap_or(1.0),
            error: errors.unwrap_or(1.0),
        }
    }
}

fn finished(
    settings: &RenderSettings,
    passes: &[Passed],
    scale: Scale,
    seconds: f64,
    prepare: f64,
) -> Probe {
    let passes: Vec<Known> = passes
        .iter()
        .map(|passed| {
            let known = Known::from(passed);
            Known {
                seconds: known.seconds * scale.time,
                rays: (known.rays as f64 * scale.work) as u64,
                error: known.error * scale.error,
                low: known.low * scale.error,
                high: known.high * scale.error,
                ..known
            }
        })
        .collect();
    Probe {
        size: [settings.width, settings.height],
        forecast: Forecast::of(&passes),
        exact: passes.last().is_some_and(|pass| pass.error == 0.0),
        passes,
        seconds,
        prepare,
    }
}
