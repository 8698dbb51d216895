//! Images: precision is kept, every compression of OpenEXR is read as OpenEXR itself reads it.

use std::path::{Path, PathBuf};

use exr::prelude::*;
use sundog::import::{decode_image, load_environment};
use sundog::scene::{Image, Pixels, Scene};

use super::blender::run_script;
use super::kit::{place, png};

fn floats(image: &Image) -> &[f32] {
    match &image.pixels {
        Pixels::F32(values) => values,
        other => panic!("not floats: {other:?}"),
    }
}

#[test]
fn precision_and_channels_are_those_of_the_file() {
    let grey8 = decode_image(
        &png(image::GrayImage::from_raw(2, 1, vec![0, 200])
            .unwrap()
            .into()),
        "a",
    )
    .unwrap();
    assert_eq!((grey8.width, grey8.height, grey8.channels), (2, 1, 1));
    assert!(matches!(&grey8.pixels, Pixels::U8(v) if v[..] == [0, 200]));
    let deep: image::ImageBuffer<image::Rgba<u16>, Vec<u16>> =
        image::ImageBuffer::from_raw(1, 2, vec![1, 256, 65535, 4, 5, 6, 7, 8]).unwrap();
    let rgba16 = decode_image(&png(deep.into()), "b").unwrap();
    assert_eq!(rgba16.channels, 4);
    assert!(matches!(&rgba16.pixels, Pixels::U16(v) if v[..] == [1, 256, 65535, 4, 5, 6, 7, 8]));
    let grey_alpha: image::ImageBuffer<image::LumaA<u8>, Vec<u8>> =
        image::ImageBuffer::from_raw(1, 1, vec![9, 8]).unwrap();
    assert_eq!(
        decode_image(&png(grey_alpha.into()), "c").unwrap().channels,
        2
    );
}

#[test]
fn jpeg_is_read() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(image::RgbImage::from_pixel(
        16,
        16,
        image::Rgb([200, 100, 50]),
    ))
    .write_to(&mut bytes, image::ImageFormat::Jpeg)
    .unwrap();
    let image = decode_image(&bytes.into_inner(), "jpeg").unwrap();
    let Pixels::U8(values) = &image.pixels else {
        panic!()
    };
    // A flat block survives JPEG to within rounding of the colour transform.
    for texel in values.chunks(3) {
        assert!(
            texel
                .iter()
                .zip([200u8, 100, 50])
                .all(|(a, b)| a.abs_diff(b) <= 2),
            "{texel:?}"
        );
    }
}

/// BMP, TIFF and Targa keep all codes; GIF has a palette, which four colours fit.
#[test]
fn bmp_tiff_targa_and_gif_are_read() {
    let codes = [10u8, 20, 30, 250, 5, 0, 0, 255, 128, 7, 7, 7];
    let picture =
        image::DynamicImage::from(image::RgbImage::from_raw(2, 2, codes.to_vec()).unwrap());
    for format in [
        image::ImageFormat::Bmp,
        image::ImageFormat::Tiff,
        image::ImageFormat::Tga,
        image::ImageFormat::Gif,
    ] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        let read = decode_image(&bytes.into_inner(), "small").unwrap();
        assert_eq!((read.width, read.height), (2, 2), "{format:?}");
        let Pixels::U8(values) = &read.pixels else {
            panic!("{format:?}")
        };
        let texels = values.chunks(read.channels as usize);
        let colors: Vec<u8> = texels.flat_map(|texel| texel[..3].to_vec()).collect();
        assert_eq!(colors, codes, "{format:?}");
    }
}

// --- Radiance HDR ---

/// A flat (not run-length encoded) Radiance picture of RGBE texels.
fn radiance(width: usize, texels: &[[u8; 4]]) -> Vec<u8> {
    let height = texels.len() / width;
    let mut file =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    file.extend(texels.iter().flatten());
    file
}

