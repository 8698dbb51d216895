//! OpenColorIO, as far as Sundog needs it: configurations, what is in them, and processors that turn pixels.
//!
//! Texts are copied at the border; nothing here borrows from the library. A [`Config`] may be used from any thread: calls
//! that look into one are made one at a time (OpenColorIO fills some caches in its const functions without a lock). A
//! [`Processor`] works on pixels from any number of threads at once.

mod config;

pub use config::{ColourSpace, Config, DisplayChain, Look, Role, Source, View};

use std::ffi::{CStr, CString, c_char};
use std::ptr::{self, NonNull};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

mod sys {
    #![allow(
        missing_docs,
        non_camel_case_types,
        non_snake_case,
        non_upper_case_globals,
        dead_code
    )]
    #![allow(clippy::all)]
    include!(concat!(env!("OUT_DIR"), "/ocio.rs"));
}

/// What OpenColorIO, or the shim over it, said when it refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct OcioError {
    /// One line, without a full stop at the end.
    pub text: String,
}

impl OcioError {
    fn new(text: &str) -> Self {
        // OpenColorIO's texts can have many lines (whole YAML excerpts): they become one, and not a long one.
        const LONGEST: usize = 600;
        let mut line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if line.chars().count() > LONGEST {
            line = line.chars().take(LONGEST).collect::<String>() + " …";
        }
        // "Error: Loading … failed. yaml-cpp: …" is to become part of a sentence.
        line = line
            .trim_start_matches("Error: ")
            .replace(" failed. ", " failed: ");
        while line.ends_with(['.', ' ']) {
            line.pop();
        }
        if line.is_empty() {
            line.push_str("OpenColorIO failed and did not say why");
        }
        Self { text: line }
    }
}

/// Versions of OpenColorIO: `0xMMmmpp00`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Versions {
    /// Of the headers that the shim was compiled with.
    pub headers: u32,
    /// Of the library that it runs with.
    pub library: u32,
}

impl Versions {
    /// The library's version as `2.6.0`.
    pub fn library_text(self) -> String {
        version_text(self.library)
    }
}

fn version_text(hex: u32) -> String {
    format!("{}.{}.{}", hex >> 24, (hex >> 16) & 0xff, (hex >> 8) & 0xff)
}

/// Checks the shim and the library against what this program was built for, once, and gives the versions.
///
/// # Errors
/// If a struct of the shim has another size than here, or the library another major or minor version than the headers:
/// the pieces don't belong together, and nothing else may be called.
pub fn check() -> Result<Versions, OcioError> {
    static CHECKED: OnceLock<Result<Versions, OcioError>> = OnceLock::new();
    CHECKED.get_or_init(check_now).clone()
}

fn check_now() -> Result<Versions, OcioError> {
    let mut abi = sys::SundogOcioAbi {
        abi_version: 0,
        role_size: 0,
        colour_space_size: 0,
        view_size: 0,
        look_size: 0,
        display_size: 0,
        headers_version: 0,
        library_version: 0,
    };
    // SAFETY: `abi` lives through the call, and the shim writes only if its own struct has the size that is given.
    let written = unsafe { sys::sundog_ocio_abi(&mut abi, size_of::<sys::SundogOcioAbi>()) };
    let sizes = [
        (abi.role_size, size_of::<sys::SundogOcioRole>()),
        (
            abi.colour_space_size,
            size_of::<sys::SundogOcioColourSpace>(),
        ),
        (abi.view_size, size_of::<sys::SundogOcioView>()),
        (abi.look_size, size_of::<sys::SundogOcioLook>()),
        (abi.display_size, size_of::<sys::SundogOcioDisplay>()),
    ];
    let same_sizes = sizes
        .iter()
        .all(|(theirs, ours)| usize::try_from(*theirs) == Ok(*ours));
    if !written || abi.abi_version != sys::SUNDOG_OCIO_ABI_VERSION || !same_sizes {
        return Err(OcioError::new(
            "the program and its shim over OpenColorIO were built from different sources: build again with `cargo clean` before",
        ));
    }
    let versions = Versions {
        headers: abi.headers_version,
        library: abi.library_version,
    };
    if versions.headers >> 16 != versions.library >> 16 {
        return Err(OcioError::new(&format!(
            "this program was built for OpenColorIO {} and finds {}: set LD_LIBRARY_PATH to nothing, or build again",
            version_text(versions.headers),
            version_text(versions.library),
        )));
    }
    Ok(versions)
}

/// What OpenColorIO warned of since the last call, a text each.
pub fn take_warnings() -> Vec<String> {
    // SAFETY: the call takes nothing; what it gives is null or a text of its own allocation.
    let text = unsafe { take_text(sys::sundog_ocio_take_log()) };
    text.unwrap_or_default()
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect()
}

