//! KTX2 with Basis Universal textures (KHR_texture_basisu): ETC1S and UASTC, through the crate `basisu`.

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};

use super::ImageFailure;
use crate::import::guard::guarded;
use crate::scene::Image;

/// What is said in the header that other programs than ours wrote, checked against the file.
struct Header {
    width: u32,
    height: u32,
    /// Bytes that the first level takes inside the decoder.
    level: u64,
}

/// The largest side that is read: the format's own limits are beyond any picture.
const MOST_PIXELS_A_SIDE: u32 = 1 << 20;

/// Width and height of the picture, and bytes a pixel that decoding it takes.
pub(super) fn dimensions(bytes: &[u8]) -> Result<(u64, u64, usize), ImageFailure> {
    let header = header(bytes).map_err(ImageFailure::Damaged)?;
    let pixels = (u64::from(header.width) * u64::from(header.height)).max(1);
    // The picture, and the level as it was before supercompression.
    let scratch = header.level.div_ceil(pixels);
    Ok((
        u64::from(header.width),
        u64::from(header.height),
        4 + usize::try_from(scratch).unwrap_or(usize::MAX / 2),
    ))
}

/// Reads the header (KTX 2.0 specification, section 3) and checks what the decoder would take on trust.
fn header(bytes: &[u8]) -> Result<Header, String> {
    let short = "it is cut off in its header";
    let word = |at: usize| -> Result<u32, String> {
        match bytes.get(at..at + 4) {
            Some(&[a, b, c, d]) => Ok(u32::from_le_bytes([a, b, c, d])),
            _ => Err(short.into()),
        }
    };
    let long = |at: usize| Ok::<u64, String>(u64::from(word(at)?) | u64::from(word(at + 4)?) << 32);
    let (format, width, height) = (word(12)?, word(20)?, word(24)?);
    let (depth, layers, faces, levels) = (word(28)?, word(32)?, word(36)?, word(40)?);
    if format != 0 {
        return Err("it is a KTX2 file without Basis Universal compression".into());
    }
    if depth > 0 || layers > 1 || faces != 1 || height == 0 {
        return Err("it is a KTX2 file of another kind than one flat picture".into());
    }
    if width == 0 || width > MOST_PIXELS_A_SIDE || height > MOST_PIXELS_A_SIDE {
        return Err(format!("it says that it has {width} × {height} pixels"));
    }
    let inside = |offset: u64, length: u64| {
        offset
            .checked_add(length)
            .is_some_and(|end| end <= bytes.len() as u64)
    };
    // The descriptor, the global data and all levels.
    let mut parts = vec![
        (u64::from(word(48)?), u64::from(word(52)?)),
        (u64::from(word(56)?), u64::from(word(60)?)),
        (long(64)?, long(72)?),
    ];
    for level in 0..levels.clamp(1, 32) as usize {
        parts.push((long(80 + level * 24)?, long(88 + level * 24)?));
    }
    if parts
        .iter()
        .any(|&(offset, length)| !inside(offset, length))
    {
        return Err("it is cut off".into());
    }
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    let level = long(96)?;
    // Sixteen bytes a block in UASTC; ETC1S says nothing here.
    if level > blocks * 16 {
        return Err(format!("its first level says that it has {level} bytes"));
    }
    Ok(Header {
        width,
        height,
        level: blocks * 16,
    })
}

/// Reads the first level as RGB, or RGBA where the file has alpha.
pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Image, ImageFailure> {
    let header = header(bytes).map_err(ImageFailure::Damaged)?;
    guarded(|| {
        let damaged = "it is damaged, or of a kind of KTX2 that is not supported";
        let texture = Transcoder::new(bytes).map_err(|_| damaged.to_string())?;
        match texture.source_format() {
            SourceFormat::Etc1s | SourceFormat::UastcLdr => {}
            _ => return Err("it is a KTX2 file of another kind than ETC1S and UASTC".into()),
        }
        if texture.base_dimensions() != (header.width, header.height) {
            return Err(damaged.into());
        }
        let mut pixels = texture
            .transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
            .map_err(|_| damaged.to_string())?;
        let channels = if texture.has_alpha() { 4 } else { 3 };
        if channels == 3 {
            let count = pixels.len() / 4;
            for pixel in 0..count {
                pixels.copy_within(pixel * 4..pixel * 4 + 3, pixel * 3);
            }
            pixels.truncate(count * 3);
        }
        Ok(Image {
            name: name.into(),
            width: header.width,
            height: header.height,
            channels,
            pixels: pixels.into(),
        })
    })
    .map_err(ImageFailure::Damaged)
}
