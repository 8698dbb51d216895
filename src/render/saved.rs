//! The state of a render in a file, from which it goes on later with the bits of one that was never broken off, or
//! which is joined with others.
//!
//! Form: a line of text, the length of a header (8 bytes, little-endian), the header (JSON), for each pixel of the
//! region, rows from top to bottom, its sums as they stand in memory on x86-64 ([`Pixel`], then, if kept, light
//! apart and nanoseconds), SHA-256 of all before. The number in the first line changes whenever a sample of the
//! same number would have other bits.

use super::develop::Film;
use super::tile::{Kept, Tile, locked, place};
use super::{Region, RenderSettings};
use crate::film::apart::PixelApart;
use crate::film::pixel::Pixel;
use crate::scene::{ColorManagement, Scene, fingerprint};
use glam::DMat3;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::Mutex;

/// How the file begins.
const FIRST_LINE: &[u8] = b"sundog state 1\n";
/// No header is longer than that.
const LONGEST_HEADER: u64 = 1 << 24;
/// Settings that say how far to go, not which samples to take.
const STOPS: [&str; 6] = [
    "samples",
    "first_sample",
    "time_limit",
    "error_target",
    "pixel_error_target",
    "threads",
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
        self.samples += other.samples;
        self.rays += other.rays;
        self.seconds += other.seconds;
        self.non_finite += other.non_finite;
        self.non_finite_examples
            .extend_from_slice(&other.non_finite_examples);
        for (cause, count) in &other.non_finite_causes {
            *self.non_finite_causes.entry(cause.clone()).or_default() += count;
        }
    }
}

