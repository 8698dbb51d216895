//! The tree of a grid in an OpenVDB file: a root, nodes of 32³ and 16³, leaves of 8³.

use super::{Entry, Source, VdbError, blosc};
use crate::import::budget::Budget;
use crate::scene::{Grid, LEAF_POINTS};
use glam::{DAffine3, IVec3, Vec4};
use half::f16;
use std::io::Read;

/// Flags of compression.
const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// Nodes are at most so many points away.
const FARTHEST: i32 = 1 << 30;
/// Boxes of 4096³ points with one value that is not the background.
const MOST_ROOT_TILES: u32 = 64;

/// Numbers of a grid in its file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    F32,
    F64,
    I32,
    I64,
}

impl Number {
    fn size(self) -> usize {
        match self {
            Self::F32 | Self::I32 => 4,
            Self::F64 | Self::I64 => 8,
        }
    }

    fn read(self, bytes: &[u8]) -> f32 {
        fn all<const N: usize>(bytes: &[u8]) -> [u8; N] {
            bytes.try_into().unwrap_or([0; N])
        }
        match self {
            Self::F32 => f32::from_le_bytes(all(bytes)),
            Self::F64 => f64::from_le_bytes(all(bytes)) as f32,
            Self::I32 => i32::from_le_bytes(all(bytes)) as f32,
            Self::I64 => i64::from_le_bytes(all(bytes)) as f32,
        }
    }
}

/// Reads values as they are packed.
struct Packed {
    number: Number,
    channels: usize,
    half: bool,
    compression: u32,
    background: Vec4,
    /// Packed bytes, unpacked ones, and a place for those that are shuffled.
    buffers: [Vec<u8>; 3],
    values: Vec<f32>,
}

type Mask = Vec<u64>;

fn is_on(mask: &[u64], at: usize) -> bool {
    mask[at >> 6] >> (at & 63) & 1 != 0
}

fn ones(mask: &[u64]) -> impl Iterator<Item = usize> {
    (0..mask.len() * 64).filter(|&at| is_on(mask, at))
}

fn mask(source: &mut Source, bits: usize) -> Result<Mask, VdbError> {
    (0..bits / 64)
        .map(|_| source.bytes().map(u64::from_le_bytes))
        .collect()
}

fn coordinate(source: &mut Source) -> Result<IVec3, VdbError> {
    let mut next = || source.bytes().map(i32::from_le_bytes);
    let found = IVec3::new(next()?, next()?, next()?);
    // All points of its node have numbers then.
    if found.cmplt(IVec3::splat(-FARTHEST)).any() || found.cmpgt(IVec3::splat(FARTHEST)).any() {
        return Err(VdbError::Damaged("a node of it is too far away"));
    }
    Ok(found)
}

impl Packed {
    fn vector(&self, numbers: &[f32]) -> Vec4 {
        match *numbers {
            [a] => Vec4::splat(a),
            [a, b, c] => Vec4::new(a, b, c, 1.0),
            _ => Vec4::ZERO,
        }
    }

    /// A value that stands alone, never halved.
    fn single(&self, source: &mut Source) -> Result<Vec4, VdbError> {
        let mut numbers = [0.0; 3];
        for number in &mut numbers[..self.channels] {
            let mut bytes = [0; 8];
            let bytes = &mut bytes[..self.number.size()];
            source.fill(bytes)?;
            *number = self.number.read(bytes);
        }
        Ok(self.vector(&numbers[..self.channels]))
    }

