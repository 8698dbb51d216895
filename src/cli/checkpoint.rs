//! `--checkpoint FILE`: the state of a render, to go on with.

use super::Failure;
use super::progress::Reporter;
use crate::output;
use crate::render::{Saved, State, memory};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The file, and when it was written.
pub struct Checkpoint {
    path: PathBuf,
    interval: Duration,
    written: Mutex<Instant>,
    lost: Mutex<Lost>,
}

/// What went wrong with the file.
#[derive(Default)]
struct Lost {
    /// Why the last state could not be written.
    last: Option<Failure>,
    /// It has been told that one could not.
    told: bool,
}

impl Checkpoint {
    /// As the flags want it.
    ///
    /// # Errors
    /// The file can't be written.
    pub fn new(path: Option<&Path>, interval: Duration) -> Result<Option<Self>, Failure> {
        let Some(path) = path else {
            return Ok(None);
        };
        output::check_writable(path)?;
        Ok(Some(Self {
            path: path.into(),
            interval,
            written: Mutex::new(Instant::now()),
            lost: Mutex::default(),
        }))
    }

    /// What it holds; `None` if it is not there yet.
    ///
    /// # Errors
    /// It is there and can't be used.
    pub fn read(&self) -> Result<Option<Saved>, Failure> {
        if !self.path.exists() {
            return Ok(None);
        }
        Ok(Some(Saved::read_within(&self.path, memory::free())?))
    }

    /// Whether it is time to write.
    pub fn is_due(&self) -> bool {
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.elapsed() >= self.interval
    }

    /// Writes the state. What fails is told once, and the render goes on: a later one may find room again. That the last one
    /// failed is told by [`finish`](Self::finish).
    pub fn write(&self, state: &State, last: bool, reporter: &Reporter) {
        let result = output::atomic_write(&self.path, |file| state.write(file));
        let failure = result.err().map(Failure::from);
        let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(failure) = &failure
            && !last
            && !std::mem::replace(&mut lost.told, true)
        {
            reporter.warn(&format!(
                "{}; the render goes on without it, and tries again",
                failure.message
            ));
        }
        lost.last = failure;
        drop(lost);
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Whether the last state was written.
    ///
    /// # Errors
    /// It could not be.
    pub fn finish(&self) -> Result<(), Failure> {
        let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.last.take().map_or(Ok(()), Err)
    }

    /// Name of the file.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }
}
