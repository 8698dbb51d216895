//! How long the output will take, as it is guessed before there is anything to put out.

use std::time::Duration;

/// Time to write what is wanted of a picture. Noise takes longer to compress than black.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutputTime {
    /// Where it has samples everywhere.
    pub full: Duration,
    /// Where it has none.
    pub blank: Duration,
    /// On top of it, if the error of what one sees is to be told.
    pub seen_error: Duration,
    /// `full` is a guess by `blank`: there were no samples yet to try it with.
    pub is_guess: bool,
}

impl OutputTime {
    /// The mean of what `tries` before have said and another one says. What is a guess does not count where there is better.
    pub fn and(self, tries: u32, other: Self) -> Self {
        if self.is_guess || other.is_guess {
            return if other.is_guess { self } else { other };
        }
        let mean = |before: Duration, now: Duration| (before * tries + now) / (tries + 1);
        Self {
            full: mean(self.full, other.full),
            blank: mean(self.blank, other.blank),
            seen_error: mean(self.seen_error, other.seen_error),
            is_guess: false,
        }
    }

    /// With samples in this share of the picture, 0 to 1.
    pub fn at(self, share: f64) -> Duration {
        let (full, blank) = (self.full.as_secs_f64(), self.blank.as_secs_f64());
        Duration::from_secs_f64(blank + share * (full - blank).max(0.0))
    }

    /// The share with samples when tracing and this output fill the seconds that are left, if it grows by `rate` a second.
    pub fn share_at_end(self, share: f64, rate: f64, left: f64) -> f64 {
        // share + rate · x, where x + at(share + rate · x) = left.
        let (now, later) = (
            self.at(share).as_secs_f64(),
            self.at(share + 1.0).as_secs_f64(),
        );
        let tracing = (left - now).max(0.0) / (1.0 + rate * (later - now));
        (share + rate * tracing).clamp(0.0, 1.0)
    }
}

/// Compressing what has samples takes at most so many times as long as what is blank (measured: 2000 MB/s to 105 MB/s on a busy
/// machine).
const MOST_GROWN: f64 = 20.0;

/// How long the state takes to write.
#[derive(Clone, Copy)]
pub(super) struct Saving {
    pub time: Duration,
    /// Samples that each pixel had at least.
    pub samples: u32,
    /// Share of the picture with samples.
    pub share: f64,
}

impl Saving {
    /// What it takes when so much of the picture has samples: at most in proportion, for what is blank takes time as well.
    pub fn at(self, share: f64) -> Duration {
        let grown = share / self.share.max(f64::MIN_POSITIVE);
        self.time.mul_f64(grown.clamp(1.0, MOST_GROWN))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/render/output_time.rs"]
mod tests;
