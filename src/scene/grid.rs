//! Values on a sparse lattice, as OpenVDB has them: leaves of 8³ points in cells of 128³.
//!
//! Museth, *VDB: High-Resolution Sparse Volumes with Dynamic Topology*, 2013. Between points values are interpolated as Cycles does:
//! linearly, or by cubic B-splines.

use glam::{DAffine3, I64Vec3, IVec3, Vec3, Vec4};
use half::f16;
use std::sync::Arc;

/// Points along a leaf's side, as a power of two.
const LEAF: i32 = 3;
/// Points of a leaf.
pub const LEAF_POINTS: usize = 1 << (3 * LEAF);
/// Points along a region's side, as a power of two; 16³ leaves.
const REGION: i32 = 7;
/// Leaves of a region.
const LEAVES: usize = 1 << (3 * (REGION - LEAF));
/// So many regions stand in a table with a place for each; more are searched.
const MOST_IN_TABLE: i64 = 1 << 20;
/// Of boxes with more points along a side it is said what all of a grid has.
const MOST_ASKED: i64 = 256;
/// Of a slot: it has one value for all its points, with a number.
const TILE: u32 = 1 << 31;

/// How values between the points are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// From the nearest eight.
    Linear,
    /// By cubic B-splines, from the nearest 64.
    Cubic,
    /// One of the nearest eight is drawn by the place itself: its mean is the linear one. So Cycles asks for temperatures, of
    /// which the light is no linear function.
    Drawn,
}

impl Interpolation {
    /// Points beyond a box whose values count in it.
    fn margin(self) -> i32 {
        if self == Self::Cubic { 2 } else { 1 }
    }
}

/// Values of leaves, as the file has them.
#[derive(Clone, Debug)]
enum Values {
    Single(Vec<f32>),
    Half(Vec<f16>),
}

/// A grid of numbers, vectors or colours.
#[derive(Clone, Debug)]
pub struct Grid {
    /// What it is called (for messages).
    pub name: String,
    /// From places among the points, which lie at whole numbers, to the object's space.
    pub object_from_index: DAffine3,
    /// Where values are set: the least and the greatest point.
    pub active: Option<(IVec3, IVec3)>,
    channels: usize,
    background: Vec4,
    regions: Regions,
    cells: Vec<Box<[u32; LEAVES]>>,
    tiles: Vec<Vec4>,
    values: Values,
    /// Least and greatest value of each leaf, by channel.
    ranges: Vec<f32>,
    /// The same of everything.
    whole: (Vec4, Vec4),
    leaves: u32,
}

/// The grids of what fills a mesh.
#[derive(Clone, Debug, Default)]
pub struct Grids {
    /// By the numbers that shader graphs have for them.
    pub by_number: Vec<Option<Arc<Grid>>>,
    /// What shaders say of densities holds in the object's own space: twice as large, it lets as much light through.
    pub density_by_object: bool,
}

impl Grids {
    /// A grid by its number.
    pub fn get(&self, number: u32) -> Option<&Arc<Grid>> {
        self.by_number.get(number as usize)?.as_ref()
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &Arc<Grid>> {
        self.by_number.iter().flatten()
    }
}

/// Where regions are: sorted, or in a table.
#[derive(Clone, Debug, Default)]
struct Regions {
    sorted: Vec<([i32; 3], u32)>,
    table: Option<(IVec3, IVec3, Box<[u32]>)>,
}

impl Regions {
    fn get(&self, region: IVec3) -> u32 {
        if let Some((low, count, table)) = &self.table {
            let at = region - low;
            if at.cmplt(IVec3::ZERO).any() || at.cmpge(*count).any() {
                return 0;
            }
            return table[((at.x * count.y + at.y) * count.z + at.z) as usize];
        }
        let found = self
            .sorted
            .binary_search_by_key(&region.to_array(), |entry| entry.0);
        found.map_or(0, |at| self.sorted[at].1)
    }

