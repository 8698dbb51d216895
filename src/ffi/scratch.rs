//! Memory in scratch files without a name, of which no more than a limit is mapped into the process at a time.
//!
//! The system counts a mapped page as the process's own as soon as it is touched. A thread looks every few milliseconds, and
//! takes the pages off the process where they are too many: they stay in the file, and come back when they are asked for.

use memmap2::{MmapOptions, MmapRaw, UncheckedAdvice};
use rustix::fs::{FallocateFlags, fallocate, fstatfs};
use rustix::io::Errno;
use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The number by which Linux knows a file system in memory (`statfs(2)`).
const TMPFS: i64 = 0x0102_1994;

/// How often the thread looks.
const LOOK: Duration = Duration::from_millis(2);

/// Bytes of scratch files that may be mapped at a time.
static MOST_MAPPED: AtomicU64 = AtomicU64::new(u64::MAX);

static MAPPED: Mutex<Mapped> = Mutex::new(Mapped {
    maps: Vec::new(),
    watched: false,
});

/// What is mapped.
struct Mapped {
    maps: Vec<Arc<MmapRaw>>,
    /// A thread looks after them.
    watched: bool,
}

fn mapped() -> MutexGuard<'static, Mapped> {
    MAPPED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says how many bytes of scratch files may be mapped into the process at a time.
///
/// Where threads read all over a file that the system has at hand, more is mapped for moments: a touched page brings 15 others with it, or
/// more, and to take them off is no faster. What is too much can be had back from the process at any time.
pub fn keep_mapped_below(bytes: u64) {
    MOST_MAPPED.store(bytes, Ordering::Relaxed);
}

/// Bytes that can be written, in a scratch file, at first all 0.
#[derive(Debug)]
pub struct Scratch {
    map: Arc<MmapRaw>,
}

impl Scratch {
    /// # Errors
    /// No folder for temporary files is on a disk, or there is no room.
    pub fn new(bytes: usize) -> io::Result<Self> {
        let file = file()?;
        reserve(&file, bytes as u64)?;
        let map = Arc::new(MmapOptions::new().len(bytes).map_raw(&file)?);
        let mut all = mapped();
        all.maps.push(map.clone());
        if !all.watched {
            let before = shared_bytes();
            let thread = std::thread::Builder::new().name("scratch".into());
            // Without it, the system takes pages when it needs them.
            all.watched = thread.spawn(move || watch(before)).is_ok();
        }
        Ok(Self { map })
    }

    /// Where the bytes begin; they do not move, and nobody else writes to them, as the file has no name.
    pub fn start(&self) -> NonNull<u8> {
        NonNull::new(self.map.as_mut_ptr()).unwrap_or(NonNull::dangling())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        mapped().maps.retain(|other| !Arc::ptr_eq(other, &self.map));
    }
}

/// Looks until nothing is mapped. `before`: bytes of files that were the process's own without it.
fn watch(before: u64) {
    loop {
        std::thread::sleep(LOOK);
        let mut all = mapped();
        if all.maps.is_empty() {
            all.watched = false;
            return;
        }
        if shared_bytes().saturating_sub(before) <= MOST_MAPPED.load(Ordering::Relaxed) {
            continue;
        }
        for map in &all.maps {
            // SAFETY: the mapping is shared with its file: what was written stays in it. Where it fails, pages stay.
            let _ = unsafe { map.unchecked_advise(UncheckedAdvice::DontNeed) };
        }
    }
}

/// Bytes of files that are mapped into the process and there (`proc_pid_status(5)`); 0 where the system does not say.
fn shared_bytes() -> u64 {
    let told = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = told.lines().filter_map(|line| {
        let value = line
            .strip_prefix("RssFile:")
            .or(line.strip_prefix("RssShmem:"))?;
        value.trim().trim_end_matches(" kB").parse::<u64>().ok()
    });
    kib.sum::<u64>() << 10
}

/// Makes a file so long, with room on the disk: a mapping that has none ends the process when it is written to.
fn reserve(mut file: &File, bytes: u64) -> io::Result<()> {
    match fallocate(file, FallocateFlags::empty(), 0, bytes) {
        Ok(()) => Ok(()),
        // The file system has no such call.
        Err(Errno::OPNOTSUPP | Errno::NOSYS) => {
            let zeros = [0; 1 << 16];
            let mut left = bytes;
            while left > 0 {
                let part = left.min(zeros.len() as u64);
                file.write_all(&zeros[..part as usize])?;
                left -= part;
            }
            Ok(())
        }
        Err(error) => Err(error.into()),
    }
}

/// A file without a name on a disk. What lies in memory would save none.
fn file() -> io::Result<File> {
    for folder in [std::env::temp_dir(), PathBuf::from("/var/tmp")] {
        if let Ok(file) = tempfile::tempfile_in(folder)
            && fstatfs(&file).is_ok_and(|system| system.f_type != TMPFS)
        {
            return Ok(file);
        }
    }
    Err(io::Error::other(
        "no folder for temporary files is on a disk: set TMPDIR to one",
    ))
}

#[cfg(test)]
#[path = "../../tests/unit/ffi/scratch.rs"]
mod tests;
