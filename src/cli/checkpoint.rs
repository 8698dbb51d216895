//! `--checkpoint FILE`: the state of a render, to go on with.

use super::Failure;
use super::parser::Parsed;
use crate::output;
use crate::render::{Saved, State, StateError};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

impl From<StateError> for Failure {
    fn from(error: StateError) -> Self {
        Failure::new(error.to_string())
    }
}

/// The file, and when it was written.
pub struct Checkpoint {
    path: PathBuf,
    interval: Duration,
    written: Mutex<Instant>,
    /// Why it could not be written at the end.
    lost: Mutex<Option<Failure>>,
}

impl Checkpoint {
    /// As the flags want it.
    ///
    /// # Errors
    /// The file can't be written.
    pub fn new(parsed: Parsed) -> Result<Option<Self>, Failure> {
        let Some(path) = parsed.path("checkpoint") else {
            return Ok(None);
        };
        output::check_writable(path)?;
        Ok(Some(Self {
            path: path.into(),
            interval: parsed.duration("checkpoint-interval").unwrap_or_default(),
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
        Ok(Some(Saved::read(&self.path)?))
    }

    /// Whether it is time to write.
    pub fn is_due(&self) -> bool {
        let written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        written.elapsed() >= self.interval
    }

    /// Writes the state; what fails is told by [`finish`](Self::finish), unless a later one succeeds.
    pub fn write(&self, state: &State) {
        let result = output::write_beside(&self.path, |file| state.write(file));
        *self.lost.lock().unwrap_or_else(PoisonError::into_inner) = result.err().map(Failure::from);
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Whether the last state was written.
    ///
    /// # Errors
    /// It could not be.
    pub fn finish(&self) -> Result<(), Failure> {
        let lost = self
            .lost
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        lost.map_or(Ok(()), Err)
    }

    /// Name of the file.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }
}
