//! OpenEXR through the crate `exr`: which of a file's many layers is the picture, and where in the
//! display window it lies. Scenes and `measure` read pictures by the same rule.

use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;
use std::sync::Arc;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader as _;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use rayon::prelude::*;

use super::ImageFailure;
use crate::import::guard::guarded;
use crate::scene::{Image, Pixels, Place, Values};

/// So many layers are named to who asks for another one.
const NAMED_LAYERS: usize = 30;

/// A layer of a file in its display window: what the data window does not cover is 0, what lies beyond is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrLayer {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// One or three.
    pub colors: usize,
    /// Whether alpha follows the colours. Colours are taken as they stand: whether they are multiplied with it is for who
    /// uses them to know.
    pub alpha: bool,
    /// Channels interleaved, rows from top to bottom.
    pub values: Vec<f32>,
}

/// A channel that has a value for each pixel: its part and its name there.
#[derive(Clone, Debug, PartialEq)]
struct Channel {
    part: usize,
    name: Text,
}

/// The channels of a layer, and what it has for alpha.
struct Choice {
    colors: Vec<Channel>,
    alpha: Option<Channel>,
}

impl Choice {
    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.colors.iter().chain(&self.alpha)
    }
}

/// Width and height of what a layer takes.
pub(super) fn dimensions(
    bytes: &[u8],
    layer: Option<&str>,
) -> std::result::Result<(u64, u64), ImageFailure> {
    let headers = headers(bytes)?;
    let choice = choose(&headers, layer)?;
    // Either window may be the larger one: overscan, or a crop.
    let sizes = choice.channels().flat_map(|channel| {
        let header = &headers[channel.part];
        [
            header.shared_attributes.display_window.size,
            header.layer_size,
        ]
    });
    Ok(sizes.fold((0, 0), |(width, height), size| {
        (
            width.max(size.width() as u64),
            height.max(size.height() as u64),
        )
    }))
}

fn headers(bytes: &[u8]) -> std::result::Result<exr::meta::Headers, ImageFailure> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    Ok(meta.headers)
}

/// A file whose header claims more values than this for each of its bytes is no picture to be measured: only flat colours
/// compress so well, and memory for a made-up size is not spent.
const MOST_VALUES_A_BYTE: u64 = 4096;

/// Refuses a file whose header claims too much.
pub(super) fn check_claim(bytes: &[u8]) -> std::result::Result<(), ImageFailure> {
    let claimed = |header: &Header| {
        let channels = header.channels.list.len() as u64;
        (header.layer_size.area() as u64).saturating_mul(channels)
    };
    let claims = headers(bytes)?;
    let values = claims.iter().map(claimed).fold(0, u64::saturating_add);
    if values > (bytes.len() as u64).saturating_mul(MOST_VALUES_A_BYTE) {
        return Err(ImageFailure::Damaged(
            "its header claims a size that its content cannot have".into(),
        ));
    }
    Ok(())
}

fn damaged(error: Error) -> ImageFailure {
    ImageFailure::Damaged(match error {
        Error::NotSupported(what) => format!("its kind of OpenEXR is not supported ({what})"),
        Error::Invalid(what) => format!("it is damaged ({what})"),
        Error::Io(what) => format!("it is damaged or cut off ({what})"),
        Error::Aborted => "reading was stopped".into(),
    })
}

/// The flat layers of a file. (A file may have very many, of very many channels.)
#[derive(Default)]
struct Layers {
    /// In their order.
    names: Vec<String>,
    /// The first channel of each layer.
    first: HashMap<String, Channel>,
    /// By their last words, the first of each.
    channels: HashMap<String, HashMap<String, Channel>>,
    subsampled: bool,
}

impl Layers {
    fn of(headers: &[Header]) -> Self {
        let mut layers = Self::default();
        let flat = headers.iter().enumerate().filter(|(_, part)| !part.deep);
        for (part, header) in flat {
            let own = &header.own_attributes.layer_name;
            let own = own.as_ref().map(Text::to_string).unwrap_or_default();
            let several = headers.len() > 1 && !own.is_empty();
            let dotted = format!("{own}.");
            for channel in &header.channels.list {
                if channel.sampling != Vec2(1, 1) {
                    layers.subsampled = true;
                    continue;
                }
                let name = channel.name.to_string();
                // Files with one part a layer may or may not repeat the part's name in the channels' names.
                let full = if several && !name.starts_with(&dotted) {
                    format!("{dotted}{name}")
                } else {
                    name
                };
                let (layer, last) = full.rsplit_once('.').unwrap_or(("", &full));
                let channel = Channel {
                    part,
                    name: channel.name.clone(),
                };
                layers.add(layer, last, channel);
            }
        }
        layers
    }

