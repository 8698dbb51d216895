//! OpenColorIO, as far as Sundog needs it: configurations, what is in them, and processors that turn pixels.
//!
//! Texts are copied at the border; nothing here borrows from the library. A [`Config`] may be used from any thread: calls
//! that look into one are made one at a time (OpenColorIO fills some caches in its const functions without a lock). A
//! [`Processor`] works on pixels from any number of threads at once.

use std::ffi::{CStr, CString, OsStr};
use std::os::raw::c_char;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
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

/// A role and the colour space that plays it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Role {
    /// For example `scene_linear`.
    pub name: String,
    /// For example `Linear Rec.709`.
    pub colour_space: String,
}

/// A colour space, as the configuration describes it. Texts that it doesn't give are empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourSpace {
    /// Its own name (aliases not counted).
    pub name: String,
    /// A group for menus.
    pub family: String,
    /// For example `scene-linear`, `sdr-video`.
    pub encoding: String,
    /// What it is, for people.
    pub description: String,
    /// Not a colour (normals, masks): never converted.
    pub is_data: bool,
    /// Its values mean a display's light and not the scene's.
    pub is_display_referred: bool,
}

/// A view of one display. Texts that the configuration doesn't give are empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct View {
    /// For example `AgX`.
    pub name: String,
    /// The colour space that it ends in.
    pub colour_space: String,
    /// The view transform on the way there, in configurations that have those.
    pub view_transform: String,
    /// Looks that the view brings along by itself, in OpenColorIO's notation.
    pub looks: String,
    /// What it is, for people.
    pub description: String,
}

/// A look: a change of the picture on the way to the view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Look {
    /// For example `AgX - Punchy`.
    pub name: String,
    /// The colour space in which it works.
    pub process_space: String,
    /// What it is, for people.
    pub description: String,
}

/// What the pixels are that a display processor is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// In the configuration's scene-linear space.
    SceneLinear,
    /// In linear Rec.709 (D65), which is to be brought to the scene-linear space first.
    LinearRec709,
}

/// What a display processor does, in this order: `source` to scene-linear, exposure, look, view and display, gamma,
/// display scale.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayChain<'a> {
    /// What the pixels are.
    pub source: Source,
    /// One of [`Config::displays`].
    pub display: &'a str,
    /// One of [`Config::views`] of that display.
    pub view: &'a str,
    /// In OpenColorIO's notation. It replaces the looks that the view brings along; `None` leaves those.
    pub look: Option<&'a str>,
    /// Factor on scene-linear light.
    pub scale: f64,
    /// Factor on the display's light at the end. Not 1 only for views that end in a display-referred space of a
    /// configuration with the role `cie_xyz_d65_interchange`.
    pub display_scale: f64,
    /// Display values are raised to this power; negative ones become 0 if it is not 1.
    pub exponent: f64,
}

/// A colour configuration.
#[derive(Debug)]
pub struct Config {
    handle: NonNull<sys::SundogOcioConfig>,
}

// SAFETY: the object behind the handle is bound to no thread (a shared pointer to a const object), and every call into
// it holds the one lock of `one_at_a_time`, dropping included.
unsafe impl Send for Config {}
// SAFETY: as for `Send`: calls from several threads are made one after the other.
unsafe impl Sync for Config {}

impl Config {
    /// Reads a configuration: a `.ocio` file, a `.ocioz` archive, or one inside the library (`ocio://default`, …).
    ///
    /// # Errors
    /// If it cannot be read or understood.
    pub fn from_file(path_or_uri: &OsStr) -> Result<Self, OcioError> {
        check()?;
        let path = c_text(path_or_uri.as_bytes())?;
        let _lock = one_at_a_time();
        // SAFETY: `path` is a text that ends with NUL and lives through the call.
        let handle =
            make(|error| unsafe { sys::sundog_ocio_config_from_file(path.as_ptr(), error) })?;
        Ok(Self { handle })
    }

    /// Reads a configuration from the text of a `.ocio` file. Files that it refers to are not found.
    ///
    /// # Errors
    /// If it cannot be understood.
    pub fn from_text(text: &[u8]) -> Result<Self, OcioError> {
        check()?;
        let _lock = one_at_a_time();
        let (start, length) = (text.as_ptr().cast::<c_char>(), text.len());
        // SAFETY: `length` bytes from `start` on can be read during the call; the shim copies them.
        let handle =
            make(|error| unsafe { sys::sundog_ocio_config_from_text(start, length, error) })?;
        Ok(Self { handle })
    }

