//! OpenVDB files: one grid of a file becomes a [`Grid`], leaf by leaf, without a second copy.
//!
//! The format is that of OpenVDB's own `io/Archive.cc`, `io/Compression.h` and `tree/*.h`, versions 222 (3.0) and later.

mod blosc;
mod tree;

use crate::import::budget::Budget;
use crate::scene::Grid;
use glam::{DAffine3, DMat3, DVec3};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Why a grid is not read; the end of a sentence that names the file.
#[derive(Debug, thiserror::Error)]
pub(crate) enum VdbError {
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    #[error("it is no OpenVDB file")]
    NoVdb,
    #[error("it is of OpenVDB's format {0}; 222 and later are read: save it by a newer program")]
    TooOld(u32),
    #[error("it is damaged: {0}")]
    Damaged(&'static str),
    #[error(
        "its grid \"{grid}\" is a {kind}, which is not read: make it one of numbers or vectors"
    )]
    Kind { grid: String, kind: String },
    #[error("its grid \"{grid}\" is placed by a {map}, which is not read: resample it in a box")]
    Map { grid: String, map: String },
    #[error("it has no grid \"{grid}\"; there are: {there}")]
    NoSuchGrid { grid: String, there: String },
    #[error("its grid \"{grid}\" takes {mebibytes} MiB of memory, and there is not so much")]
    NoMemory { grid: String, mebibytes: u64 },
    #[error(
        "its grid \"{grid}\" takes {mebibytes} MiB of memory, and grids may take {left} more (--max-memory)"
    )]
    TooLarge {
        grid: String,
        mebibytes: u64,
        left: u64,
    },
}

/// "VDB ", backwards.
const MAGIC: u64 = 0x5644_4220;
/// The oldest format that is read.
const OLDEST: u32 = 222;
/// No name is longer.
const LONGEST_NAME: u32 = 1 << 16;

struct Source {
    file: BufReader<File>,
    left: u64,
}