    fn add(&mut self, layer: &str, last: &str, channel: Channel) {
        let component = match last.to_uppercase() {
            word if ["RED", "GREEN", "BLUE", "ALPHA"].contains(&word.as_str()) => word[..1].into(),
            word => word,
        };
        if !self.first.contains_key(layer) {
            self.names.push(layer.into());
            self.first.insert(layer.into(), channel.clone());
        }
        let known = self.channels.entry(layer.into()).or_default();
        known.entry(component).or_insert(channel);
    }

    fn find(&self, layer: &str, component: &str) -> Option<Channel> {
        self.channels.get(layer)?.get(component).cloned()
    }

    fn three(&self, layer: &str, components: [&str; 3]) -> Option<Vec<Channel>> {
        let find = |component| self.find(layer, component);
        components.into_iter().map(find).collect()
    }

    /// The colours of a layer: red, green and blue; a vector; or one channel.
    fn colors(&self, layer: &str) -> Option<Vec<Channel>> {
        let three = self.three(layer, ["R", "G", "B"]);
        let three = three.or_else(|| self.three(layer, ["X", "Y", "Z"]));
        three.or_else(|| {
            let mut usual = ["Y", "Z", "X", "V"].into_iter();
            let one = usual.find_map(|component| self.find(layer, component));
            one.or_else(|| self.first.get(layer).cloned())
                .map(|channel| vec![channel])
        })
    }

    /// The layer of this name, its full one or the last word of that. Without one, in this order: plain R, G, B; the first
    /// "Combined" (Blender's beauty pass, as in `ViewLayer.Combined.R`) with colours; the first with colours; the first with
    /// luminance; the first of all.
    fn choose(&self, wanted: Option<&str>) -> Option<&str> {
        let last = |name: &str| name.rsplit('.').next().unwrap_or_default().to_owned();
        let has_color = |name: &str| self.three(name, ["R", "G", "B"]).is_some();
        let first = |fits: &dyn Fn(&str) -> bool| {
            let mut names = self.names.iter().map(String::as_str);
            names.find(|name| fits(name))
        };
        if let Some(wanted) = wanted {
            return first(&|name| name == wanted || last(name) == wanted)
                .or_else(|| first(&|name| wanted == "Combined" && name.is_empty()));
        }
        first(&|name| name.is_empty() && has_color(name))
            .or_else(|| {
                first(&|name| last(name).eq_ignore_ascii_case("combined") && has_color(name))
            })
            .or_else(|| first(&has_color))
            .or_else(|| first(&|name| self.find(name, "Y").is_some()))
            .or_else(|| first(&|_| true))
    }

    /// The names of the layers, for messages.
    fn told(&self) -> String {
        let names = self.names.iter().take(NAMED_LAYERS);
        let names = names.map(|name| if name.is_empty() { "Combined" } else { name });
        let mut told = names.collect::<Vec<_>>().join(", ");
        if self.names.len() > NAMED_LAYERS {
            told += &format!(" and {} more", self.names.len() - NAMED_LAYERS);
        }
        told
    }
}

fn choose(headers: &[Header], wanted: Option<&str>) -> std::result::Result<Choice, ImageFailure> {
    let layers = Layers::of(headers);
    let chosen = layers.choose(wanted);
    let colors = chosen.and_then(|layer| Some((layer, layers.colors(layer)?)));
    match (colors, wanted) {
        (Some((layer, colors)), _) => Ok(Choice {
            alpha: layers
                .find(layer, "A")
                .filter(|alpha| !colors.contains(alpha)),
            colors,
        }),
        (None, Some(wanted)) => Err(ImageFailure::NoSuchLayer {
            wanted: wanted.into(),
            there: layers.told(),
        }),
        (None, None) if layers.subsampled => Err(ImageFailure::Damaged(
            "its colour channels are subsampled, which is not supported".into(),
        )),
        (None, None) => Err(ImageFailure::Damaged(
            "it has no flat picture (deep data only, or no channels)".into(),
        )),
    }
}

/// Reads the picture as one, three or four channels; grey has no alpha.
pub(super) fn decode(
    bytes: &[u8],
    name: &str,
    place: Place,
) -> std::result::Result<Image, ImageFailure> {
    let headers = headers(bytes)?;
    let mut choice = choose(&headers, None)?;
    if choice.colors.len() == 1 {
        choice.alpha = None;
    }
    let frame = framed(bytes, &headers, &choice, place)?;
    Ok(Image {
        name: name.into(),
        width: u32::try_from(frame.width).unwrap_or(u32::MAX),
        height: u32::try_from(frame.height).unwrap_or(u32::MAX),
        channels: frame.channels as u32,
        pixels: Pixels::F32(Arc::new(frame.values)),
    })
}