    /// The library's own fall-back: a display `sRGB` with the view `Raw`, and no colour management at all.
    ///
    /// # Errors
    /// If the library fails.
    pub fn raw() -> Result<Self, OcioError> {
        check()?;
        let _lock = one_at_a_time();
        // SAFETY: the call takes nothing but the place for the error.
        let handle = make(|error| unsafe { sys::sundog_ocio_config_raw(error) })?;
        Ok(Self { handle })
    }

    fn pointer(&self) -> *const sys::SundogOcioConfig {
        self.handle.as_ptr()
    }

    /// Runs one call that gives a text.
    fn text(
        &self,
        get: impl FnOnce(*mut *mut c_char, *mut *mut c_char) -> bool,
    ) -> Result<Option<String>, OcioError> {
        let _lock = one_at_a_time();
        let mut text: *mut c_char = ptr::null_mut();
        call(|error| get(&mut text, error))?;
        // SAFETY: null, or a text that the shim allocated for us.
        Ok(unsafe { take_text(text) })
    }

    /// Runs a call that counts, then one that reads for every index.
    fn list<T>(
        &self,
        count: impl FnOnce(*mut usize, *mut *mut c_char) -> bool,
        read: impl FnMut(usize) -> Result<T, OcioError>,
    ) -> Result<Vec<T>, OcioError> {
        let mut length = 0_usize;
        {
            let _lock = one_at_a_time();
            call(|error| count(&mut length, error))?;
        }
        (0..length).map(read).collect()
    }

    /// The configuration's name; many have none.
    ///
    /// # Errors
    /// If the library fails.
    pub fn name(&self) -> Result<String, OcioError> {
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        let name = self.text(|out, error| unsafe {
            sys::sundog_ocio_config_name(self.pointer(), out, error)
        })?;
        Ok(name.unwrap_or_default())
    }

    /// What the configuration says about itself.
    ///
    /// # Errors
    /// If the library fails.
    pub fn description(&self) -> Result<String, OcioError> {
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        let text = self.text(|out, error| unsafe {
            sys::sundog_ocio_config_description(self.pointer(), out, error)
        })?;
        Ok(text.unwrap_or_default())
    }

    /// Major and minor version of the configuration's format.
    ///
    /// # Errors
    /// If the library fails.
    pub fn profile(&self) -> Result<(u32, u32), OcioError> {
        let _lock = one_at_a_time();
        let (mut major, mut minor) = (0, 0);
        // SAFETY: the handle is valid while `self` lives; the three places live through the call.
        call(|error| unsafe {
            sys::sundog_ocio_config_profile(self.pointer(), &mut major, &mut minor, error)
        })?;
        Ok((major, minor))
    }

    /// The files that its transforms refer to, as far as they are there. None is opened.
    ///
    /// # Errors
    /// If the library fails.
    pub fn files(&self) -> Result<Vec<PathBuf>, OcioError> {
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        let paths = self.text(|out, error| unsafe {
            sys::sundog_ocio_config_files(self.pointer(), out, error)
        })?;
        let mut paths: Vec<PathBuf> = paths
            .unwrap_or_default()
            .lines()
            .filter(|path| !path.is_empty())
            .map(PathBuf::from)
            .collect();
        paths.sort();
        paths.dedup();
        Ok(paths)
    }

    /// All roles.
    ///
    /// # Errors
    /// If the library fails.
    pub fn roles(&self) -> Result<Vec<Role>, OcioError> {
        self.list(
            // SAFETY: the handle is valid while `self` lives; both places live through the call.
            |count, error| unsafe { sys::sundog_ocio_role_count(self.pointer(), count, error) },
            |index| {
                let _lock = one_at_a_time();
                let mut raw = sys::SundogOcioRole {
                    name: ptr::null_mut(),
                    colour_space: ptr::null_mut(),
                };
                // SAFETY: the handle is valid while `self` lives; both places live through the call.
                call(|error| unsafe {
                    sys::sundog_ocio_role(self.pointer(), index, &mut raw, error)
                })?;
                // SAFETY: the shim filled the struct; its texts live until it is freed, once, after they were copied.
                unsafe {
                    let role = Role {
                        name: read_text(raw.name),
                        colour_space: read_text(raw.colour_space),
                    };
                    sys::sundog_ocio_role_free(&mut raw);
                    Ok(role)
                }
            },
        )
    }