    /// So many values that stand together: `values` has them then.
    fn together(&mut self, source: &mut Source, count: usize) -> Result<(), VdbError> {
        let size = if self.half { 2 } else { self.number.size() };
        let bytes = count * self.channels * size;
        self.values.clear();
        // OpenVDB writes nothing at all of no halves.
        if self.half && count == 0 {
            return Ok(());
        }
        let [packed, plain, scratch] = &mut self.buffers;
        plain.clear();
        plain.resize(bytes, 0);
        if self.compression & (BLOSC | ZIP) == 0 {
            source.fill(plain)?;
        } else {
            let told = source.i64()?;
            let length = told.unsigned_abs();
            if told <= 0 && length != bytes as u64 {
                return Err(VdbError::Damaged("a block of it has a wrong size"));
            }
            if told <= 0 {
                source.fill(plain)?;
            } else {
                if length > source.left {
                    return Err(VdbError::Damaged(
                        "a packed block of it lies beyond its end",
                    ));
                }
                // No packing makes its input much longer.
                if length > 2 * bytes as u64 + 4096 {
                    return Err(VdbError::Damaged("a packed block of it is too long"));
                }
                packed.clear();
                packed.resize(length as usize, 0);
                source.fill(packed)?;
                if self.compression & BLOSC != 0 {
                    if bytes > 0 {
                        blosc::unpack(packed, plain, scratch).map_err(VdbError::Damaged)?;
                    }
                } else {
                    let broken = |_| VdbError::Damaged("a packed block of it cannot be unpacked");
                    let mut reader = flate2::read::ZlibDecoder::new(&packed[..]);
                    reader.read_exact(plain).map_err(broken)?;
                }
            }
        }
        if self.half {
            let halves = plain.as_chunks::<2>().0;
            let read = halves.iter().map(|&b| f16::from_le_bytes(b).to_f32());
            self.values.extend(read);
        } else {
            let number = self.number;
            let read = plain.chunks_exact(number.size()).map(|b| number.read(b));
            self.values.extend(read);
        }
        Ok(())
    }

    /// The values of a node with so many points; inactive ones may be left out in the file (`io::readCompressedValues`).
    fn node(
        &mut self,
        source: &mut Source,
        active: &[u64],
        into: &mut Vec<f32>,
    ) -> Result<(), VdbError> {
        let count = active.len() * 64;
        let [told] = source.bytes()?;
        if told > 6 {
            return Err(VdbError::Damaged(
                "a node of it is stored in a way that there is not",
            ));
        }
        let background = self.background;
        let (mut off, mut on) = (if told == 0 { background } else { -background }, background);
        if matches!(told, 2 | 4 | 5) {
            off = self.single(source)?;
            if told == 5 {
                on = self.single(source)?;
            }
        }
        let selected = if matches!(told, 3..=5) {
            mask(source, count)?
        } else {
            vec![0; active.len()]
        };
        into.clear();
        let active_only = self.compression & ACTIVE_MASK != 0 && told != 6;
        let there = if active_only {
            active.iter().map(|bits| bits.count_ones() as usize).sum()
        } else {
            count
        };
        self.together(source, there)?;
        if !active_only {
            into.append(&mut self.values);
            return Ok(());
        }
        let mut values = self.values.chunks_exact(self.channels);
        for at in 0..count {
            let given = is_on(active, at).then(|| values.next()).flatten();
            match given {
                Some(value) => into.extend_from_slice(value),
                None => {
                    let value = if is_on(&selected, at) { on } else { off };
                    into.extend_from_slice(&value.to_array()[..self.channels]);
                }
            }
        }
        Ok(())
    }
}

/// The numbers of a tree's type, as "Tree_float_5_4_3" or "Tree_vec3s_5_4_3_HalfFloat".
fn kind_of(kind: &str) -> Option<(Number, usize)> {
    let kind = kind.strip_suffix("_HalfFloat").unwrap_or(kind);
    let of = kind.strip_prefix("Tree_")?.strip_suffix("_5_4_3")?;
    Some(match of {
        "float" => (Number::F32, 1),
        "double" => (Number::F64, 1),
        "int32" => (Number::I32, 1),
        "int64" => (Number::I64, 1),
        "vec3s" => (Number::F32, 3),
        "vec3d" => (Number::F64, 3),
        "vec3i" => (Number::I32, 3),
        _ => return None,
    })
}

/// The place of a child in a node whose children lie along each axis as a power of two.
fn child(number: usize, power: u32) -> IVec3 {
    let mask = (1usize << power) - 1;
    let axis = |shift: u32| (number >> shift & mask) as i32;
    IVec3::new(axis(2 * power), axis(power), axis(0))
}