#[test]
fn radiance_pictures_become_an_environment() {
    let (_folder, path) = place("sky.hdr");
    // value = mantissa · 2^(exponent − 136)
    std::fs::write(
        &path,
        radiance(
            2,
            &[
                [128, 64, 32, 129],
                [255, 0, 0, 140],
                [4, 4, 4, 128],
                [0, 0, 0, 0],
            ],
        ),
    )
    .unwrap();
    let mut scene = Scene::default();
    let diagnostics = load_environment(&mut scene, &path, 2.5, 90.0).unwrap();
    assert!(diagnostics.is_empty());
    let environment = scene.environment.as_ref().unwrap();
    assert_eq!(environment.radiance, [2.5; 3]);
    assert!((environment.rotation * glam::DVec3::X - glam::DVec3::Y).length() < 1e-7);
    let image = &scene.images[environment.image.unwrap().0 as usize];
    assert_eq!((image.width, image.height, image.channels), (2, 2, 3));
    let expected = [
        1.0, 0.5, 0.25, 4080.0, 0.0, 0.0, 0.015_625, 0.015_625, 0.015_625, 0.0, 0.0, 0.0,
    ];
    for (found, expected) in floats(image).iter().zip(expected) {
        assert!(
            (found - expected).abs() <= expected * 1e-6,
            "{found} {expected}"
        );
    }
    // A second environment takes the place of the first.
    load_environment(&mut scene, &path, 1.0, 0.0).unwrap();
    assert_eq!(scene.images.len(), 1);
}

#[test]
fn eight_bit_environments_are_srgb() {
    let (_folder, path) = place("sky.png");
    let pixels = image::RgbImage::from_raw(2, 1, vec![0, 255, 128, 10, 10, 10]).unwrap();
    std::fs::write(&path, png(pixels.into())).unwrap();
    let mut scene = Scene::default();
    load_environment(&mut scene, &path, 1.0, 0.0).unwrap();
    // IEC 61966-2-1 by hand: ((128/255 + 0.055) / 1.055)^2.4, 10/255/12.92.
    let expected = [
        0.0,
        1.0,
        0.215_860_5,
        0.003_035_27,
        0.003_035_27,
        0.003_035_27,
    ];
    for (found, expected) in floats(&scene.images[0]).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn environments_that_cannot_be_are_errors() {
    let (folder, path) = place("sky.hdr");
    let mut scene = Scene::default();
    let mut error = |path: &Path, strength, rotation| {
        let error = load_environment(&mut scene, path, strength, rotation)
            .unwrap_err()
            .to_string();
        assert!(scene.environment.is_none() && scene.images.is_empty());
        error
    };
    assert!(error(&path, 1.0, 0.0).contains("there is no such file"));
    std::fs::write(
        &path,
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n",
    )
    .unwrap();
    assert!(error(&path, 1.0, 0.0).contains("100000 × 100000"));
    std::fs::write(&path, b"just text").unwrap();
    assert!(error(&path, 1.0, 0.0).contains("OpenEXR or Radiance HDR"));
    assert!(error(&path, f32::NAN, 0.0).contains("strength"));
    assert!(error(&path, 1.0, f32::INFINITY).contains("rotation"));
    assert!(error(folder.path(), 1.0, 0.0).contains("it is a folder"));
}

// --- OpenEXR ---

/// Writes RGB channels under these names, as one layer.
fn layer(
    size: (usize, usize),
    name: Option<&str>,
    channels: &[(&str, f32)],
) -> Layer<AnyChannels<FlatSamples>> {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels
        .iter()
        .map(|&(name, value)| AnyChannel::new(name, FlatSamples::F32(vec![value; size.0 * size.1])))
        .collect();
    let attributes = match name {
        Some(name) => LayerAttributes::named(name),
        None => LayerAttributes::default(),
    };
    Layer::new(
        size,
        attributes,
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list),
    )
}

