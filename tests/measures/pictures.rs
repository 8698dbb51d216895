//! Pictures that are written are read again, and damaged ones are sentences.

use sundog::film;
use sundog::measure::{Encoding, load, load_with_alpha};
use sundog::output::exr as output;

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
    let image = sundog::import::decode_image(&bytes, "a").unwrap();
    assert_eq!((image.width, image.height, image.channels), (2, 1, 3));
}

#[test]
fn scenes_and_measures_find_the_same_picture() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    // What each channel holds is its number.
    for (names, expected) in [
        (&["N.X", "N.Y", "N.Z"][..], &[0.0, 1.0, 2.0][..]),
        (&["A", "Y"], &[1.0]),
        (&["Depth.Z", "some.B", "some.G", "some.R"], &[3.0, 2.0, 1.0]),
        (
            &[
                "a.B",
                "a.G",
                "a.R",
                "b.Combined.blue",
                "b.Combined.green",
                "b.Combined.red",
            ],
            &[5.0, 4.0, 3.0],
        ),
        (&["Depth.Z"], &[0.0]),
    ] {
        let channels = names.iter().enumerate().map(|(number, name)| {
            let name = Text::new_or_none(name).unwrap();
            AnyChannel::new(name, FlatSamples::F32(vec![number as f32; 2]))
        });
        let layer = Layer::new(
            Vec2(2, 1),
            LayerAttributes::default(),
            Encoding::UNCOMPRESSED,
            AnyChannels::sort(channels.collect()),
        );
        Image::from_layer(layer).write().to_file(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let image = sundog::import::decode_image(&bytes, "a").unwrap();
        assert_eq!(image.channels as usize, expected.len(), "{names:?}");
        let grey = [expected[0]; 3];
        let pixel: [f32; 3] = expected.try_into().unwrap_or(grey);
        assert_eq!(sundog::import::colors(&image), [pixel; 2], "{names:?}");
        assert_eq!(load(&path, None).unwrap().pixels, [pixel; 2], "{names:?}");
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

/// Damage is an error or another picture, never a panic: bytes in turn replaced by values that make sizes and counts large or
/// negative, and each file cut off at many lengths. Each byte of the header, beyond it each `step`th; with all values, or with
/// one of them in turn.
fn damage(step: usize, all_values: bool) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let mut read = 0;
    for file in files() {
        assert!(file.len() > 100, "there is no file to damage");
        let header = file.len().min(400);
        let in_header = (0..header).step_by(if all_values { 1 } else { 3 });
        for index in in_header.chain((header..file.len()).step_by(step)) {
            for value in [0x7f, 0xff] {
                if !all_values && (index % 2 == 0) == (value == 0xff) {
                    continue;
                }
                let mut damaged = file.clone();
                damaged[index] = value;
                std::fs::write(&path, damaged).unwrap();
                read += usize::from(load(&path, None).is_ok());
            }
        }
        for length in (0..file.len()).step_by(5 * step) {
            std::fs::write(&path, &file[..length]).unwrap();
            let _ = load(&path, None);
        }
    }
    assert!(read > 0);
}

/// `long` damages every byte with each value.
#[test]
fn damaged_files_are_errors() {
    damage(23, false);
}

mod long {
    #[test]
    #[ignore = "long: `make test-long` runs it"]
    fn files_with_any_damaged_byte_are_errors() {
        super::damage(1, true);
    }
}
