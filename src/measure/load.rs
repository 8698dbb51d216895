//! Reading pictures that are to be measured.

use super::{Encoding, MeasureError, Picture};
use crate::import::{check_proportion, read_exr_part};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{Text, Vec2};
use image::ImageDecoder;
use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;
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
    let bytes = std::fs::read(path).map_err(|error| unreadable(plain(&error)))?;
    if bytes.len() < 4 {
        return Err(unreadable("it is too short for a picture".into()));
    }
    if bytes.starts_with(b"\x76\x2f\x31\x01") {
        return load_exr(path, &bytes, layer);
    }
    if let Some(wanted) = layer {
        return Err(MeasureError::NoSuchLayer {
            path: path.display().to_string(),
            wanted: wanted.into(),
            there: "no layers, because it is not an EXR file".into(),
        });
    }
    let mut reader = image::ImageReader::new(Cursor::new(&bytes))
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
    // (What the whole may take is asked for below; this is for the decoder's own tables.)
    limits.max_alloc = Some(MOST_PIXELS as u64 * 24);
    reader.limits(limits);
    let damaged = |error: image::ImageError| unreadable(error.to_string());
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MOST_PIXELS as u64 {
        return Err(unreadable(format!(
            "it has {width} × {height} pixels, which is too large"
        )));
    }
    check_proportion(bytes.len(), pixels, size_of::<[f32; 3]>())
        .map_err(|failure| unreadable(failure.to_string()))?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(damaged)?;
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

/// One channel of the file.
struct Channel<'a> {
    /// All but the last word of its full name, which begins with the part's; empty for plain `R`.
    layer: String,
    /// The last word: `R`, `Z`, `X` …
    component: String,
    /// Which part it is in.
    part: usize,
    /// Its name there.
    name: &'a Text,
}

impl<'a> Channel<'a> {
    /// Those of all flat parts that have a value for each pixel.
    fn all(headers: &'a [Header]) -> Vec<Self> {
        let mut channels = Vec::new();
        for (part, header) in headers.iter().enumerate().filter(|(_, part)| !part.deep) {
            let prefix = header
                .own_attributes
                .layer_name
                .as_ref()
                .map(Text::to_string)
                .unwrap_or_default();
            let several = headers.len() > 1 && !prefix.is_empty();
            let dotted = format!("{prefix}.");
            for channel in &header.channels.list {
                let name = channel.name.to_string();
                // Files with one part a layer may or may not repeat the part's name in the channels' names.
                let full = if several && !name.starts_with(&dotted) {
                    format!("{dotted}{name}")
                } else {
                    name
                };
                let (layer, component) = full.rsplit_once('.').unwrap_or(("", &full));
                if channel.sampling == Vec2(1, 1) {
                    channels.push(Self {
                        layer: layer.into(),
                        component: component.to_uppercase(),
                        part,
                        name: &channel.name,
                    });
                }
            }
        }
        channels
    }
}

/// The values of some channels of one part.
struct Plane {
    /// Where the data window begins in the display window, which may be left of it or above.
    at: (i64, i64),
    /// Of the data window.
    size: (usize, usize),
    /// How many channels there are.
    channels: usize,
    /// Interleaved.
    values: Vec<f32>,
}

impl Plane {
    /// The value of a pixel of the display window; 0 beyond the data window.
    fn value(&self, x: usize, y: usize, channel: usize) -> f32 {
        let inside = |at: usize, begin: i64, size: usize| {
            usize::try_from(at as i64 - begin)
                .ok()
                .filter(|index| *index < size)
        };
        let column = inside(x, self.at.0, self.size.0);
        let row = inside(y, self.at.1, self.size.1);
        match (column, row) {
            (Some(column), Some(row)) => {
                let index = (row * self.size.0 + column) * self.channels + channel;
                self.values.get(index).copied().unwrap_or(0.0)
            }
            _ => 0.0,
        }
    }
}

/// So many layers are named to who asks for another one.
const NAMED_LAYERS: usize = 30;

