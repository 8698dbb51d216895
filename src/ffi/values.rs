//! Numbers of an image, in memory or in a scratch file that is mapped into it: the system reads what is asked for, and gives up
//! what was not asked for long when memory gets short.

use super::scratch::Scratch;
use bytemuck::Pod;
use std::fmt;
use std::io;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

/// Where numbers are to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In memory.
    Memory,
    /// In a scratch file, if there is room for one.
    File,
}

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
    File(Scratch),
}

// SAFETY: `start` points into `kept`, which `Values` owns as a vector owns its values; both of its kinds may be sent.
unsafe impl<T: Send> Send for Values<T> {}
// SAFETY: as above; a shared reference gives shared references to the values alone.
unsafe impl<T: Sync> Sync for Values<T> {}

impl<T: Pod> Values<T> {
    /// Zeros in a scratch file, which has no name and is gone when nobody reads it.
    ///
    /// # Errors
    /// No folder for temporary files is on a disk, or there is no room.
    pub fn zeros_in_file(count: usize) -> io::Result<Self> {
        let too_many = || io::Error::from(io::ErrorKind::InvalidInput);
        let bytes = count.checked_mul(size_of::<T>()).ok_or_else(too_many)?;
        if bytes == 0 {
            return Ok(Vec::new().into());
        }
        let scratch = Scratch::new(bytes)?;
        Ok(Self {
            // A page begins where any number may.
            start: scratch.start().cast(),
            count,
            kept: Kept::File(scratch),
        })
    }

    /// Zeros at a place.
    pub fn zeros(count: usize, place: Place) -> Self {
        if place == Place::File
            && let Ok(there) = Self::zeros_in_file(count)
        {
            return there;
        }
        vec![T::zeroed(); count].into()
    }

    /// Copies numbers into a scratch file.
    ///
    /// # Errors
    /// As [`Self::zeros_in_file`].
    pub fn in_file(values: &[T]) -> io::Result<Self> {
        let mut there = Self::zeros_in_file(values.len())?;
        there.copy_from_slice(values);
        Ok(there)
    }
}

impl<T: Clone> Values<T> {
    /// A vector of them.
    pub fn into_vec(self) -> Vec<T> {
        match self.kept {
            Kept::Memory(values) => values,
            Kept::File(_) => self.to_vec(),
        }
    }
}

impl<T> Values<T> {
    /// Whether they are in a scratch file.
    pub fn are_in_file(&self) -> bool {
        self.place() == Place::File
    }

    /// Where they are.
    pub fn place(&self) -> Place {
        match self.kept {
            Kept::Memory(_) => Place::Memory,
            Kept::File(_) => Place::File,
        }
    }
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

impl<T> DerefMut for Values<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        if let Kept::Memory(values) = &mut self.kept {
            // The one way from here on: a slice through `values` would end what `start` may do.
            self.start = NonNull::from(&mut **values).cast();
        }
        // SAFETY: the slice of `kept`, which is borrowed for as long; nobody but `Values` reaches what a scratch file holds.
        unsafe { std::slice::from_raw_parts_mut(self.start.as_ptr(), self.count) }
    }
}

impl<T: Pod> Clone for Values<T> {
    /// A copy where they are, if there is room for it.
    fn clone(&self) -> Self {
        if self.are_in_file()
            && let Ok(copy) = Self::in_file(self)
        {
            return copy;
        }
        // Not with zeros first.
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