    fn finish(&mut self) {
        self.sorted.sort_unstable();
        self.sorted.dedup_by_key(|entry| entry.0);
        let points = || self.sorted.iter().map(|entry| IVec3::from(entry.0));
        let low = points().fold(IVec3::MAX, IVec3::min);
        let high = points().fold(IVec3::MIN, IVec3::max);
        if self.sorted.is_empty() {
            return;
        }
        let size = high.as_i64vec3() - low.as_i64vec3() + 1;
        // The first, so that the product is a number.
        if size.max_element() > MOST_IN_TABLE || size.element_product() > MOST_IN_TABLE {
            return;
        }
        let count = size.as_ivec3();
        let mut table = vec![0; size.element_product() as usize].into_boxed_slice();
        for (region, slot) in self.sorted.drain(..) {
            let at = IVec3::from(region) - low;
            table[((at.x * count.y + at.y) * count.z + at.z) as usize] = slot;
        }
        self.table = Some((low, count, table));
    }
}

/// What is at a point.
enum Found {
    /// In a leaf: where its values begin.
    Leaf(usize),
    Constant(Vec4),
}

/// There is not enough memory for so many bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMemory(pub u64);

impl Grid {
    /// Without points; `half`: the values are kept as f16.
    pub fn new(
        name: impl Into<String>,
        channels: usize,
        background: Vec4,
        object_from_index: DAffine3,
        half: bool,
    ) -> Self {
        Self {
            name: name.into(),
            object_from_index,
            active: None,
            channels,
            background,
            regions: Regions::default(),
            cells: Vec::new(),
            tiles: Vec::new(),
            values: if half {
                Values::Half(Vec::new())
            } else {
                Values::Single(Vec::new())
            },
            ranges: Vec::new(),
            whole: (background, background),
            leaves: 0,
        }
    }

    /// From an array whose first axis goes fastest; where all channels are 0 nothing is set.
    pub fn dense(
        name: impl Into<String>,
        (channels, size): (usize, IVec3),
        values: &[f32],
        object_from_index: DAffine3,
    ) -> Result<Self, NoMemory> {
        let mut grid = Self::new(name, channels, Vec4::ZERO, object_from_index, false);
        let leaves = (size + 7) / 8;
        let mut origins = Vec::new();
        let at = |p: IVec3| {
            let inside = p.cmplt(size).all();
            let number = ((p.z * size.y + p.y) * size.x + p.x) as usize * channels;
            inside.then(|| &values[number..number + channels])
        };
        let points = || (0..LEAF_POINTS as i32).map(|i| IVec3::new(i >> 6, i >> 3 & 7, i & 7));
        for x in 0..leaves.x {
            for y in 0..leaves.y {
                for z in 0..leaves.z {
                    let origin = IVec3::new(x, y, z) * 8;
                    let is_set =
                        |p: IVec3| at(origin + p).is_some_and(|v| v.iter().any(|&v| v != 0.0));
                    let mut any = false;
                    for p in points().filter(|&p| is_set(p)) {
                        grid.set_active(origin + p, IVec3::ONE);
                        any = true;
                    }
                    if any {
                        grid.add_leaf(origin);
                        origins.push(origin);
                    }
                }
            }
        }
        grid.finish_topology()?;
        let mut leaf = vec![0.0; LEAF_POINTS * channels];
        for origin in origins {
            for (p, into) in points().zip(leaf.chunks_mut(channels)) {
                match at(origin + p) {
                    Some(values) => into.copy_from_slice(values),
                    None => into.fill(0.0),
                }
            }
            grid.push_leaf(&leaf);
        }
        Ok(grid)
    }

    /// What tells it apart from others: its shape, and its values in the order of its leaves.
    pub fn digest(&self, mut block: impl FnMut(&[u8])) {
        let facts = (
            self.channels,
            self.background,
            self.object_from_index,
            self.active,
        );
        block(format!("{facts:?} {:?} {:?}", self.regions, self.tiles).as_bytes());
        self.cells
            .iter()
            .for_each(|cells| block(bytemuck::cast_slice(&cells[..])));
        match &self.values {
            Values::Single(values) => block(bytemuck::cast_slice(values)),
            Values::Half(values) => values.chunks(LEAF_POINTS).for_each(|leaf| {
                let bits: Vec<u16> = leaf.iter().map(|value| value.to_bits()).collect();
                block(bytemuck::cast_slice(&bits));
            }),
        }
    }

