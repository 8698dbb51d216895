//! Open Image Denoise, as far as Sundog needs it, opened when it is asked for: a machine without it renders all the same.
//!
//! The declarations are by hand, since there are no headers in the package that carries the library: handles are opaque,
//! enumerations are C's `int`, and no struct crosses the border. [`Library::open`] asks for the version and gives nothing of
//! a wrong one away.

use libloading::os::unix::{Library as Object, RTLD_LOCAL, RTLD_NOW};
use serde::Serialize;
use std::ffi::{CStr, OsString, c_char, c_double, c_int, c_void};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::ptr::{self, NonNull};

/// The file that is opened; the others are found beside it.
pub const FILE: &str = "libOpenImageDenoise.so.2";
/// The start of the file with the processor's part.
const CPU_PART: &str = "libOpenImageDenoise_device_cpu.so.";
/// The oldest version with all that is called here: 2.3 brought the fast quality. The next major version has another interface.
const VERSIONS: std::ops::Range<i32> = 20_300..30_000;

/// Each library first looks for symbols in itself and in what it brings (glibc's `dlfcn.h`).
///
/// Embree's TBB is in this process by the same symbols, and an older one.
const RTLD_DEEPBIND: c_int = 8;

const DEVICE_CPU: c_int = 1;
const FORMAT_FLOAT3: c_int = 3;
const ERROR_CANCELLED: c_int = 6;

// The enumerations of the interface are those of C: what is passed as an `int` has 32 bits.
const _: () = assert!(size_of::<c_int>() == 4 && size_of::<bool>() == 1);

type Handle = NonNull<c_void>;
type Monitor = unsafe extern "C" fn(*mut c_void, c_double) -> bool;

/// What the library, or the search for it, said when it refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum OidnError {
    /// It can't be opened.
    #[error("{path} can't be opened: {reason}")]
    NotOpened {
        /// The file.
        path: String,
        /// The loader's words.
        reason: String,
    },
    /// It is not the version that is called here.
    #[error(
        "{path} is version {version} of Open Image Denoise, and Sundog needs 2.3 or newer (below 3)"
    )]
    Version {
        /// The file.
        path: String,
        /// As `2.1.0`.
        version: String,
    },
    /// A call failed.
    #[error("Open Image Denoise: {0}")]
    Failed(String),
    /// Whoever called does not want it any more.
    #[error("denoising was broken off")]
    Cancelled,
}

/// How much work the denoiser does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[repr(i32)]
pub enum Quality {
    /// The least.
    Fast = 4,
    /// Between them.
    Balanced = 5,
    /// The best.
    #[default]
    High = 6,
}

/// What an image is to a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// What is denoised, if it is not a guide itself.
    Color,
    /// A guide, or what is denoised by itself.
    Albedo,
    /// A guide, or what is denoised by itself.
    Normal,
}

impl Role {
    fn name(self) -> &'static CStr {
        match self {
            Self::Color => c"color",
            Self::Albedo => c"albedo",
            Self::Normal => c"normal",
        }
    }
}

/// An image: `channels` floats a pixel, of which the first three are looked at, rows from top to bottom.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a> {
    /// Values.
    pub data: &'a [f32],
    /// Floats of a pixel.
    pub channels: usize,
}

/// What one run of a filter does.
#[derive(Debug, Clone, Copy)]
pub struct Filter {
    /// Values may be above 1.
    pub hdr: bool,
    /// The guides have no noise of their own.
    pub clean_guides: bool,
    /// Work.
    pub quality: Quality,
}

/// Declares the functions that are called, and how they are found.
macro_rules! functions {
    ($($name:ident: $symbol:literal, fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the library.
        struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            fn find(library: &Object) -> Result<Self, libloading::Error> {
                Ok(Self {
                    $($name: {
                        // SAFETY: the type is that of the function in `oidn.h` of versions 2.x. The pointer is valid as long
                        // as the library is open, which is as long as the process.
                        let found = unsafe {
                            library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($symbol)
                        }?;
                        *found
                    },)*
                })
            }
        }
    };
}

functions! {
    new_device: b"oidnNewDevice\0", fn(c_int) -> Option<Handle>;
    release_device: b"oidnReleaseDevice\0", fn(Handle);
    set_device_bool: b"oidnSetDeviceBool\0", fn(Handle, *const c_char, bool);
    set_device_int: b"oidnSetDeviceInt\0", fn(Handle, *const c_char, c_int);
    get_device_int: b"oidnGetDeviceInt\0", fn(Handle, *const c_char) -> c_int;
    commit_device: b"oidnCommitDevice\0", fn(Handle);
    get_device_error: b"oidnGetDeviceError\0", fn(Option<Handle>, *mut *const c_char) -> c_int;
    new_filter: b"oidnNewFilter\0", fn(Handle, *const c_char) -> Option<Handle>;
    release_filter: b"oidnReleaseFilter\0", fn(Handle);
    set_filter_image: b"oidnSetSharedFilterImage\0", fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool: b"oidnSetFilterBool\0", fn(Handle, *const c_char, bool);
    set_filter_int: b"oidnSetFilterInt\0", fn(Handle, *const c_char, c_int);
    set_filter_monitor: b"oidnSetFilterProgressMonitorFunction\0", fn(Handle, Option<Monitor>, *mut c_void);
    commit_filter: b"oidnCommitFilter\0", fn(Handle);
    execute_filter: b"oidnExecuteFilter\0", fn(Handle);
}

