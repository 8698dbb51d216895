//! Finished pictures, code values of a display, as PNG or JPEG.

use super::{Format, Metadata, OutputError, atomic_write, png};
use crate::color::{DisplayPixels, DisplaySamples};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// A finished picture.
#[derive(Clone, Copy, Debug)]
pub struct DisplayPicture<'a> {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Rows from top to bottom.
    pub pixels: &'a DisplayPixels,
}

/// Writes a finished picture as PNG (8 or 16 bits, with alpha if it has one) or JPEG (8 bits, no alpha).
///
/// `quality` is JPEG's, 1 to 100; `metadata` becomes text chunks in PNG files and is not kept in JPEG files.
///
/// # Errors
/// The format cannot hold the picture, or the file cannot be written; then there is no file.
pub fn write(
    path: &Path,
    format: Format,
    picture: DisplayPicture,
    quality: u8,
    metadata: &Metadata,
) -> Result<(), OutputError> {
    let DisplayPicture {
        width,
        height,
        pixels,
    } = picture;
    let failed = |reason: &str| OutputError::Failed {
        path: path.display().to_string(),
        reason: reason.into(),
    };
    match (format, &pixels.samples) {
        (Format::Png, DisplaySamples::Eight(values)) => {
            png::write(path, width, height, png::Codes::Eight(values), metadata)
        }
        (Format::Png, DisplaySamples::Sixteen(values)) => {
            png::write(path, width, height, png::Codes::Sixteen(values), metadata)
        }
        (Format::Jpeg, DisplaySamples::Eight(values)) if pixels.channels == 3 => {
            if width > u32::from(u16::MAX) || height > u32::from(u16::MAX) {
                return Err(failed(
                    "JPEG has at most 65535 pixels a side; choose .png or .exr",
                ));
            }
            if values.len() != 3 * width as usize * height as usize {
                return Err(failed("its pixels do not fit its size"));
            }
            atomic_write(path, |file| {
                JpegEncoder::new_with_quality(file, quality).write_image(
                    values,
                    width,
                    height,
                    ExtendedColorType::Rgb8,
                )
            })
        }
        (Format::Jpeg, _) => Err(failed("JPEG has 8 bits a channel and no alpha")),
        (Format::Exr, _) => Err(failed("EXR holds linear light, not display values")),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/output/display.rs"]
mod tests;
