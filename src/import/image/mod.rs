//! Image files become [`Image`]s: PNG and WebP through the crate `image`, Radiance HDR
//! likewise, JPEG through `zune-jpeg`, OpenEXR (with every compression of the format) through the crate `exr`.

mod jpeg;
mod ktx2;
mod loading;
mod openexr;
mod reduced;

use std::borrow::Cow;
use std::io::Cursor;
use std::sync::Arc;

use bytemuck::Pod;
use image::{ColorType, ImageDecoder, ImageReader};
use rayon::prelude::*;
use thiserror::Error;

use crate::import::budget::Budget;
use crate::import::guard::guarded;
use crate::math::srgb;
use crate::scene::{Image, Pixels, Place, Values};

pub(crate) use self::loading::{Bytes, Encoded, bytes_of_file, decode_all, tell_in_file};
pub use self::openexr::ExrLayer;
pub(crate) use self::reduced::{TextureLimit, halved};
use self::reduced::{halvings, reduced, to_files};

/// Why an image cannot be decoded.
#[derive(Debug, Error)]
pub enum ImageFailure {
    /// Of no kind that Sundog reads.
    #[error(
        "it is {0}, which Sundog does not read: use PNG, JPEG, WebP, KTX2, OpenEXR or Radiance HDR"
    )]
    Kind(String),
    /// Larger than any picture.
    #[error("it says that it has {width} × {height} pixels, but at most {MOST_PIXELS} are read")]
    Size {
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// The memory it asks for is out of proportion.
    #[error("it {0}")]
    Memory(String),
    /// A file has no such layer.
    #[error("it has no layer {wanted}; it has {there}")]
    NoSuchLayer {
        /// What was asked for.
        wanted: String,
        /// What there is.
        there: String,
    },
    /// Damaged, or a feature of its format that the decoder lacks.
    #[error("{0}")]
    Damaged(String),
}

/// The largest image that is read: 16384 × 16384 pixels, or the same number in another shape.
pub const MOST_PIXELS: u64 = 1 << 28;

/// What kind of image a file's first bytes promise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Png,
    Jpeg,
    WebP,
    Hdr,
    Exr,
    Ktx2,
    Gif,
    Bmp,
    Tiff,
    Tga,
    /// Known, but not read.
    /// With its article.
    Unsupported(&'static str),
    Unknown,
}

/// Tells an image's kind by its first bytes.
pub(crate) fn sniff(bytes: &[u8]) -> Format {
    let at = |offset: usize, what: &[u8]| bytes.get(offset..offset + what.len()) == Some(what);
    if at(0, b"\x89PNG\r\n\x1a\n") {
        Format::Png
    } else if at(0, b"\xff\xd8\xff") {
        Format::Jpeg
    } else if at(0, b"RIFF") && at(8, b"WEBP") {
        Format::WebP
    } else if at(0, b"#?") {
        Format::Hdr
    } else if at(0, b"\x76\x2f\x31\x01") {
        Format::Exr
    } else if at(0, b"\xabKTX 20\xbb\r\n\x1a\n") {
        Format::Ktx2
    } else if at(0, b"\xabKTX") {
        Format::Unsupported("a KTX 1")
    } else if at(0, b"DDS ") {
        Format::Unsupported("a DDS")
    } else if at(4, b"ftypavif") || at(4, b"ftypavis") {
        Format::Unsupported("an AVIF")
    } else if at(0, b"GIF8") {
        Format::Gif
    } else if at(0, b"BM") {
        Format::Bmp
    } else if at(0, b"II*\0") || at(0, b"MM\0*") {
        Format::Tiff
    } else if bytes.ends_with(b"TRUEVISION-XFILE.\0") || is_tga_header(bytes) {
        Format::Tga
    } else {
        Format::Unknown
    }
}

