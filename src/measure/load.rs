//! Reading pictures that are to be measured.

use super::{Encoding, MeasureError, Picture};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, Text, read};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// A file whose header claims more values than this for each of its bytes is not believed: no
/// compression of EXR's gets there on a real picture, and memory for a made-up size is not spent.
const MOST_VALUES_A_BYTE: u64 = 4096;

/// The largest side that is read.
const MAX_SIDE: u32 = 1 << 16;

/// The most pixels of an EXR's display window, which its content need not fill.
const MOST_PIXELS: usize = 1 << 28;

/// Reads a picture: an EXR or HDR as linear light, a PNG or JPEG as display values. What it is follows
/// from its content. An EXR's picture is its display window: what the data window does not cover is black,
/// what lies beyond is left out.
///
/// `layer` names a layer of an EXR file, such as `Normal` or `ViewLayer.Normal`; without it the
/// picture itself is taken: plain R, G, B, or else the first `Combined`, or else the first layer
/// with colours.
///
/// # Errors
/// The file cannot be read, is no picture, or has no such layer.
pub fn load(path: &Path, layer: Option<&str>) -> Result<Picture, MeasureError> {
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
) -> Result<(Picture, Option<Vec<f32>>), MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(plain(&error)))?;
    if !metadata.is_file() {
        return Err(unreadable(
            if metadata.is_dir() {
                "it is a folder"
            } else {
                "it is not a regular file"
            }
            .into(),
        ));
    }
    let mut file = BufReader::new(File::open(path).map_err(|error| unreadable(plain(&error)))?);
    let mut magic = [0; 4];
    file.read_exact(&mut magic)
        .map_err(|_| unreadable("it is too short for a picture".into()))?;
    file.seek(SeekFrom::Start(0))
        .map_err(|error| unreadable(plain(&error)))?;
    if magic == *b"\x76\x2f\x31\x01" {
        return load_exr(path, file, metadata.len(), layer);
    }
    if let Some(wanted) = layer {
        return Err(MeasureError::NoSuchLayer {
            path: path.display().to_string(),
            wanted: wanted.into(),
            there: "no layers, because it is not an EXR file".into(),
        });
    }
    let mut reader = image::ImageReader::new(file)
        .with_guessed_format()
        .map_err(|error| unreadable(plain(&error)))?;
    let encoding = match reader.format() {
        Some(image::ImageFormat::Png | image::ImageFormat::Jpeg) => Encoding::Display,
        Some(image::ImageFormat::Hdr) => Encoding::Linear,
        _ => return Err(unreadable("it is neither EXR, HDR, PNG nor JPEG".into())),
    };
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    let image = reader
        .decode()
        .map_err(|error| unreadable(error.to_string()))?;
    let (width, height) = (image.width(), image.height());
    let pixels = image.into_rgb32f().pixels().map(|pixel| pixel.0).collect();
    Ok((
        Picture {
            width,
            height,
            pixels,
            encoding,
        },
        None,
    ))
}

fn plain(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}

/// One channel of the file with its full name, the part's name in front.
struct Channel {
    /// All but the last word of the name; empty for plain `R`.
    layer: String,
    /// The last word: `R`, `Z`, `X` …
    component: String,
    /// Where the data window begins in the display window, which may be left of it or above.
    at: (i64, i64),
    /// Of the data window.
    size: (usize, usize),
    samples: FlatSamples,
}

impl Channel {
    /// The value of a pixel of the display window; 0 beyond the data window.
    fn value(&self, x: usize, y: usize) -> f32 {
        let inside = |at: usize, begin: i64, size: usize| {
            usize::try_from(at as i64 - begin)
                .ok()
                .filter(|index| *index < size)
        };
        let column = inside(x, self.at.0, self.size.0);
        let row = inside(y, self.at.1, self.size.1);
        match (column, row) {
            (Some(column), Some(row)) => self
                .samples
                .value_by_flat_index(row * self.size.0 + column)
                .to_f32(),
            _ => 0.0,
        }
    }
}