/// All but the pixels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Header {
    /// The program that wrote it.
    pub program: String,
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
    /// Light apart is kept.
    pub apart: bool,
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
        film: &Film<'a>,
        traced: Traced,
        left_out: &[String],
    ) -> Self {
        let tiles = film.tiles();
        let (mut clamped, mut most) = ([0.0; 2], 0);
        let mut kept = Kept::default();
        for tile in tiles {
            let tile = locked(tile);
            for row in &tile.clamped {
                for (sum, c) in clamped.iter_mut().zip(row) {
                    *sum += c;
                }
            }
            most = tile.pixels.iter().map(|p| p.samples).fold(most, u32::max);
            kept = Kept {
                apart: !tile.apart.is_empty(),
                costs: !tile.costs.is_empty(),
            };
        }
        let first = settings.first_sample;
        Self {
            header: Header {
                program: env!("CARGO_PKG_VERSION").into(),
                scene: scene_hash.into(),
                settings: shape(settings),
                size: (settings.width, settings.height),
                region: settings.region(),
                passes: settings.passes.iter().map(|p| p.name().into()).collect(),
                axes: film.axes().to_cols_array_2d(),
                ranges: vec![(first, first.saturating_add(most))],
                whole: true,
                apart: kept.apart,
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
        out.put(FIRST_LINE)?;
        out.put(&(header.len() as u64).to_le_bytes())?;
        out.put(&header)?;
        let region = self.header.region;
        self.rows(region, &mut out, |tile| bytemuck::cast_slice(&tile.pixels))?;
        if self.header.apart {
            self.rows(region, &mut out, |tile| bytemuck::cast_slice(&tile.apart))?;
        }
        if self.header.costs {
            self.rows(region, &mut out, |tile| bytemuck::cast_slice(&tile.costs))?;
        }
        let Hashed { out, hash } = out;
        out.write_all(&hash.finalize())
    }

    /// Bytes that stand beside the pixels, row by row of the region.
    fn rows(
        &self,
        region: Region,
        out: &mut Hashed,
        bytes: impl Fn(&Tile) -> &[u8],
    ) -> io::Result<()> {
        for band in self.tiles.chunks(super::tile::across(region)) {
            let tiles: Vec<_> = band.iter().map(locked).collect();
            let rows = tiles.first().map_or(0, |tile| tile.height as usize);
            for row in 0..rows {
                for tile in &tiles {
                    let all = bytes(tile);
                    let length = all.len() / rows;
                    out.put(&all[row * length..(row + 1) * length])?;
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

impl Hashed<'_> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hash.update(bytes);
        self.out.write_all(bytes)
    }
}

/// A state that has been read.
#[derive(Clone, Debug)]
pub struct Saved {
    /// All but the pixels.
    pub(super) header: Header,
    pub(super) pixels: Vec<Pixel>,
    pub(super) apart: Vec<PixelApart>,
    pub(super) costs: Vec<u64>,
}

impl Saved {
    /// Reads a file.
    ///
    /// # Errors
    /// It can't be read, is no state, or is damaged.
    pub fn read(path: &Path) -> Result<Self, StateError> {
        let name = || path.display().to_string();
        let not_readable = |error: io::Error| StateError::NotReadable {
            path: name(),
            reason: error.to_string(),
        };
        let broken = |reason: &str| StateError::Broken {
            path: name(),
            reason: reason.into(),
        };
        let file = std::fs::File::open(path).map_err(not_readable)?;
        let length = file.metadata().map_err(not_readable)?.len();
        let mut file = Reader {
            file: io::BufReader::new(file),
            hash: Sha256::new(),
        };
        let mut first = [0; FIRST_LINE.len()];
        let same_kind = file.get(&mut first).is_ok() && first.starts_with(b"sundog state ");
        if !same_kind {
            return Err(broken("it begins in another way"));
        }
        if first != FIRST_LINE {
            return Err(broken("another version of Sundog wrote it"));
        }
        let cut = |_| broken("it ends too early");
        let mut count = [0; 8];
        file.get(&mut count).map_err(cut)?;
        let count = u64::from_le_bytes(count);
        if count > LONGEST_HEADER.min(length) {
            return Err(broken("its header is too long"));
        }
        let mut text = vec![0; count as usize];
        file.get(&mut text).map_err(cut)?;
        let header: Header = serde_json::from_slice(&text)
            .map_err(|error| broken(&format!("its header does not say what it should: {error}")))?;
        let Region { x0, y0, x1, y1 } = header.region;
        if x0 >= x1 || y0 >= y1 || x1 > header.size.0 || y1 > header.size.1 {
            return Err(broken("its region is none"));
        }
        // Sides below 2^32 each: the product is below 2^64, and the length of the file bounds it further.
        let pixels = u64::from(x1 - x0) * u64::from(y1 - y0);
        let each = size_of::<Pixel>()
            + if header.apart {
                size_of::<PixelApart>()
            } else {
                0
            }
            + if header.costs { size_of::<u64>() } else { 0 };
        let expected = pixels
            .checked_mul(each as u64)
            .and_then(|n| n.checked_add(FIRST_LINE.len() as u64 + 8 + count + 32));
        if expected != Some(length) {
            return Err(broken("its length does not fit its size"));
        }
        let pixels = pixels as usize;
        let saved = Self {
            pixels: file.values(pixels).map_err(cut)?,
            apart: file
                .values(if header.apart { pixels } else { 0 })
                .map_err(cut)?,
            costs: file
                .values(if header.costs { pixels } else { 0 })
                .map_err(cut)?,
            header,
        };
        let hash = std::mem::take(&mut file.hash).finalize();
        let mut told = [0; 32];
        file.get(&mut told).map_err(cut)?;
        if hash[..] != told {
            return Err(broken("it is damaged"));
        }
        Ok(saved)
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

    /// Puts the pixels where they were.
    pub(super) fn restore(&self, tiles: &[Mutex<Tile>]) -> Traced {
        let region = self.header.region;
        for (row, start) in (0..region.height()).zip((0..).step_by(region.width() as usize)) {
            for column in 0..region.width() {
                let (tile, index) = place(region, column, row);
                let from = start + column as usize;
                let mut tile = locked(&tiles[tile]);
                tile.pixels[index] = self.pixels[from];
                if let (Some(to), Some(from)) = (tile.apart.get_mut(index), self.apart.get(from)) {
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

struct Reader<R> {
    file: R,
    hash: Sha256,
}

impl<R: Read> Reader<R> {
    fn get(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact(bytes)?;
        self.hash.update(&*bytes);
        Ok(())
    }

    fn values<T: bytemuck::Pod>(&mut self, count: usize) -> io::Result<Vec<T>> {
        let mut values = vec![T::zeroed(); count];
        self.get(bytemuck::cast_slice_mut(&mut values))?;
        Ok(values)
    }
}
