//! Time that does not depend on what else the machine does.

use crate::film::Bands;
use crate::render::{Event, Observer, Passed};
use std::sync::Mutex;
use std::time::Duration;

/// Clock ticks a second in what Linux tells of processes: a constant of its interface on x86-64 (`USER_HZ`).
const TICKS: f64 = 100.0;

/// Seconds that all threads of this process have had a processor, where the system says so. Linux rounds to 10 ms.
pub fn processor_seconds() -> Option<f64> {
    of_stat(&std::fs::read_to_string("/proc/self/stat").ok()?)
}

/// `utime` and `stime` (proc(5)): fields 14 and 15, the second one being a name in brackets that may hold anything.
fn of_stat(stat: &str) -> Option<f64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    let mut fields = after_name.split_ascii_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some((ticks()? + ticks()?) as f64 / TICKS)
}

/// Takes the processor time of a render's tracing, and passes everything on.
pub struct Clock<'a> {
    inner: &'a dyn Observer,
    /// At the first sample and after the last whole pass.
    readings: Mutex<[Option<f64>; 2]>,
}

impl<'a> Clock<'a> {
    /// Before anything is rendered.
    pub fn new(inner: &'a dyn Observer) -> Self {
        Self {
            inner,
            readings: Mutex::default(),
        }
    }

    /// Processor time of tracing, over the threads: the time that it takes where nothing else is at work. `trace`
    /// where the system does not tell.
    pub fn seconds(&self, trace: Duration, threads: usize) -> f64 {
        match *self.readings() {
            [Some(begun), Some(ended)] if ended > begun => (ended - begun) / threads.max(1) as f64,
            _ => trace.as_secs_f64(),
        }
    }

    fn readings(&self) -> std::sync::MutexGuard<'_, [Option<f64>; 2]> {
        self.readings
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Observer for Clock<'_> {
    fn event(&self, event: &Event) {
        if matches!(event, Event::Prepared { .. }) {
            self.readings()[0] = processor_seconds();
        }
        self.inner.event(event);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }

    fn whole_pass(&self, film: &dyn Bands, passed: &Passed) {
        self.readings()[1] = processor_seconds();
        self.inner.whole_pass(film, passed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_time_is_read_behind_any_name() {
        let stat = "7 (a) b 1) S 1 7 7 0 -1 4194560 100 0 0 0 250 50 0 0 20 0 9 0 1 2 3";
        assert_eq!(of_stat(stat), Some(3.0));
        assert_eq!(of_stat("7 (a) S 1"), None);
        assert_eq!(of_stat(""), None);
    }
}
