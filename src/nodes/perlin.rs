//! Perlin's improved noise (Perlin 2002) in one to four dimensions, on the lattice and with the gradients of Blender's nodes.

use std::ops::{Add, Mul};

use wide::{CmpGt, CmpLt, f32x4};

use super::lanes::{self, Words};
use super::{fused, hash, mix};

/// A point in N dimensions, up to four; the axes beyond them are 0.
#[derive(Clone, Copy)]
pub(super) struct Point<const N: usize>(f32x4);

impl<const N: usize> Point<N> {
    /// A point of a coordinate for each axis.
    #[inline(always)]
    pub(super) fn from_axes(mut coordinate: impl FnMut(usize) -> f32) -> Self {
        let mut p = [0.0; 4];
        for (axis, x) in p.iter_mut().take(N).enumerate() {
            *x = coordinate(axis);
        }
        Self(f32x4::new(p))
    }
}

impl<const N: usize> Add for Point<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl<const N: usize> Mul<f32> for Point<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, scale: f32) -> Self {
        Self(self.0 * f32x4::splat(scale))
    }
}

/// What noise makes of a point.
pub(super) trait Noise: Copy + Add<Output = Self> + Mul<f32, Output = Self> {
    /// Noise from about −1 to 1.
    fn signed_noise(self) -> f32;

    /// An offset of 100 to 200 on each axis, which stands for a seed that the noise itself has not.
    fn random_offset(seed: usize) -> Self;

    /// The point moved along each axis by noise of that axis' seed.
    fn distorted(self, distortion: f32) -> Self;
}

/// How many seeds the nodes use: one for each axis' distortion, and one for each of two colour channels.
const SEEDS: usize = 6;

/// 100 to 200, of a hash of 0 to 1, rounded once: Cycles' is a fused multiplication and addition.
const fn offset(hash: f32) -> f32 {
    (100.0 + hash as f64 * 100.0) as f32
}

/// The offset in one dimension, for each seed.
const OFFSETS_1: [f32; SEEDS] = {
    let mut offsets = [0.0; SEEDS];
    let mut seed = 0;
    while seed < SEEDS {
        offsets[seed] = offset(hash::unit_1(seed as f32));
        seed += 1;
    }
    offsets
};

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

/// Each dimension has its gradients, and a scale found by experiment that brings their noise to about −1..1.
macro_rules! noise {
    ($dimensions:literal: $scale:literal * $gradients:ident of $wrap:ident) => {
        impl Noise for Point<$dimensions> {
            #[inline]
            fn signed_noise(self) -> f32 {
                $scale * $gradients(&axes(self.0, $wrap))
            }

            #[inline]
            fn random_offset(seed: usize) -> Self {
                Self::from_axes(|axis| {
                    if $dimensions == 1 {
                        OFFSETS_1[seed]
                    } else {
                        OFFSETS[seed][axis]
                    }
                })
            }

            fn distorted(self, distortion: f32) -> Self {
                if distortion == 0.0 {
                    return self;
                }
                self + Self::from_axes(|axis| {
                    (self + Self::random_offset(axis)).signed_noise() * distortion
                })
            }
        }
    };
}

noise!(1: 0.2500 * gradients_1 of wrap);
noise!(2: 0.6616 * gradients_2 of wrap);
noise!(3: 0.9820 * gradients_3 of wrap_by_quotient);
noise!(4: 0.8344 * gradients_4 of wrap_by_quotient);

/// The noise repeats at this distance on each axis, lest large coordinates lose their fraction.
const PERIOD: f32 = 100_000.0;

/// Coordinates of at least this size have no fraction to speak of, and are moved off the lattice, where noise is zero.
const LARGE: f32 = 1_000_000.0;

/// A coordinate within the period, by the exact remainder.
fn wrap(x: f32) -> f32 {
    x % PERIOD + off_lattice(x)
}

/// The same by a rounded quotient, as Cycles does in three and four dimensions.
fn wrap_by_quotient(x: f32) -> f32 {
    x - (x * (1.0 / PERIOD)).trunc() * PERIOD + off_lattice(x)
}

fn off_lattice(x: f32) -> f32 {
    if x.abs() >= LARGE { 0.5 } else { 0.0 }
}

/// The axes of a point on the lattice.
struct Axes {
    /// Numbers of the cell, and of the next one on each axis.
    cells: [[u32; 4]; 2],
    /// The place in the cell, as seen from either.
    places: [[f32; 4]; 2],
    /// The weight of the next cell.
    fades: [f32; 4],
}