/// The opened library.
pub struct Library {
    functions: Functions,
    path: PathBuf,
    version: i32,
}

impl Library {
    /// Opens the library in a folder, or (an empty path) the one that the system's loader finds.
    ///
    /// # Errors
    /// It is not there, lacks something, or has another version.
    pub fn open(folder: &Path) -> Result<Self, OidnError> {
        let path = folder.join(FILE);
        let not_opened = |error: libloading::Error| OidnError::NotOpened {
            path: path.display().to_string(),
            reason: error.to_string(),
        };
        let object = open(&path).map_err(not_opened)?;
        // The library would open it without RTLD_DEEPBIND; what is open already stays as it is.
        let cpu_part = files(folder).into_iter().find(is_cpu_part);
        let cpu_part = cpu_part.map(|name| open(&folder.join(name)));
        let functions = Functions::find(&object).map_err(not_opened)?;
        // Never closed: it has threads and handlers of its own.
        std::mem::forget((object, cpu_part.transpose().map_err(not_opened)?));
        let mut library = Self {
            functions,
            path,
            version: 0,
        };
        let version = Device::new(&library, 1)?.int(c"version");
        library.version = version;
        if VERSIONS.contains(&library.version) {
            return Ok(library);
        }
        Err(OidnError::Version {
            path: library.path.display().to_string(),
            version: library.version(),
        })
    }

    /// As `2.5.1`.
    pub fn version(&self) -> String {
        let version = self.version;
        format!(
            "{}.{}.{}",
            version / 10_000,
            version / 100 % 100,
            version % 100
        )
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes the error that was kept last; of a device, or of none.
    fn error(&self, device: Option<Handle>) -> Option<OidnError> {
        let mut text = ptr::null();
        // SAFETY: the handle is of a device that lives, or none; `text` lives through the call.
        let code = unsafe { (self.functions.get_device_error)(device, &mut text) };
        if code == 0 {
            return None;
        }
        if code == ERROR_CANCELLED {
            return Some(OidnError::Cancelled);
        }
        let words = NonNull::new(text.cast_mut()).map(|text| {
            // SAFETY: the library gives a text that ends with NUL and lives until the next call that fails.
            unsafe { CStr::from_ptr(text.as_ptr()) }
        });
        let words = words.map_or_else(
            || format!("error {code}"),
            |text| text.to_string_lossy().into_owned(),
        );
        Some(OidnError::Failed(words))
    }
}

fn open(path: &Path) -> Result<Object, libloading::Error> {
    // SAFETY: what runs when it is opened is the library's own set-up, which asks for nothing of this process.
    unsafe { Object::open(Some(path), RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND) }
}

/// Names of what is in a folder.
fn files(folder: &Path) -> Vec<OsString> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name()).collect()
}

fn is_cpu_part(name: &OsString) -> bool {
    name.as_encoded_bytes().starts_with(CPU_PART.as_bytes())
}

/// The processor, as the library works with it.
pub struct Device<'a> {
    library: &'a Library,
    handle: Handle,
}

impl<'a> Device<'a> {
    /// With so many threads, or (0) as many as the processor has.
    ///
    /// # Errors
    /// The library can't work on this processor.
    pub fn new(library: &'a Library, threads: usize) -> Result<Self, OidnError> {
        let functions = &library.functions;
        // SAFETY: the call takes a number; what it gives is null or a handle that is released once, by `drop`.
        let handle = unsafe { (functions.new_device)(DEVICE_CPU) };
        let Some(handle) = handle else {
            let unknown = || OidnError::Failed("it has no device for this processor".into());
            return Err(library.error(None).unwrap_or_else(unknown));
        };
        let device = Self { library, handle };
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the handle lives, and the names end with NUL.
        unsafe {
            // Threads tied to processors would stay so when others are busy.
            (functions.set_device_bool)(handle, c"setAffinity".as_ptr(), false);
            (functions.set_device_int)(handle, c"numThreads".as_ptr(), threads);
            (functions.commit_device)(handle);
        }
        device.checked()?;
        Ok(device)
    }