    /// The active colour spaces, in the configuration's order.
    ///
    /// # Errors
    /// If the library fails.
    pub fn colour_spaces(&self) -> Result<Vec<ColourSpace>, OcioError> {
        self.list(
            // SAFETY: the handle is valid while `self` lives; both places live through the call.
            |count, error| unsafe {
                sys::sundog_ocio_colour_space_count(self.pointer(), count, error)
            },
            |index| {
                let _lock = one_at_a_time();
                let mut raw = sys::SundogOcioColourSpace {
                    name: ptr::null_mut(),
                    family: ptr::null_mut(),
                    encoding: ptr::null_mut(),
                    description: ptr::null_mut(),
                    is_data: false,
                    is_display_referred: false,
                };
                // SAFETY: the handle is valid while `self` lives; both places live through the call.
                call(|error| unsafe {
                    sys::sundog_ocio_colour_space(self.pointer(), index, &mut raw, error)
                })?;
                // SAFETY: the shim filled the struct; its texts live until it is freed, once, after they were copied.
                unsafe {
                    let space = ColourSpace {
                        name: read_text(raw.name),
                        family: read_text(raw.family),
                        encoding: read_text(raw.encoding),
                        description: read_text(raw.description),
                        is_data: raw.is_data,
                        is_display_referred: raw.is_display_referred,
                    };
                    sys::sundog_ocio_colour_space_free(&mut raw);
                    Ok(space)
                }
            },
        )
    }

    /// Whether there is a colour space, active or not, or a role or an alias, of this name.
    ///
    /// # Errors
    /// If the library fails.
    pub fn has_colour_space(&self, name: &str) -> Result<bool, OcioError> {
        let name = c_text(name.as_bytes())?;
        let _lock = one_at_a_time();
        let mut has = false;
        // SAFETY: the handle is valid while `self` lives; the text and both places live through the call.
        call(|error| unsafe {
            sys::sundog_ocio_has_colour_space(self.pointer(), name.as_ptr(), &mut has, error)
        })?;
        Ok(has)
    }

    /// The active displays, in the configuration's order.
    ///
    /// # Errors
    /// If the library fails.
    pub fn displays(&self) -> Result<Vec<String>, OcioError> {
        self.list(
            // SAFETY: the handle is valid while `self` lives; both places live through the call.
            |count, error| unsafe { sys::sundog_ocio_display_count(self.pointer(), count, error) },
            |index| {
                // SAFETY: the handle is valid while `self` lives; both places live through the call.
                let name = self.text(|out, error| unsafe {
                    sys::sundog_ocio_display(self.pointer(), index, out, error)
                })?;
                Ok(name.unwrap_or_default())
            },
        )
    }

    /// The display that the configuration means where none is named.
    ///
    /// # Errors
    /// If the library fails.
    pub fn default_display(&self) -> Result<Option<String>, OcioError> {
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        let name = self.text(|out, error| unsafe {
            sys::sundog_ocio_default_display(self.pointer(), out, error)
        })?;
        Ok(name.filter(|name| !name.is_empty()))
    }

    /// The active views of a display, in the configuration's order; none for a display that isn't there.
    ///
    /// # Errors
    /// If the library fails.
    pub fn views(&self, display: &str) -> Result<Vec<View>, OcioError> {
        let display = c_text(display.as_bytes())?;
        self.list(
            // SAFETY: the handle is valid while `self` lives; the text and both places live through the call.
            |count, error| unsafe {
                sys::sundog_ocio_view_count(self.pointer(), display.as_ptr(), count, error)
            },
            |index| {
                let _lock = one_at_a_time();
                let mut raw = sys::SundogOcioView {
                    name: ptr::null_mut(),
                    colour_space: ptr::null_mut(),
                    view_transform: ptr::null_mut(),
                    looks: ptr::null_mut(),
                    description: ptr::null_mut(),
                };
                // SAFETY: the handle is valid while `self` lives; the text and both places live through the call.
                call(|error| unsafe {
                    sys::sundog_ocio_view(self.pointer(), display.as_ptr(), index, &mut raw, error)
                })?;
                // SAFETY: the shim filled the struct; its texts live until it is freed, once, after they were copied.
                unsafe {
                    let view = View {
                        name: read_text(raw.name),
                        colour_space: read_text(raw.colour_space),
                        view_transform: read_text(raw.view_transform),
                        looks: read_text(raw.looks),
                        description: read_text(raw.description),
                    };
                    sys::sundog_ocio_view_free(&mut raw);
                    Ok(view)
                }
            },
        )
    }

