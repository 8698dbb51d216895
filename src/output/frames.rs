//! The picture as files of raw floats while it grows, for a program that shows it.

use super::{OutputError, Passing, check_writable, raw};
use crate::film::Bands;
use serde::Serialize;
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

/// What is told of a frame.
#[derive(Serialize)]
pub struct Frame {
    event: &'static str,
    file: String,
    width: u32,
    height: u32,
    region: [u32; 4],
    samples: u32,
    #[serde(rename = "final")]
    last: bool,
    passes: Vec<raw::PassLocation>,
}

/// The folder of frames.
pub struct Frames {
    folder: PathBuf,
    size: (u32, u32),
    region: [u32; 4],
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
    lost: Option<OutputError>,
}

impl Frames {
    /// Makes sure that the folder is there and can be written to.
    ///
    /// # Errors
    /// It is not, or it cannot.
    pub fn check(folder: &Path) -> Result<(), OutputError> {
        check_writable(&folder.join(name(1)))
    }

    /// Frames of a region (from x and y, to x and y) of a picture of a size go to a folder.
    pub fn new(folder: &Path, size: (u32, u32), region: [u32; 4]) -> Self {
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

    /// Writes a frame if it is time for one, and the last one anyway.
    ///
    /// # Errors
    /// A frame that is not the last cannot be written: no more are tried before the last. What happens to that one,
    /// [`finish`](Self::finish) tells.
    pub fn write(
        &self,
        picture: &dyn Bands,
        samples: u32,
        last: bool,
    ) -> Result<Option<Frame>, OutputError> {
        if !last && !self.is_due() {
            return Ok(None);
        }
        let written = self.write_now(picture, samples, last);
        let mut state = self.state();
        state.due = Some(Instant::now() + state.interval);
        state.interval = state.interval.mul_f64(GROWTH).min(LONGEST);
        match written {
            Ok(frame) => Ok(Some(frame)),
            Err(error) if last => {
                state.lost = Some(error);
                Ok(None)
            }
            Err(error) => {
                state.failed = true;
                Err(error)
            }
        }
    }

    fn write_now(
        &self,
        picture: &dyn Bands,
        samples: u32,
        last: bool,
    ) -> Result<Frame, OutputError> {
        let mut state = self.state();
        let name = name(state.count + 1);
        let path = self.folder.join(&name);
        let passes = raw::write(&path, picture)?;
        state.count += 1;
        state.lying.push(path);
        Ok(Frame {
            event: "frame",
            file: name,
            width: self.size.0,
            height: self.size.1,
            region: self.region,
            samples,
            last,
            passes,
        })
    }

    /// How long a frame like this takes to write: it is written under a name that nobody is told, and removed.
    pub fn rehearse(&self, picture: &dyn Bands) -> Duration {
        let path = self.folder.join("rehearsal");
        let _passing = Passing::file(&path);
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
    pub fn finish(&self) -> Result<(), OutputError> {
        self.state().lost.take().map_or(Ok(()), Err)
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Whether the program that started this one has ended: the system gives its children to another.
    pub fn reader_is_gone(&self) -> bool {
        std::os::unix::process::parent_id() != self.reader
    }

    /// Whether it is time for an intermediate frame and the reader keeps up.
    pub fn is_due(&self) -> bool {
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