    /// Numbers of a point.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Bytes that the values take.
    pub fn bytes(&self) -> u64 {
        let values = match &self.values {
            Values::Single(values) => values.len() * 4,
            Values::Half(values) => values.len() * 2,
        };
        let rest = self.ranges.len() * 4 + self.cells.len() * LEAVES * 4;
        (values + rest) as u64
    }

    /// Takes note that something is set in a box.
    pub fn set_active(&mut self, low: IVec3, size: IVec3) {
        let high = low.saturating_add(size - 1);
        self.active = Some(match self.active {
            Some((a, b)) => (a.min(low), b.max(high)),
            None => (low, high),
        });
    }

    fn region(&mut self, origin: IVec3) -> &mut [u32; LEAVES] {
        let region = (origin >> REGION).to_array();
        // A file names the leaves of a region one after the other.
        let known = self.regions.sorted.last().filter(|last| last.0 == region);
        let slot = match known {
            Some(&(_, slot)) if slot & TILE == 0 => slot,
            _ => {
                self.cells.push(Box::new([0; LEAVES]));
                let slot = self.cells.len() as u32;
                self.regions.sorted.push((region, slot));
                slot
            }
        };
        &mut self.cells[slot as usize - 1]
    }

    /// A leaf whose values are pushed later, in the same order. The leaves of a region come one after the other.
    pub fn add_leaf(&mut self, origin: IVec3) {
        self.leaves += 1;
        let number = self.leaves;
        self.region(origin)[leaf_of(origin)] = number;
    }

    /// One value for a whole leaf.
    pub fn add_tile(&mut self, origin: IVec3, value: Vec4) {
        if value != self.background {
            let tile = self.tile(value);
            self.region(origin)[leaf_of(origin)] = tile;
        }
    }

    /// One value for a whole region.
    pub fn add_region(&mut self, origin: IVec3, value: Vec4) {
        if value != self.background {
            let tile = self.tile(value);
            let region = (origin >> REGION).to_array();
            self.regions.sorted.push((region, tile));
        }
    }

    fn tile(&mut self, value: Vec4) -> u32 {
        self.widen(value, value);
        if self.tiles.last() != Some(&value) {
            self.tiles.push(value);
        }
        (self.tiles.len() - 1) as u32 | TILE
    }

    /// Bytes that the values of all its leaves take.
    pub fn bytes_of_leaves(&self) -> u64 {
        let size = match self.values {
            Values::Half(_) => 2,
            Values::Single(_) => 4,
        };
        let leaf = (LEAF_POINTS * size + 2 * 4) * self.channels;
        u64::from(self.leaves) * leaf as u64
    }

    /// Makes place for the leaves' values.
    pub fn finish_topology(&mut self) -> Result<(), NoMemory> {
        self.regions.finish();
        let count = self.leaves as usize * LEAF_POINTS * self.channels;
        let ranges = self.leaves as usize * self.channels * 2;
        let bytes = self.bytes_of_leaves();
        let failed = |_| NoMemory(bytes);
        match &mut self.values {
            Values::Single(values) => values.try_reserve_exact(count).map_err(failed)?,
            Values::Half(values) => values.try_reserve_exact(count).map_err(failed)?,
        }
        self.ranges.try_reserve_exact(ranges).map_err(failed)
    }

    fn widen(&mut self, least: Vec4, most: Vec4) {
        self.whole = (self.whole.0.min(least), self.whole.1.max(most));
    }

    /// Least and greatest values of a leaf, by its number.
    fn range_of(&self, leaf: usize) -> (Vec4, Vec4) {
        let at = leaf * self.channels * 2;
        let of = |channel: usize, end: usize| {
            let channel = channel.min(self.channels - 1);
            self.ranges[at + channel * 2 + end]
        };
        let end = |end| Vec4::new(of(0, end), of(1, end), of(2, end), of(3, end));
        (end(0), end(1))
    }