/// Reads a tree whose topology comes next.
pub(super) fn read(
    source: &mut Source,
    entry: &Entry,
    (compression, half): (u32, bool),
    name: &str,
    (place, budget): (DAffine3, &Budget),
) -> Result<Grid, VdbError> {
    let Some((number, channels)) = kind_of(&entry.kind) else {
        let words = entry.kind.strip_prefix("Tree_").unwrap_or(&entry.kind);
        return Err(VdbError::Kind {
            grid: name.into(),
            kind: words.into(),
        });
    };
    if source.u32()? != 1 {
        return Err(VdbError::Damaged("its leaves have several values"));
    }
    let mut packed = Packed {
        number,
        channels,
        half: half && matches!(number, Number::F32 | Number::F64),
        compression,
        background: Vec4::ZERO,
        buffers: Default::default(),
        values: Vec::new(),
    };
    let background = packed.single(source)?;
    packed.background = background;
    let mut grid = Grid::new(name, channels, background, place, packed.half);
    let (tiles, nodes) = (source.u32()?, source.u32()?);
    let mut filled = 0;
    for _ in 0..tiles {
        let origin = coordinate(source)?;
        let value = packed.single(source)?;
        let [active] = source.bytes()?;
        if active != 0 {
            grid.set_active(origin, IVec3::splat(4096));
        }
        if value != background {
            // A few bytes each, they would take much memory.
            filled += 1;
            if filled > MOST_ROOT_TILES {
                return Err(VdbError::Damaged("more of it is filled than there can be"));
            }
            for i in 0..1 << 15 {
                grid.add_region(origin + child(i, 5) * 128, value);
            }
        }
    }
    let mut values = Vec::new();
    let mut leaves = 0usize;
    for _ in 0..nodes {
        let origin = coordinate(source)?;
        let (children, active) = (mask(source, 1 << 15)?, mask(source, 1 << 15)?);
        packed.node(source, &active, &mut values)?;
        for at in (0..1 << 15).filter(|&at| !is_on(&children, at)) {
            let value = packed.vector(&values[at * channels..(at + 1) * channels]);
            let corner = origin + child(at, 5) * 128;
            if is_on(&active, at) {
                grid.set_active(corner, IVec3::splat(128));
            }
            grid.add_region(corner, value);
        }
        for at in ones(&children) {
            let corner = origin + child(at, 5) * 128;
            leaves += region(source, &mut grid, &mut packed, corner, &mut values)?;
        }
    }
    let no_memory = |bytes: crate::scene::NoMemory| VdbError::NoMemory {
        grid: name.into(),
        mebibytes: bytes.0 >> 20,
    };
    let bytes = grid.bytes_of_leaves();
    if budget.take(bytes, 1).is_err() {
        return Err(VdbError::TooLarge {
            grid: name.into(),
            mebibytes: bytes >> 20,
            left: budget.left() >> 20,
        });
    }
    grid.finish_topology().map_err(no_memory)?;
    source.go_to(entry.blocks)?;
    for _ in 0..leaves {
        let active = mask(source, LEAF_POINTS)?;
        packed.node(source, &active, &mut values)?;
        grid.push_leaf(&values);
    }
    Ok(grid)
}

/// A node of 16³ leaves; how many there are.
fn region(
    source: &mut Source,
    grid: &mut Grid,
    packed: &mut Packed,
    origin: IVec3,
    values: &mut Vec<f32>,
) -> Result<usize, VdbError> {
    let (children, active) = (mask(source, 1 << 12)?, mask(source, 1 << 12)?);
    packed.node(source, &active, values)?;
    let channels = packed.channels;
    for at in (0..1 << 12).filter(|&at| !is_on(&children, at)) {
        let value = packed.vector(&values[at * channels..(at + 1) * channels]);
        let corner = origin + child(at, 4) * 8;
        if is_on(&active, at) {
            grid.set_active(corner, IVec3::splat(8));
        }
        grid.add_tile(corner, value);
    }
    let mut leaves = 0;
    for at in ones(&children) {
        let corner = origin + child(at, 4) * 8;
        let set = mask(source, LEAF_POINTS)?;
        // Most leaves lie between others.
        let known = grid
            .active
            .is_some_and(|(low, high)| corner.cmpge(low).all() && (corner + 7).cmple(high).all());
        for point in ones(&set).filter(|_| !known) {
            grid.set_active(corner + child(point, 3), IVec3::ONE);
        }
        grid.add_leaf(corner);
        leaves += 1;
    }
    Ok(leaves)
}
