//! Perlin's improved noise (Perlin 2002) in one to four dimensions, on the lattice and with the gradients of Blender's nodes.

use glam::{Vec2, Vec3, Vec4};

use super::{fused, hash, mix};

/// A point at which noise has a value: 1D to 4D.
pub(super) trait Coordinates:
    Copy + std::ops::Add<Output = Self> + std::ops::Mul<f32, Output = Self>
{
    /// How many axes there are.
    const AXES: usize;

    /// Noise from about −1 to 1.
    fn signed_noise(self) -> f32;

    /// An offset of 100 to 200 on each axis, which stands for a seed that the noise itself has not.
    fn random_offset(seed: usize) -> Self;

    /// A point of a value for each axis.
    fn from_axes(value: impl FnMut(usize) -> f32) -> Self;
}

/// The noise repeats at this distance on each axis, lest large coordinates lose their fraction.
const PERIOD: f32 = 100_000.0;

/// Coordinates of at least this size have no fraction to speak of, and are moved off the lattice, where noise is zero.
const LARGE: f32 = 1_000_000.0;

/// One axis of the point within the period, by the exact remainder.
#[inline]
fn wrap(x: f32) -> f32 {
    if x.abs() < PERIOD {
        x
    } else {
        x % PERIOD + off_lattice(x)
    }
}

/// The same by a rounded quotient, as Cycles does in three and four dimensions.
#[inline]
fn wrap_by_quotient(x: f32) -> f32 {
    if x.abs() < PERIOD {
        x
    } else {
        x - (x * (1.0 / PERIOD)).trunc() * PERIOD + off_lattice(x)
    }
}

#[inline]
fn off_lattice(x: f32) -> f32 {
    if x.abs() >= LARGE { 0.5 } else { 0.0 }
}

/// Number of the cell, and the place in it.
#[inline(always)]
fn cell(x: f32) -> (u32, f32) {
    let floor = x.floor();
    (floor as i32 as u32, x - floor)
}

/// Perlin's quintic, whose first and second derivatives are zero at both ends.
#[inline(always)]
fn fade(t: f32) -> f32 {
    (t * t) * (t * fused(t, fused(t, 6.0, -15.0), 10.0))
}

/// `value`, with its sign changed if this bit of the hash is set.
#[inline(always)]
fn signed(value: f32, hash: u32, bit: u32) -> f32 {
    f32::from_bits(value.to_bits() ^ (((hash >> bit) & 1) << 31))
}

#[inline(always)]
fn gradient_1(hash: u32, x: f32) -> f32 {
    signed((1 + (hash & 7)) as f32, hash, 3) * x
}

#[inline(always)]
fn gradient_2(hash: u32, x: f32, y: f32) -> f32 {
    let along_x = hash & 7 < 4;
    let u = if along_x { x } else { y };
    let v = 2.0 * if along_x { y } else { x };
    signed(u, hash, 0) + signed(v, hash, 1)
}

/// Perlin's twelve edges of the cube, four of them twice.
#[inline(always)]
fn gradient_3(hash: u32, x: f32, y: f32, z: f32) -> f32 {
    let h = hash & 15;
    let u = if h < 8 { x } else { y };
    let x_or_z = if h == 12 || h == 14 { x } else { z };
    let v = if h < 4 { y } else { x_or_z };
    signed(u, h, 0) + signed(v, h, 1)
}

#[inline(always)]
fn gradient_4(hash: u32, x: f32, y: f32, z: f32, w: f32) -> f32 {
    let h = hash & 31;
    let u = if h < 24 { x } else { y };
    let v = if h < 16 { y } else { z };
    let s = if h < 8 { z } else { w };
    signed(u, h, 0) + signed(v, h, 1) + signed(s, h, 2)
}

/// One step in a direction of the lattice, if this bit of the corner's number is set.
#[inline(always)]
fn corner(cell: u32, place: f32, number: usize, bit: u32) -> (u32, f32) {
    let step = (number >> bit & 1) as u32;
    (cell.wrapping_add(step), place - step as f32)
}

impl Coordinates for f32 {
    const AXES: usize = 1;

    #[inline]
    fn signed_noise(self) -> f32 {
        let (i, x) = cell(wrap(self));
        let left = gradient_1(hash::words_1(i), x);
        let right = gradient_1(hash::words_1(i.wrapping_add(1)), x - 1.0);
        0.2500 * fused(fade(x), right - left, left)
    }

    #[inline]
    fn random_offset(seed: usize) -> Self {
        const OFFSETS: [f32; SEEDS] = {
            let mut offsets = [0.0; SEEDS];
            let mut seed = 0;
            while seed < SEEDS {
                offsets[seed] = offset(hash::unit_1(seed as f32));
                seed += 1;
            }
            offsets
        };
        OFFSETS[seed]
    }

