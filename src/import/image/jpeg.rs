//! JPEG: by `zune-jpeg`, strictly, as its usual way paints what is missing grey without a word.

use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;

use super::ImageFailure;
use crate::scene::{Image, Pixels, Place, Values};
use std::sync::Arc;

/// Reads a picture whose size has been checked.
pub(super) fn decode(bytes: &[u8], name: &str, place: Place) -> Result<Image, ImageFailure> {
    let layout = Layout::of(bytes);
    if !layout.ends {
        return Err(ImageFailure::Damaged(
            "it is cut off: the marker of a JPEG's end is missing".into(),
        ));
    }
    if layout.apart_and_subsampled() {
        return decode_by_the_other(bytes, name);
    }
    if layout.components == 3
        && layout.rows_differ
        && let Ok(image) = decode_by_the_other(bytes, name)
    {
        return Ok(image);
    }
    match decode_with(bytes, (name, place), true) {
        // Junk before the picture's data takes nothing from it.
        Err(ImageFailure::Damaged(reason)) if reason.contains("between headers") => {
            decode_with(bytes, (name, place), false)
        }
        result => result,
    }
}

fn decode_with(
    bytes: &[u8],
    (name, place): (&str, Place),
    strict: bool,
) -> Result<Image, ImageFailure> {
    let damaged = |error: zune_jpeg::errors::DecodeErrors| {
        let words = error.to_string();
        ImageFailure::Damaged(format!(
            "it is damaged or cut off ({})",
            words.split_whitespace().collect::<Vec<_>>().join(" ")
        ))
    };
    let options = DecoderOptions::default()
        .set_strict_mode(strict)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let unknown = || ImageFailure::Damaged("its kind of JPEG is not supported".into());
    let (width, height) = decoder.dimensions().ok_or_else(unknown)?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let (color, channels) = if grey {
        (ColorSpace::Luma, 1)
    } else {
        (ColorSpace::RGB, 3)
    };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(color));
    let size = decoder.output_buffer_size().ok_or_else(unknown)?;
    let mut values = Values::zeros(size, place);
    decoder.decode_into(&mut values).map_err(damaged)?;
    whole(name, (width, height), channels, values)
}

/// By `jpeg-decoder`, for files whose colours have fewer rows. `zune-jpeg` rounds them up twice: over a photo red is 0.36 codes too high,
/// green 0.26 too low and blue 0.45 too high beside libjpeg, which Blender has; here 0.07, 0.03 and 0.08.
///
/// `zune-jpeg` 0.5.15 gives stripes of wrong colours where the components of such a file stand apart, too (mended in its 0.5.16, of which
/// there is a candidate only).
fn decode_by_the_other(bytes: &[u8], name: &str) -> Result<Image, ImageFailure> {
    let damaged =
        |words: String| ImageFailure::Damaged(format!("it is damaged or cut off ({words})"));
    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    let values = decoder.decode().map_err(|e| damaged(e.to_string()))?;
    let info = decoder.info().ok_or_else(|| damaged("no header".into()))?;
    let channels = match info.pixel_format {
        jpeg_decoder::PixelFormat::L8 => 1,
        jpeg_decoder::PixelFormat::RGB24 => 3,
        other => {
            return Err(ImageFailure::Damaged(format!(
                "its kind of JPEG is not supported ({other:?} with its components apart)"
            )));
        }
    };
    let size = (usize::from(info.width), usize::from(info.height));
    whole(name, size, channels, values.into())
}

fn whole(
    name: &str,
    (width, height): (usize, usize),
    channels: u32,
    values: Values<u8>,
) -> Result<Image, ImageFailure> {
    if width
        .saturating_mul(height)
        .saturating_mul(channels as usize)
        != values.len()
    {
        return Err(ImageFailure::Damaged(
            "it is damaged (it has another size than it says)".into(),
        ));
    }
    Ok(Image {
        name: name.into(),
        width: u32::try_from(width).unwrap_or(u32::MAX),
        height: u32::try_from(height).unwrap_or(u32::MAX),
        channels,
        pixels: Pixels::U8(Arc::new(values)),
    })
}

/// What the markers say, without decoding (ITU-T T.81, B.1 and B.2).
#[derive(Clone, Copy, Debug, Default)]
struct Layout {
    /// The marker of the end is there.
    ends: bool,
    /// Huffman-coded in one go, not progressive.
    sequential: bool,
    /// Components of the picture, and of its first scan.
    components: u8,
    in_first_scan: Option<u8>,
    /// Some component has more rows than another.
    rows_differ: bool,
}

impl Layout {
    fn apart_and_subsampled(&self) -> bool {
        self.sequential
            && self.rows_differ
            && self.in_first_scan.is_some_and(|n| n < self.components)
    }

    fn of(bytes: &[u8]) -> Self {
        let mut layout = Self::default();
        let mut at = 2;
        loop {
            // Between segments, and in a scan's data: on to what is a marker and no stuffed byte, fill byte or restart.
            let Some(&[first, marker]) = bytes.get(at..at + 2) else {
                return layout;
            };
            if first != 0xff || matches!(marker, 0 | 0x01 | 0xd0..=0xd8) {
                at += 1;
                continue;
            }
            match marker {
                0xff => {
                    at += 1;
                    continue;
                }
                0xd9 => {
                    layout.ends = true;
                    return layout;
                }
                _ => {}
            }
            let Some(&[high, low]) = bytes.get(at + 2..at + 4) else {
                return layout;
            };
            let length = usize::from(u16::from_be_bytes([high, low])).max(2);
            let body = bytes
                .get(at + 4..(at + 2 + length).min(bytes.len()))
                .unwrap_or_default();
            match marker {
                // Frame headers; C4, C8 and CC are others.
                0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => layout.frame(marker, body),
                0xda if layout.in_first_scan.is_none() => {
                    layout.in_first_scan = body.first().copied();
                }
                _ => {}
            }
            at += 2 + length;
        }
    }

    fn frame(&mut self, marker: u8, body: &[u8]) {
        self.sequential = matches!(marker, 0xc0 | 0xc1);
        self.components = body.get(5).copied().unwrap_or(0);
        let mut rows = body
            .get(6..)
            .unwrap_or_default()
            .chunks_exact(3)
            .take(usize::from(self.components))
            .map(|component| component[1] & 0x0f);
        let first = rows.next();
        self.rows_differ = rows.any(|other| Some(other) != first);
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/image/jpeg.rs"]
mod tests;
