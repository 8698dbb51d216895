//! The state of a render in a file, from which it goes on later with the bits of one that was never broken off, or
//! which is joined with others.
//!
//! Form: a line of text, the length of a header (8 bytes, little-endian), the header (JSON), a frame of zstd, SHA-256 of
//! all before. In the frame, for each pixel of the region, rows from top to bottom, its sums as they stand in memory on
//! x86-64 ([`Pixel`], then, if kept, light apart and nanoseconds). The number in the first line changes whenever the form
//! does, or a sample of the same number would have other bits.
//!
//! Whoever can write a file can make its checksum right: so all that it says is looked at before it is believed.

use super::resolve::Film;
use super::tile::{Kept, Tile, locked, place};
use super::{InstructionSet, Region, RenderSettings};
use crate::film::light_passes::PixelPasses;
use crate::film::pixel::Pixel;
use crate::film::{Pass, Passes};
use crate::scene::{ColorManagement, Scene, fingerprint};
use glam::DMat3;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;

/// How the file begins.
const FIRST_LINE: &[u8] = b"sundog state 2\n";
/// How it began before it named the instructions of the processor.
const OLD_FIRST_LINE: &[u8] = b"sundog state 1\n";
/// No header is longer than that.
const LONGEST_HEADER: u64 = 1 << 24;
/// Level of compression. Of a state of 140 MB, level 1 makes 43.7 MB in 0.55 s, and level 3 makes 43.3 MB in 1.7 s.
const LEVEL: i32 = 1;
/// Bytes of the checksum.
const CHECKSUM: u64 = 32;
/// Bytes that are unpacked before it is looked whether there are more.
const PIECE: usize = 1 << 20;
/// No side of a picture is longer.
const LONGEST_SIDE: u32 = 1 << 20;
/// No honest count of samples, rays or nanoseconds is larger: so many rays take a thousand machines a thousand years. Sums of
/// eight such counts fit u64.
const LARGEST_COUNT: u64 = 1 << 60;
/// No honest render takes longer, in seconds: thirty thousand years.
const LONGEST_TIME: f64 = 1e12;
/// Settings that say how far to go, not which samples to take; and the instructions, which the header names by themselves.
const STOPS: [&str; 7] = [
    "samples",
    "first_sample",
    "time_limit",
    "error_target",
    "pixel_error_target",
    "threads",
    "instruction_set",
];

/// Why a state can't be used.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The file can't be read.
    #[error("{path} can't be read: {reason}")]
    NotReadable {
        /// The file.
        path: String,
        /// The system's words.
        reason: String,
    },
    /// It is no state, or a damaged one.
    #[error("{path} is no state of a render: {reason}")]
    Broken {
        /// The file.
        path: String,
        /// What is wrong.
        reason: String,
    },
    /// This machine can't hold it.
    #[error(
        "{path} holds a picture of {} × {} pixels, which needs about {} MB, and {} MB are free; join it on a larger machine", size.0, size.1, needed >> 20, free >> 20
    )]
    TooLarge {
        /// The file.
        path: String,
        /// Pixels of the part of the picture that is in it.
        size: (u32, u32),
        /// Bytes.
        needed: u64,
        /// Bytes.
        free: u64,
    },
    /// Two states that do not belong together.
    #[error("{0}")]
    Different(String),
}

/// What a render had done when it was saved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Traced {
    /// Samples of all pixels together.
    pub samples: u64,
    /// Rays.
    pub rays: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Samples that were not finite …
    pub non_finite: u64,
    /// … and where the first of them were.
    pub non_finite_examples: Vec<(u32, u32, u32)>,
    /// … and why, as far as it was told then.
    #[serde(default)]
    pub non_finite_causes: BTreeMap<String, u64>,
}

impl Traced {
    /// Both together.
    pub fn join(&mut self, other: &Self) {
        self.samples = self.samples.saturating_add(other.samples);
        self.rays = self.rays.saturating_add(other.rays);
        self.seconds += other.seconds;
        self.non_finite = self.non_finite.saturating_add(other.non_finite);
        self.non_finite_examples
            .extend_from_slice(&other.non_finite_examples);
        for (cause, count) in &other.non_finite_causes {
            let all = self.non_finite_causes.entry(cause.clone()).or_default();
            *all = all.saturating_add(*count);
        }
    }