fn load_exr(
    path: &Path,
    mut file: BufReader<File>,
    length: u64,
    layer: Option<&str>,
) -> Result<(Picture, Option<Vec<f32>>), MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let headers = exr::meta::MetaData::read_from_buffered(&mut file, false)
        .map_err(|error| unreadable(error.to_string()))?
        .headers;
    let values: u64 = headers
        .iter()
        .map(|header| {
            (header.layer_size.area() as u64).saturating_mul(header.channels.list.len() as u64)
        })
        .fold(0, u64::saturating_add);
    let side = headers
        .iter()
        .map(|header| header.layer_size.x().max(header.layer_size.y()))
        .max()
        .unwrap_or(0);
    if side > MAX_SIDE as usize || values > length.saturating_mul(MOST_VALUES_A_BYTE) {
        return Err(unreadable(
            "its header claims a size that its content cannot have".into(),
        ));
    }
    file.seek(SeekFrom::Start(0))
        .map_err(|error| unreadable(plain(&error)))?;
    // (All parts share one display window.)
    let window = headers
        .first()
        .map(|header| header.shared_attributes.display_window)
        .unwrap_or_default();
    let (width, height) = (window.size.x(), window.size.y());
    if width.max(height) > MAX_SIDE as usize || width.saturating_mul(height) > MOST_PIXELS {
        return Err(unreadable(format!(
            "its display window has {width} × {height} pixels, which is too large"
        )));
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(file)
        .map_err(|error| unreadable(error.to_string()))?;
    let mut channels = Vec::new();
    for part in image.layer_data {
        let prefix = part
            .attributes
            .layer_name
            .as_ref()
            .map(Text::to_string)
            .unwrap_or_default();
        let several = headers.len() > 1 && !prefix.is_empty();
        let begin = part.attributes.layer_position;
        let at = (
            i64::from(begin.x()) - i64::from(window.position.x()),
            i64::from(begin.y()) - i64::from(window.position.y()),
        );
        for channel in part.channel_data.list {
            let name = channel.name.to_string();
            // Files with one part a layer may or may not repeat the part's name in the channels' names.
            let full = if several && !name.starts_with(&format!("{prefix}.")) {
                format!("{prefix}.{name}")
            } else {
                name
            };
            let (layer, component) = full.rsplit_once('.').unwrap_or(("", &full));
            if channel.sampling == exr::prelude::Vec2(1, 1) {
                channels.push(Channel {
                    layer: layer.into(),
                    component: component.to_uppercase(),
                    at,
                    size: (part.size.x(), part.size.y()),
                    samples: channel.sample_data,
                });
            }
        }
    }
    let mut layers: Vec<&str> = Vec::new();
    for channel in &channels {
        if !layers.contains(&channel.layer.as_str()) {
            layers.push(&channel.layer);
        }
    }
    let find = |layer: &str, component: &str| {
        channels
            .iter()
            .find(|c| c.layer == layer && c.component == component)
    };
    let has_color = |layer: &str| {
        ["R", "G", "B"]
            .iter()
            .all(|component| find(layer, component).is_some())
    };
    let last_word = |layer: &str| layer.rsplit('.').next().unwrap_or_default().to_owned();
    let chosen = match layer {
        Some(wanted) => layers
            .iter()
            .find(|name| **name == wanted || last_word(name) == wanted)
            .or_else(|| {
                layers
                    .iter()
                    .find(|name| wanted == "Combined" && name.is_empty())
            }),
        None => layers
            .iter()
            .find(|name| name.is_empty() && has_color(name))
            .or_else(|| {
                layers
                    .iter()
                    .find(|name| last_word(name) == "Combined" && has_color(name))
            })
            .or_else(|| layers.iter().find(|name| has_color(name)))
            .or_else(|| layers.first()),
    };
    let no_such_layer = || MeasureError::NoSuchLayer {
        path: path.display().to_string(),
        wanted: layer.unwrap_or("with colours").into(),
        there: layers
            .iter()
            .map(|name| if name.is_empty() { "Combined" } else { name })
            .collect::<Vec<_>>()
            .join(", "),
    };
    let chosen = *chosen.ok_or_else(no_such_layer)?;
    let triples = [
        ["R", "G", "B"],
        ["X", "Y", "Z"],
        ["Y", "Y", "Y"],
        ["Z", "Z", "Z"],
        ["X", "X", "X"],
        ["V", "V", "V"],
    ];
    let found: Option<[&Channel; 3]> = triples.iter().find_map(|[first, second, third]| {
        Some([
            find(chosen, first)?,
            find(chosen, second)?,
            find(chosen, third)?,
        ])
    });
    let [red, green, blue] = found.ok_or_else(no_such_layer)?;
    let places = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = places()
        .map(|(x, y)| [red, green, blue].map(|channel| channel.value(x, y)))
        .collect();
    let alpha = find(chosen, "A").map(|alpha| places().map(|(x, y)| alpha.value(x, y)).collect());
    Ok((
        Picture {
            width: width as u32,
            height: height as u32,
            pixels,
            encoding: Encoding::Linear,
        },
        alpha,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film;
    use crate::output::exr as output;

    fn written(
        layers: Vec<film::Layer>,
        options: &output::ExrOptions,
    ) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = film::Picture {
            width: 3,
            height: 2,
            layers,
        };
        output::write(
            &path,
            &picture,
            options,
            &vec![("sundog/é".into(), "Käse".into())],
        )
        .unwrap();
        (folder, path)
    }

    fn layer(name: &str, channels: &[&str], first: f32) -> film::Layer {
        film::Layer {
            name: name.into(),
            channels: channels.iter().map(|c| (*c).to_owned()).collect(),
            data: (0..6 * channels.len()).map(|i| first + i as f32).collect(),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let (_folder, path) = written(
            vec![
                layer("Combined", &["R", "G", "B", "A"], 0.0),
                layer("Depth", &["Z"], 100.0),
                layer("Normal", &["X", "Y", "Z"], -3.0),
            ],
            &output::ExrOptions::default(),
        );
        let combined = load(&path, None).unwrap();
        assert_eq!(
            (combined.width, combined.height, combined.encoding),
            (3, 2, Encoding::Linear)
        );
        assert_eq!(combined.pixels[0], [0.0, 1.0, 2.0]);
        assert_eq!(combined.pixels[4], [16.0, 17.0, 18.0]);
        assert_eq!(load(&path, Some("Depth")).unwrap().pixels[5], [105.0; 3]);
        assert_eq!(
            load(&path, Some("Normal")).unwrap().pixels[1],
            [0.0, 1.0, 2.0]
        );
        assert_eq!(load(&path, Some("Combined")).unwrap(), combined);
        let missing = load(&path, Some("Mist")).unwrap_err().to_string();
        assert!(
            missing.ends_with("has no layer Mist; it has Combined, Depth, Normal"),
            "{missing}"
        );
    }

    #[test]
    fn alpha_comes_along_where_there_is_one() {
        let (_folder, path) = written(
            vec![
                layer("Combined", &["R", "G", "B", "A"], 0.0),
                layer("Normal", &["X", "Y", "Z"], -3.0),
            ],
            &output::ExrOptions::default(),
        );
        let (picture, alpha) = load_with_alpha(&path, None).unwrap();
        assert_eq!(picture, load(&path, None).unwrap());
        assert_eq!(alpha.unwrap(), [3.0, 7.0, 11.0, 15.0, 19.0, 23.0]);
        assert_eq!(load_with_alpha(&path, Some("Normal")).unwrap().1, None);
    }

    /// Data windows that lie inside, beyond and across the display window, and one that begins elsewhere than at 0.
    #[test]
    fn the_display_window_is_the_picture() {
        use exr::prelude::*;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (display_at, data_at, data_size) in [
            ((0, 0), (1, 1), (2, 1)),
            ((0, 0), (-2, -1), (9, 9)),
            ((10, -5), (9, -4), (3, 2)),
            ((0, 0), (100, 100), (2, 2)),
        ] {
            let value = |x: i32, y: i32| (x * 10 + y) as f32;
            let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
                let light = value(data_at.0 + at.x() as i32, data_at.1 + at.y() as i32);
                (light, light + 0.25, light + 0.5, 0.5_f32)
            });
            let size = Vec2(data_size.0, data_size.1);
            let attributes = LayerAttributes {
                layer_position: Vec2(data_at.0, data_at.1),
                ..LayerAttributes::default()
            };
            let layer = Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels);
            let window = IntegerBounds::new(Vec2(display_at.0, display_at.1), Vec2(4, 3));
            let image = Image::from_layer(layer);
            Image {
                attributes: ImageAttributes::new(window),
                ..image
            }
            .write()
            .to_file(&path)
            .unwrap();

            let (picture, alpha) = load_with_alpha(&path, None).unwrap();
            assert_eq!((picture.width, picture.height), (4, 3));
            let alpha = alpha.unwrap();
            for row in 0..3 {
                for column in 0..4 {
                    let (x, y) = (display_at.0 + column, display_at.1 + row);
                    let covered = (data_at.0..data_at.0 + data_size.0 as i32).contains(&x)
                        && (data_at.1..data_at.1 + data_size.1 as i32).contains(&y);
                    let light = value(x, y);
                    let expected = if covered {
                        ([light, light + 0.25, light + 0.5], 0.5)
                    } else {
                        ([0.0; 3], 0.0)
                    };
                    let index = (row * 4 + column) as usize;
                    assert_eq!((picture.pixels[index], alpha[index]), expected);
                }
            }
        }
    }

    #[test]
    fn radiance_files_are_light() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        let light = [
            image::Rgb([1.0_f32, 0.5, 4.0]),
            image::Rgb([0.25, 64.0, 0.0]),
        ];
        let file = std::fs::File::create(&path).unwrap();
        image::codecs::hdr::HdrEncoder::new(file)
            .encode(&light, 2, 1)
            .unwrap();
        let (picture, alpha) = load_with_alpha(&path, None).unwrap();
        assert_eq!(
            (picture.width, picture.height, picture.encoding, alpha),
            (2, 1, Encoding::Linear, None)
        );
        // Powers of two, but each only to 8 bits of the pixel's largest value.
        for (read, wanted) in picture
            .pixels
            .iter()
            .flatten()
            .zip(light.iter().flat_map(|pixel| pixel.0))
        {
            assert!((read - wanted).abs() <= 64.0 / 128.0, "{picture:?}");
        }
    }

    #[test]
    fn sixteen_bits_keep_distances_and_clamp_light() {
        let mut bright = layer("Combined", &["R", "G", "B"], 0.0);
        bright.data[0] = 1e6;
        bright.data[1] = -1e6;
        let mut depth = layer("Depth", &["Z"], 0.0);
        depth.data[0] = 123_456.78;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = film::Picture {
            width: 3,
            height: 2,
            layers: vec![bright, depth],
        };
        let options = output::ExrOptions {
            sample_type: output::SampleType::Half,
            ..Default::default()
        };
        let written = output::write(&path, &picture, &options, &Vec::new()).unwrap();
        assert_eq!(written.clamped, 2);
        assert_eq!(
            load(&path, None).unwrap().pixels[0],
            [65504.0, -65504.0, 2.0]
        );
        assert_eq!(
            load(&path, Some("Depth")).unwrap().pixels[0],
            [123_456.78; 3]
        );
    }

    #[test]
    fn what_is_no_picture_is_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (content, expected) in [
            (&b""[..], "too short"),
            (b"abcdefgh", "neither EXR, HDR, PNG nor JPEG"),
            (b"\x76\x2f\x31\x01\x02\x00\x00\x00", "cannot read"),
            (b"\x89PNG\r\n\x1a\n", "cannot read"),
        ] {
            std::fs::write(&path, content).unwrap();
            let message = load(&path, None).unwrap_err().to_string();
            assert!(
                message.contains(expected) && !message.contains('\n'),
                "{message}"
            );
        }
        assert!(
            load(&folder.path().join("no.exr"), None)
                .unwrap_err()
                .to_string()
                .ends_with("there is no such file")
        );
        assert!(
            load(folder.path(), None)
                .unwrap_err()
                .to_string()
                .ends_with("it is a folder")
        );
    }

    /// Every kind of file, whole.
    fn files() -> Vec<Vec<u8>> {
        use exr::prelude::Compression;
        let mut files = Vec::new();
        for compression in [
            Compression::Uncompressed,
            Compression::RLE,
            Compression::ZIP1,
            Compression::ZIP16,
            Compression::PIZ,
        ] {
            let options = output::ExrOptions {
                compression,
                ..Default::default()
            };
            let layers = vec![
                layer("Combined", &["R", "G", "B", "A"], 0.5),
                layer("Depth", &["Z"], 1.0),
            ];
            let (_folder, path) = written(layers, &options);
            files.push(std::fs::read(path).unwrap());
        }
        let picture =
            image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([x as u8 * 20, y as u8 * 30, 7]));
        for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg] {
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, format).unwrap();
            files.push(bytes.into_inner());
        }
        files
    }

    /// Damage is an error or another picture, never a panic: each byte in turn replaced by values that
    /// make sizes and counts large or negative, and each file cut off at many lengths.
    #[test]
    fn damaged_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut read = 0;
        for file in files() {
            assert!(file.len() > 100, "there is no file to damage");
            for index in 0..file.len() {
                for value in [0x7f, 0xff] {
                    let mut damaged = file.clone();
                    damaged[index] = value;
                    std::fs::write(&path, damaged).unwrap();
                    read += usize::from(load(&path, None).is_ok());
                }
            }
            for length in (0..file.len()).step_by(5) {
                std::fs::write(&path, &file[..length]).unwrap();
                let _ = load(&path, None);
            }
        }
        assert!(read > 0);
    }
}
