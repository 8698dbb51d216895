//! Time that does not depend on what else the machine does.

use crate::film::Bands;
use crate::render::{Event, Observer, Passed};
use rustix::time::{ClockId, clock_gettime};
use std::sync::Mutex;
use std::time::Duration;

/// Seconds that all threads of this process have had a processor.
pub fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::try_from(time).map_or(0.0, |time| time.as_secs_f64())
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
    /// where there was no whole pass.
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
            self.readings()[0] = Some(processor_seconds());
        }
        self.inner.event(event);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }

    fn whole_pass(&self, film: &dyn Bands, passed: &Passed) {
        self.readings()[1] = Some(processor_seconds());
        self.inner.whole_pass(film, passed);
    }
}

#[cfg(test)]
#[path = "../../tests/unit/cost/clock.rs"]
mod tests;