    /// What can't be true of it.
    fn fault(&self, size: (u32, u32)) -> Option<&'static str> {
        let counts = [self.samples, self.rays, self.non_finite];
        let causes = self.non_finite_causes.values();
        if counts.iter().chain(causes).any(|&n| n > LARGEST_COUNT) {
            return Some("its counts are none");
        }
        if !(0.0..=LONGEST_TIME).contains(&self.seconds) {
            return Some("its time is none");
        }
        let outside = |&(x, y, _): &(u32, u32, u32)| x >= size.0 || y >= size.1;
        let examples = &self.non_finite_examples;
        let wrong = examples.len() as u64 > self.non_finite || examples.iter().any(outside);
        wrong.then_some("its samples that were not finite are none of the picture")
    }
}

/// All but the pixels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Header {
    /// The program that wrote it.
    pub program: String,
    /// The version of Embree that met the surfaces …
    pub embree: String,
    /// … and the instructions that it took.
    pub instruction_set: InstructionSet,
    /// Fingerprint of the scene.
    pub scene: String,
    /// The settings that decide which samples there are.
    pub settings: serde_json::Map<String, serde_json::Value>,
    /// Size of the whole picture.
    pub size: (u32, u32),
    /// The part of it that is here.
    pub region: Region,
    /// Passes by name.
    pub passes: Vec<String>,
    /// The camera's axes, for passes that speak in them.
    pub axes: [[f64; 3]; 3],
    /// Numbers of the samples that are here, or are begun: from, and the one after the last.
    pub ranges: Vec<(u32, u32)>,
    /// It can be gone on with: samples of each pixel are the first ones of the only range.
    pub whole: bool,
    /// Light is kept apart for passes.
    #[serde(rename = "apart")]
    pub light_passes: bool,
    /// Nanoseconds are kept.
    pub costs: bool,
    /// Luminance that clamping took from direct and indirect light.
    pub clamped: [f64; 2],
    /// Effects that the scene calls for and the settings leave out.
    #[serde(default)]
    pub left_out: Vec<String>,
    /// How the scene wishes to be shown.
    pub color_management: ColorManagement,
    /// Counts.
    pub traced: Traced,
}

impl Header {
    /// The camera's axes.
    pub(super) fn axes(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.axes)
    }

    /// Which sums there are besides those of all pixels.
    fn kept(&self) -> Kept {
        Kept {
            light_passes: self.light_passes,
            costs: self.costs,
        }
    }

    /// Bytes of a pixel.
    fn pixel_bytes(&self) -> usize {
        let light_passes = if self.light_passes {
            size_of::<PixelPasses>()
        } else {
            0
        };
        let costs = if self.costs { size_of::<u64>() } else { 0 };
        size_of::<Pixel>() + light_passes + costs
    }

    /// Samples that a pixel may have: all that are here or begun.
    pub(super) fn most_samples(&self) -> u32 {
        // They do not overlap (`fault`): their sum is below 2^32.
        self.ranges.iter().map(|(from, to)| to - from).sum()
    }

    /// What can't be true of it.
    fn fault(&self) -> Option<&'static str> {
        let Region { x0, y0, x1, y1 } = self.region;
        let size = self.size;
        if x0 >= x1 || y0 >= y1 || x1 > size.0 || y1 > size.1 {
            return Some("its region is none");
        }
        if size.0.max(size.1) > LONGEST_SIDE {
            return Some("its picture is too large");
        }
        let Ok(passes) = Passes::parse(self.passes.iter().map(String::as_str)) else {
            return Some("it has passes that there are not");
        };
        if self.kept() != kept(passes) {
            return Some("it does not keep what its passes need");
        }
        let each = self.ranges.iter().all(|(from, to)| from <= to);
        let sorted = self.ranges.is_sorted_by(|a, b| a.1 <= b.0);
        if self.ranges.is_empty() || !each || !sorted {
            return Some("its samples are none");
        }
        let floats = self.axes.as_flattened().iter().chain(&self.clamped);
        if !floats.copied().all(f64::is_finite) {
            return Some("its numbers are not finite");
        }
        self.traced.fault(size)
    }

    /// Why the pixels of another can't be put to those of this one.
    pub(super) fn unlike(&self, other: &Self) -> Option<String> {
        let shape = |h: &Self| (h.size, h.region, h.kept());
        if shape(self) != shape(other) || self.passes != other.passes || self.axes != other.axes {
            return Some("they are of different pictures".into());
        }
        if self.instruction_set != other.instruction_set {
            let (a, b) = (self.instruction_set, other.instruction_set);
            let least = a.min(b);
            return Some(format!(
                "the first was traced with the instruction set {a}, the second with {b}, and bits differ; render all parts with --instruction-set {least}"
            ));
        }
        (self.embree != other.embree).then(|| {
            format!(
                "the first was traced with Embree {}, the second with {}, and bits differ; render all parts with the same Sundog",
                self.embree, other.embree
            )
        })
    }
}