fn write_layers(layers: Vec<Layer<AnyChannels<FlatSamples>>>, size: (usize, usize)) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let attributes = ImageAttributes::with_size(size);
    let image: exr::image::Image<Layers<AnyChannels<FlatSamples>>> =
        exr::image::Image::from_layers(attributes, layers);
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn the_picture_is_found_among_layers_and_parts() {
    let size = (4, 3);
    let rgb = |prefix: &str, value: f32| {
        ["R", "G", "B"]
            .iter()
            .zip([1.0, 2.0, 3.0])
            .map(|(c, k)| (format!("{prefix}{c}"), value * k))
            .collect::<Vec<_>>()
    };
    let channels = |lists: Vec<Vec<(String, f32)>>| lists.into_iter().flatten().collect::<Vec<_>>();
    let read = |lists: Vec<Vec<(String, f32)>>| {
        let list = channels(lists);
        let list: Vec<(&str, f32)> = list.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        let image = decode_image(
            &write_layers(vec![layer(size, None, &list)], size),
            "layers",
        )
        .unwrap();
        assert_eq!((image.width, image.height), (4, 3));
        floats(&image)[..image.channels as usize].to_vec()
    };
    let depth = || vec![("ViewLayer.Depth.Z".to_string(), 99.0)];
    assert_eq!(
        read(vec![
            rgb("A.Normal.", 5.0),
            depth(),
            rgb("ViewLayer.Combined.", 1.0)
        ]),
        [1.0, 2.0, 3.0]
    );
    assert_eq!(
        read(vec![
            rgb("A.Normal.", 5.0),
            rgb("ViewLayer.Combined.", 1.0),
            rgb("", 7.0)
        ]),
        [7.0, 14.0, 21.0]
    );
    assert_eq!(read(vec![depth(), rgb("some.", 2.0)]), [2.0, 4.0, 6.0]);
    assert_eq!(
        read(vec![vec![("Y".into(), 0.5), ("A".into(), 1.0)]]),
        [0.5]
    );
    assert_eq!(read(vec![depth()]), [99.0]);

    let part = |name: &str, channels: &[(&str, f32)]| layer(size, Some(name), channels);
    let parts = vec![
        part("depth", &[("Z", 9.0)]),
        part("Combined", &[("B", 3.0), ("G", 2.0), ("R", 1.0)]),
        part("normal", &[("B", 6.0), ("G", 5.0), ("R", 4.0)]),
    ];
    let image = decode_image(&write_layers(parts, size), "parts").unwrap();
    assert_eq!(floats(&image)[..3], [1.0, 2.0, 3.0]);
}

#[test]
fn the_display_window_is_the_picture() {
    // A data window of 4 × 3 at (1, −1) in a display window of 6 × 4 at (0, 0): it hangs over the top.
    let samples = |k: f32| FlatSamples::F32((0..12).map(|i| k * (1 + i) as f32).collect());
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = ["R", "G", "B"]
        .into_iter()
        .zip([1.0, 10.0, 100.0])
        .map(|(n, k)| AnyChannel::new(n, samples(k)))
        .collect();
    let attributes = LayerAttributes {
        layer_position: Vec2(1, -1),
        ..LayerAttributes::default()
    };
    let layer = Layer::new(
        (4, 3),
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let bytes = write_layers(vec![layer], (6, 4));
    let image = decode_image(&bytes, "crop").unwrap();
    assert_eq!((image.width, image.height, image.channels), (6, 4, 3));
    let red: Vec<f32> = floats(&image).chunks(3).map(|t| t[0]).collect();
    #[rustfmt::skip]
    let expected = [
        0.0, 5.0, 6.0, 7.0, 8.0, 0.0,
        0.0, 9.0, 10.0, 11.0, 12.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
    assert_eq!(red, expected);
    assert!(
        floats(&image)
            .chunks(3)
            .all(|t| t[1] == t[0] * 10.0 && t[2] == t[0] * 100.0)
    );
}

#[test]
fn tiled_half_and_integer_files_are_read() {
    let (width, height) = (37, 29);
    let values: Vec<f32> = (0..width * height).map(|i| i as f32 * 0.5).collect();
    for (samples, scale) in [
        (
            FlatSamples::F16(values.iter().map(|v| f16::from_f32(*v)).collect()),
            1.0,
        ),
        (
            FlatSamples::U32(values.iter().map(|v| (*v * 2.0) as u32).collect()),
            2.0,
        ),
    ] {
        let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = ["R", "G", "B"]
            .into_iter()
            .map(|n| AnyChannel::new(n, samples.clone()))
            .collect();
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: exr::image::Blocks::Tiles(Vec2(16, 8)),
            line_order: LineOrder::Increasing,
        };
        let layer = Layer::new(
            (width, height),
            LayerAttributes::default(),
            encoding,
            AnyChannels::sort(channels),
        );
        let image = decode_image(&write_layers(vec![layer], (width, height)), "tiles").unwrap();
        for (texel, value) in floats(&image).chunks(3).zip(&values) {
            assert_eq!(texel, [value * scale; 3]);
        }
    }
}

#[test]
fn environment_texels_that_are_no_radiance_are_replaced_and_counted() {
    let (_folder, path) = place("sky.exr");
    let values = [f32::NAN, f32::INFINITY, -3.0, 2.0, f32::NEG_INFINITY, -0.0];
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = ["R", "G", "B"]
        .into_iter()
        .map(|n| AnyChannel::new(n, FlatSamples::F32(values.to_vec())))
        .collect();
    let layer = Layer::new(
        (6, 1),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(channels),
    );
    std::fs::write(&path, write_layers(vec![layer], (6, 1))).unwrap();
    let mut scene = Scene::default();
    let diagnostics = load_environment(&mut scene, &path, 1.0, 0.0).unwrap();
    let red: Vec<f32> = floats(&scene.images[0]).chunks(3).map(|t| t[0]).collect();
    assert_eq!(red, [0.0, 2.0, 0.0, 2.0, 0.0, 0.0]);
    let message = diagnostics.iter().next().unwrap().to_string();
    assert!(message.contains("4 texels"), "{message}");
}

/// A whole OpenEXR file of a few pixels.
pub fn small_exr() -> Vec<u8> {
    write_layers(
        vec![layer((4, 4), None, &[("R", 1.0), ("G", 2.0), ("B", 3.0)])],
        (4, 4),
    )
}

/// The same damage every time: Knuth's MMIX linear congruential generator.
struct Damage(u64);

impl Damage {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }

    /// A copy with a few bytes changed, in one of three cases cut off too.
    fn of(&mut self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            bytes[at] = self.below(256) as u8;
        }
        if self.below(3) == 0 {
            bytes.truncate(self.below(whole.len()));
        }
        bytes
    }
}