    /// The view that the configuration means where none is named for a display.
    ///
    /// # Errors
    /// If the library fails.
    pub fn default_view(&self, display: &str) -> Result<Option<String>, OcioError> {
        let display = c_text(display.as_bytes())?;
        // SAFETY: the handle is valid while `self` lives; the text and both places live through the call.
        let name = self.text(|out, error| unsafe {
            sys::sundog_ocio_default_view(self.pointer(), display.as_ptr(), out, error)
        })?;
        Ok(name.filter(|name| !name.is_empty()))
    }

    /// All looks, in the configuration's order.
    ///
    /// # Errors
    /// If the library fails.
    pub fn looks(&self) -> Result<Vec<Look>, OcioError> {
        self.list(
            // SAFETY: the handle is valid while `self` lives; both places live through the call.
            |count, error| unsafe { sys::sundog_ocio_look_count(self.pointer(), count, error) },
            |index| {
                let _lock = one_at_a_time();
                let mut raw = sys::SundogOcioLook {
                    name: ptr::null_mut(),
                    process_space: ptr::null_mut(),
                    description: ptr::null_mut(),
                };
                // SAFETY: the handle is valid while `self` lives; both places live through the call.
                call(|error| unsafe {
                    sys::sundog_ocio_look(self.pointer(), index, &mut raw, error)
                })?;
                // SAFETY: the shim filled the struct; its texts live until it is freed, once, after they were copied.
                unsafe {
                    let look = Look {
                        name: read_text(raw.name),
                        process_space: read_text(raw.process_space),
                        description: read_text(raw.description),
                    };
                    sys::sundog_ocio_look_free(&mut raw);
                    Ok(look)
                }
            },
        )
    }

    /// Whether the scene-linear space is linear Rec.709 (D65), the space that Sundog computes in, up to the digits in
    /// which configurations write their matrices.
    ///
    /// # Errors
    /// If the configuration gives no way to find out (no interchange role, nothing that looks familiar).
    pub fn is_scene_linear_rec709(&self) -> Result<bool, OcioError> {
        let _lock = one_at_a_time();
        let mut is = false;
        // SAFETY: the handle is valid while `self` lives; both places live through the call.
        call(|error| unsafe {
            sys::sundog_ocio_is_scene_linear_rec709(self.pointer(), &mut is, error)
        })?;
        Ok(is)
    }

    /// From one colour space (name, alias or role) to another.
    ///
    /// # Errors
    /// If one of them isn't there, or a file that the way needs cannot be read.
    pub fn convert_processor(
        &self,
        source: &str,
        destination: &str,
    ) -> Result<Processor, OcioError> {
        let (source, destination) = (c_text(source.as_bytes())?, c_text(destination.as_bytes())?);
        let _lock = one_at_a_time();
        // SAFETY: the handle is valid while `self` lives; the texts live through the call.
        let handle = make(|error| unsafe {
            sys::sundog_ocio_convert_processor(
                self.pointer(),
                source.as_ptr(),
                destination.as_ptr(),
                error,
            )
        })?;
        Ok(Processor { handle })
    }

    /// From scene light to a display's code values.
    ///
    /// # Errors
    /// If a name isn't there, or a file that the way needs cannot be read.
    pub fn display_processor(&self, chain: &DisplayChain<'_>) -> Result<Processor, OcioError> {
        let look = chain.look.map(|look| c_text(look.as_bytes())).transpose()?;
        let (display, view) = (
            c_text(chain.display.as_bytes())?,
            c_text(chain.view.as_bytes())?,
        );
        let raw = sys::SundogOcioDisplay {
            from_scene_linear: chain.source == Source::SceneLinear,
            display: display.as_ptr(),
            view: view.as_ptr(),
            look: look.as_ref().map_or(ptr::null(), |text| text.as_ptr()),
            scale: chain.scale,
            display_scale: chain.display_scale,
            exponent: chain.exponent,
        };
        let _lock = one_at_a_time();
        // SAFETY: the handle is valid while `self` lives; the struct and the texts that it points to live through the call.
        let handle = make(|error| unsafe {
            sys::sundog_ocio_display_processor(
                self.pointer(),
                &raw,
                size_of::<sys::SundogOcioDisplay>(),
                error,
            )
        })?;
        Ok(Processor { handle })
    }
}