impl Source {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], VdbError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, into: &mut [u8]) -> Result<(), VdbError> {
        let too_early = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => VdbError::Damaged("it ends too early"),
            _ => VdbError::Unreadable(error),
        };
        self.file.read_exact(into).map_err(too_early)
    }

    fn u32(&mut self) -> Result<u32, VdbError> {
        self.bytes().map(u32::from_le_bytes)
    }

    fn i64(&mut self) -> Result<i64, VdbError> {
        self.bytes().map(i64::from_le_bytes)
    }

    fn vector(&mut self) -> Result<DVec3, VdbError> {
        let mut next = || self.bytes().map(f64::from_le_bytes);
        Ok(DVec3::new(next()?, next()?, next()?))
    }

    fn text(&mut self) -> Result<String, VdbError> {
        let length = self.u32()?;
        if length > LONGEST_NAME {
            return Err(VdbError::Damaged("a name in it has no end"));
        }
        let mut bytes = vec![0; length as usize];
        self.fill(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn go_to(&mut self, position: i64) -> Result<(), VdbError> {
        let position = u64::try_from(position).ok().filter(|&p| p <= self.left);
        let position = position.ok_or(VdbError::Damaged("a part of it lies beyond its end"))?;
        // Near places are in the buffer already.
        let here = self.file.stream_position()?;
        let way = position.wrapping_sub(here) as i64;
        self.file.seek_relative(way)?;
        Ok(())
    }

    /// Passes over what is known of a file or a grid; whether the grid's numbers are halves.
    fn metadata(&mut self) -> Result<bool, VdbError> {
        let mut half = false;
        for _ in 0..self.u32()? {
            let name = self.text()?;
            let kind = self.text()?;
            let length = self.u32()?;
            if kind == "bool" && length == 1 {
                let [value] = self.bytes()?;
                half |= name == "is_saved_as_half_float" && value != 0;
            } else {
                let here = self.file.stream_position()?;
                self.go_to(here.saturating_add(u64::from(length)) as i64)?;
            }
        }
        Ok(half)
    }
}

/// Where a grid is in a file.
#[derive(Clone, Debug)]
struct Entry {
    name: String,
    kind: String,
    /// Whose tree it shares, if any.
    parent: String,
    grid: i64,
    blocks: i64,
}

impl Entry {
    /// Without the number that tells grids of one name apart.
    fn plain_name(&self) -> &str {
        self.name.split('\u{1e}').next().unwrap_or_default()
    }
}

/// Reads a grid of a file by its name, if the budget has room for it: that is known before its values are read.
pub(crate) fn read(path: &Path, name: &str, budget: &Budget) -> Result<Grid, VdbError> {
    let file = File::open(path)?;
    let left = file.metadata()?.len();
    let mut source = Source {
        file: BufReader::with_capacity(1 << 18, file),
        left,
    };
    let magic: [u8; 8] = source.bytes().map_err(|_| VdbError::NoVdb)?;
    if u64::from_le_bytes(magic) != MAGIC {
        return Err(VdbError::NoVdb);
    }
    let version = source.u32()?;
    if version < OLDEST {
        return Err(VdbError::TooOld(version));
    }
    let [.., has_offsets] = source.bytes::<9>()?;
    if has_offsets == 0 {
        return Err(VdbError::Damaged("it does not say where its grids are"));
    }
    source.bytes::<36>()?;
    source.metadata()?;
    let mut entries: Vec<Entry> = Vec::new();
    for _ in 0..source.u32()? {
        let (name, kind, parent) = (source.text()?, source.text()?, source.text()?);
        let [grid, blocks, end] = [source.i64()?, source.i64()?, source.i64()?];
        entries.push(Entry {
            name,
            kind,
            parent,
            grid,
            blocks,
        });
        source.go_to(end)?;
    }
    let Some(entry) = entries.iter().find(|entry| entry.plain_name() == name) else {
        let names: Vec<&str> = entries.iter().map(Entry::plain_name).collect();
        return Err(VdbError::NoSuchGrid {
            grid: name.into(),
            there: names.join(", "),
        });
    };
    let (_, _, place) = start(&mut source, entry)?;
    let shared = (!entry.parent.is_empty()).then_some(&entry.parent);
    let tree = shared.and_then(|parent| entries.iter().find(|e| e.name == *parent));
    let tree = tree.unwrap_or(entry);
    let (compression, half, _) = start(&mut source, tree)?;
    tree::read(
        &mut source,
        tree,
        (compression, half),
        name,
        (place, budget),
    )
}

/// What comes before a grid's tree: how it is packed, whether by halves, and where it is.
fn start(source: &mut Source, entry: &Entry) -> Result<(u32, bool, DAffine3), VdbError> {
    source.go_to(entry.grid)?;
    let compression = source.u32()?;
    let half = source.metadata()?;
    let map = source.text()?;
    let scale = |s: DVec3| DAffine3::from_scale(s);
    // Inverses and such follow the scale.
    let place = match &*map {
        "UniformScaleMap" | "ScaleMap" => {
            let place = scale(source.vector()?);
            source.bytes::<96>()?;
            place
        }
        "TranslationMap" => DAffine3::from_translation(source.vector()?),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let translation = source.vector()?;
            let place = DAffine3 {
                translation,
                ..scale(source.vector()?)
            };
            source.bytes::<96>()?;
            place
        }
        "AffineMap" | "UnitaryMap" => {
            // Rows of a matrix that is multiplied from the left: each is the image of an axis.
            let mut row = || {
                let axis = source.vector()?;
                source.bytes::<8>().map(|_| axis)
            };
            let (x, y, z, translation) = (row()?, row()?, row()?, row()?);
            DAffine3 {
                matrix3: DMat3::from_cols(x, y, z),
                translation,
            }
        }
        _ => {
            let grid = entry.plain_name().into();
            return Err(VdbError::Map { grid, map });
        }
    };
    if !place.is_finite() || place.matrix3.determinant() == 0.0 {
        return Err(VdbError::Damaged("a grid in it has no extent"));
    }
    Ok((compression, half, place))
}

#[cfg(test)]
#[path = "../../../tests/unit/import/vdb/mod.rs"]
mod tests;