    #[inline]
    fn from_axes(mut value: impl FnMut(usize) -> f32) -> Self {
        value(0)
    }
}

/// How many seeds the nodes use: one for each axis' distortion, and one for each of two colour channels.
const SEEDS: usize = 6;

/// 100 to 200, of a hash of 0 to 1, rounded once: Cycles' is a fused multiplication and addition.
const fn offset(hash: f32) -> f32 {
    (100.0 + hash as f64 * 100.0) as f32
}

/// The offsets from two dimensions on: for each seed those of the axes.
const OFFSETS: [[f32; 4]; SEEDS] = {
    let mut offsets = [[0.0; 4]; SEEDS];
    let mut number = 0;
    while number < 4 * SEEDS {
        let (seed, axis) = (number / 4, number % 4);
        offsets[seed][axis] = offset(hash::unit_2(seed as f32, axis as f32));
        number += 1;
    }
    offsets
};

impl Coordinates for Vec2 {
    const AXES: usize = 2;

    #[inline]
    fn signed_noise(self) -> f32 {
        let (i, x) = cell(wrap(self.x));
        let (j, y) = cell(wrap(self.y));
        let values: [f32; 4] = std::array::from_fn(|number| {
            let (i, x) = corner(i, x, number, 0);
            let (j, y) = corner(j, y, number, 1);
            gradient_2(hash::words_2(i, j), x, y)
        });
        let fade_x = fade(x);
        let low = mix(values[0], values[1], fade_x);
        let high = mix(values[2], values[3], fade_x);
        0.6616 * mix(low, high, fade(y))
    }

    #[inline]
    fn random_offset(seed: usize) -> Self {
        Self::from_axes(|axis| OFFSETS[seed][axis])
    }

    #[inline]
    fn from_axes(mut value: impl FnMut(usize) -> f32) -> Self {
        Self::new(value(0), value(1))
    }
}

impl Coordinates for Vec3 {
    const AXES: usize = 3;

    #[inline]
    fn signed_noise(self) -> f32 {
        let (i, x) = cell(wrap_by_quotient(self.x));
        let (j, y) = cell(wrap_by_quotient(self.y));
        let (k, z) = cell(wrap_by_quotient(self.z));
        let values: [f32; 8] = std::array::from_fn(|number| {
            let (i, x) = corner(i, x, number, 0);
            let (j, y) = corner(j, y, number, 1);
            let (k, z) = corner(k, z, number, 2);
            gradient_3(hash::words_3(i, j, k), x, y, z)
        });
        0.9820 * trilinear(&values, fade(x), fade(y), fade(z))
    }

    #[inline]
    fn random_offset(seed: usize) -> Self {
        Self::from_axes(|axis| OFFSETS[seed][axis])
    }

    #[inline]
    fn from_axes(mut value: impl FnMut(usize) -> f32) -> Self {
        Self::new(value(0), value(1), value(2))
    }
}

impl Coordinates for Vec4 {
    const AXES: usize = 4;

    #[inline]
    fn signed_noise(self) -> f32 {
        let (i, x) = cell(wrap_by_quotient(self.x));
        let (j, y) = cell(wrap_by_quotient(self.y));
        let (k, z) = cell(wrap_by_quotient(self.z));
        let (l, w) = cell(wrap_by_quotient(self.w));
        let gradient = |number: usize| {
            let (i, x) = corner(i, x, number, 0);
            let (j, y) = corner(j, y, number, 1);
            let (k, z) = corner(k, z, number, 2);
            let (l, w) = corner(l, w, number, 3);
            gradient_4(hash::words_4(i, j, k, l), x, y, z, w)
        };
        let near: [f32; 8] = std::array::from_fn(gradient);
        let far: [f32; 8] = std::array::from_fn(|number| gradient(number + 8));
        let fade_w = fade(w);
        let values: [f32; 8] = std::array::from_fn(|number| mix(near[number], far[number], fade_w));
        0.8344 * trilinear(&values, fade(x), fade(y), fade(z))
    }

    #[inline]
    fn random_offset(seed: usize) -> Self {
        Self::from_axes(|axis| OFFSETS[seed][axis])
    }

    #[inline]
    fn from_axes(mut value: impl FnMut(usize) -> f32) -> Self {
        Self::new(value(0), value(1), value(2), value(3))
    }
}

/// Between the eight corners of a cell, numbered with X in the lowest bit.
#[inline(always)]
fn trilinear(values: &[f32; 8], x: f32, y: f32, z: f32) -> f32 {
    let along_x: [f32; 4] = std::array::from_fn(|i| mix(values[2 * i], values[2 * i + 1], x));
    let along_y: [f32; 2] = std::array::from_fn(|i| mix(along_x[2 * i], along_x[2 * i + 1], y));
    mix(along_y[0], along_y[1], z)
}