    /// The values of the next leaf.
    pub fn push_leaf(&mut self, values: &[f32]) {
        for channel in 0..self.channels {
            let of = || values.iter().skip(channel).step_by(self.channels);
            self.ranges
                .push(of().copied().fold(f32::INFINITY, f32::min));
            self.ranges
                .push(of().copied().fold(f32::NEG_INFINITY, f32::max));
        }
        let (least, most) = self.range_of(self.ranges.len() / (2 * self.channels) - 1);
        self.widen(least, most);
        match &mut self.values {
            Values::Single(into) => into.extend_from_slice(values),
            Values::Half(into) => into.extend(values.iter().map(|&v| f16::from_f32(v))),
        }
    }

    fn find(&self, point: IVec3) -> Found {
        let region = self.regions.get(point >> REGION);
        let slot = match region {
            0 => return Found::Constant(self.background),
            tile if tile & TILE != 0 => return self.constant(tile),
            cells => self.cells[cells as usize - 1][leaf_of(point)],
        };
        match slot {
            0 => Found::Constant(self.background),
            tile if tile & TILE != 0 => self.constant(tile),
            leaf => Found::Leaf((leaf as usize - 1) * LEAF_POINTS),
        }
    }

    fn constant(&self, tile: u32) -> Found {
        Found::Constant(self.tiles[(tile & !TILE) as usize])
    }

    #[inline]
    fn value_of(&self, number: usize) -> Vec4 {
        let at = number * self.channels;
        let value = |i: usize| match &self.values {
            Values::Single(values) => values[at + i],
            Values::Half(values) => values[at + i].to_f32(),
        };
        match self.channels {
            1 => Vec4::splat(value(0)),
            3 => Vec4::new(value(0), value(1), value(2), 1.0),
            _ => Vec4::new(value(0), value(1), value(2), value(3)),
        }
    }

    /// At a point.
    pub fn value(&self, point: IVec3) -> Vec4 {
        match self.find(point) {
            Found::Leaf(start) => self.value_of(start + number_in_leaf(point)),
            Found::Constant(value) => value,
        }
    }

    /// At a place, by the points' numbers; the fourth is 1 where there are no four.
    pub fn sample(&self, place: Vec3, how: Interpolation) -> Vec4 {
        // Beyond it f32 tells no points apart, and there are none.
        let place = place.clamp(Vec3::splat(-1e9), Vec3::splat(1e9));
        let floor = place.floor();
        let (base, t) = (floor.as_ivec3(), place - floor);
        let found = match how {
            Interpolation::Linear => self.linear(base, t),
            Interpolation::Cubic => self.cubic(base, t),
            Interpolation::Drawn => self.value(base + drawn(place, t)),
        };
        if self.channels == 4 {
            found
        } else {
            found.truncate().extend(1.0)
        }
    }

    fn linear(&self, base: IVec3, t: Vec3) -> Vec4 {
        let inner = (base & 7).max_element() < 7;
        let mut values = [Vec4::ZERO; 8];
        let corner = |i: usize| IVec3::new((i >> 2) as i32, (i >> 1 & 1) as i32, (i & 1) as i32);
        match self.find(base) {
            Found::Constant(value) if inner => return value,
            Found::Leaf(start) if inner => {
                let first = start + number_in_leaf(base);
                for (i, value) in values.iter_mut().enumerate() {
                    *value = self.value_of(first + ((i >> 2) << 6) + ((i >> 1 & 1) << 3) + (i & 1));
                }
            }
            _ => {
                for (i, value) in values.iter_mut().enumerate() {
                    *value = self.value(base + corner(i));
                }
            }
        }
        let [a, b, c, d, e, f, g, h] = values;
        let x = |near: Vec4, far: Vec4| near + (far - near) * t.x;
        let y = |near: Vec4, far: Vec4| near + (far - near) * t.y;
        let z = |near: Vec4, far: Vec4| near + (far - near) * t.z;
        x(y(z(a, b), z(c, d)), y(z(e, f), z(g, h)))
    }