#[test]
fn damaged_pictures_never_panic() {
    let texels: Vec<u8> = (0..24 * 20 * 3).map(|i| (i * 7 % 251) as u8).collect();
    let picture = image::DynamicImage::from(image::RgbImage::from_raw(24, 20, texels).unwrap());
    for format in [
        image::ImageFormat::Png,
        image::ImageFormat::Jpeg,
        image::ImageFormat::WebP,
        image::ImageFormat::Hdr,
        image::ImageFormat::Gif,
        image::ImageFormat::Bmp,
        image::ImageFormat::Tiff,
        image::ImageFormat::Tga,
    ] {
        let picture = if format == image::ImageFormat::Hdr {
            picture.to_rgb32f().into()
        } else {
            picture.clone()
        };
        let mut whole = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut whole, format).unwrap();
        let whole = whole.into_inner();
        assert!(decode_image(&whole, "whole").is_ok(), "{format:?}");
        let mut damage = Damage(1);
        for _ in 0..2000 {
            if let Ok(image) = decode_image(&damage.of(&whole), "damaged") {
                let values = match &image.pixels {
                    Pixels::U8(v) => v.len(),
                    Pixels::U16(v) => v.len(),
                    Pixels::F32(v) => v.len(),
                };
                assert_eq!(
                    values,
                    image.width as usize * image.height as usize * image.channels as usize
                );
            }
        }
    }
}

#[test]
fn damaged_exr_files_never_panic() {
    let list = [("R", 1.0), ("G", 2.0), ("B", 3.0)];
    for encoding in [
        Encoding::SMALL_LOSSLESS,
        Encoding {
            compression: Compression::PIZ,
            ..Encoding::SMALL_LOSSLESS
        },
        Encoding {
            compression: Compression::RLE,
            ..Encoding::SMALL_LOSSLESS
        },
        Encoding {
            compression: Compression::PXR24,
            ..Encoding::SMALL_LOSSLESS
        },
        Encoding {
            compression: Compression::B44,
            ..Encoding::SMALL_LOSSLESS
        },
        Encoding {
            compression: Compression::DWAA(None),
            ..Encoding::SMALL_LOSSLESS
        },
    ] {
        let mut one = layer((40, 30), None, &list);
        one.encoding = encoding;
        let whole = write_layers(vec![one], (40, 30));
        assert!(decode_image(&whole, "whole").is_ok());
        let mut damage = Damage(7);
        for _ in 0..400 {
            let _ = decode_image(&damage.of(&whole), "damaged");
        }
    }
}

