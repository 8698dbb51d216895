//! Pictures become files: EXR with layers, PNG, JPEG, written beside, then renamed; and packets for a viewer.

mod atomic_write;
pub mod display;
pub mod exr;
mod frames;
pub mod png;
pub mod raw;
pub mod tev;
mod view;

pub use atomic_write::{
    Passing, atomic_write, check_writable, remove_unfinished, same_file, same_place,
};
pub use frames::{Frame, Frames};
pub use view::{View, ViewError, to_rec709};

use std::path::Path;

/// Why a file could not be written. Each message is one sentence with the file's name.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The name does not end in an extension that stands for a format.
    #[error(
        "cannot write {path}: the format follows from the end of the name, which must be .exr, .png or .jpg"
    )]
    UnknownFormat {
        /// The file.
        path: String,
    },
    /// There is no such folder, or nothing can be written there.
    #[error("cannot write {path}: {reason}")]
    NotWritable {
        /// The file.
        path: String,
        /// What is in the way, and the way out.
        reason: String,
    },
    /// Writing failed half-way; the unfinished file has been removed.
    #[error("cannot write {path}: {reason}")]
    Failed {
        /// The file.
        path: String,
        /// What the system or the encoder says.
        reason: String,
    },
}

/// File formats of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Linear light in floats, all layers.
    Exr,
    /// Display values, 8 or 16 bits.
    Png,
    /// Display values, 8 bits, lossy.
    Jpeg,
}

impl Format {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// The extension is none of `.exr`, `.png`, `.jpg`, `.jpeg` (in any case).
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            Some("jpg" | "jpeg") => Ok(Self::Jpeg),
            _ => Err(OutputError::UnknownFormat {
                path: path.display().to_string(),
            }),
        }
    }
}

/// What is written into a file besides its pixels: names (`sundog/samples`) with texts.
pub type Metadata = Vec<(String, String)>;

#[cfg(test)]
#[path = "../../tests/unit/output/mod.rs"]
mod tests;