/// One at a time into the library's configurations; see the note at the top.
fn one_at_a_time() -> MutexGuard<'static, ()> {
    static LOCK: Mutex<()> = Mutex::new(());
    LOCK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes a text that the shim allocated, and frees it. `None` for null.
///
/// # Safety
/// `text` is null or came from the shim as the caller's own, and is not used afterwards.
unsafe fn take_text(text: *mut c_char) -> Option<String> {
    if text.is_null() {
        return None;
    }
    // SAFETY: not null, so by the shim's rule a text that ends with NUL.
    let copy = unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned();
    // SAFETY: the shim allocated it and gave it to us; nobody else holds it.
    unsafe { sys::sundog_ocio_text_free(text) };
    Some(copy)
}

/// Reads a text that stays the shim's (a field of a struct that is freed as a whole).
///
/// # Safety
/// `text` is null or points to a text that ends with NUL and lives through the call.
unsafe fn read_text(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: see above.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

/// Calls a function of the shim that takes a place for an error text as its last argument and returns whether it worked.
fn call(function: impl FnOnce(*mut *mut c_char) -> bool) -> Result<(), OcioError> {
    let mut error: *mut c_char = ptr::null_mut();
    let ok = function(&mut error);
    // SAFETY: null, or an error text that the shim allocated for us.
    let text = unsafe { take_text(error) };
    if ok {
        Ok(())
    } else {
        Err(OcioError::new(
            &text.unwrap_or_else(|| "there is not enough memory".to_owned()),
        ))
    }
}

/// As [`call`], for functions that make an object.
fn make<T>(function: impl FnOnce(*mut *mut c_char) -> *mut T) -> Result<NonNull<T>, OcioError> {
    let mut made: *mut T = ptr::null_mut();
    call(|error| {
        made = function(error);
        !made.is_null()
    })?;
    NonNull::new(made).ok_or_else(|| OcioError::new(""))
}

fn c_text(bytes: &[u8]) -> Result<CString, OcioError> {
    CString::new(bytes).map_err(|_| OcioError::new("the name has a zero byte in it"))
}

/// A chain of colour operations, ready for pixels. It needs its [`Config`] no longer.
#[derive(Debug)]
pub struct Processor {
    handle: NonNull<sys::SundogOcioProcessor>,
}

// SAFETY: the object behind the handle is bound to no thread (a shared pointer to a const object).
unsafe impl Send for Processor {}
// SAFETY: OpenColorIO's CPU processor is made to be applied from many threads at once; it is const after it was made,
// and none of its properties is made dynamic here.
unsafe impl Sync for Processor {}

impl Processor {
    /// Turns pixels in place. Values may be anything, infinities and NaN too.
    ///
    /// # Errors
    /// If the library fails.
    pub fn apply_rgb(&self, pixels: &mut [[f32; 3]]) -> Result<(), OcioError> {
        self.apply(pixels.as_flattened_mut(), 3)
    }

    /// Turns the colours of pixels in place. Alpha is handed through: who has associated alpha divides before.
    ///
    /// # Errors
    /// If the library fails.
    pub fn apply_rgba(&self, pixels: &mut [[f32; 4]]) -> Result<(), OcioError> {
        self.apply(pixels.as_flattened_mut(), 4)
    }

    fn apply(&self, values: &mut [f32], channels: usize) -> Result<(), OcioError> {
        if values.is_empty() {
            return Ok(());
        }
        let count = values.len() / channels;
        let (handle, start) = (self.handle.as_ptr(), values.as_mut_ptr());
        // SAFETY: the handle is valid while `self` lives; `count` pixels of `channels` floats lie at `start`, and nobody
        // else has them during the call.
        call(|error| unsafe { sys::sundog_ocio_apply(handle, start, count, channels, error) })
    }

    /// True if every pixel stays as it is.
    ///
    /// # Errors
    /// If the library fails.
    pub fn is_identity(&self) -> Result<bool, OcioError> {
        let mut identity = false;
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        call(|error| unsafe {
            sys::sundog_ocio_processor_is_identity(self.handle.as_ptr(), &mut identity, error)
        })?;
        Ok(identity)
    }
}

impl Drop for Processor {
    fn drop(&mut self) {
        // SAFETY: the handle came from the shim, and this is the only place that frees it. The lock: what the processor
        // shares with its configuration's caches is let go here.
        let _lock = one_at_a_time();
        // SAFETY: as above.
        unsafe { sys::sundog_ocio_processor_free(self.handle.as_ptr()) };
    }
}

#[cfg(test)]
#[path = "../../tests/unit/ffi/ocio.rs"]
mod tests;