/// What passes need to be kept.
fn kept(passes: Passes) -> Kept {
    Kept {
        light_passes: passes.need_light_passes(),
        costs: passes.has(Pass::Cost),
    }
}

/// The settings that decide which samples there are.
fn shape(settings: &RenderSettings) -> serde_json::Map<String, serde_json::Value> {
    let mut shape = match serde_json::to_value(settings) {
        Ok(serde_json::Value::Object(map)) => map,
        _ => serde_json::Map::new(),
    };
    for name in STOPS {
        shape.remove(name);
    }
    shape
}

/// What a render has come to, to be written.
pub struct State<'a> {
    header: Header,
    tiles: &'a [Mutex<Tile>],
}

impl<'a> State<'a> {
    /// Of a render under way.
    pub(super) fn new(
        scene: &Scene,
        scene_hash: &str,
        settings: &RenderSettings,
        (embree, instruction_set): (&str, InstructionSet),
        film: &Film<'a>,
        traced: Traced,
        left_out: &[String],
    ) -> Self {
        let tiles = film.tiles();
        let (mut clamped, mut most) = ([0.0; 2], 0);
        let kept = kept(settings.passes);
        for tile in tiles {
            let tile = locked(tile);
            for row in &tile.clamped {
                for (sum, c) in clamped.iter_mut().zip(row) {
                    *sum += c;
                }
            }
            // A pass that is under way has begun what it is to end with: threads may go on while this is written.
            let begun = tile.pixels.iter().map(|p| p.samples.max(p.until));
            most = begun.fold(most, u32::max);
        }
        let first = settings.first_sample;
        Self {
            header: Header {
                program: env!("CARGO_PKG_VERSION").into(),
                embree: embree.into(),
                instruction_set,
                scene: scene_hash.into(),
                settings: shape(settings),
                size: (settings.width, settings.height),
                region: settings.region(),
                passes: settings.passes.iter().map(|p| p.name().into()).collect(),
                axes: film.axes().to_cols_array_2d(),
                ranges: vec![(first, first.saturating_add(most))],
                whole: true,
                light_passes: kept.light_passes,
                costs: kept.costs,
                clamped,
                color_management: scene.color_management.clone(),
                left_out: left_out.to_vec(),
                traced,
            },
            tiles,
        }
    }

    /// Of pixels that have been read.
    pub(super) fn of(header: Header, tiles: &'a [Mutex<Tile>]) -> Self {
        Self { header, tiles }
    }

    /// Writes it.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = Hashed {
            out,
            hash: Sha256::new(),
        };
        let header = serde_json::to_vec(&self.header)?;
        out.write_all(FIRST_LINE)?;
        out.write_all(&(header.len() as u64).to_le_bytes())?;
        out.write_all(&header)?;
        let region = self.header.region;
        let mut packed = zstd::Encoder::new(&mut out, LEVEL)?;
        self.rows(region, &mut packed, |tile| {
            bytemuck::cast_slice(&tile.pixels)
        })?;
        if self.header.light_passes {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.light_passes)
            })?;
        }
        if self.header.costs {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.costs)
            })?;
        }
        packed.finish()?;
        let Hashed { out, hash } = out;
        out.write_all(&hash.finalize())
    }

    /// Bytes that stand beside the pixels, row by row of the region.
    fn rows(
        &self,
        region: Region,
        out: &mut dyn Write,
        bytes: impl Fn(&Tile) -> &[u8],
    ) -> io::Result<()> {
        for band in self.tiles.chunks(super::tile::across(region)) {
            let tiles: Vec<_> = band.iter().map(locked).collect();
            let rows = tiles.first().map_or(0, |tile| tile.height as usize);
            for row in 0..rows {
                for tile in &tiles {
                    let all = bytes(tile);
                    let length = all.len() / rows;
                    out.write_all(&all[row * length..(row + 1) * length])?;
                }
            }
        }
        Ok(())
    }
}

struct Hashed<'a> {
    out: &'a mut dyn Write,
    hash: Sha256,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A state that has been read.
#[derive(Clone, Debug)]
pub struct Saved {
    /// All but the pixels.
    pub(super) header: Header,
    pub(super) pixels: Vec<Pixel>,
    pub(super) light_passes: Vec<PixelPasses>,
    pub(super) costs: Vec<u64>,
}

impl Saved {
    /// Reads a file.
    ///
    /// # Errors
    /// It can't be read, is no state, or is damaged.
    pub fn read(path: &Path) -> Result<Self, StateError> {
        Self::read_within(path, u64::MAX)
    }

