//! What becomes of a picture while it grows: frames, a viewer, a checkpoint, lines.

use super::checkpoint::Checkpoint;
use super::outputs::Outputs;
use super::progress::Reporter;
use super::{console, interrupt};
use crate::denoise::HalvesError;
use crate::film::Bands;
use crate::output::{Frames, tev::Viewer};
use crate::render::{self, Event, Observer, OutputTime, Passed};
use serde_json::json;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Tells what happens, writes frames if there is a folder for them, and tells a viewer if there is one.
pub struct Watcher<'a> {
    /// Who tells.
    pub reporter: &'a Reporter,
    /// Where frames go.
    pub frames: Option<&'a Frames>,
    /// Who shows the picture.
    pub viewer: Option<&'a Viewer>,
    /// Where the state goes.
    pub checkpoint: Option<&'a Checkpoint>,
    /// Files to be written at the end.
    pub outputs: &'a Outputs,
    /// What the halves of the picture said last of its error once it is denoised.
    pub denoised: Mutex<Option<HalvesError>>,
}

/// Nothing panics while it holds the value.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watcher<'_> {
    /// Writes a frame, if there is a folder for them and it is time, or it is the last.
    pub fn write_frame(&self, picture: &dyn Bands, samples: u32, last: bool) {
        let Some(frames) = self.frames else { return };
        match frames.write(picture, samples, last) {
            Ok(Some(frame)) => {
                console::json_line(&frame);
            }
            // The render goes on: the last frame may find room again, or fails with the reason.
            Err(error) => self.reporter.warn(&format!(
                "{error}; the render goes on, and tries again at its end"
            )),
            Ok(None) => {}
        }
    }

    /// Whether it is time for the viewer's next picture.
    fn shows_next(&self, viewer: &Viewer) -> bool {
        viewer.is_due(&|warning| self.reporter.warn(warning))
    }
}

impl Observer for Watcher<'_> {
    fn event(&self, event: &Event) {
        // From here on there is something to keep; until now Ctrl-C ends the process at once.
        if let Event::Prepared { .. } = event {
            interrupt::keep();
        }
        self.reporter.event(event);
    }

    fn cancelled(&self) -> bool {
        if self.frames.is_some_and(Frames::reader_is_gone) {
            interrupt::nobody_watches();
        }
        self.reporter.cancelled()
    }

    fn wants_picture(&self) -> bool {
        self.frames.is_some_and(Frames::is_due) || self.viewer.is_some_and(|v| self.shows_next(v))
    }

    fn picture(&self, picture: &dyn Bands, samples: u32, last: bool) {
        // The last picture is the viewer's once the files are written.
        if let Some(viewer) = self.viewer
            && !last
            && self.shows_next(viewer)
        {
            viewer.show(picture);
        }
        // One that is to be denoised comes later.
        if !last || self.outputs.denoiser.is_none() {
            self.write_frame(picture, samples, last);
        }
    }

    fn keeps_picture(&self) -> bool {
        self.outputs.denoiser.is_some() || !self.outputs.files.is_empty() || self.viewer.is_some()
    }

    fn time_for_output(&self, film: &dyn Bands) -> OutputTime {
        let mut time = OutputTime::default();
        if self.keeps_picture() {
            time = self.outputs.rehearse(film);
        }
        if let Some(frames) = self.frames {
            let frame = frames.rehearse(film);
            time.full += frame;
            time.blank += frame;
        }
        time
    }

    fn denoised_error(
        &self,
        film: &dyn Bands,
        halves: [&dyn Bands; 2],
        passed: &Passed,
    ) -> Option<f64> {
        match self
            .outputs
            .denoised_error(film, halves, passed.samples, &|| self.cancelled())
        {
            Ok(error) => {
                self.reporter
                    .tell(&json!({ "event": "denoised_error", "error": error }));
                *locked(&self.denoised) = error;
                error.map(|error| error.flip)
            }
            // It will fail again at the end, and be told then.
            Err(_) => None,
        }
    }

    fn wants_state(&self, last: bool) -> bool {
        self.checkpoint.is_some_and(|file| last || file.is_due())
    }

    fn state(&self, state: &render::State, last: bool) {
        if let Some(checkpoint) = self.checkpoint {
            checkpoint.write(state, last, self.reporter);
        }
    }
}