impl Drop for Config {
    fn drop(&mut self) {
        let _lock = one_at_a_time();
        // SAFETY: the handle came from the shim, and this is the only place that frees it.
        unsafe { sys::sundog_ocio_config_free(self.handle.as_ptr()) };
    }
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
mod tests {
    use super::*;

    fn default_config() -> Config {
        Config::from_file(OsStr::new("ocio://default")).unwrap()
    }

    #[test]
    fn shim_and_library_belong_together() {
        let versions = check().unwrap();
        assert_eq!(versions.headers >> 16, versions.library >> 16);
        assert!(
            versions.library >= 0x0204_0000,
            "{}",
            versions.library_text()
        );
    }

    #[test]
    fn a_struct_of_another_size_is_refused() {
        let mut abi = std::mem::MaybeUninit::<sys::SundogOcioAbi>::zeroed();
        // SAFETY: the size is wrong on purpose: the shim must write nothing.
        let written =
            unsafe { sys::sundog_ocio_abi(abi.as_mut_ptr(), size_of::<sys::SundogOcioAbi>() - 4) };
        assert!(!written);
    }

    #[test]
    fn the_built_in_configuration_can_be_listed() {
        let config = default_config();
        assert!(config.name().unwrap().starts_with("cg-config-"));
        assert_eq!(config.profile().unwrap().0, 2);
        assert!(
            config
                .roles()
                .unwrap()
                .iter()
                .any(|role| role.name == "scene_linear" && role.colour_space == "ACEScg")
        );
        assert!(
            config
                .colour_spaces()
                .unwrap()
                .iter()
                .any(|space| space.name == "ACEScg" && !space.is_data)
        );
        let display = config.default_display().unwrap().unwrap();
        assert!(config.displays().unwrap().contains(&display));
        let view = config.default_view(&display).unwrap().unwrap();
        assert!(
            config
                .views(&display)
                .unwrap()
                .iter()
                .any(|listed| listed.name == view)
        );
        assert!(config.views("no such display").unwrap().is_empty());
        assert!(!config.looks().unwrap().is_empty());
        assert!(config.has_colour_space("scene_linear").unwrap());
        assert!(!config.has_colour_space("no such space").unwrap());
    }

    #[test]
    fn converting_there_and_back_is_nothing() {
        let config = default_config();
        let rec709 = "Linear Rec.709 (sRGB)";
        let there = config.convert_processor(rec709, "ACEScg").unwrap();
        let back = config.convert_processor("ACEScg", rec709).unwrap();
        let before = [[0.18_f32, 0.5, 1.0], [0.0, -0.25, 4.0]];
        let mut pixels = before;
        there.apply_rgb(&mut pixels).unwrap();
        // Red of Rec.709 into AP1 with the Bradford adaptation, row by row: 0.6131 0.3395 0.0474 (S-2014-004's primaries).
        assert!(
            (pixels[0][0] - (0.6131 * 0.18 + 0.3395 * 0.5 + 0.0474)).abs() < 2e-4,
            "{pixels:?}"
        );
        back.apply_rgb(&mut pixels).unwrap();
        for (a, b) in pixels.iter().flatten().zip(before.iter().flatten()) {
            // Two 3×3 matrices in f32 on values up to 4.
            assert!((a - b).abs() <= 16.0 * f32::EPSILON * 4.0, "{a} {b}");
        }
        assert!(
            config
                .convert_processor("ACEScg", "ACEScg")
                .unwrap()
                .is_identity()
                .unwrap()
        );
    }

    #[test]
    fn alpha_is_handed_through() {
        let config = default_config();
        let processor = config.convert_processor("ACEScg", "ACES2065-1").unwrap();
        let mut with_alpha = [[0.2_f32, 0.3, 0.4, 0.123]];
        let mut without = [[0.2_f32, 0.3, 0.4]];
        processor.apply_rgba(&mut with_alpha).unwrap();
        processor.apply_rgb(&mut without).unwrap();
        assert_eq!(with_alpha[0][..3], without[0]);
        assert_eq!(with_alpha[0][3], 0.123);
        processor.apply_rgb(&mut []).unwrap();
    }

