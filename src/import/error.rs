//! The one error type of the import room, and reading whole files with good messages.

use std::path::Path;

use thiserror::Error;

use super::image::ImageFailure;

/// Why a file could not become (part of) a scene. Each message is one sentence that names the file,
/// the object concerned and, where there is one, the way out.
#[derive(Debug, Error)]
pub enum ImportError {
    /// A file cannot be opened or read.
    #[error("cannot read {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system says.
        reason: String,
    },
    /// A file that the scene names cannot be read.
    #[error(
        "{file}: {object} needs the file {needed}, which cannot be read ({reason}): put it where the scene expects it, or export the scene again as .glb"
    )]
    MissingPart {
        /// The scene file.
        file: String,
        /// What in the scene needs it.
        object: String,
        /// The file that is needed.
        needed: String,
        /// What the system says.
        reason: String,
    },
    /// A file that the scene names does not lie in the scene's folder.
    #[error(
        "{file}: {object} needs the file {needed}, which lies outside of the scene's folder: if you trust the scene, give --allow-outside"
    )]
    Outside {
        /// The scene file.
        file: String,
        /// What in the scene needs it.
        object: String,
        /// The file that is needed.
        needed: String,
    },
    /// A part of the scene lies at an address on the network.
    #[error(
        "{file}: {object}: its address \"{address}\" is not a file beside the scene: download it, put it there, and name that file instead"
    )]
    Remote {
        /// The scene file.
        file: String,
        /// What in the scene needs it.
        object: String,
        /// Where it is, shortened.
        address: String,
    },
    /// The file is of another format, or only part of one.
    #[error("{file} is not a glTF 2.0 file that can be read: {reason}")]
    NotGltf {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file is no USD stage, or only part of one.
    #[error("{file} is not a USD file that can be read: {reason}")]
    NotUsd {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file contradicts itself or the format.
    #[error("{file}: {object}: {problem}")]
    Malformed {
        /// The file.
        file: String,
        /// The object concerned.
        object: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The file cannot be understood without an extension that Sundog does not have.
    #[error("{file} demands the glTF extension {extension}, which Sundog does not have: {remedy}")]
    Unsupported {
        /// The file.
        file: String,
        /// The extension.
        extension: String,
        /// The way out.
        remedy: String,
    },
    /// An image cannot be decoded.
    #[error("{file}: {object} cannot be read as an image: {reason}")]
    Image {
        /// The file.
        file: String,
        /// The image.
        object: String,
        /// What is wrong with it.
        reason: ImageFailure,
    },
}

impl ImportError {
    pub(crate) fn malformed(
        file: &str,
        object: impl Into<String>,
        problem: impl Into<String>,
    ) -> Self {
        Self::Malformed {
            file: file.into(),
            object: object.into(),
            problem: problem.into(),
        }
    }

    pub(crate) fn image(file: &str, object: impl Into<String>, reason: ImageFailure) -> Self {
        Self::Image {
            file: file.into(),
            object: object.into(),
            reason,
        }
    }
}

/// Reads a whole regular file (a device or a pipe might never end).
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, ImportError> {
    read_bytes(path).map_err(|reason| ImportError::Unreadable {
        file: path.display().to_string(),
        reason,
    })
}

/// As [`read_file`], with the bare reason.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    let metadata = std::fs::metadata(path).map_err(|e| plain(&e))?;
    if metadata.is_dir() {
        return Err("it is a folder".into());
    }
    if !metadata.is_file() {
        return Err("it is not a regular file".into());
    }
    std::fs::read(path).map_err(|e| plain(&e))
}

/// The system's reason in words, without an error number.
fn plain(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        std::io::ErrorKind::OutOfMemory => "there is not enough memory for it".into(),
        _ => error.to_string(),
    }
}
