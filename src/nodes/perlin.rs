//! Perlin's improved noise (Perlin 2002) in one to four dimensions, on the lattice and with the gradients of Blender's nodes.

use std::ops::{Add, Mul};

use pulp::NullaryFnOnce;
use wide::{CmpGt, CmpLt, f32x4, f32x8, u32x4, u32x8};

use super::{fused, hash, lanes, mix, on_vectors};

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

/// Noise of each axis' seed, on that axis.
struct Offsets<const N: usize>(Point<N>);

impl<const N: usize> NullaryFnOnce for Offsets<N>
where
    Point<N>: Noise,
{
    type Output = Point<N>;

    #[inline(always)]
    fn call(self) -> Point<N> {
        let mut noise = [0.0; 4];
        for (axis, noise) in noise.iter_mut().enumerate().take(N) {
            *noise = (self.0 + Point::random_offset(axis)).signed_noise();
        }
        Point(f32x4::new(noise))
    }
}

/// What brings the noise of two dimensions to about −1..1.
const SCALE_2: f32 = 0.6616;
/// The same of three dimensions.
const SCALE_3: f32 = 0.9820;

/// Each dimension has its gradients, and a scale found by experiment that brings their noise to about −1..1.
macro_rules! noise {
    ($dimensions:literal: $scale:tt * $gradients:ident of $wrap:ident) => {
        impl Noise for Point<$dimensions> {
            #[inline(always)]
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

            #[inline(always)]
            fn distorted(self, distortion: f32) -> Self {
                // Most are not, and a call takes longer than the question.
                if distortion == 0.0 {
                    return self;
                }
                self + on_vectors(Offsets(self)) * distortion
            }
        }
    };
}

noise!(1: 0.2500 * gradients_1 of wrap);
noise!(2: SCALE_2 * gradients_2 of wrap);
noise!(3: SCALE_3 * gradients_3 of wrap_by_quotient);
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
    /// The number of the cell.
    cell: [u32; 4],
    /// The place in it.
    place: [f32; 4],
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
    let words: fn(f32x4) -> u32x4 = bytemuck::cast;
    // What is above has all bits set, which is −1.
    let cell = words(rounded) - u32x4::splat(WHOLE.to_bits()) + words(above);
    Axes {
        cell: cell.to_array(),
        place: place.to_array(),
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
    /// One of the two cells on an axis, and the place as seen from there.
    #[inline(always)]
    fn side(&self, axis: usize, number: usize) -> (u32, f32) {
        (
            self.cell[axis].wrapping_add(number as u32),
            self.place[axis] - number as f32,
        )
    }
}

/// The words and places of the eight corners along three axes, the first of which changes slowest.
#[inline(always)]
fn cube(axes: &Axes) -> ([u32x8; 3], [f32x8; 3]) {
    const SIDES: [[u32; 8]; 3] = [
        [0, 0, 0, 0, 1, 1, 1, 1],
        [0, 0, 1, 1, 0, 0, 1, 1],
        [0, 1, 0, 1, 0, 1, 0, 1],
    ];
    let words = |axis: usize| u32x8::splat(axes.cell[axis]) + u32x8::new(SIDES[axis]);
    let places = |axis: usize| {
        f32x8::splat(axes.place[axis]) - f32x8::new(SIDES[axis].map(|side| side as f32))
    };
    (
        [words(0), words(1), words(2)],
        [places(0), places(1), places(2)],
    )
}

/// `value`, with its sign changed if this bit of the hash is set.
#[inline(always)]
fn signed<const BIT: u32>(value: f32, hash: u32) -> f32 {
    f32::from_bits(value.to_bits() ^ ((hash << (31 - BIT)) & (1 << 31)))
}

/// Between the two ends of a cell, with slopes of 1 to 8, up or down.
#[inline(always)]
fn gradients_1(axes: &Axes) -> f32 {
    let gradient = |number: usize| {
        let (i, x) = axes.side(0, number);
        let hash = hash::words_1(i);
        signed::<3>((1 + (hash & 7)) as f32, hash) * x
    };
    let (left, right) = (gradient(0), gradient(1));
    fused(axes.fades[0], right - left, left)
}

/// Between the four corners of a cell.
#[inline(always)]
fn gradients_2(axes: &Axes) -> f32 {
    let (hash, places) = square(axes);
    between_2(hash, places, axes)
}

/// Hashes of the four corners of a cell, and the place as seen from them.
#[inline(always)]
fn square(axes: &Axes) -> (u32x4, [f32x4; 2]) {
    let [(a, x), (b, next_x)] = [0, 1].map(|number| axes.side(0, number));
    let [(c, y), (d, next_y)] = [0, 1].map(|number| axes.side(1, number));
    let hash = lanes::words_2(u32x4::new([a, a, b, b]), u32x4::new([c, d, c, d]));
    let places = [[x, x, next_x, next_x], [y, next_y, y, next_y]];
    (hash, places.map(f32x4::new))
}

/// What gradients by these hashes give at the place.
#[inline(always)]
fn between_2(hash: u32x4, [x, y]: [f32x4; 2], axes: &Axes) -> f32 {
    let values = lanes::gradient_2(hash, x, y);
    bilinear(values.to_array(), axes.fades[0], axes.fades[1])
}

/// Between the eight corners of a cell: Perlin's twelve edges of the cube, four of them twice.
#[inline(always)]
fn gradients_3(axes: &Axes) -> f32 {
    let ([i, j, k], places) = cube(axes);
    trilinear(lanes::gradient_3(lanes::words_3(i, j, k), places), axes)
}

/// Noise of three numbers, by other bytes of the hashes that gradients are chosen by. `flat`: the third coordinate does not count.
pub(super) fn three(place: glam::Vec3, flat: bool) -> glam::Vec3 {
    let p = place.to_array();
    let bits = [0u32, 8, 16];
    glam::Vec3::from(if flat {
        let axes = axes(Point::<2>::from_axes(|axis| p[axis]).0, wrap);
        let (hash, places) = square(&axes);
        bits.map(|bits| SCALE_2 * between_2(hash >> bits, places, &axes))
    } else {
        let axes = axes(Point::<3>::from_axes(|axis| p[axis]).0, wrap_by_quotient);
        let ([i, j, k], places) = cube(&axes);
        let hash = lanes::words_3(i, j, k);
        bits.map(|bits| SCALE_3 * trilinear(lanes::gradient_3(hash >> bits, places), &axes))
    })
}

/// Between the sixteen corners of a cell: edges of the cube in four dimensions, of which one axis is left out.
#[inline(always)]
fn gradients_4(axes: &Axes) -> f32 {
    let ([i, j, k], [x, y, z]) = cube(axes);
    let side = |number: usize| {
        let (l, w) = axes.side(3, number);
        let hash = lanes::words_4(i, j, k, u32x8::splat(l));
        lanes::gradient_4(hash, [x, y, z, f32x8::splat(w)])
    };
    trilinear(mix(side(0), side(1), axes.fades[3]), axes)
}

/// Between the eight corners of [`cube`].
#[inline(always)]
fn trilinear(corners: f32x8, axes: &Axes) -> f32 {
    let [before, after]: [f32x4; 2] = bytemuck::cast(corners);
    let values = mix(before, after, axes.fades[0]);
    bilinear(values.to_array(), axes.fades[1], axes.fades[2])
}

/// Between four corners, the `slow` axis first.
#[inline(always)]
fn bilinear([a, b, c, d]: [f32; 4], slow: f32, quick: f32) -> f32 {
    mix(mix(a, c, slow), mix(b, d, slow), quick)
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/perlin.rs"]
mod tests;
