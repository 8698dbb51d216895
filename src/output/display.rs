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
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let metadata = vec![("sundog/view".to_owned(), "Käse".to_owned())];
        let values: Vec<u16> = (0..24).map(|i| i * 2000 + 7).collect();
        let pixels = DisplayPixels {
            channels: 4,
            samples: DisplaySamples::Sixteen(values.clone()),
        };
        let picture = DisplayPicture {
            width: 3,
            height: 2,
            pixels: &pixels,
        };
        let path = folder.path().join("a.png");
        write(&path, Format::Png, picture, 90, &metadata).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgba16);
        assert_eq!(read.into_rgba16().into_raw(), values);
        let decoder =
            ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let reader = decoder.read_info().unwrap();
        let text = &reader.info().utf8_text[0];
        assert_eq!(
            (text.keyword.as_str(), text.get_text().unwrap().as_str()),
            ("sundog/view", "Käse")
        );
        // JPEG has neither alpha nor 16 bits; nothing may stand under the name then.
        let path = folder.path().join("a.jpg");
        assert!(write(&path, Format::Jpeg, picture, 90, &metadata).is_err());
        assert!(!path.exists());
        let pixels = DisplayPixels {
            channels: 3,
            samples: DisplaySamples::Eight(vec![200; 18]),
        };
        write(
            &path,
            Format::Jpeg,
            DisplayPicture {
                pixels: &pixels,
                ..picture
            },
            90,
            &metadata,
        )
        .unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (3, 2));
        // A flat colour survives JPEG but for rounding between RGB and YCbCr.
        assert!(
            read.pixels()
                .all(|pixel| pixel.0.iter().all(|value| value.abs_diff(200) <= 2))
        );
    }

    #[test]
    fn a_size_that_does_not_fit_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let pixels = DisplayPixels {
            channels: 3,
            samples: DisplaySamples::Eight(vec![0; 17]),
        };
        for (name, format) in [("a.png", Format::Png), ("a.jpg", Format::Jpeg)] {
            let path = folder.path().join(name);
            let picture = DisplayPicture {
                width: 3,
                height: 2,
                pixels: &pixels,
            };
            assert!(write(&path, format, picture, 90, &Vec::new()).is_err());
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }
}
