//! When to stop by what the observer says of the denoised picture.

use super::resolve::Film;
use super::tile::locked;
use super::{Observer, Passed};
use crate::film::Bands;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The halves of a picture are denoised from so many samples on …
const FROM: f64 = 8.0;
/// … and again when there are so many times the samples, as that takes long.
const AGAIN: f64 = 1.4;

/// The rule, and what was told last.
pub(super) struct DenoisedRule {
    target: f64,
    told: Mutex<Told>,
}

#[derive(Clone, Copy, Default)]
struct Told {
    error: Option<f64>,
    /// Mean samples a pixel when it was told …
    samples: f64,
    /// … and how long that took.
    took: Option<Duration>,
}

impl DenoisedRule {
    /// With a target; 0 for none.
    pub fn new(target: f64) -> Self {
        Self {
            target,
            told: Mutex::default(),
        }
    }

    /// Asks for the error, if there is a target for it and there are enough new samples. `time`: what is left, if that is limited,
    /// and how long it takes at the first time.
    pub fn judge(
        &self,
        film: &Film,
        observer: &dyn Observer,
        passed: &Passed,
        time: Option<(Duration, Duration)>,
    ) {
        let before = *locked(&self.told);
        let due = (AGAIN * before.samples).max(FROM);
        if self.target <= 0.0 || passed.error.is_none() || passed.samples < due {
            return;
        }
        if time.is_some_and(|(left, first)| left <= before.took.unwrap_or(first)) {
            return;
        }
        let begun = Instant::now();
        let halves = [false, true].map(|second| film.replicate(second));
        let halves = [&halves[0] as &dyn Bands, &halves[1]];
        let error = observer.denoised_error(film, halves, passed);
        *locked(&self.told) = Told {
            error,
            samples: passed.samples,
            took: Some(begun.elapsed()),
        };
    }

    /// Whether what was told last is not above the target.
    pub fn is_met(&self) -> bool {
        let error = locked(&self.told).error;
        self.target > 0.0 && error.is_some_and(|error| error <= self.target)
    }
}
