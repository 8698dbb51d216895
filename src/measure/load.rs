//! Reading pictures that are to be measured.

use super::{Encoding, MeasureError, RgbImage};
use crate::import::{ImageFailure, decode_colors, read_exr};
use std::path::Path;

/// Reads a picture: an EXR or HDR as linear light, a PNG or JPEG as display values. What it is follows
/// from its content. An EXR's picture is its display window: what the data window does not cover is black,
/// what lies beyond is left out.
///
/// `layer` names a layer of an EXR file, such as `Normal` or `ViewLayer.Normal`; without it the picture itself is taken
/// (see [`read_exr`]).
///
/// # Errors
/// The file cannot be read, is no picture, or has no such layer.
pub fn load(path: &Path, layer: Option<&str>) -> Result<RgbImage, MeasureError> {
    load_with_alpha(path, layer).map(|(picture, _)| picture)
}

/// As [`load`], with the alpha of the pixels of an EXR layer that has one; the colours are then
/// multiplied by it, as EXR has it.
///
/// # Errors
/// As [`load`].
pub fn load_with_alpha(
    path: &Path,
    layer: Option<&str>,
) -> Result<(RgbImage, Option<Vec<f32>>), MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(plain(&error)))?;
    if !metadata.is_file() {
        let kind = if metadata.is_dir() {
            "it is a folder"
        } else {
            "it is not a regular file"
        };
        return Err(unreadable(kind.into()));
    }
    let bytes = std::fs::read(path).map_err(|error| unreadable(plain(&error)))?;
    if bytes.len() < 4 {
        return Err(unreadable("it is too short for a picture".into()));
    }
    let no_such_layer = |wanted: &str, there: String| MeasureError::NoSuchLayer {
        path: path.display().to_string(),
        wanted: wanted.into(),
        there,
    };
    let failed = |failure: ImageFailure| match failure {
        ImageFailure::NoSuchLayer { wanted, there } => no_such_layer(&wanted, there),
        other => unreadable(other.to_string()),
    };
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        return load_exr(&bytes, layer).map_err(failed);
    }
    if let Some(wanted) = layer {
        let there = "no layers, because it is not an EXR file";
        return Err(no_such_layer(wanted, there.into()));
    }
    let encoding = match image::guess_format(&bytes) {
        Ok(image::ImageFormat::Png | image::ImageFormat::Jpeg) => Encoding::Display,
        _ if bytes.starts_with(b"#?") => Encoding::Linear,
        _ => return Err(unreadable("it is neither EXR, HDR, PNG nor JPEG".into())),
    };
    let (image, pixels) = decode_colors(&bytes).map_err(failed)?;
    let picture = RgbImage {
        width: image.width,
        height: image.height,
        pixels,
        encoding,
    };
    Ok((picture, None))
}

fn plain(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}

fn load_exr(
    bytes: &[u8],
    layer: Option<&str>,
) -> Result<(RgbImage, Option<Vec<f32>>), ImageFailure> {
    let layer = read_exr(bytes, layer)?;
    let channels = layer.colors + usize::from(layer.alpha);
    let pixels = || layer.values.chunks_exact(channels);
    // One channel stands three times.
    let [green, blue] = [1, 2].map(|channel| channel % layer.colors);
    let picture = RgbImage {
        // (Sizes are checked to be far below this.)
        width: u32::try_from(layer.width).unwrap_or(u32::MAX),
        height: u32::try_from(layer.height).unwrap_or(u32::MAX),
        pixels: pixels()
            .map(|pixel| [pixel[0], pixel[green], pixel[blue]])
            .collect(),
        encoding: Encoding::Linear,
    };
    let alpha = || pixels().map(|pixel| pixel[layer.colors]).collect();
    Ok((picture, layer.alpha.then(alpha)))
}