    fn int(&self, name: &CStr) -> i32 {
        // SAFETY: the handle lives, and the name ends with NUL.
        unsafe { (self.library.functions.get_device_int)(self.handle, name.as_ptr()) }
    }

    fn checked(&self) -> Result<(), OidnError> {
        self.library.error(Some(self.handle)).map_or(Ok(()), Err)
    }

    /// Denoises the first of some images, the others being its guides, into `out` with as many channels: only the first three of
    /// them are written. `cancelled` is asked now and then, from any thread.
    ///
    /// # Errors
    /// The images have other sizes; a call fails, for want of memory for instance; or it was cancelled, and `out` is worth nothing.
    pub fn run(
        &self,
        (width, height): (u32, u32),
        images: &[(Role, Image)],
        out: (&mut [f32], usize),
        filter: Filter,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), OidnError> {
        let size = (width as usize, height as usize);
        let (out, out_channels) = out;
        let fits = |length: usize, channels: usize| {
            let pixels = size.0.checked_mul(size.1);
            channels >= 3 && pixels.and_then(|pixels| pixels.checked_mul(channels)) == Some(length)
        };
        let images_fit = images
            .iter()
            .all(|(_, image)| fits(image.data.len(), image.channels));
        if !images_fit || !fits(out.len(), out_channels) {
            return Err(OidnError::Failed(
                "its images are of different sizes".into(),
            ));
        }
        let run = FilterRun::new(self)?;
        for (role, image) in images {
            // The library reads inputs alone.
            let data = image.data.as_ptr().cast_mut();
            run.set_image(role.name(), data, size, image.channels);
        }
        run.set_image(c"output", out.as_mut_ptr(), size, out_channels);
        run.execute(filter, cancelled)
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is this one's own, and no filter of it lives.
        unsafe { (self.library.functions.release_device)(self.handle) }
    }
}

/// A filter, from its making to its only run: it keeps pointers, so that it lives no longer than the images.
struct FilterRun<'a> {
    device: &'a Device<'a>,
    handle: Handle,
    /// What the library is told of belongs to one thread at a time.
    not_sync: PhantomData<*mut f32>,
}

impl<'a> FilterRun<'a> {
    fn new(device: &'a Device<'a>) -> Result<Self, OidnError> {
        let library = device.library;
        // SAFETY: the device lives; what it gives is null or a handle that is released once, by `drop`.
        let handle = unsafe { (library.functions.new_filter)(device.handle, c"RT".as_ptr()) };
        let Some(handle) = handle else {
            let unknown = || OidnError::Failed("it has no filter for rendered pictures".into());
            return Err(library.error(Some(device.handle)).unwrap_or_else(unknown));
        };
        Ok(Self {
            device,
            handle,
            not_sync: PhantomData,
        })
    }

    /// `data` has the pixels of the size, with so many floats each, and outlives the run.
    fn set_image(&self, name: &CStr, data: *mut f32, size: (usize, usize), channels: usize) {
        let pixel = channels * size_of::<f32>();
        // SAFETY: the handle lives, the name ends with NUL, and `run` has checked that the size fits the data.
        unsafe {
            (self.device.library.functions.set_filter_image)(
                self.handle,
                name.as_ptr(),
                data.cast(),
                FORMAT_FLOAT3,
                size.0,
                size.1,
                0,
                pixel,
                pixel * size.0,
            );
        }
    }

    fn execute(
        self,
        filter: Filter,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), OidnError> {
        let functions = &self.device.library.functions;
        let user: *const &(dyn Fn() -> bool + Sync) = &cancelled;
        // SAFETY: the handle, the images and `cancelled` live until the run has ended; names end with NUL.
        unsafe {
            (functions.set_filter_bool)(self.handle, c"hdr".as_ptr(), filter.hdr);
            (functions.set_filter_bool)(self.handle, c"srgb".as_ptr(), false);
            (functions.set_filter_bool)(self.handle, c"cleanAux".as_ptr(), filter.clean_guides);
            (functions.set_filter_int)(self.handle, c"quality".as_ptr(), filter.quality as c_int);
            let user = user.cast_mut().cast();
            (functions.set_filter_monitor)(self.handle, Some(goes_on), user);
            (functions.commit_filter)(self.handle);
            (functions.execute_filter)(self.handle);
        }
        self.device.checked()
    }
}

impl Drop for FilterRun<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is this one's own.
        unsafe { (self.device.library.functions.release_filter)(self.handle) }
    }
}

/// Whether a run is still wanted.
unsafe extern "C" fn goes_on(user: *mut c_void, _: c_double) -> bool {
    // SAFETY: `execute` has set the pointer to a reference that outlives the run.
    let cancelled = unsafe { &*user.cast::<&(dyn Fn() -> bool + Sync)>() };
    !cancelled()
}

#[cfg(test)]
#[path = "../../tests/unit/ffi/oidn.rs"]
mod tests;
