//! Which objects a pixel shows, and how much of each: for Cryptomatte, indices and mist.
//!
//! A pixel keeps numbers of objects; what they are called comes in when a pass is made. An object has one material here, so
//! that its number tells the material and the asset, too.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Objects that a pixel tells apart; what is more goes to the last of them, as in Cycles.
const SLOTS: usize = 16;
/// One, of weights in fixed point: sums of them do not depend on their order.
const ONE: f64 = 4_294_967_296.0;
/// No object.
const NONE: u32 = 0;

/// What a path of the camera meets first; what it passes by chance is met, too.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstObject {
    /// Its number.
    pub number: u32,
    /// How much of the sample is its, for mattes …
    pub weight: f32,
    /// … and for mist: they differ where coloured light is before a surface that lets coloured light pass.
    pub there: f32,
    /// From the camera.
    pub distance: f32,
    /// What comes through to it from around, if that is asked for.
    pub open: Vec3,
}

impl FirstObject {
    /// Whether its numbers are some.
    pub fn is_finite(&self) -> bool {
        let numbers = [self.weight, self.there, self.distance];
        numbers.iter().all(|number| number.is_finite()) && self.open.is_finite()
    }
}

/// Blender's mist: nothing up to `start`, all from `start + depth` on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mist {
    /// Where it begins, metres.
    pub start: f32,
    /// How far it takes to be all, metres.
    pub depth: f32,
    /// Power of what lies between: Blender's Quadratic is 2, Linear 1, Inverse Quadratic 1/2.
    pub falloff: f32,
}

impl Default for Mist {
    /// Blender's new world.
    fn default() -> Self {
        Self {
            start: 5.0,
            depth: 25.0,
            falloff: 2.0,
        }
    }
}

impl Mist {
    /// Whether nobody has asked for another one.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Its share at a distance.
    fn at(self, distance: f32) -> f32 {
        let share = if self.depth > 0.0 {
            ((distance - self.start) / self.depth).clamp(0.0, 1.0)
        } else {
            f32::from(distance > self.start)
        };
        share.powf(self.falloff)
    }
}

/// What names a matte: Cryptomatte's kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Matte {
    /// The object itself.
    Object,
    /// Its material.
    Material,
    /// The topmost of its parents.
    Asset,
}

/// What is known of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Hashes of the names of object, material and asset.
    ids: [u32; 3],
    /// Pass indices of object and material.
    indices: [f32; 2],
}

impl Label {
    /// From names of object, material and asset, and the pass indices of object and material.
    pub fn new(names: [&str; 3], indices: [f32; 2]) -> Self {
        Self {
            ids: names.map(hash),
            indices,
        }
    }

    /// Whether its numbers are some.
    pub fn is_finite(&self) -> bool {
        self.indices.iter().all(|index| index.is_finite())
    }
}

/// Cryptomatte's hash of a name: MurmurHash3, 32 bits.
pub fn hash(name: &str) -> u32 {
    // A slice can be read.
    murmur3::murmur3_32(&mut name.as_bytes(), 0).unwrap_or_default()
}

/// The number that stands for a hash in a pass: its bits, made such that they are neither infinite nor subnormal, as
/// Cryptomatte's specification has it (Friedman and Jones 2015, "Generating ID floats").
fn id_float(hash: u32) -> f32 {
    let exponent = hash >> 23 & 255;
    let hash = if exponent == 0 || exponent == 255 {
        hash ^ 1 << 23
    } else {
        hash
    };
    f32::from_bits(hash)
}

/// A number in fixed point.
fn fixed(value: f32) -> i64 {
    (f64::from(value) * ONE) as i64
}

/// What is kept of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelObjects {
    /// Numbers of objects and 1, in the order in which they came.
    numbers: [u32; SLOTS],
    weights: [i64; SLOTS],
    /// Sum of what is not in the mist, in fixed point.
    clear: i64,
    /// Sum of what comes through from around.
    open: [i64; 3],
    /// What the ray through the middle meets, and 1.
    middle: u32,
    /// No bytes without a name.
    unused: u32,
}

