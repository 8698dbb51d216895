//! Configurations of OpenColorIO, and what is in them.

use super::{
    OcioError, Processor, c_text, call, check, make, one_at_a_time, read_text, sys, take_text,
};
use std::ffi::{OsStr, c_char};
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::ptr::{self, NonNull};

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
