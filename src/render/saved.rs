//! The state of a render in a file, from which it goes on later with the bits of one that was never broken off, or
//! which is joined with others.
//!
//! Form: a line of text, the length of a header (8 bytes, little-endian), the header (JSON), a frame of zstd, SHA-256 of
//! all before. In the frame, for each pixel of the region, rows from top to bottom, its sums as they stand in memory on
//! x86-64 ([`Pixel`], then, if kept, light apart, features for denoisers, nanoseconds, objects, light groups, the scene's own passes, and the radiance of half of the samples). The number in the first line changes whenever the form
//! does, or a sample of the same number would have other bits.
//!
//! Whoever can write a file can make its checksum right: so all that it says is looked at before it is believed.

mod header;

pub use header::{Header, Traced};

use super::catchers::has_catchers;
use super::resolve::Film;
use super::tile::{Kept, Tile, locked, place, shown};
use super::{InstructionSet, Region, RenderSettings};
use crate::film::Pass;
use crate::film::features::PixelFeatures;
use crate::film::light_passes::PixelPasses;
use crate::film::objects::PixelObjects;
use crate::film::pixel::Pixel;
use crate::scene::{Scene, fingerprint};
use glam::DVec3;
use header::LARGEST_COUNT;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Mutex;

/// How the file begins.
const FIRST_LINE: &[u8] = b"sundog state 3\n";
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
/// Settings that say how far to go, not which samples to take; and the instructions, which the header names by themselves.
const STOPS: [&str; 8] = [
    "samples",
    "first_sample",
    "time_limit",
    "error_target",
    "pixel_error_target",
    "noise_threshold",
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
        let kept = Kept::of_render(settings, scene);
        let passes = settings.passes;
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
                passes: passes.iter().map(|p| p.name().into()).collect(),
                axes: film.axes().to_cols_array_2d(),
                ranges: vec![(first, first.saturating_add(most))],
                whole: true,
                light_passes: kept.light_passes,
                features: kept.features,
                costs: kept.costs,
                objects: kept.objects,
                labels: film.labels().to_vec(),
                light_groups: scene.light_groups.clone(),
                aovs: shown(passes, &scene.aovs).to_vec(),
                catchers: has_catchers(scene, settings),
                transparent: settings.transparent_film,
                vectors: passes.has(Pass::Vector),
                halves: kept.halves,
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
        if self.header.features {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.features)
            })?;
        }
        if self.header.costs {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.costs)
            })?;
        }
        if self.header.objects {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.objects)
            })?;
        }
        if !self.header.light_groups.is_empty() {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.groups)
            })?;
        }
        if self.header.kept().aovs > 0 {
            self.rows(region, &mut packed, |tile| bytemuck::cast_slice(&tile.aovs))?;
        }
        if self.header.halves {
            self.rows(region, &mut packed, |tile| {
                bytemuck::cast_slice(&tile.halves)
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
    pub(super) features: Vec<PixelFeatures>,
    pub(super) costs: Vec<u64>,
    pub(super) objects: Vec<PixelObjects>,
    pub(super) groups: Vec<DVec3>,
    pub(super) aovs: Vec<f64>,
    pub(super) halves: Vec<DVec3>,
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
            features: values(&mut packed, if_kept(header.features)).map_err(unpack)?,
            costs: values(&mut packed, if_kept(header.costs)).map_err(unpack)?,
            objects: values(&mut packed, if_kept(header.objects)).map_err(unpack)?,
            groups: values(&mut packed, pixels * header.light_groups.len()).map_err(unpack)?,
            aovs: values(&mut packed, header.kept().aovs * pixels).map_err(unpack)?,
            halves: values(&mut packed, if_kept(header.halves)).map_err(unpack)?,
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
        let mut features = self.pixels.iter().zip(&self.features);
        self.pixels.iter().all(|pixel| pixel.is_sound(most))
            && light_passes.all(|(pixel, light_passes)| light_passes.is_sound(pixel.samples))
            && features.all(|(pixel, features)| features.is_sound(pixel.samples))
            && self.costs.iter().all(|&cost| cost <= LARGEST_COUNT)
            && (self.objects.iter()).all(|pixel| pixel.is_sound(self.header.labels.len()))
            && self
                .halves
                .iter()
                .chain(&self.groups)
                .all(|sum| sum.is_finite())
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
        if settings.noise_threshold.is_some() && !self.header.halves {
            return Err("the saved state was made without --noise-threshold, which has to be there from the first sample; leave it out, give another --checkpoint file, or delete it to begin anew".into());
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
                if let (Some(to), Some(from)) =
                    (tile.features.get_mut(index), self.features.get(from))
                {
                    *to = *from;
                }
                if let (Some(to), Some(from)) = (tile.costs.get_mut(index), self.costs.get(from)) {
                    *to = *from;
                }
                if let (Some(to), Some(from)) =
                    (tile.objects.get_mut(index), self.objects.get(from))
                {
                    *to = *from;
                }
                let each = self.header.light_groups.len();
                let to = tile.groups_of(index..index + 1);
                tile.groups[to].copy_from_slice(&self.groups[from * each..][..each]);
                let each = self.header.kept().aovs;
                let of = tile.aovs_of(&(index..index + 1));
                tile.aovs[of].copy_from_slice(&self.aovs[from * each..(from + 1) * each]);
                if let (Some(to), Some(from)) = (tile.halves.get_mut(index), self.halves.get(from))
                {
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
#[path = "../../tests/unit/render/saved.rs"]
mod tests;