    #[test]
    fn exposure_and_gamma_come_at_the_two_ends() {
        let config = Config::from_text(LINEAR_WITH_RAW_VIEW.as_bytes()).unwrap();
        let chain = DisplayChain {
            source: Source::SceneLinear,
            display: "d",
            view: "v",
            look: None,
            scale: 4.0,
            display_scale: 1.0,
            exponent: 0.5,
        };
        let mut pixels = [[0.25_f32, 0.0625, 1.0]];
        config
            .display_processor(&chain)
            .unwrap()
            .apply_rgb(&mut pixels)
            .unwrap();
        for (value, wanted) in pixels[0].iter().zip([1.0_f32, 0.5, 2.0]) {
            // OpenColorIO's quick power is good to about 17 bits.
            assert!((value - wanted).abs() < 2e-5 * wanted, "{pixels:?}");
        }
    }

    const LINEAR_WITH_RAW_VIEW: &str = "ocio_profile_version: 2
roles: {default: lin, scene_linear: lin}
displays:
  d:
    - !<View> {name: v, colorspace: lin}
colorspaces:
  - !<ColorSpace>
    name: lin
";

    #[test]
    fn broken_texts_and_names_are_errors() {
        for text in [
            "",
            "no configuration",
            "ocio_profile_version: 99",
            "ocio_profile_version: [",
            "ocio_profile_version: 2\ncolorspaces: 3",
            "\0\0\0",
            "%YAML 9.9\n---\n!!binary AAAA",
        ] {
            let error = Config::from_text(text.as_bytes()).unwrap_err();
            assert!(
                !error.text.is_empty() && !error.text.contains('\n'),
                "{error:?}"
            );
        }
        // Nesting that a recursive reader could run out of stack with.
        let deep = format!("ocio_profile_version: 2\nroles: {}", "[".repeat(200_000));
        assert!(Config::from_text(deep.as_bytes()).is_err());
        assert!(Config::from_file(OsStr::new("/no/such/config.ocio")).is_err());
        assert!(Config::from_file(OsStr::new("ocio://no-such-config")).is_err());
        assert!(Config::from_file(OsStr::new("a\0b")).is_err());

        let config = default_config();
        assert!(config.convert_processor("ACEScg", "no such space").is_err());
        let chain = DisplayChain {
            source: Source::SceneLinear,
            display: "x",
            view: "y",
            look: None,
            scale: 1.0,
            display_scale: 1.0,
            exponent: 1.0,
        };
        assert!(config.display_processor(&chain).is_err());
    }

    #[test]
    fn a_configuration_without_a_way_to_rec709_says_so() {
        let config = Config::from_text(LINEAR_WITH_RAW_VIEW.as_bytes()).unwrap();
        assert!(config.is_scene_linear_rec709().is_err());
        assert!(Config::raw().unwrap().is_scene_linear_rec709().is_err());
    }

    #[test]
    fn pixels_of_every_kind_and_from_many_threads() {
        let config = default_config();
        let display = config.default_display().unwrap().unwrap();
        let view = config.default_view(&display).unwrap().unwrap();
        assert!(!config.is_scene_linear_rec709().unwrap());
        let chain = DisplayChain {
            source: Source::LinearRec709,
            display: &display,
            view: &view,
            look: None,
            scale: 2.0,
            display_scale: 1.0,
            exponent: 0.8,
        };
        let processor = config.display_processor(&chain).unwrap();
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            -0.0,
            1e-45,
            0.5,
        ];
        let count = odd.len();
        let pixels: Vec<[f32; 3]> = (0..count * count * count)
            .map(|index| {
                [
                    odd[index / count / count],
                    odd[index / count % count],
                    odd[index % count],
                ]
            })
            .collect();
        let mut alone = pixels.clone();
        processor.apply_rgb(&mut alone).unwrap();
        let bits = |pixels: &[[f32; 3]]| {
            pixels
                .iter()
                .flatten()
                .map(|value| value.to_bits())
                .collect::<Vec<_>>()
        };
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let mut mine = pixels.clone();
                    processor.apply_rgb(&mut mine).unwrap();
                    assert_eq!(bits(&mine), bits(&alone));
                });
            }
        });
    }

    #[test]
    fn a_configuration_may_be_asked_from_many_threads() {
        let config = default_config();
        let display = config.default_display().unwrap().unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        assert!(!config.views(&display).unwrap().is_empty());
                        assert!(config.convert_processor("ACEScg", "ACES2065-1").is_ok());
                    }
                });
            }
        });
    }
}
