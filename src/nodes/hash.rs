//! The hashes behind Blender's textures: Bob Jenkins' lookup3 (burtleburtle.net/bob/c/lookup3.c) on the bits of numbers, and
//! the PCG hashes of vectors (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").

use glam::{Vec2, Vec3, Vec4};

/// What lookup3 starts from, for so many words of key.
pub(super) const fn seed(words: u32) -> u32 {
    0xdead_beef_u32.wrapping_add(words << 2).wrapping_add(13)
}

/// lookup3's last mixing of three words; its third word is the hash.
#[inline(always)]
const fn finish(mut a: u32, mut b: u32, mut c: u32) -> u32 {
    c = (c ^ b).wrapping_sub(b.rotate_left(14));
    a = (a ^ c).wrapping_sub(c.rotate_left(11));
    b = (b ^ a).wrapping_sub(a.rotate_left(25));
    c = (c ^ b).wrapping_sub(b.rotate_left(16));
    a = (a ^ c).wrapping_sub(c.rotate_left(4));
    b = (b ^ a).wrapping_sub(a.rotate_left(14));
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

/// Hash of one word.
#[inline(always)]
pub(super) const fn words_1(x: u32) -> u32 {
    let start = seed(1);
    finish(start.wrapping_add(x), start, start)
}

/// Hash of two words.
#[inline(always)]
pub(super) const fn words_2(x: u32, y: u32) -> u32 {
    let start = seed(2);
    finish(start.wrapping_add(x), start.wrapping_add(y), start)
}

/// Hash of three words.
#[inline(always)]
pub(super) const fn words_3(x: u32, y: u32, z: u32) -> u32 {
    let start = seed(3);
    finish(
        start.wrapping_add(x),
        start.wrapping_add(y),
        start.wrapping_add(z),
    )
}

/// Hash of four words: lookup3 mixes the first three before it adds the fourth.
#[inline(always)]
pub(super) const fn words_4(x: u32, y: u32, z: u32, w: u32) -> u32 {
    let start = seed(4);
    let mut a = start.wrapping_add(x);
    let mut b = start.wrapping_add(y);
    let mut c = start.wrapping_add(z);
    a = a.wrapping_sub(c) ^ c.rotate_left(4);
    c = c.wrapping_add(b);
    b = b.wrapping_sub(a) ^ a.rotate_left(6);
    a = a.wrapping_add(c);
    c = c.wrapping_sub(b) ^ b.rotate_left(8);
    b = b.wrapping_add(a);
    a = a.wrapping_sub(c) ^ c.rotate_left(16);
    c = c.wrapping_add(b);
    b = b.wrapping_sub(a) ^ a.rotate_left(19);
    a = a.wrapping_add(c);
    c = c.wrapping_sub(b) ^ b.rotate_left(4);
    b = b.wrapping_add(a);
    finish(a.wrapping_add(w), b, c)
}

/// A hash as a number from 0 to 1, both included.
#[inline(always)]
pub(super) const fn unit(hash: u32) -> f32 {
    hash as f32 * (1.0 / 4_294_967_296.0)
}

/// One number to one, 0 to 1.
#[inline]
pub(super) const fn unit_1(x: f32) -> f32 {
    unit(words_1(x.to_bits()))
}

/// Two numbers to one.
#[inline]
pub(super) const fn unit_2(x: f32, y: f32) -> f32 {
    unit(words_2(x.to_bits(), y.to_bits()))
}

/// Three numbers to one.
#[inline]
pub(super) const fn unit_3(x: f32, y: f32, z: f32) -> f32 {
    unit(words_3(x.to_bits(), y.to_bits(), z.to_bits()))
}

/// Four numbers to one.
#[inline]
pub(super) const fn unit_4(x: f32, y: f32, z: f32, w: f32) -> f32 {
    unit(words_4(x.to_bits(), y.to_bits(), z.to_bits(), w.to_bits()))
}

/// A number to a colour.
#[inline]
pub(super) fn color_1(x: f32) -> Vec3 {
    Vec3::new(unit_1(x), unit_2(x, 1.0), unit_2(x, 2.0))
}

/// Two numbers to a colour.
#[inline]
pub(super) fn color_2(p: Vec2) -> Vec3 {
    Vec3::new(
        unit_2(p.x, p.y),
        unit_3(p.x, p.y, 1.0),
        unit_3(p.x, p.y, 2.0),
    )
}

/// Two numbers to two.
#[inline]
pub(super) fn units_2([x, y]: [f32; 2]) -> [f32; 2] {
    [unit_2(x, y), unit_3(x, y, 1.0)]
}

/// Four numbers to four, which differ by the order of the numbers.
#[inline]
pub(super) fn units_4([x, y, z, w]: [f32; 4]) -> [f32; 4] {
    [
        unit_4(x, y, z, w),
        unit_4(w, x, y, z),
        unit_4(z, w, x, y),
        unit_4(y, z, w, x),
    ]
}

/// Three numbers to a colour.
#[inline]
pub(super) fn color_3(p: Vec3) -> Vec3 {
    Vec3::new(
        unit_3(p.x, p.y, p.z),
        unit_4(p.x, p.y, p.z, 1.0),
        unit_4(p.x, p.y, p.z, 2.0),
    )
}

/// Four numbers to a colour: the channels differ by the order of the numbers.
#[inline]
pub(super) fn color_4(p: Vec4) -> Vec3 {
    Vec3::new(
        unit_4(p.x, p.y, p.z, p.w),
        unit_4(p.z, p.x, p.w, p.y),
        unit_4(p.w, p.z, p.y, p.x),
    )
}

/// One step of the PCG hashes on each number.
const fn lcg(x: i32) -> i32 {
    x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

/// The PCG hashes' result as numbers from 0 to 1. Blender leaves out the sign, and shifts with it.
#[inline(always)]
fn units<const N: usize>(v: [i32; N]) -> [f32; N] {
    v.map(|x| (x & 0x7fff_ffff) as f32 * (1.0 / 2_147_483_648.0))
}

/// Two whole numbers to two from 0 to 1.
#[inline(always)]
pub(super) fn pcg_2(v: [i32; 2]) -> [f32; 2] {
    let mix = |[mut x, mut y]: [i32; 2]| {
        x = x.wrapping_add(y.wrapping_mul(1_664_525));
        y = y.wrapping_add(x.wrapping_mul(1_664_525));
        [x, y]
    };
    units(mix(mix(v.map(lcg)).map(|x| x ^ (x >> 16))))
}

/// Three whole numbers to three from 0 to 1.
#[inline(always)]
pub(super) fn pcg_3(v: [i32; 3]) -> [f32; 3] {
    let mix = |[mut x, mut y, mut z]: [i32; 3]| {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        [x, y, z]
    };
    units(mix(mix(v.map(lcg)).map(|x| x ^ (x >> 16))))
}

/// Four whole numbers to four from 0 to 1.
#[inline(always)]
pub(super) fn pcg_4(v: [i32; 4]) -> [f32; 4] {
    let mix = |[mut x, mut y, mut z, mut w]: [i32; 4]| {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    units(mix(mix(v.map(lcg)).map(|x| x ^ (x >> 16))))
}