impl PixelObjects {
    /// Adds what a sample has met.
    pub fn add(&mut self, first: &FirstObject, mist: Mist) {
        if first.weight > 0.0 {
            self.add_weight(first.number.saturating_add(1), fixed(first.weight));
        }
        let clear = (1.0 - mist.at(first.distance)) * first.there;
        self.clear = self.clear.saturating_add(fixed(clear));
        for (sum, value) in self.open.iter_mut().zip(first.open.to_array()) {
            *sum = sum.saturating_add(fixed(value));
        }
    }

    fn add_weight(&mut self, number: u32, weight: i64) {
        let found = self.numbers.iter().position(|&n| n == number || n == NONE);
        let slot = found.unwrap_or(SLOTS - 1);
        if self.numbers[slot] == NONE {
            self.numbers[slot] = number;
        }
        self.weights[slot] = self.weights[slot].saturating_add(weight);
    }

    /// Takes note of what the ray through the middle meets.
    pub fn set_middle(&mut self, number: Option<u32>) {
        self.middle = number.map_or(NONE, |number| number.saturating_add(1));
    }

    /// Adds other samples of the same pixel.
    pub fn join(&mut self, other: &Self) {
        for (&number, &weight) in other.numbers.iter().zip(&other.weights) {
            if number != NONE {
                self.add_weight(number, weight);
            }
        }
        self.clear = self.clear.saturating_add(other.clear);
        for (sum, value) in self.open.iter_mut().zip(other.open) {
            *sum = sum.saturating_add(value);
        }
        if self.middle == NONE {
            self.middle = other.middle;
        }
    }

    /// Whether its numbers are those of so many objects: for one that comes from a file.
    pub fn is_sound(&self, objects: usize) -> bool {
        let known = |&number: &u32| number as usize <= objects;
        self.numbers.iter().all(known) && known(&self.middle)
    }

    /// The mist, given the reciprocal of the number of samples.
    pub fn mist(&self, scale: f64) -> f32 {
        (1.0 - self.clear as f64 / ONE * scale).max(0.0) as f32
    }

    /// Ambient occlusion, given the reciprocal of the number of samples.
    pub fn open(&self, scale: f64) -> [f32; 3] {
        self.open.map(|sum| (sum as f64 / ONE * scale) as f32)
    }

    /// Pass index of the object in the middle, or of its material; 0 of nothing.
    pub fn index(&self, labels: &[Label], of_material: bool) -> f32 {
        let label = (self.middle as usize)
            .checked_sub(1)
            .and_then(|number| labels.get(number));
        label.map_or(0.0, |label| label.indices[usize::from(of_material)])
    }

    /// Two mattes, those of a rank and the next one: for each the number of what it is of, and how much of the pixel it is.
    pub fn mattes(&self, labels: &[Label], kind: Matte, rank: usize, scale: f64) -> [f32; 4] {
        let mut all: Vec<(u32, i64)> = Vec::with_capacity(SLOTS);
        for (&number, &weight) in self.numbers.iter().zip(&self.weights) {
            let label = (number as usize)
                .checked_sub(1)
                .and_then(|number| labels.get(number));
            let Some(label) = label.filter(|_| weight > 0) else {
                continue;
            };
            let id = label.ids[kind as usize];
            match all.iter_mut().find(|(known, _)| *known == id) {
                Some((_, sum)) => *sum = sum.saturating_add(weight),
                None => all.push((id, weight)),
            }
        }
        // Of equal ones the order must not depend on which came first.
        all.sort_by_key(|&(id, weight)| (std::cmp::Reverse(weight), id));
        let of = |rank: usize| {
            all.get(rank).map_or([0.0; 2], |&(id, weight)| {
                [id_float(id), (weight as f64 / ONE * scale) as f32]
            })
        };
        let ([id, share], [next, next_share]) = (of(rank), of(rank + 1));
        [id, share, next, next_share]
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/objects.rs"]
mod tests;