/// Whether a file begins as a Targa image does. Files of the format's first version have no signature: all of the header's
/// fields have to be legal (Truevision, *TGA File Format Specification*, 2.0, fields 2 to 5).
fn is_tga_header(bytes: &[u8]) -> bool {
    let Some(
        &[
            _,
            map,
            kind,
            _,
            _,
            _,
            _,
            map_depth,
            _,
            _,
            _,
            _,
            width0,
            width1,
            height0,
            height1,
            depth,
            descriptor,
        ],
    ) = bytes.first_chunk()
    else {
        return false;
    };
    let is_mapped = matches!(kind, 1 | 9);
    let is_legal_map = if is_mapped {
        map == 1 && matches!(map_depth, 15 | 16 | 24 | 32)
    } else {
        map <= 1
    };
    let is_legal_depth = match kind {
        1 | 9 => matches!(depth, 8 | 16),
        2 | 10 => matches!(depth, 15 | 16 | 24 | 32),
        3 | 11 => matches!(depth, 8 | 16),
        _ => false,
    };
    let is_empty = [width0, width1] == [0; 2] || [height0, height1] == [0; 2];
    // The highest bits of the descriptor have to be 0.
    is_legal_map && is_legal_depth && !is_empty && descriptor & 0xc0 == 0
}

/// Reads an image in the precision of the file: 8 and 16 bit stay as they are, HDR becomes `f32`.
///
/// # Errors
/// The image is of no kind that is read, damaged, or absurdly large.
pub fn decode_image(bytes: &[u8], name: &str) -> Result<Image, ImageFailure> {
    check_size(bytes, &Budget::for_image(bytes.len()))?;
    decode_at(bytes, name, Place::Memory)
}

/// The same, for colours that become three floats a pixel: that is what they may take of memory.
///
/// # Errors
/// As [`decode_image`].
pub fn decode_colors(bytes: &[u8]) -> Result<(Image, Vec<[f32; 3]>), ImageFailure> {
    let budget = Budget::for_image(bytes.len());
    check_size(bytes, &budget)?;
    if let Some((width, height)) = dimensions(bytes)? {
        check_pixels((width, height), size_of::<[f32; 3]>(), &budget)?;
    }
    let image = decode_at(bytes, "", Place::Memory)?;
    let colors = colors(&image);
    Ok((image, colors))
}

/// Width and height of what the crate image reads.
fn dimensions(bytes: &[u8]) -> Result<Option<(u64, u64)>, ImageFailure> {
    match sniff(bytes) {
        Format::Exr | Format::Ktx2 | Format::Unsupported(_) | Format::Unknown => Ok(None),
        _ => {
            let bytes = radiance(bytes);
            let decoder = reader(&bytes).into_decoder().map_err(damaged)?;
            let (width, height) = decoder.dimensions();
            Ok(Some((u64::from(width), u64::from(height))))
        }
    }
}

/// What is said of bytes that are no image.
fn unknown(bytes: &[u8]) -> ImageFailure {
    let kind = super::pointer(bytes).unwrap_or("of an unknown kind");
    ImageFailure::Kind(kind.into())
}

/// As [`decode_image`], after [`check_size`], to a place.
pub(crate) fn decode_at(bytes: &[u8], name: &str, place: Place) -> Result<Image, ImageFailure> {
    let decoded = guarded(|| {
        Ok(match sniff(bytes) {
            Format::Exr => openexr::decode(bytes, name, place),
            Format::Jpeg => jpeg::decode(bytes, name, place),
            Format::Hdr => decode_with_image(&radiance(bytes), name, place),
            Format::Ktx2 => ktx2::decode(bytes, name),
            Format::Unsupported(kind) => Err(ImageFailure::Kind(format!("{kind} image"))),
            Format::Unknown => Err(unknown(bytes)),
            _ => decode_with_image(bytes, name, place),
        })
    });
    decoded.map_err(ImageFailure::Damaged)?
}