    fn cubic(&self, base: IVec3, t: Vec3) -> Vec4 {
        let (wx, wy, wz) = (weights(t.x), weights(t.y), weights(t.z));
        let mut sum = Vec4::ZERO;
        for i in 0..64usize {
            let (x, y, z) = (i >> 4, i >> 2 & 3, i & 3);
            let point = base + IVec3::new(x as i32, y as i32, z as i32) - 1;
            sum += self.value(point) * (wx[x] * wy[y] * wz[z]);
        }
        sum
    }

    /// Least and greatest value in a box, by the points' numbers.
    pub fn range(&self, low: Vec3, high: Vec3, how: Interpolation) -> (Vec4, Vec4) {
        let limit = Vec3::splat(1e9);
        let (low, high) = (low.clamp(-limit, limit), high.clamp(-limit, limit));
        let margin = how.margin() - 1;
        let from = low.floor().as_ivec3() - margin;
        let to = high.floor().as_ivec3() + 1 + margin;
        let (mut least, mut most) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        let mut take = |value: Vec4, other: Vec4| {
            least = least.min(value);
            most = most.max(other);
        };
        // What lies beyond all that is set is the same everywhere.
        let Some((first, last)) = self.extent() else {
            return (self.background, self.background);
        };
        if from.cmplt(first).any() || to.cmpgt(last).any() {
            take(self.background, self.background);
        }
        let (from, to) = (from.max(first), to.min(last));
        let size = (to.as_i64vec3() - from.as_i64vec3() + 1).max(I64Vec3::ZERO);
        if size.max_element() > MOST_ASKED {
            return self.whole;
        }
        if size.element_product() <= LEAF_POINTS as i64 {
            each(from, to, |point| take(self.value(point), self.value(point)));
        } else {
            each(from >> LEAF, to >> LEAF, |leaf| {
                match self.find(leaf << LEAF) {
                    Found::Constant(value) => take(value, value),
                    Found::Leaf(start) => {
                        let (a, b) = self.range_of(start / LEAF_POINTS);
                        take(a, b);
                    }
                }
            });
        }
        (least, most)
    }

    /// Points beyond which there is the background alone.
    fn extent(&self) -> Option<(IVec3, IVec3)> {
        let (low, high) = match &self.regions.table {
            Some((low, count, _)) => (*low, *low + *count - 1),
            None => {
                let points = || self.regions.sorted.iter().map(|entry| IVec3::from(entry.0));
                let low = points().reduce(IVec3::min)?;
                (low, points().fold(low, IVec3::max))
            }
        };
        Some((low << REGION, (high << REGION) + ((1 << REGION) - 1)))
    }
}

/// Calls for each point of a box.
fn each(from: IVec3, to: IVec3, mut call: impl FnMut(IVec3)) {
    for x in from.x..=to.x {
        for y in from.y..=to.y {
            for z in from.z..=to.z {
                call(IVec3::new(x, y, z));
            }
        }
    }
}

/// A leaf's number in its region, of one of its points.
fn leaf_of(point: IVec3) -> usize {
    let leaf = point >> LEAF & 15;
    (leaf.x << 8 | leaf.y << 4 | leaf.z) as usize
}

fn number_in_leaf(point: IVec3) -> usize {
    let p = point & 7;
    (p.x << 6 | p.y << 3 | p.z) as usize
}

/// Of cubic B-splines.
fn weights(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    let inner = |t: f32| (4.0 + t * t * (3.0 * t - 6.0)) / 6.0;
    [s * s * s / 6.0, inner(t), inner(s), t * t * t / 6.0]
}

/// One of the eight corners around a place, by a hash of the place.
fn drawn(place: Vec3, t: Vec3) -> IVec3 {
    let mix = |seed: u32| {
        let mut h = seed;
        for bits in place.to_array().map(f32::to_bits) {
            // The finaliser of MurmurHash3 (Appleby).
            h ^= bits;
            h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
            h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
            h ^= h >> 16;
        }
        (h >> 8) as f32 / (1 << 24) as f32
    };
    IVec3::new(
        i32::from(mix(1) < t.x),
        i32::from(mix(2) < t.y),
        i32::from(mix(3) < t.z),
    )
}

#[cfg(test)]
#[path = "../../tests/unit/scene/grid.rs"]
mod tests;
