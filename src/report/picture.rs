//! Pictures as PNG inside of a page.

use super::ReportError;
use base64::Engine;

/// A picture to be looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageImage {
    /// What it is.
    pub name: String,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Display values, RGB interleaved, rows from top to bottom.
    pub rgb: Vec<u8>,
}

impl PageImage {
    /// The picture as a file.
    ///
    /// # Errors
    /// The number of values does not fit the size.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        png(&self.name, (self.width, self.height), &self.rgb)
    }
}

/// RGB of 8 bits as PNG.
pub(super) fn png(name: &str, size: (u32, u32), rgb: &[u8]) -> Result<Vec<u8>, ReportError> {
    encoded(name, size, 3, rgb, |encoder| {
        encoder.set_color(png::ColorType::Rgb);
    })
}

/// A byte for each pixel that says which colour it has, as PNG.
pub(super) fn indexed_png(
    name: &str,
    size: (u32, u32),
    indices: &[u8],
    colors: &[[u8; 3]],
) -> Result<Vec<u8>, ReportError> {
    encoded(name, size, 1, indices, |encoder| {
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(colors.as_flattened().to_vec());
    })
}

fn encoded(
    name: &str,
    (width, height): (u32, u32),
    channels: usize,
    data: &[u8],
    set_up: impl FnOnce(&mut png::Encoder<&mut Vec<u8>>),
) -> Result<Vec<u8>, ReportError> {
    let failed = |reason: String| ReportError::NotShown {
        picture: name.to_owned(),
        reason,
    };
    if data.is_empty() || data.len() != channels * width as usize * height as usize {
        return Err(failed(format!(
            "{} values do not make {width} × {height} pixels",
            data.len()
        )));
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    set_up(&mut encoder);
    encoder
        .write_header()
        .and_then(|mut writer| {
            writer.write_image_data(data)?;
            writer.finish()
        })
        .map_err(|error| failed(error.to_string()))?;
    Ok(bytes)
}

/// Bytes as an address that holds them.
pub(super) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    format!(
        "data:{kind};base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}
