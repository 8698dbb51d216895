//! OpenEXR through the crate `exr`: which of a file's many layers is the picture, and where in the
//! display window it lies.

use std::collections::HashMap;
use std::io::Cursor;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader as _;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use rayon::prelude::*;

use super::{ImageFailure, MOST_PIXELS};
use crate::scene::Image;

/// The channels that make up the picture, by name in the file.
#[derive(Clone, Debug, PartialEq)]
enum Picture {
    /// Red, green, blue, and alpha where there is one.
    Color(Vec<Text>),
    Grey(Text),
}

/// Width and height of the display window of the part that is shown.
pub(super) fn dimensions(bytes: &[u8]) -> std::result::Result<(u64, u64), ImageFailure> {
    let meta = metadata(bytes)?;
    let (part, _) = choose(&meta.headers)?;
    let header = &meta.headers[part];
    let display = header.shared_attributes.display_window.size;
    let data = header.layer_size;
    // Either may be the larger one: overscan, or a crop.
    Ok((
        display.width().max(data.width()) as u64,
        display.height().max(data.height()) as u64,
    ))
}

fn metadata(bytes: &[u8]) -> std::result::Result<MetaData, ImageFailure> {
    MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)
}

fn damaged(error: Error) -> ImageFailure {
    ImageFailure::Damaged(match error {
        Error::NotSupported(what) => format!("its kind of OpenEXR is not supported ({what})"),
        Error::Invalid(what) => format!("it is damaged ({what})"),
        Error::Io(what) => format!("it is damaged or cut off ({what})"),
        Error::Aborted => "reading was stopped".into(),
    })
}

/// The part of the file and its channels that are the picture.
///
/// In this order: plain R, G, B; a layer named "Combined" (Blender's beauty pass, as in
/// `ViewLayer.Combined.R`); the first layer that has R, G and B; luminance `Y`; the first channel of
/// all, as grey.
fn choose(headers: &[Header]) -> std::result::Result<(usize, Picture), ImageFailure> {
    let mut best: Option<(u32, usize, Picture)> = None;
    for (part, header) in headers.iter().enumerate() {
        if header.deep {
            continue;
        }
        let part_name = header
            .own_attributes
            .layer_name
            .as_ref()
            .map(Text::to_string)
            .unwrap_or_default();
        let combined = |s: &str| {
            s.rsplit('.')
                .next()
                .is_some_and(|l| l.eq_ignore_ascii_case("combined"))
        };
        let channels: Vec<(String, &Text)> = header
            .channels
            .list
            .iter()
            .map(|channel| (channel.name.to_string(), &channel.name))
            .collect();
        // The first channel of each layer for each colour: a file may have many of both.
        let mut colors: HashMap<(&str, usize), &Text> = HashMap::new();
        for (name, text) in &channels {
            let (layer, last) = split(name);
            if let Some(color) = COLORS
                .iter()
                .position(|words| words.iter().any(|word| last.eq_ignore_ascii_case(word)))
            {
                colors.entry((layer, color)).or_insert(text);
            }
        }
        for (name, text) in &channels {
            let (layer, last) = split(name);
            let color = |number: usize| colors.get(&(layer, number)).map(|text| (*text).clone());
            let rgb = match (color(0), color(1), color(2)) {
                (Some(r), Some(g), Some(b)) => Some(Picture::Color(
                    [r, g, b].into_iter().chain(color(3)).collect(),
                )),
                _ => None,
            };
            let (rank, picture) = match rgb {
                Some(rgb) if layer.is_empty() && (part_name.is_empty() || part == 0) => (0, rgb),
                Some(rgb) if combined(layer) || (layer.is_empty() && combined(&part_name)) => {
                    (1, rgb)
                }
                Some(rgb) => (2, rgb),
                None if last.eq_ignore_ascii_case("y") => (3, Picture::Grey((*text).clone())),
                None => (4, Picture::Grey((*text).clone())),
            };
            if best.as_ref().is_none_or(|(r, _, _)| rank < *r) {
                best = Some((rank, part, picture));
            }
        }
    }
    match best {
        Some((_, part, picture)) => Ok((part, picture)),
        None => Err(ImageFailure::Damaged(
            "it has no flat picture (deep data only, or no channels)".into(),
        )),
    }
}