/// The colours of an image; codes as shares of the largest, grey three times.
pub fn colors(image: &Image) -> Vec<[f32; 3]> {
    fn of<T: Copy>(values: &[T], channels: u32, float: impl Fn(T) -> f32) -> Vec<[f32; 3]> {
        let pixels = values.chunks_exact(channels.max(1) as usize);
        pixels
            .map(|pixel| match *pixel {
                [r, g, b, ..] => [float(r), float(g), float(b)],
                [grey, ..] => [float(grey); 3],
                [] => [0.0; 3],
            })
            .collect()
    }
    match &image.pixels {
        Pixels::F32(values) => of(values, image.channels, |value| value),
        Pixels::U8(codes) => of(codes, image.channels, |code| f32::from(code) / 255.0),
        Pixels::U16(codes) => of(codes, image.channels, |code| f32::from(code) / 65535.0),
    }
}

/// Reads an image as linear RGB floats, which lie in a scratch file if they take more than `most` bytes; 8- and 16-bit images
/// are taken as sRGB-encoded.
pub(crate) fn decode_linear_rgb(
    bytes: &[u8],
    name: &str,
    budget: &Budget,
    most: Option<u64>,
) -> Result<Image, ImageFailure> {
    let (width, height, _) = checked_size(bytes, budget)?;
    let taken = width * height * size_of::<[f32; 3]>() as u64;
    let place = match most {
        Some(most) if taken > most => Place::File,
        _ => Place::Memory,
    };
    let image = decode_at(bytes, name, place)?;
    let is_light = matches!(image.pixels, Pixels::F32(_));
    if image.channels == 3 && is_light {
        return Ok(image);
    }
    let channels = image.channels.clamp(1, 4) as usize;
    let count = image.width as usize * image.height as usize;
    let mut values = Values::<f32>::zeros(3 * count, place);
    let (into, _) = values.as_chunks_mut::<3>();
    into.par_iter_mut().enumerate().for_each(|(at, rgb)| {
        let texel = image.pixels.texel(channels, at * channels);
        *rgb = texel.truncate().to_array();
        if !is_light {
            *rgb = rgb.map(srgb::decode);
        }
    });
    Ok(Image {
        channels: 3,
        pixels: Pixels::F32(Arc::new(values)),
        ..image
    })
}

/// Makes values fit to be radiance; returns how many texels (of three values) were not.
pub(crate) fn make_radiance(values: &mut [f32]) -> usize {
    let largest = values
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .fold(0.0, f32::max);
    let mut replaced = 0;
    for texel in values.chunks_mut(3) {
        let mut touched = false;
        for value in texel {
            let clean = if value.is_nan() {
                0.0
            } else {
                value.clamp(0.0, largest)
            };
            // Also true for not-a-numbers; −0 equals 0 and stays.
            touched |= clean != *value;
            *value = clean;
        }
        replaced += usize::from(touched);
    }
    replaced
}

/// Reads a layer of an OpenEXR file by its name, such as `Normal` or `ViewLayer.Normal`; without one, what is taken for the
/// picture of a scene's image, too.
///
/// # Errors
/// There is no such layer, or the file is damaged or absurdly large.
pub fn read_exr(bytes: &[u8], layer: Option<&str>) -> Result<ExrLayer, ImageFailure> {
    openexr::check_claim(bytes)?;
    let size = openexr::dimensions(bytes, layer)?;
    check_pixels(size, 16, &Budget::for_image(bytes.len()))?;
    openexr::read(bytes, layer)
}

/// Reads only the header and charges the budget with what decoding will take.
pub(crate) fn check_size(bytes: &[u8], budget: &Budget) -> Result<(), ImageFailure> {
    checked_size(bytes, budget).map(drop)
}

