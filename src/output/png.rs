//! Finished pictures as PNG.

use super::{Metadata, OutputError, atomic_write};
use png::{BitDepth, ColorType, Encoder};
use std::path::Path;

/// Code values of a finished picture: RGB or RGBA interleaved, rows from top to bottom.
#[derive(Clone, Copy, Debug)]
pub enum Codes<'a> {
    /// 8 bits a channel.
    Eight(&'a [u8]),
    /// 16 bits a channel.
    Sixteen(&'a [u16]),
}

/// Writes a PNG; `metadata` becomes text chunks.
///
/// # Errors
/// The number of values does not fit the size, or the file cannot be written; then there is no file.
pub fn write(
    path: &Path,
    width: u32,
    height: u32,
    codes: Codes,
    metadata: &Metadata,
) -> Result<(), OutputError> {
    let count = match codes {
        Codes::Eight(values) => values.len(),
        Codes::Sixteen(values) => values.len(),
    };
    let pixels = width as usize * height as usize;
    let color = match count.checked_div(pixels) {
        Some(3) if count == 3 * pixels => ColorType::Rgb,
        Some(4) if count == 4 * pixels => ColorType::Rgba,
        _ => {
            return Err(OutputError::Failed {
                path: path.display().to_string(),
                reason: format!("{count} values do not make {width} × {height} pixels"),
            });
        }
    };
    atomic_write(path, |file| -> Result<(), png::EncodingError> {
        let mut encoder = Encoder::new(file, width, height);
        encoder.set_color(color);
        for (name, value) in metadata {
            // iTXt: keywords are Latin-1 of at most 79 letters, texts are UTF-8.
            encoder.add_itxt_chunk(name.clone(), value.clone())?;
        }
        match codes {
            Codes::Eight(values) => {
                encoder.set_depth(BitDepth::Eight);
                encoder.write_header()?.write_image_data(values)
            }
            Codes::Sixteen(values) => {
                encoder.set_depth(BitDepth::Sixteen);
                // PNG's 16 bits are big-endian.
                let bytes: Vec<u8> = values
                    .iter()
                    .flat_map(|value| value.to_be_bytes())
                    .collect();
                encoder.write_header()?.write_image_data(&bytes)
            }
        }
    })
}