    /// Reads a file whose picture this machine can hold twice over in so many bytes: as it was saved, and to go on with.
    ///
    /// # Errors
    /// It can't be read, is no state, is damaged, or is larger.
    pub fn read_within(path: &Path, free: u64) -> Result<Self, StateError> {
        let name = || path.display().to_string();
        let not_readable = |error: io::Error| StateError::NotReadable {
            path: name(),
            reason: error.to_string(),
        };
        let broken = |reason: &str| StateError::Broken {
            path: name(),
            reason: reason.into(),
        };
        // A pipe would be waited for, and a device has no end.
        let about = std::fs::metadata(path).map_err(not_readable)?;
        if !about.is_file() {
            return Err(broken("it is no file"));
        }
        let length = about.len();
        let mut file = File::open(path).map_err(not_readable)?;
        let mut first = [0; FIRST_LINE.len()];
        let same_kind = file.read_exact(&mut first).is_ok() && first.starts_with(b"sundog state ");
        if !same_kind {
            return Err(broken("it begins in another way"));
        }
        if first == OLD_FIRST_LINE {
            return Err(broken(
                "an older Sundog wrote it, which did not say by which instructions of the processor; finish it with that one, or render it again",
            ));
        }
        if first != FIRST_LINE {
            return Err(broken("another version of Sundog wrote it"));
        }
        let cut = |_| broken("it ends too early");
        let mut count = [0; 8];
        file.read_exact(&mut count).map_err(cut)?;
        let count = u64::from_le_bytes(count);
        let start = FIRST_LINE.len() as u64 + 8;
        // Lengths below 2^63 as they are of a file; the header's is bounded first.
        if count > LONGEST_HEADER || start + count + CHECKSUM > length {
            return Err(broken("its header is too long"));
        }
        check_sum(&mut file, length - CHECKSUM)
            .map_err(not_readable)?
            .then_some(())
            .ok_or_else(|| broken("it is damaged, or its length has changed"))?;
        file.seek(SeekFrom::Start(start)).map_err(not_readable)?;
        let mut text = vec![0; count as usize];
        file.read_exact(&mut text).map_err(cut)?;
        let header = header(&text).map_err(|reason| broken(&reason))?;
        if let Some(fault) = header.fault() {
            return Err(broken(fault));
        }
        let (width, height) = (header.region.width(), header.region.height());
        // Sides of at most 2^20: far below 2^64.
        let pixels = u64::from(width) * u64::from(height);
        let needed = 2 * pixels * header.pixel_bytes() as u64;
        if needed > free {
            return Err(StateError::TooLarge {
                path: name(),
                size: (width, height),
                needed,
                free,
            });
        }
        let packed = BufReader::new(file).take(length - CHECKSUM - start - count);
        let unpack = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => broken("it has fewer pixels than it says"),
            io::ErrorKind::OutOfMemory => broken("there is not enough memory for its pixels"),
            _ => broken("its pixels can't be unpacked"),
        };
        let mut packed = zstd::Decoder::with_buffer(packed)
            .map_err(unpack)?
            .single_frame();
        let pixels = pixels as usize;
        let if_kept = |kept: bool| if kept { pixels } else { 0 };
        let saved = Self {
            pixels: values(&mut packed, pixels).map_err(unpack)?,
            light_passes: values(&mut packed, if_kept(header.light_passes)).map_err(unpack)?,
            costs: values(&mut packed, if_kept(header.costs)).map_err(unpack)?,
            header,
        };
        let more = packed.read(&mut [0]).map_err(unpack)? > 0;
        if more || packed.finish().limit() > 0 {
            return Err(broken("its length does not fit its size"));
        }
        if !saved.has_sound_pixels() {
            return Err(broken("its pixels are none of a render"));
        }
        Ok(saved)
    }

    /// Whether the sums can be those of the samples that the header tells of.
    fn has_sound_pixels(&self) -> bool {
        let most = self.header.most_samples();
        let mut light_passes = self.pixels.iter().zip(&self.light_passes);
        self.pixels.iter().all(|pixel| pixel.is_sound(most))
            && light_passes.all(|(pixel, light_passes)| light_passes.is_sound(pixel.samples))
            && self.costs.iter().all(|&cost| cost <= LARGEST_COUNT)
    }

    /// Samples that each pixel has at least.
    pub fn samples(&self) -> u32 {
        self.pixels.iter().map(|p| p.samples).min().unwrap_or(0)
    }

    /// Says why a scene can't be gone on with from here.
    pub(super) fn check(&self, scene: &Scene, settings: &RenderSettings) -> Result<(), String> {
        if self.header.scene != fingerprint(scene) {
            return Err("the saved state is of another scene, or the scene has changed since; give another --checkpoint file, or delete it to begin anew".into());
        }
        if let Some(difference) = difference(&self.header.settings, &shape(settings)) {
            return Err(format!(
                "the saved state was made with other settings: {difference}; give the same, another --checkpoint file, or delete it to begin anew"
            ));
        }
        let set =
            InstructionSet::or_default(settings.instruction_set).map_err(|e| e.to_string())?;
        let saved = self.header.instruction_set;
        if saved != set {
            let way = if saved.is_here() {
                format!("give --instruction-set {saved}")
            } else {
                "go on with it on a processor that has that".into()
            };
            return Err(format!(
                "the saved state was traced with the instruction set {saved}, and going on with {set} would mix bits; {way}, or give another --checkpoint file"
            ));
        }
        let names = settings.passes.iter().map(|p| p.name());
        let same = self.header.size == (settings.width, settings.height)
            && self.header.region == settings.region()
            && self.header.passes.iter().map(String::as_str).eq(names);
        if !same {
            return Err("the saved state is of another picture than its settings say: it is broken; give another --checkpoint file, or delete it to begin anew".into());
        }
        let from = self.header.ranges.first().map_or(0, |range| range.0);
        if !self.header.whole || self.header.ranges.len() > 1 {
            return Err("the saved state is joined from parts with gaps between them: it can be shown, not gone on with".into());
        }
        if from != settings.first_sample {
            return Err(format!(
                "the saved state begins with sample {from}, not {}; give the same --sample-range",
                settings.first_sample
            ));
        }
        Ok(())
    }

    /// Says why it can't be gone on with by this version of Embree.
    pub(super) fn check_embree(&self, version: &str) -> Result<(), String> {
        let saved = &self.header.embree;
        (saved == version).then_some(()).ok_or_else(|| {
            format!(
                "the saved state was traced with Embree {saved}, and going on with {version} would mix bits; finish it with the Sundog that wrote it, or give another --checkpoint file"
            )
        })
    }

    /// Puts the pixels where they were, none of which is to have more than `most` samples at the end of the pass that was
    /// under way.
    pub(super) fn restore(&self, tiles: &[Mutex<Tile>], most: u32) -> Traced {
        let region = self.header.region;
        for (row, start) in (0..region.height()).zip((0..).step_by(region.width() as usize)) {
            for column in 0..region.width() {
                let (tile, index) = place(region, column, row);
                let from = start + column as usize;
                let mut tile = locked(&tiles[tile]);
                let mut pixel = self.pixels[from];
                pixel.until = pixel.until.min(most.max(pixel.samples));
                tile.pixels[index] = pixel;
                if let (Some(to), Some(from)) = (
                    tile.light_passes.get_mut(index),
                    self.light_passes.get(from),
                ) {
                    *to = *from;
                }
                if let (Some(to), Some(from)) = (tile.costs.get_mut(index), self.costs.get(from)) {
                    *to = *from;
                }
            }
        }
        if let Some(first) = tiles.first()
            && let Some(row) = locked(first).clamped.first_mut()
        {
            *row = self.header.clamped;
        }
        self.header.traced.clone()
    }
}

