//! The allocator of a program: the system's, which tells where it has no more. (Rust's own hook for that, which would spare
//! the abort with a backtrace, is not stable.)

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator with what is called, with the bytes that were asked for, where it has none. Who is called must not
/// need memory.
pub struct Telling(pub fn(usize) -> !);

impl Telling {
    #[inline]
    fn checked(&self, memory: *mut u8, bytes: usize) -> *mut u8 {
        if memory.is_null() {
            (self.0)(bytes)
        }
        memory
    }
}

// SAFETY: all is done by the system's allocator, with the caller's own arguments; what it gives is passed on as it is.
unsafe impl GlobalAlloc for Telling {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        self.checked(unsafe { System.alloc(layout) }, layout.size())
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        self.checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    #[inline]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        self.checked(unsafe { System.realloc(memory, layout, size) }, size)
    }

    #[inline]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the same promises.
        unsafe { System.dealloc(memory, layout) }
    }
}