/// Reads a layer, or the one that is the picture.
pub(super) fn read(
    bytes: &[u8],
    layer: Option<&str>,
) -> std::result::Result<ExrLayer, ImageFailure> {
    let headers = headers(bytes)?;
    let choice = choose(&headers, layer)?;
    let frame = framed(bytes, &headers, &choice, Place::Memory)?;
    Ok(ExrLayer {
        width: frame.width,
        height: frame.height,
        colors: choice.colors.len(),
        alpha: choice.alpha.is_some(),
        values: frame.values.into_vec(),
    })
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
    values: Values<f32>,
}

impl Plane {
    /// Writes one of its channels to where it lies in a picture of the display window, whose other pixels stay as they are.
    fn copy_channel(&self, channel: usize, frame: &mut Frame, into: usize) {
        // Where the windows meet, in the frame's pixels.
        let meet = |begin: i64, size: usize, limit: usize| {
            let clamped = |at: i64| at.clamp(0, limit as i64) as usize;
            clamped(begin)..clamped(begin.saturating_add(size as i64))
        };
        let columns = meet(self.at.0, self.size.0, frame.width);
        let rows = meet(self.at.1, self.size.1, frame.height);
        for y in rows {
            let row = (y as i64 - self.at.1) as usize * self.size.0;
            for x in columns.clone() {
                let column = (x as i64 - self.at.0) as usize;
                let from = (row + column) * self.channels + channel;
                frame.values[(y * frame.width + x) * frame.channels + into] = self.values[from];
            }
        }
    }
}

/// A picture of the display window, channels interleaved.
struct Frame {
    width: usize,
    height: usize,
    channels: usize,
    values: Values<f32>,
}

/// The chosen channels in the frame of the display window, which all parts share.
fn framed(
    bytes: &[u8],
    headers: &[Header],
    choice: &Choice,
    place: Place,
) -> std::result::Result<Frame, ImageFailure> {
    let mut parts: BTreeMap<usize, Vec<&Text>> = BTreeMap::new();
    for channel in choice.channels() {
        parts.entry(channel.part).or_default().push(&channel.name);
    }
    let mut planes: BTreeMap<usize, Plane> = BTreeMap::new();
    let mut window = IntegerBounds::default();
    for (&part, names) in &parts {
        let header = &headers[part];
        let (data, size) = (header.own_attributes.layer_position, header.layer_size);
        window = header.shared_attributes.display_window;
        if window.size.area() == 0 {
            window = IntegerBounds::new(data, size);
        }
        let from = |data: i32, display: i32| i64::from(data) - i64::from(display);
        let plane = Plane {
            at: (
                from(data.x(), window.position.x()),
                from(data.y(), window.position.y()),
            ),
            size: (size.width(), size.height()),
            channels: names.len(),
            values: read_part(bytes, part, names, place)?,
        };
        planes.insert(part, plane);
    }
    let (width, height) = (window.size.width(), window.size.height());
    let whole = |plane: &Plane| plane.at == (0, 0) && plane.size == (width, height);
    let channels = choice.channels().count();
    let values = match planes.pop_first() {
        Some((_, plane)) if planes.is_empty() && whole(&plane) => plane.values,
        first => {
            planes.extend(first);
            let mut frame = Frame {
                width,
                height,
                channels,
                // 0 beyond the data windows.
                values: Values::zeros(width * height * channels, place),
            };
            for (into, channel) in choice.channels().enumerate() {
                let names = &parts[&channel.part];
                let slot = names.iter().position(|name| **name == channel.name);
                if let (Some(plane), Some(slot)) = (planes.get(&channel.part), slot) {
                    plane.copy_channel(slot, &mut frame, into);
                }
            }
            frame.values
        }
    };
    Ok(Frame {
        width,
        height,
        channels,
        values,
    })
}

/// The named channels of one part, interleaved, in the data window's frame.
///
/// Blocks are decompressed a batch at a time, so that a file of forty passes does not have to fit
/// into memory beside its picture.
fn read_part(
    bytes: &[u8],
    part: usize,
    wanted: &[&Text],
    place: Place,
) -> std::result::Result<Values<f32>, ImageFailure> {
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
    let mut values = Values::zeros(width * height * channels, place);
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
                // Unpacking B44 counts below 0 in damaged files, which builds with debug assertions do not let pass.
                guarded(|| Ok(UncompressedBlock::decompress_chunk(chunk, &meta, false)))
                    .map_err(|words| Error::Invalid(words.into()))?
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
    wanted: &[&Text],
    (width, height): (usize, usize),
    values: &mut [f32],
) -> Result<()> {
    let channels = wanted.len();
    for line in block.lines(&header.channels) {
        let channel = &header.channels.list[line.location.channel];
        let Some(slot) = wanted.iter().position(|name| **name == channel.name) else {
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