/// Last words of channels' names.
const COLORS: [[&str; 2]; 4] = [["r", "red"], ["g", "green"], ["b", "blue"], ["a", "alpha"]];

/// A channel's layer and what it is of it.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// Reads the picture as one, three or four channels of `f32`, in the display window's frame; what the
/// data window does not cover is black, and transparent where there is alpha. Colours are taken as they
/// stand: whether they are multiplied with alpha is for who uses them to know.
pub(super) fn decode(bytes: &[u8], name: &str) -> std::result::Result<Image, ImageFailure> {
    let (width, height) = dimensions(bytes)?;
    if width.saturating_mul(height) > MOST_PIXELS {
        return Err(ImageFailure::Size { width, height });
    }
    let meta = metadata(bytes)?;
    let (part, picture) = choose(&meta.headers)?;
    let header = &meta.headers[part];
    let wanted: Vec<Text> = match &picture {
        Picture::Color(names) => names.clone(),
        Picture::Grey(name) => vec![name.clone()],
    };
    if header
        .channels
        .list
        .iter()
        .any(|c| wanted.contains(&c.name) && c.sampling != Vec2(1, 1))
    {
        return Err(ImageFailure::Damaged(
            "its colour channels are subsampled, which is not supported".into(),
        ));
    }
    let display = header.shared_attributes.display_window;
    let data_origin = header.own_attributes.layer_position;
    let size = header.layer_size;
    let channels = wanted.len();

    let values = read_part(bytes, part, &wanted)?;
    let covers = display.position == data_origin && display.size == size;
    let (width, height, values) = if covers || display.size.area() == 0 {
        (size.width(), size.height(), values)
    } else {
        let mut framed = vec![0.0; display.size.area() * channels];
        let shift = data_origin - display.position;
        for y in 0..size.height() {
            let Ok(row) = usize::try_from(y as i64 + i64::from(shift.y())) else {
                continue;
            };
            if row >= display.size.height() {
                break;
            }
            // The overlap of the two windows along x.
            let from = (-i64::from(shift.x())).clamp(0, size.width() as i64) as usize;
            let to = (display.size.width() as i64 - i64::from(shift.x()))
                .clamp(from as i64, size.width() as i64) as usize;
            let target = (row * display.size.width()) as i64 + from as i64 + i64::from(shift.x());
            let length = (to - from) * channels;
            let source = (y * size.width() + from) * channels;
            let target = target.max(0) as usize * channels;
            if let (Some(into), Some(what)) = (
                framed.get_mut(target..target + length),
                values.get(source..source + length),
            ) {
                into.copy_from_slice(what);
            }
        }
        (display.size.width(), display.size.height(), framed)
    };
    Ok(Image {
        name: name.into(),
        width: u32::try_from(width).unwrap_or(u32::MAX),
        height: u32::try_from(height).unwrap_or(u32::MAX),
        channels: channels as u32,
        pixels: values.into(),
    })
}