#[test]
fn every_compression_is_read_as_openexr_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    run_script("write_exr.py", folder.path());
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    files.retain(|p| p.extension().is_some_and(|e| e == "exr") && !p.ends_with("combined.exr"));
    // Eight compressions in two depths and two in one, with three kinds of channels each.
    assert_eq!(files.len(), (8 * 2 + 2) * 3);
    for path in &files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let image = decode_image(&std::fs::read(path).unwrap(), name)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let bytes = std::fs::read(path.with_extension("f32")).unwrap();
        let expected: Vec<f32> = bytes
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        let channels = image.channels as usize;
        let all = if name.ends_with("RGBA") {
            4
        } else {
            channels.min(3)
        };
        assert_eq!(
            (image.width, image.height, channels),
            (70, 45, all),
            "{name}"
        );
        // DWA's cosine transform is in floats whose order of additions is the decoder's own; its output is
        // rounded to half floats (11 bits), so that two decoders may differ by one such step, 2⁻¹⁰ relative.
        let tolerance = if name.starts_with("DWA") {
            1.0 / 1024.0
        } else {
            0.0
        };
        for (i, (texel, expected)) in floats(&image)
            .chunks(channels)
            .zip(expected.chunks(4))
            .enumerate()
        {
            for (found, expected) in texel.iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= tolerance * expected.abs(),
                    "{name}, texel {i}: {found} is not {expected}"
                );
            }
        }
    }
    let combined = decode_image(
        &std::fs::read(folder.path().join("combined.exr")).unwrap(),
        "combined",
    )
    .unwrap();
    assert_eq!(
        (combined.width, combined.height, combined.channels),
        (16, 8, 4)
    );
    for texel in floats(&combined).chunks(4) {
        for (found, expected) in texel.iter().zip([0.25, 0.5, 2.0, 1.0]) {
            // DWAA at its default level 45 keeps a constant to better than a percent.
            assert!((found / expected - 1.0).abs() < 0.01, "{texel:?}");
        }
    }
}

/// Moves images into scratch files until the others fit, tells which, and changes no bit of them: of glTF and of USD.
#[test]
fn images_beyond_what_they_may_take_lie_in_files() {
    let mut file = super::kit::Builder::square();
    let noise =
        image::RgbImage::from_fn(64, 32, |x, y| image::Rgb([(x * 7 + y * 13) as u8, 9, 200]));
    let folder = tempfile::tempdir().unwrap();
    noise.save(folder.path().join("noise.png")).unwrap();
    let stage = folder.path().join("stage.usda");
    std::fs::write(&stage, TEXTURED_STAGE).unwrap();
    let texture = file.png_texture(noise.into());
    file.json["materials"][0]["pbrMetallicRoughness"] =
        serde_json::json!({ "baseColorTexture": { "index": texture } });
    let there = |usd: bool, most: Option<u64>| {
        let options = sundog::import::ImportOptions {
            image_bytes: most,
            ..Default::default()
        };
        let imported = if usd {
            sundog::import::load(&stage, &options).unwrap()
        } else {
            file.load_with(&options).unwrap()
        };
        let image = &imported.scene.images[0];
        assert_eq!((image.width, image.height), (64, 32));
        let told = super::kit::found(&imported, "image-in-file").len();
        (image.pixels.clone(), image.pixels.are_in_file(), told)
    };
    let (whole, ..) = there(false, None);
    for usd in [false, true] {
        for (most, in_file) in [
            (None, false),
            (Some(3 * 64 * 32), false),
            (Some(3 * 64 * 32 - 1), true),
        ] {
            let (pixels, is_in_file, told) = there(usd, most);
            assert_eq!(
                (is_in_file, told),
                (in_file, usize::from(in_file)),
                "{most:?}"
            );
            assert!(pixels.is_same(&whole), "{most:?}");
        }
    }
}

const TEXTURED_STAGE: &str = r#"#usda 1.0
def Mesh "square" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (interpolation = "vertex")
    rel material:binding = </material>
}
def Material "material" {
    token outputs:surface.connect = </material/surface.outputs:surface>
    def Shader "surface" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </material/image.outputs:rgb>
        token outputs:surface
    }
    def Shader "image" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @noise.png@
        float3 outputs:rgb
    }
}
"#;

/// An environment beyond what is left of the memory lies in a file, with the same numbers.
#[test]
fn environments_lie_in_files_as_images_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.png");
    image::RgbImage::from_fn(32, 16, |x, y| image::Rgb([x as u8, y as u8, 99]))
        .save(&path)
        .unwrap();
    let bytes = 32 * 16 * 12;
    let there = |most: Option<u64>| {
        let mut scene = sundog::scene::Scene::default();
        let at = (1.0, 0.0);
        sundog::import::load_environment_within(&mut scene, &path, at, most).unwrap();
        scene.images.remove(0).pixels
    };
    assert!(!there(Some(bytes)).are_in_file());
    let moved = there(Some(bytes - 1));
    assert!(moved.are_in_file() && moved.is_same(&there(None)));
}
