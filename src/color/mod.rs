//! OpenColorIO: configs, displays, views, looks, exposure, gamma; and where the config comes from.
//!
//! Inside, Sundog computes in linear Rec.709. On the way to a display, in the order that Blender keeps too: to the
//! configuration's scene-linear space, exposure, look (into its own process space), view and display, gamma.

mod config;
mod error;
mod listing;
mod locate;
mod looks;
mod pixels;
mod tables;

pub use config::{
    ColorConfig, DisplayProcessor, DisplaySummary, DisplayTransform, InputProcessor, LookSummary,
    ResolvedDisplay, ViewSummary,
};
pub use error::ColorError;
pub use listing::Listing;
pub use locate::{ConfigOrigin, SearchPlaces};
pub use pixels::{Depth, DisplayPixels, DisplaySamples, SceneColors};

/// The version of the OpenColorIO library that runs, as `2.6.0`; fails if it is not the one that was built for.
///
/// # Errors
/// If the library and the program don't belong together; to be called at the start.
pub fn library_version() -> Result<String, ColorError> {
    crate::ffi::ocio::check()
        .map(crate::ffi::ocio::Versions::library_text)
        .map_err(|error| ColorError::Library { reason: error.text })
}
