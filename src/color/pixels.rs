//! From linear floats through a processor to the whole numbers of a picture file.

use crate::color::ColorError;
use crate::ffi::ocio::Processor;
use rayon::prelude::*;

/// Pixels of linear Rec.709 light, row after row.
#[derive(Debug, Clone, Copy)]
pub enum SceneColors<'a> {
    /// Without alpha.
    Rgb(&'a [[f32; 3]]),
    /// With associated alpha (colours are multiplied by it), as in EXR files and as Blender renders.
    Rgba(&'a [[f32; 4]]),
    /// As `Rgba`, to be shown on black: files without alpha (JPEG). The alpha is dropped, which is the same thing.
    RgbaOnBlack(&'a [[f32; 4]]),
}

impl SceneColors<'_> {
    /// The number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Self::Rgb(pixels) => pixels.len(),
            Self::Rgba(pixels) | Self::RgbaOnBlack(pixels) => pixels.len(),
        }
    }

    /// Whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Bits of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// 0..=255.
    #[default]
    Eight,
    /// 0..=65535.
    Sixteen,
}

/// The values of [`DisplayPixels`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DisplaySamples {
    /// 8 bits a channel.
    Eight(Vec<u8>),
    /// 16 bits a channel, in the machine's byte order.
    Sixteen(Vec<u16>),
}

/// Code values of a display, packed, row after row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DisplayPixels {
    /// 3 (RGB) or 4 (RGB and unassociated alpha, as PNG has it).
    pub channels: usize,
    /// `channels` values a pixel.
    pub samples: DisplaySamples,
}

/// Pixels of one piece of work: big enough for OpenColorIO to be quick, small enough for its floats to stay in the cache.
pub(super) const PIECE: usize = 4096;

/// Applies `processor` to all pixels, on all threads of the current rayon pool, and rounds.
pub(super) fn to_display(
    processor: &Processor,
    colors: SceneColors<'_>,
    depth: Depth,
) -> Result<DisplayPixels, ColorError> {
    let samples = match depth {
        Depth::Eight => DisplaySamples::Eight(quantised(processor, colors, to_8_bits)?),
        Depth::Sixteen => DisplaySamples::Sixteen(quantised(processor, colors, to_16_bits)?),
    };
    Ok(DisplayPixels {
        channels: if matches!(colors, SceneColors::Rgba(_)) {
            4
        } else {
            3
        },
        samples,
    })
}

fn quantised<T: Copy + Default + Send + Sync>(
    processor: &Processor,
    colors: SceneColors<'_>,
    round: fn(f32) -> T,
) -> Result<Vec<T>, ColorError> {
    let failed = |error: crate::ffi::ocio::OcioError| ColorError::Apply { reason: error.text };
    match colors {
        SceneColors::Rgb(pixels) => {
            let mut out = vec![[T::default(); 3]; pixels.len()];
            out.par_chunks_mut(PIECE)
                .zip(pixels.par_chunks(PIECE))
                .try_for_each(|(out, pixels)| {
                    opaque(processor, pixels.to_vec(), out, round).map_err(failed)
                })?;
            Ok(out.into_flattened())
        }
        SceneColors::RgbaOnBlack(pixels) => {
            let mut out = vec![[T::default(); 3]; pixels.len()];
            out.par_chunks_mut(PIECE)
                .zip(pixels.par_chunks(PIECE))
                .try_for_each(|(out, pixels)| {
                    let colours = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
                    opaque(processor, colours, out, round).map_err(failed)
                })?;
            Ok(out.into_flattened())
        }
        SceneColors::Rgba(pixels) => {
            let mut out = vec![[T::default(); 4]; pixels.len()];
            out.par_chunks_mut(PIECE)
                .zip(pixels.par_chunks(PIECE))
                .try_for_each(|(out, pixels)| {
                    // The view is not linear: it is meant for the colour that a surface has, not for that times alpha.
                    let mut straight: Vec<[f32; 3]> =
                        pixels.iter().map(|&pixel| unassociated(pixel)).collect();
                    processor.apply_rgb(&mut straight).map_err(failed)?;
                    for ((out, shown), pixel) in out.iter_mut().zip(&straight).zip(pixels) {
                        *out = [
                            round(shown[0]),
                            round(shown[1]),
                            round(shown[2]),
                            round(pixel[3]),
                        ];
                    }
                    Ok(())
                })?;
            Ok(out.into_flattened())
        }
    }
}

fn opaque<T>(
    processor: &Processor,
    mut colours: Vec<[f32; 3]>,
    out: &mut [[T; 3]],
    round: fn(f32) -> T,
) -> Result<(), crate::ffi::ocio::OcioError> {
    processor.apply_rgb(&mut colours)?;
    for (out, shown) in out.iter_mut().zip(&colours) {
        *out = shown.map(round);
    }
    Ok(())
}

/// The colour without its alpha. Where alpha is 0 the colour is pure emission and stays.
fn unassociated([r, g, b, alpha]: [f32; 4]) -> [f32; 3] {
    if alpha == 0.0 || alpha == 1.0 {
        [r, g, b]
    } else {
        let factor = 1.0 / alpha;
        [r * factor, g * factor, b * factor]
    }
}

/// Nearest of 0..=255; what is no number becomes 0.
fn to_8_bits(value: f32) -> u8 {
    // `as` goes to the nearest bound, and to 0 for NaN.
    (value * 255.0 + 0.5) as u8
}

/// Nearest of 0..=65535; what is no number becomes 0.
fn to_16_bits(value: f32) -> u16 {
    (value * 65535.0 + 0.5) as u16
}

#[cfg(test)]
#[path = "../../tests/unit/color/pixels.rs"]
mod tests;
