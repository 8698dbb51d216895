//! The four corners of a lattice in the plane at once: lookup3 and the choice of gradients on the processor's vectors of four
//! words. The compiler finds vectors in loops of eight corners, not in these.

use wide::{f32x4, u32x4};

/// Four words or floats.
pub(super) type Words = u32x4;

#[inline(always)]
fn rotate<const BITS: u32>(x: Words) -> Words {
    (x << BITS) | (x >> (32 - BITS))
}

/// What lookup3 starts from, for so many words of key.
#[inline(always)]
fn seed(words: u32) -> Words {
    Words::splat(super::hash::seed(words))
}

/// `hash::finish` of four keys.
#[inline(always)]
fn finish(mut a: Words, mut b: Words, mut c: Words) -> Words {
    c = (c ^ b) - rotate::<14>(b);
    a = (a ^ c) - rotate::<11>(c);
    b = (b ^ a) - rotate::<25>(a);
    c = (c ^ b) - rotate::<16>(b);
    a = (a ^ c) - rotate::<4>(c);
    b = (b ^ a) - rotate::<14>(a);
    (c ^ b) - rotate::<24>(b)
}

/// Hashes of two words each.
#[inline(always)]
pub(super) fn words_2(x: Words, y: Words) -> Words {
    let start = seed(2);
    finish(start + x, start + y, start)
}

/// The bits of four floats.
#[inline(always)]
pub(super) fn bits(x: f32x4) -> Words {
    bytemuck::cast(x)
}

#[inline(always)]
fn floats(x: Words) -> f32x4 {
    bytemuck::cast(x)
}

/// `yes` where none of these bits of the hash is set, else `no`.
#[inline(always)]
fn unless(hash: Words, mask: u32, yes: Words, no: Words) -> Words {
    (hash & Words::splat(mask))
        .cmp_eq(Words::splat(0))
        .blend(yes, no)
}

/// `value`, with its sign changed if this bit of the hash is set.
#[inline(always)]
fn signed<const BIT: u32>(value: Words, hash: Words) -> f32x4 {
    floats(value ^ ((hash << (31 - BIT)) & Words::splat(1 << 31)))
}

/// Gradients of the plane: twice as steep along one axis.
#[inline(always)]
pub(super) fn gradient_2(hash: Words, x: f32x4, y: f32x4) -> f32x4 {
    let (x, y) = (bits(x), bits(y));
    let u = unless(hash, 4, x, y);
    let v = floats(unless(hash, 4, y, x));
    signed::<0>(u, hash) + signed::<1>(bits(v + v), hash)
}