fn load_exr(
    path: &Path,
    bytes: &[u8],
    layer: Option<&str>,
) -> Result<(Picture, Option<Vec<f32>>), MeasureError> {
    let unreadable = |reason: String| MeasureError::Unreadable {
        path: path.display().to_string(),
        reason,
    };
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false)
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
    if side > MAX_SIDE as usize || values > (bytes.len() as u64).saturating_mul(MOST_VALUES_A_BYTE)
    {
        return Err(unreadable(
            "its header claims a size that its content cannot have".into(),
        ));
    }
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
    let channels = Channel::all(&headers);
    // The first of each name: a file may have very many.
    let mut layers: Vec<&str> = Vec::new();
    let mut known: HashMap<&str, HashMap<&str, &Channel>> = HashMap::new();
    for channel in &channels {
        let components = known.entry(&channel.layer).or_insert_with(|| {
            layers.push(&channel.layer);
            HashMap::new()
        });
        components.entry(&channel.component).or_insert(channel);
    }
    let find = |layer: &str, component: &str| known.get(layer)?.get(component).copied();
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
    let no_such_layer = || {
        let names = layers.iter().take(NAMED_LAYERS);
        let mut there = names
            .map(|name| if name.is_empty() { "Combined" } else { name })
            .collect::<Vec<_>>()
            .join(", ");
        if layers.len() > NAMED_LAYERS {
            there.push_str(&format!(" and {} more", layers.len() - NAMED_LAYERS));
        }
        MeasureError::NoSuchLayer {
            path: path.display().to_string(),
            wanted: layer.unwrap_or("with colours").into(),
            there,
        }
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
    let wanted: Vec<&Channel> = [red, green, blue]
        .into_iter()
        .chain(find(chosen, "A"))
        .collect();
    // What is read of the file, and the picture that it becomes.
    let mut pixels = (width * height) as u64;
    let mut names: BTreeMap<usize, Vec<Text>> = BTreeMap::new();
    for channel in &wanted {
        let names = names.entry(channel.part).or_insert_with(|| {
            pixels = pixels.max(headers[channel.part].layer_size.area() as u64);
            Vec::new()
        });
        if !names.contains(channel.name) {
            names.push(channel.name.clone());
        }
    }
    check_proportion(bytes.len(), pixels, wanted.len() * size_of::<f32>())
        .map_err(|failure| unreadable(failure.to_string()))?;
    let mut planes: BTreeMap<usize, Plane> = BTreeMap::new();
    for (&part, names) in &names {
        let header = &headers[part];
        let begin = header.own_attributes.layer_position;
        let plane = Plane {
            at: (
                i64::from(begin.x()) - i64::from(window.position.x()),
                i64::from(begin.y()) - i64::from(window.position.y()),
            ),
            size: (header.layer_size.x(), header.layer_size.y()),
            channels: names.len(),
            values: read_exr_part(bytes, part, names)
                .map_err(|failure| unreadable(failure.to_string()))?,
        };
        planes.insert(part, plane);
    }
    let places: Vec<(&Plane, usize)> = wanted
        .iter()
        .filter_map(|channel| {
            let slot = names.get(&channel.part)?;
            let slot = slot.iter().position(|name| name == channel.name)?;
            Some((planes.get(&channel.part)?, slot))
        })
        .collect();
    let value = |number: usize, x: usize, y: usize| {
        places
            .get(number)
            .map_or(0.0, |(plane, slot)| plane.value(x, y, *slot))
    };
    let all = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = all()
        .map(|(x, y)| std::array::from_fn(|number| value(number, x, y)))
        .collect();
    let alpha = (wanted.len() > 3).then(|| all().map(|(x, y)| value(3, x, y)).collect());
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

    /// Twenty thousand channels: what is looked for is found, and time does not grow with the square (this test would take
    /// minutes).
    #[test]
    fn very_many_channels_are_no_trouble() {
        use exr::prelude::*;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let channel = |name: String, value: f32| {
            let name = Text::new_or_none(&name).unwrap();
            AnyChannel::new(name, FlatSamples::F32(vec![value; 2]))
        };
        let channels = (0..20_000)
            .map(|n| channel(format!("L{n:05}.{}", ["R", "G", "B", "A"][n % 4]), n as f32))
            .chain(["R", "G", "B"].map(|name| channel(format!("Wanted.{name}"), 7.0)));
        let layer = Layer::new(
            Vec2(2, 1),
            LayerAttributes::default(),
            Encoding::UNCOMPRESSED,
            AnyChannels::sort(channels.collect()),
        );
        Image::from_layer(layer).write().to_file(&path).unwrap();
        assert_eq!(load(&path, None).unwrap().pixels, [[7.0; 3]; 2]);
        let missing = load(&path, Some("Mist")).unwrap_err().to_string();
        assert!(
            missing.ends_with(" more") && missing.len() < 1000,
            "{missing}"
        );
        let bytes = std::fs::read(&path).unwrap();
        let image = crate::import::decode_image(&bytes, "a").unwrap();
        assert_eq!((image.width, image.height, image.channels), (2, 1, 3));
    }

    #[test]
    fn large_pictures_of_one_colour_are_believed_and_larger_ones_are_not() {
        // 8K of 16 bytes a pixel in the fewest bytes, and what a small file may claim.
        check_proportion(1000, 7680 * 4320, 16).unwrap();
        check_proportion(4 << 20, 16_384 * 16_384, 12).unwrap();
        assert!(check_proportion(1200, 16_384 * 16_384, 12).is_err());
        assert!(check_proportion(33_000, 16_384 * 16_384, 12).is_err());
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