/// The first setting that differs, in words.
pub(super) fn difference(
    a: &serde_json::Map<String, serde_json::Value>,
    b: &serde_json::Map<String, serde_json::Value>,
) -> Option<String> {
    let absent = serde_json::Value::Null;
    let keys = a.keys().chain(b.keys());
    keys.map(|key| {
        (
            key,
            a.get(key).unwrap_or(&absent),
            b.get(key).unwrap_or(&absent),
        )
    })
    .find(|(_, a, b)| a != b)
    .map(|(key, a, b)| format!("{} {a} instead of {b}", key.replace('_', " ")))
}

/// Whether what a file holds up to its end is what its end says. Leaves it there.
fn check_sum(file: &mut File, length: u64) -> io::Result<bool> {
    file.seek(SeekFrom::Start(0))?;
    let mut hash = Sha256::new();
    let mut rest = file.take(length);
    let mut piece = vec![0; PIECE];
    loop {
        match rest.read(&mut piece) {
            Ok(0) => break,
            Ok(count) => hash.update(&piece[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    let mut told = [0; CHECKSUM as usize];
    let whole = file.read_exact(&mut told).is_ok();
    Ok(whole && hash.finalize()[..] == told)
}

/// Reads a header; what it says is still to be looked at.
fn header(text: &[u8]) -> Result<Header, String> {
    let strange = |error| format!("its header does not say what it should: {error}");
    let value: serde_json::Value = serde_json::from_slice(text).map_err(strange)?;
    // They get to the terminal.
    if has_control_characters(&value) {
        return Err("its header has control characters".into());
    }
    serde_json::from_value(value).map_err(strange)
}

fn has_control_characters(value: &serde_json::Value) -> bool {
    let strange = |text: &str| text.chars().any(char::is_control);
    match value {
        serde_json::Value::String(text) => strange(text),
        serde_json::Value::Array(list) => list.iter().any(has_control_characters),
        serde_json::Value::Object(map) => map
            .iter()
            .any(|(name, value)| strange(name) || has_control_characters(value)),
        _ => false,
    }
}

/// So many values; takes memory only as they come, whatever their number.
fn values<T: bytemuck::Pod>(from: &mut impl Read, count: usize) -> io::Result<Vec<T>> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(count)
        .map_err(|_| io::ErrorKind::OutOfMemory)?;
    while values.len() < count {
        let begun = values.len();
        let piece = (PIECE / size_of::<T>()).min(count - begun);
        values.resize(begun + piece, T::zeroed());
        from.read_exact(bytemuck::cast_slice_mut(&mut values[begun..]))?;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::super::tile::tiles;
    use super::*;
    use crate::film::pixel::FirstHit;
    use glam::Vec3;
    use serde_json::{Value, json};

    const REGION: Region = Region {
        x0: 1,
        y0: 2,
        x1: 41,
        y1: 37,
    };

    /// The state of a render whose pixels have four samples, with all sums.
    fn written(instructions: &str) -> Vec<u8> {
        let passes = ["Combined", "DiffDir", "Debug Cost"].map(String::from);
        let passes = Passes::parse(passes.iter().map(String::as_str)).unwrap_or(Passes::ALL);
        let header: Header = serde_json::from_value(json!({
            "program": "0.1.0", "embree": "4.4.0", "instruction_set": instructions, "scene": "abc",
            "settings": { "seed": 0 }, "size": [50, 40], "region": REGION,
            "passes": passes.iter().map(Pass::name).collect::<Vec<_>>(),
            "axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "ranges": [[3, 7]], "whole": true,
            "apart": passes.need_light_passes(), "costs": passes.has(Pass::Cost), "clamped": [0.5, 0.0],
            "left_out": ["coat"], "color_management": ColorManagement::default(),
            "traced": {
                "samples": 5600, "rays": 12000, "seconds": 1.5, "non_finite": 2,
                "non_finite_examples": [[1, 2, 3], [49, 39, 6]], "non_finite_causes": { "a lobe": 2 },
            },
        }))
        .unwrap();
        let tiles = tiles(REGION, header.kept());
        for tile in &tiles {
            for (index, pixel) in (1..).zip(&mut locked(tile).pixels) {
                for number in 3..7 {
                    pixel.add(
                        number,
                        Vec3::splat(index as f32 / 7.0),
                        &FirstHit::default(),
                    );
                }
                pixel.until = 4;
            }
        }
        let mut bytes = Vec::new();
        State::of(header, &tiles).write(&mut bytes).unwrap();
        bytes
    }

    /// The header and what follows it but the checksum.
    fn taken_apart(bytes: &[u8]) -> (Value, Vec<u8>) {
        let start = FIRST_LINE.len() + 8;
        let length = u64::from_le_bytes(bytes[start - 8..start].try_into().unwrap()) as usize;
        let header = serde_json::from_slice(&bytes[start..start + length]).unwrap();
        let end = bytes.len() - CHECKSUM as usize;
        (header, bytes[start + length..end].to_vec())
    }

    /// A file of them, with the right checksum.
    fn sealed(header: &[u8], body: &[u8]) -> tempfile::NamedTempFile {
        let length = (header.len() as u64).to_le_bytes();
        let mut bytes = [FIRST_LINE, &length, header, body].concat();
        bytes.extend_from_slice(&Sha256::digest(&bytes));
        in_file(&bytes)
    }

    fn in_file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    fn refused(header: &Value, body: &[u8]) -> String {
        let file = sealed(&serde_json::to_vec(header).unwrap(), body);
        let error = Saved::read_within(file.path(), 1 << 30).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with(&file.path().display().to_string()));
        assert!(!text.contains(char::is_control), "{text:?}");
        text
    }

    #[test]
    fn what_is_written_is_read_and_is_smaller() {
        for set in ["avx2", "sse4.2"] {
            let bytes = written(set);
            let file = in_file(&bytes);
            let saved = Saved::read(file.path()).unwrap();
            assert_eq!(saved.header.instruction_set.name(), set);
            assert_eq!((saved.pixels.len(), saved.samples()), (40 * 35, 4));
            let tiles = tiles(REGION, saved.header.kept());
            saved.restore(&tiles, u32::MAX);
            let mut again = Vec::new();
            State::of(saved.header.clone(), &tiles)
                .write(&mut again)
                .unwrap();
            assert!(again == bytes);
            assert!(3 * bytes.len() < 40 * 35 * saved.header.pixel_bytes());
        }
    }

    /// What the file says of its pass under way does not make a render go farther than it is told to.
    #[test]
    fn no_more_samples_are_taken_than_are_asked_for() {
        let (header, _) = taken_apart(&written("avx2"));
        let tiles_of = tiles(
            REGION,
            serde_json::from_value::<Header>(header.clone())
                .unwrap()
                .kept(),
        );
        for tile in &tiles_of {
            for pixel in &mut locked(tile).pixels {
                pixel.until = u32::MAX;
            }
        }
        let mut bytes = Vec::new();
        let header = serde_json::from_value(header).unwrap();
        State::of(header, &tiles_of).write(&mut bytes).unwrap();
        let saved = Saved::read(in_file(&bytes).path()).unwrap();
        saved.restore(&tiles_of, 64);
        let until = |tile: &Mutex<Tile>| locked(tile).pixels.iter().all(|pixel| pixel.until == 64);
        assert!(tiles_of.iter().all(until));
    }

    #[test]
    fn older_states_are_refused_by_name() {
        let bytes = written("avx2");
        let old = [OLD_FIRST_LINE, &bytes[FIRST_LINE.len()..]].concat();
        let text = Saved::read(in_file(&old).path()).unwrap_err().to_string();
        assert!(
            text.contains("an older Sundog") && text.contains("instructions"),
            "{text}"
        );
        let newer = [&b"sundog state 9\n"[..], &bytes[FIRST_LINE.len()..]].concat();
        let text = Saved::read(in_file(&newer).path()).unwrap_err().to_string();
        assert!(text.contains("another version"), "{text}");
    }

    /// Each field of the header set to what no render has written, with the right checksum.
    #[test]
    fn hostile_headers_are_refused() {
        let (good, body) = taken_apart(&written("avx2"));
        let with = |path: &str, value: Value| {
            let mut header = good.clone();
            *header.pointer_mut(path).unwrap() = value;
            header
        };
        let most = u32::MAX;
        let path = sealed(&serde_json::to_vec(&good).unwrap(), &body);
        Saved::read(path.path()).unwrap();
        for (path, value, words) in [
            (
                "/region",
                json!({ "x0": 41, "y0": 2, "x1": 1, "y1": 37 }),
                "region",
            ),
            (
                "/region",
                json!({ "x0": 1, "y0": 2, "x1": most, "y1": 37 }),
                "region",
            ),
            (
                "/region",
                json!({ "x0": 1, "y0": 2, "x1": 1, "y1": 2 }),
                "region",
            ),
            (
                "/region",
                json!({ "x0": -1, "y0": 2, "x1": 41, "y1": 37 }),
                "header",
            ),
            (
                "/region",
                json!({ "x0": 1, "y0": 2, "x1": 40, "y1": 37 }),
                "length",
            ),
            (
                "/region",
                json!({ "x0": 1, "y0": 2, "x1": 42, "y1": 37 }),
                "fewer pixels",
            ),
            ("/size", json!([most, most]), "too large"),
            ("/size", json!([0, 0]), "region"),
            ("/size", json!([40.5, 40]), "header"),
            ("/instruction_set", json!("avx512"), "header"),
            ("/embree", json!("4.4\u{1b}[2J"), "control characters"),
            ("/scene", json!("\u{9b}31m"), "control characters"),
            ("/settings", json!({ "a\n": 1 }), "control characters"),
            ("/settings", json!(7), "header"),
            ("/passes", json!(["Depth of the sea"]), "passes"),
            ("/passes", json!(["Combined"]), "passes"),
            ("/passes", json!([]), "passes"),
            ("/apart", json!(false), "passes"),
            ("/costs", json!(false), "passes"),
            ("/axes/1/1", json!(null), "header"),
            ("/ranges", json!([]), "samples"),
            ("/ranges", json!([[7, 3]]), "samples"),
            ("/ranges", json!([[0, 4], [3, 7]]), "samples"),
            ("/ranges", json!([[4, 7], [0, 3]]), "samples"),
            ("/ranges", json!([[0, most], [1, most]]), "samples"),
            ("/ranges", json!([[3, 6]]), "pixels"),
            ("/ranges", json!([[3, u64::MAX]]), "header"),
            ("/clamped/0", json!(f64::INFINITY), "header"),
            ("/traced/seconds", json!(-1.0), "time"),
            ("/traced/seconds", json!(1e300), "time"),
            ("/traced/seconds", json!("NaN"), "header"),
            ("/traced/samples", json!(u64::MAX), "counts"),
            ("/traced/rays", json!(u64::MAX), "counts"),
            ("/traced/rays", json!(-1), "header"),
            ("/traced/non_finite", json!(u64::MAX), "counts"),
            ("/traced/non_finite", json!(1), "not finite"),
            (
                "/traced/non_finite_examples/0",
                json!([50, 0, 0]),
                "not finite",
            ),
            (
                "/traced/non_finite_causes",
                json!({ "a": u64::MAX }),
                "counts",
            ),
            (
                "/traced/non_finite_causes",
                json!({ "a\r": 1 }),
                "control characters",
            ),
            ("/left_out/0", json!("\u{7}"), "control characters"),
        ] {
            let text = refused(&with(path, value.clone()), &body);
            assert!(text.contains(words), "{path} {value}: {text}");
        }
        // Without a field, and as something else altogether.
        for name in good.as_object().unwrap().keys() {
            if name != "left_out" {
                let mut header = good.clone();
                header.as_object_mut().unwrap().remove(name);
                refused(&header, &body);
            }
            // These two take any object.
            if !["settings", "color_management"].contains(&name.as_str()) {
                refused(&with(&format!("/{name}"), json!({ "x": [[[]]] })), &body);
            }
        }
        for text in ["", "{", "null", "[]", &"[".repeat(100_000)] {
            let file = sealed(text.as_bytes(), &body);
            let error = Saved::read(file.path()).unwrap_err().to_string();
            assert!(error.contains("header does not say"), "{error}");
        }
        let mut long = [FIRST_LINE, &u64::MAX.to_le_bytes(), b"{}"].concat();
        long.extend_from_slice(&[0; 64]);
        let error = Saved::read(in_file(&long).path()).unwrap_err().to_string();
        assert!(error.contains("header is too long"), "{error}");
    }

    /// Pixels that are not what the header says, with the right checksum.
    #[test]
    fn hostile_pixels_are_refused() {
        let (good, body) = taken_apart(&written("avx2"));
        for body in [&b""[..], &b"not packed at all"[..], &body[..body.len() - 3]] {
            refused(&good, body);
        }
        let text = refused(&good, &[&body[..], &b"more"[..]].concat());
        assert!(text.contains("length"), "{text}");
        let plain = zstd::decode_all(&body[..]).unwrap();
        let packed = |plain: &[u8]| zstd::encode_all(plain, LEVEL).unwrap();
        let text = refused(&good, &packed(&[&plain[..], &[0]].concat()));
        assert!(text.contains("length"), "{text}");
        let text = refused(&good, &packed(&plain[..plain.len() - 1]));
        assert!(text.contains("fewer"), "{text}");
        // Any byte of the first pixel's sums and counts set to its largest value: refused, or harmless.
        let each = size_of::<Pixel>();
        let apart = 40 * 35 * each;
        let all = apart..apart + size_of::<PixelPasses>();
        for first in (0..each).chain(all).step_by(4) {
            let mut strange = plain.clone();
            strange[first..first + 4].fill(0xff);
            let file = sealed(&serde_json::to_vec(&good).unwrap(), &packed(&strange));
            if let Ok(saved) = Saved::read(file.path()) {
                let part = || Ok((String::from("a"), saved.clone()));
                let merged = super::super::merge([part()]).unwrap();
                merged.rendering();
                assert!(super::super::merge([part(), part()]).is_err());
            }
        }
        let mut strange = plain.clone();
        strange[..8].copy_from_slice(&f64::NAN.to_le_bytes());
        let text = refused(&good, &packed(&strange));
        assert!(text.contains("none of a render"), "{text}");
    }

    /// A small file of a large picture takes neither memory nor time.
    #[test]
    fn a_picture_that_does_not_fit_is_refused() {
        let (mut header, body) = taken_apart(&written("avx2"));
        header["size"] = json!([1 << 20, 1 << 20]);
        header["region"] = json!({ "x0": 0, "y0": 0, "x1": 1 << 20, "y1": 1 << 20 });
        let text = refused(&header, &body);
        assert!(text.contains("are free"), "{text}");
        // And where nobody says how much is free, it ends with the pixels.
        header["region"]["y1"] = json!(1 << 10);
        let file = sealed(&serde_json::to_vec(&header).unwrap(), &body);
        let text = Saved::read(file.path()).unwrap_err().to_string();
        assert!(
            text.contains("fewer pixels") || text.contains("memory"),
            "{text}"
        );
        assert!(
            Saved::read(Path::new("/dev/zero"))
                .unwrap_err()
                .to_string()
                .contains("no file")
        );
    }
}
