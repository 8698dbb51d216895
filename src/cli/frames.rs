//! `--frames FOLDER`: the picture as files of raw floats while it grows, for a program that shows it.

use super::checkpoint::Checkpoint;
use super::outputs::Outputs;
use super::progress::Reporter;
use super::tev::Viewer;
use super::{Failure, console, interrupt};
use crate::film::Bands;
use crate::output::{self, raw};
use crate::render::{self, Event, Observer, OutputTime, Region};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time from the first samples to the first frame.
const FIRST: Duration = Duration::from_millis(100);
/// Each interval is so many times the one before …
const GROWTH: f64 = 1.5;
/// … up to this.
const LONGEST: Duration = Duration::from_secs(5);
/// So many frames may lie unread before the next one waits.
const UNREAD: usize = 2;

/// The folder of frames.
pub struct Frames {
    folder: PathBuf,
    size: (u32, u32),
    region: Region,
    /// The process that started this one, which reads.
    reader: u32,
    state: Mutex<State>,
}

struct State {
    /// Frames written so far.
    count: u32,
    /// When the next one is due; none before the first samples.
    due: Option<Instant>,
    interval: Duration,
    /// Frames that may still lie there.
    lying: Vec<PathBuf>,
    /// An intermediate frame could not be written: no more are tried.
    failed: bool,
    /// Why the last frame could not be written.
    lost: Option<Failure>,
}

impl Frames {
    /// Makes sure that the folder is there and can be written to.
    ///
    /// # Errors
    /// It is not, or it cannot.
    pub fn check(folder: &Path) -> Result<(), Failure> {
        Ok(output::check_writable(&folder.join(name(1)))?)
    }

    /// Frames of a region of a picture of a size go to a folder.
    pub fn new(folder: &Path, size: (u32, u32), region: Region) -> Self {
        Self {
            folder: folder.into(),
            size,
            region,
            reader: std::os::unix::process::parent_id(),
            state: Mutex::new(State {
                count: 0,
                due: None,
                interval: FIRST,
                lying: Vec::new(),
                failed: false,
                lost: None,
            }),
        }
    }

    /// Writes a frame and tells it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, picture: &dyn Bands, samples: u32, last: bool) -> Result<(), Failure> {
        let mut state = self.state();
        let name = name(state.count + 1);
        let path = self.folder.join(&name);
        let passes = raw::write(&path, picture)?;
        state.count += 1;
        state.lying.push(path);
        let Region { x0, y0, x1, y1 } = self.region;
        console::json_line(&json!({
            "event": "frame",
            "file": name,
            "width": self.size.0,
            "height": self.size.1,
            "region": [x0, y0, x1, y1],
            "samples": samples,
            "final": last,
            "passes": passes,
        }));
        Ok(())
    }

    /// How long a frame like this takes to write: it is written under a name that nobody is told, and removed.
    fn rehearse(&self, picture: &dyn Bands) -> Duration {
        let path = self.folder.join("rehearsal");
        let _passing = output::Passing::file(&path);
        let begun = Instant::now();
        // What fails here will fail again, and be told then.
        let _ = raw::write(&path, picture);
        let time = begun.elapsed();
        let _ = std::fs::remove_file(&path);
        time
    }

    /// Whether the last frame came to be.
    ///
    /// # Errors
    /// It could not be written.
    pub fn finish(&self) -> Result<(), Failure> {
        self.state().lost.take().map_or(Ok(()), Err)
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Whether the program that started this one has ended: the system gives its children to another.
    fn reader_is_gone(&self) -> bool {
        std::os::unix::process::parent_id() != self.reader
    }

    /// Whether it is time for an intermediate frame and the reader keeps up.
    fn is_due(&self) -> bool {
        let mut state = self.state();
        let interval = state.interval;
        let due = *state.due.get_or_insert_with(|| Instant::now() + interval);
        if state.failed || Instant::now() < due {
            return false;
        }
        state.lying.retain(|path| path.exists());
        state.lying.len() < UNREAD
    }
}

/// Names sort as the frames follow each other.
fn name(number: u32) -> String {
    format!("frame-{number:06}.raw")
}

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
        self.frames.is_some_and(Frames::is_due)
            || self
                .viewer
                .is_some_and(|viewer| viewer.is_due(self.reporter))
    }

    fn picture(&self, picture: &dyn Bands, samples: u32, last: bool) {
        // The last picture is the viewer's once the files are written.
        if let Some(viewer) = self.viewer
            && !last
            && viewer.is_due(self.reporter)
        {
            viewer.show(picture);
        }
        let Some(frames) = self.frames else { return };
        if !last && !frames.is_due() {
            return;
        }
        let written = frames.write(picture, samples, last);
        let mut state = frames.state();
        match written {
            Err(failure) if last => state.lost = Some(failure),
            // The render goes on: the last frame may find room again, or fails with the reason.
            Err(failure) => {
                state.failed = true;
                self.reporter.warn(&format!(
                    "{}; the render goes on, and tries again at its end",
                    failure.message
                ));
            }
            Ok(()) => {}
        }
        state.due = Some(Instant::now() + state.interval);
        state.interval = state.interval.mul_f64(GROWTH).min(LONGEST);
    }

    fn keeps_picture(&self) -> bool {
        !self.outputs.files.is_empty() || self.viewer.is_some()
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

    fn wants_state(&self, last: bool) -> bool {
        self.checkpoint.is_some_and(|file| last || file.is_due())
    }

    fn state(&self, state: &render::State, last: bool) {
        if let Some(checkpoint) = self.checkpoint {
            checkpoint.write(state, last, self.reporter);
        }
    }
}