/// The named channels of one part, interleaved, in the data window's frame.
///
/// Blocks are decompressed a batch at a time, so that a file of forty passes does not have to fit
/// into memory beside its picture.
pub fn read_part(
    bytes: &[u8],
    part: usize,
    wanted: &[Text],
) -> std::result::Result<Vec<f32>, ImageFailure> {
    let chunks = exr::block::read(Cursor::new(bytes), false)
        .and_then(|reader| {
            reader.filter_chunks(false, |_, tile, block| {
                block.layer == part && tile.level_index == Vec2(0, 0)
            })
        })
        .map_err(damaged)?;
    let meta = chunks.meta_data().clone();
    let header = meta
        .headers
        .get(part)
        .ok_or_else(|| ImageFailure::Damaged("it is damaged".into()))?;
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    let channels = wanted.len();
    let mut values = vec![0.0; width * height * channels];
    let mut chunks = chunks.peekable();
    while chunks.peek().is_some() {
        let batch: Vec<Chunk> = chunks
            .by_ref()
            .take(BATCH)
            .collect::<Result<_>>()
            .map_err(damaged)?;
        let blocks: Vec<UncompressedBlock> = batch
            .into_par_iter()
            .map(|chunk| {
                check_dwa(&chunk, header)?;
                UncompressedBlock::decompress_chunk(chunk, &meta, false)
            })
            .collect::<Result<_>>()
            .map_err(damaged)?;
        for block in blocks {
            put(&block, header, wanted, (width, height), &mut values).map_err(damaged)?;
        }
    }
    Ok(values)
}

/// Blocks decompressed at a time.
const BATCH: usize = 64;

/// Copies the wanted channels of a block to their places.
fn put(
    block: &UncompressedBlock,
    header: &Header,
    wanted: &[Text],
    (width, height): (usize, usize),
    values: &mut [f32],
) -> Result<()> {
    let channels = wanted.len();
    for line in block.lines(&header.channels) {
        let channel = &header.channels.list[line.location.channel];
        let Some(slot) = wanted.iter().position(|name| *name == channel.name) else {
            continue;
        };
        let (x, y) = (line.location.position.x(), line.location.position.y());
        if y >= height || x + line.location.sample_count > width {
            return Err(Error::Invalid("block outside of the data window".into()));
        }
        let target = values
            .iter_mut()
            .skip((y * width + x) * channels + slot)
            .step_by(channels);
        match channel.sample_type {
            SampleType::F16 => {
                for (value, sample) in target.zip(line.read_samples::<f16>()) {
                    *value = sample?.to_f32();
                }
            }
            SampleType::F32 => {
                for (value, sample) in target.zip(line.read_samples::<f32>()) {
                    *value = sample?;
                }
            }
            SampleType::U32 => {
                for (value, sample) in target.zip(line.read_samples::<u32>()) {
                    *value = sample? as f32;
                }
            }
        }
    }
    Ok(())
}

/// Refuses a DWAA or DWAB chunk whose counters promise more than its block can hold: the decoder
/// takes memory by them without asking.
///
/// The chunk begins with eleven 64-bit counters (OpenEXR's technical introduction, "DWA"): version;
/// unknown data's size, plain and packed; packed sizes of AC, DC and RLE data; RLE data's size,
/// unpacked and raw; number of AC and of DC values; kind of AC packing.
fn check_dwa(chunk: &Chunk, header: &Header) -> Result<()> {
    if !matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    ) {
        return Ok(());
    }
    let data: &[u8] = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let block = header.max_block_pixel_size();
    // Values are kept for whole blocks of 8 × 8 samples; four bytes each is the widest channel.
    let samples = block
        .width()
        .next_multiple_of(8)
        .saturating_mul(block.height().next_multiple_of(8))
        .saturating_mul(header.channels.list.len());
    let most = (samples as u64).saturating_mul(4).saturating_add(1024);
    let counter = |i: usize| {
        let bytes = data
            .get(i * 8..i * 8 + 8)
            .and_then(|b| <[u8; 8]>::try_from(b).ok());
        bytes.map_or(0, u64::from_le_bytes)
    };
    const UNPACKED: [usize; 5] = [1, 6, 7, 8, 9];
    const PACKED: [usize; 4] = [2, 3, 4, 5];
    if UNPACKED.iter().any(|&i| counter(i) > most)
        || PACKED.iter().any(|&i| counter(i) > data.len() as u64)
    {
        return Err(Error::Invalid("DWA counters out of range".into()));
    }
    Ok(())
}
