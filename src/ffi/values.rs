//! Numbers of an image, in memory or in a scratch file that is mapped into it: the system reads what is asked for, and gives up
//! what was not asked for long when memory gets short.

use bytemuck::Pod;
use memmap2::{Mmap, MmapOptions};
use rustix::fs::fstatfs;
use std::fmt;
use std::fs::File;
use std::io::{self, Write};
use std::ops::{Deref, DerefMut};
use std::path::PathBuf;
use std::ptr::NonNull;

/// Numbers that are read as a slice, wherever they are.
pub struct Values<T> {
    /// Where they begin: in `kept`, which does not move them.
    start: NonNull<T>,
    count: usize,
    kept: Kept<T>,
}

/// What the numbers live in.
enum Kept<T> {
    Memory(Vec<T>),
    #[expect(dead_code, reason = "it keeps the memory mapped")]
    File(Mmap),
}

// SAFETY: `start` points into `kept`, which `Values` owns as a vector owns its values; both of its kinds may be sent.
unsafe impl<T: Send> Send for Values<T> {}
// SAFETY: as above; a shared reference gives shared references to the values alone.
unsafe impl<T: Sync> Sync for Values<T> {}

/// The number by which Linux knows a file system in memory (`statfs(2)`).
const TMPFS: i64 = 0x0102_1994;

impl<T: Pod> Values<T> {
    /// Moves numbers into a scratch file, which has no name and is gone when nobody reads it.
    ///
    /// # Errors
    /// No folder for temporary files is on a disk, or there is no room.
    pub fn in_file(values: &[T]) -> io::Result<Self> {
        let mut file = scratch()?;
        file.write_all(bytemuck::cast_slice(values))?;
        if values.is_empty() {
            return Ok(Vec::new().into());
        }
        // SAFETY: the file has no name and its one handle is here: nobody changes it or makes it shorter.
        let map = unsafe { MmapOptions::new().map(&file)? };
        // A page begins where any number may.
        let count = bytemuck::try_cast_slice::<u8, T>(&map).map_or(0, <[T]>::len);
        if count != values.len() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let start = NonNull::from(&*map).cast();
        Ok(Self {
            start,
            count,
            kept: Kept::File(map),
        })
    }
}

impl<T> Values<T> {
    /// Whether they are in a scratch file.
    pub fn are_in_file(&self) -> bool {
        matches!(self.kept, Kept::File(_))
    }
}

/// A file without a name on a disk. What lies in memory would save none.
fn scratch() -> io::Result<File> {
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

impl<T> From<Vec<T>> for Values<T> {
    fn from(values: Vec<T>) -> Self {
        Self {
            start: NonNull::from(&*values).cast(),
            count: values.len(),
            kept: Kept::Memory(values),
        }
    }
}

impl<T> Deref for Values<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        // SAFETY: `start` and `count` are those of the slice in `kept`, which lives as long and is not changed meanwhile.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.count) }
    }
}

impl<T: Clone> DerefMut for Values<T> {
    /// Those of a file are taken into memory first.
    fn deref_mut(&mut self) -> &mut [T] {
        if self.are_in_file() {
            *self = self.to_vec().into();
        }
        match &mut self.kept {
            Kept::Memory(values) => {
                // The one way from here on: a slice through `values` would end what `start` may do.
                self.start = NonNull::from(&mut **values).cast();
                // SAFETY: the slice of `values`, which is borrowed for as long.
                unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.count) }
            }
            Kept::File(_) => &mut [],
        }
    }
}

impl<T: Clone> Clone for Values<T> {
    /// A copy in memory.
    fn clone(&self) -> Self {
        self.to_vec().into()
    }
}

impl<T: PartialEq> PartialEq for Values<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: fmt::Debug> fmt::Debug for Values<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&**self, f)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/ffi/values.rs"]
mod tests;