/// The axes of a point; `wrap` brings large coordinates into the period.
#[inline(always)]
fn axes(mut p: f32x4, wrap: fn(f32) -> f32) -> Axes {
    // Adding it rounds to whole numbers, and the half keeps negative ones in the same binade. `floor` is a call where the
    // processor's instruction for it may be lacking.
    const WHOLE: f32 = 1.5 * (1 << 23) as f32;
    if !p.abs().cmp_lt(f32x4::splat(PERIOD)).all() {
        let within = |x: f32| if x.abs() < PERIOD { x } else { wrap(x) };
        p = f32x4::new(p.to_array().map(within));
    }
    let rounded = p + f32x4::splat(WHOLE);
    let nearest = rounded - f32x4::splat(WHOLE);
    let above = nearest.cmp_gt(p);
    let place = p - (nearest - (above & f32x4::ONE));
    // What is above has all bits set, which is −1.
    let cell = lanes::bits(rounded) - Words::splat(WHOLE.to_bits()) + lanes::bits(above);
    Axes {
        cells: [cell.to_array(), (cell + Words::splat(1)).to_array()],
        places: [place.to_array(), (place - f32x4::ONE).to_array()],
        fades: fade(place).to_array(),
    }
}

/// Perlin's quintic, whose first and second derivatives are zero at both ends; fused as in Cycles.
#[inline(always)]
fn fade(t: f32x4) -> f32x4 {
    let factor = |t: f32| fused(t, fused(t, 6.0, -15.0), 10.0);
    let [x, y, z, w] = t.to_array();
    (t * t) * (t * f32x4::new([factor(x), factor(y), factor(z), factor(w)]))
}

impl Axes {
    /// This one of the two cells on an axis, for four corners.
    #[inline(always)]
    fn at(&self, axis: usize, side: usize) -> (Words, f32x4) {
        (
            Words::splat(self.cells[side][axis]),
            f32x4::splat(self.places[side][axis]),
        )
    }

    /// The first and then the second, two corners each.
    #[inline(always)]
    fn slow(&self, axis: usize) -> (Words, f32x4) {
        let (a, b) = (self.cells[0][axis], self.cells[1][axis]);
        let (x, y) = (self.places[0][axis], self.places[1][axis]);
        (Words::new([a, a, b, b]), f32x4::new([x, x, y, y]))
    }

    /// The first and the second in turn.
    #[inline(always)]
    fn quick(&self, axis: usize) -> (Words, f32x4) {
        let (a, b) = (self.cells[0][axis], self.cells[1][axis]);
        let (x, y) = (self.places[0][axis], self.places[1][axis]);
        (Words::new([a, b, a, b]), f32x4::new([x, y, x, y]))
    }
}

/// Between the two ends of a cell, with slopes of 1 to 8, up or down.
#[inline(always)]
fn gradients_1(axes: &Axes) -> f32 {
    let gradient = |side: usize| {
        let hash = hash::words_1(axes.cells[side][0]);
        let slope = (1 + (hash & 7)) as f32;
        let slope = if hash & 8 == 0 { slope } else { -slope };
        slope * axes.places[side][0]
    };
    let (left, right) = (gradient(0), gradient(1));
    fused(axes.fades[0], right - left, left)
}

/// Between the four corners of a cell.
#[inline(always)]
fn gradients_2(axes: &Axes) -> f32 {
    let ((i, x), (j, y)) = (axes.slow(0), axes.quick(1));
    let values = lanes::gradient_2(lanes::words_2(i, j), x, y);
    bilinear(values, axes.fades[0], axes.fades[1])
}

/// Between the eight corners of a cell.
#[inline(always)]
fn gradients_3(axes: &Axes) -> f32 {
    let ((j, y), (k, z)) = (axes.slow(1), axes.quick(2));
    let gradient = |side: usize| {
        let (i, x) = axes.at(0, side);
        lanes::gradient_3(lanes::words_3(i, j, k), x, y, z)
    };
    let values = between(gradient(0), gradient(1), axes.fades[0]);
    bilinear(values, axes.fades[1], axes.fades[2])
}

/// Between the sixteen corners of a cell.
#[inline(always)]
fn gradients_4(axes: &Axes) -> f32 {
    let ((j, y), (k, z)) = (axes.slow(1), axes.quick(2));
    let gradient = |x_side: usize, w_side: usize| {
        let ((i, x), (l, w)) = (axes.at(0, x_side), axes.at(3, w_side));
        lanes::gradient_4(lanes::words_4(i, j, k, l), x, y, z, w)
    };
    let low = between(gradient(0, 0), gradient(0, 1), axes.fades[3]);
    let high = between(gradient(1, 0), gradient(1, 1), axes.fades[3]);
    let values = between(low, high, axes.fades[0]);
    bilinear(values, axes.fades[1], axes.fades[2])
}

/// Between four corners and four others.
#[inline(always)]
fn between(low: f32x4, high: f32x4, t: f32) -> f32x4 {
    low + (high - low) * f32x4::splat(t)
}

/// Between four corners, the `slow` axis first.
#[inline(always)]
fn bilinear(values: f32x4, slow: f32, quick: f32) -> f32 {
    let [a, b, c, d] = values.to_array();
    mix(mix(a, c, slow), mix(b, d, slow), quick)
}