/// The same, telling width, height and bytes a pixel.
pub(crate) fn checked_size(bytes: &[u8], budget: &Budget) -> Result<(u64, u64, u64), ImageFailure> {
    let (width, height, pixel_bytes) = match sniff(bytes) {
        Format::Exr => {
            let (width, height) = openexr::dimensions(bytes, None)?;
            (width, height, 16)
        }
        Format::Ktx2 => ktx2::dimensions(bytes)?,
        Format::Unsupported(kind) => return Err(ImageFailure::Kind(format!("{kind} image"))),
        Format::Unknown => return Err(unknown(bytes)),
        _ => {
            let bytes = radiance(bytes);
            let decoder = reader(&bytes).into_decoder().map_err(damaged)?;
            let (width, height) = decoder.dimensions();
            (
                u64::from(width),
                u64::from(height),
                usize::from(decoder.color_type().bytes_per_pixel()),
            )
        }
    };
    check_pixels((width, height), pixel_bytes, budget)?;
    Ok((width, height, pixel_bytes as u64))
}

fn check_pixels(
    (width, height): (u64, u64),
    pixel_bytes: usize,
    budget: &Budget,
) -> Result<(), ImageFailure> {
    let pixels = width.saturating_mul(height);
    if pixels > MOST_PIXELS || width > u64::from(u32::MAX) || height > u64::from(u32::MAX) {
        return Err(ImageFailure::Size { width, height });
    }
    if pixels == 0 {
        return Err(ImageFailure::Damaged("it has no pixels".into()));
    }
    budget
        .take(pixels, pixel_bytes)
        .map_err(ImageFailure::Memory)
}

/// A Radiance picture under the name that the decoder asks for: the format's own is `#?RADIANCE`, but the word after `#?` is
/// the program's that wrote it, and `#?RGBE` is common.
fn radiance(bytes: &[u8]) -> Cow<'_, [u8]> {
    const NAME: &[u8] = b"#?RADIANCE";
    if sniff(bytes) != Format::Hdr || bytes.starts_with(NAME) {
        return bytes.into();
    }
    let line = bytes.iter().position(|&b| b == b'\n');
    let rest = line.and_then(|end| bytes.get(end..)).unwrap_or_default();
    [NAME, rest].concat().into()
}

fn reader(bytes: &[u8]) -> ImageReader<Cursor<&[u8]>> {
    let format = match sniff(bytes) {
        Format::Png => image::ImageFormat::Png,
        Format::WebP => image::ImageFormat::WebP,
        Format::Hdr => image::ImageFormat::Hdr,
        Format::Gif => image::ImageFormat::Gif,
        Format::Bmp => image::ImageFormat::Bmp,
        Format::Tiff => image::ImageFormat::Tiff,
        Format::Tga => image::ImageFormat::Tga,
        _ => image::ImageFormat::Jpeg,
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // `check_size` has its own limits; the decoder's own are for its scratch memory.
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MOST_PIXELS * 24);
    reader.limits(limits);
    reader
}

fn damaged(error: image::ImageError) -> ImageFailure {
    // Some end with a line break.
    let words = error.to_string();
    ImageFailure::Damaged(words.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn decode_with_image(bytes: &[u8], name: &str, place: Place) -> Result<Image, ImageFailure> {
    let decoder = reader(bytes).into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let pixels = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            Pixels::U8(values(decoder, place)?)
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            Pixels::U16(values(decoder, place)?)
        }
        ColorType::Rgb32F | ColorType::Rgba32F => Pixels::F32(values(decoder, place)?),
        other => {
            return Err(ImageFailure::Kind(format!("of the pixel format {other:?}")));
        }
    };
    Ok(Image {
        name: name.into(),
        width,
        height,
        channels: u32::from(color.channel_count()),
        pixels,
    })
}

/// The numbers that a decoder gives, at a place.
fn values<T: Pod>(
    decoder: impl ImageDecoder,
    place: Place,
) -> Result<Arc<Values<T>>, ImageFailure> {
    let too_many = |_| ImageFailure::Damaged("it has more pixels than memory has room for".into());
    let bytes = usize::try_from(decoder.total_bytes()).map_err(too_many)?;
    let mut values = Values::zeros(bytes / size_of::<T>(), place);
    let into = bytemuck::cast_slice_mut(&mut values[..]);
    decoder.read_image(into).map_err(damaged)?;
    Ok(Arc::new(values))
}
