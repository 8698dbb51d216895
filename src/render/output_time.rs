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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracing_and_output_fill_the_time() {
        let output = OutputTime {
            full: Duration::from_secs_f64(2.0),
            blank: Duration::from_secs_f64(0.5),
            ..OutputTime::default()
        };
        assert_eq!(output.at(0.0), output.blank);
        assert_eq!(output.at(1.0), output.full);
        // A tenth of the picture a second.
        let share = output.share_at_end(0.1, 0.1, 5.0);
        let tracing = (share - 0.1) / 0.1;
        assert!((tracing + output.at(share).as_secs_f64() - 5.0).abs() < 1e-8);
        // All of it long before the end; and no time at all.
        assert_eq!(output.share_at_end(0.5, 1.0, 60.0), 1.0);
        assert_eq!(output.share_at_end(0.25, 1.0, 0.1), 0.25);
        // Black that takes longer is a matter of chance.
        let odd = OutputTime {
            full: output.blank,
            blank: output.full,
            ..output
        };
        assert_eq!(odd.at(0.5), odd.blank);
        assert_eq!(odd.share_at_end(0.0, 0.1, 7.0), 0.5);
    }
    #[test]
    fn tries_are_averaged() {
        let of = |seconds, is_guess| {
            let time = Duration::from_secs(seconds);
            OutputTime {
                full: time,
                blank: time,
                seen_error: time,
                is_guess,
            }
        };
        assert_eq!(of(1, false).and(3, of(5, false)), of(2, false));
        assert_eq!(of(1, true).and(1, of(5, false)), of(5, false));
        assert_eq!(of(1, false).and(1, of(5, true)), of(1, false));
    }
}
