//! Renders whose picture is kept after 1, 2, 4, 8 … samples.

use super::super::Failure;
use super::super::outputs::light;
use super::super::progress::Reporter;
use crate::film::{self, Bands};
use crate::measure::RgbImage;
use crate::render::{self, Event, Observer, Passed, RenderSettings};
use crate::scene::Scene;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// A picture, and what it took.
pub struct Shot {
    /// Samples a pixel.
    pub samples: u32,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Linear light.
    pub picture: RgbImage,
}

/// Keeps the picture after the passes that it is asked for.
struct Watcher<'a> {
    reporter: &'a Reporter,
    wanted: &'a (dyn Fn(u32) -> bool + Sync),
    shots: Mutex<Vec<Shot>>,
}

impl Observer for Watcher<'_> {
    fn event(&self, event: &Event) {
        self.reporter.event(event);
    }

    fn cancelled(&self) -> bool {
        self.reporter.cancelled()
    }

    fn whole_pass(&self, film: &dyn Bands, passed: &Passed) {
        if (self.wanted)(passed.least) {
            let shot = Shot {
                samples: passed.least,
                seconds: passed.seconds,
                picture: light(&film::Picture::collect(film)),
            };
            self.shots
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(shot);
        }
    }

    fn keeps_picture(&self) -> bool {
        false
    }
}

/// A render's picture after each power of two and at the end.
pub fn doubling(
    scene: &Scene,
    path: &Path,
    settings: &RenderSettings,
    reporter: &Reporter,
) -> Result<Vec<Shot>, Failure> {
    let end = settings.samples;
    let wanted = move |samples: u32| samples.is_power_of_two() || samples == end;
    run(scene, path, settings, reporter, &wanted)
}

/// A render's last picture.
pub fn last(
    scene: &Scene,
    path: &Path,
    settings: &RenderSettings,
    reporter: &Reporter,
) -> Result<RgbImage, Failure> {
    let end = settings.samples;
    let mut shots = run(scene, path, settings, reporter, &move |samples| {
        samples == end
    })?;
    let shot = shots.pop().ok_or_else(|| unfinished(path))?;
    Ok(shot.picture)
}

fn unfinished(path: &Path) -> Failure {
    Failure {
        code: super::super::exit::EXIT_INTERRUPTED,
        message: format!("{}: interrupted; nothing was written", path.display()),
    }
}

fn run(
    scene: &Scene,
    path: &Path,
    settings: &RenderSettings,
    reporter: &Reporter,
    wanted: &(dyn Fn(u32) -> bool + Sync),
) -> Result<Vec<Shot>, Failure> {
    let watcher = Watcher {
        reporter,
        wanted,
        shots: Mutex::default(),
    };
    let rendering = render::render(scene, settings, &watcher);
    reporter.end();
    let rendering =
        rendering.map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    if rendering.statistics.samples < settings.samples {
        return Err(unfinished(path));
    }
    let shots = watcher.shots.into_inner();
    Ok(shots.unwrap_or_else(PoisonError::into_inner))
}
