//! Corners of the lattice side by side: lookup3 and the choice of gradients on the processor's vectors of words. Written out, as
//! it depends on the compiler's settings whether it finds vectors in a loop of corners.

use std::ops::{Add, BitAnd, BitOr, BitXor, Shl, Shr, Sub};

use wide::{f32x4, f32x8, u32x4, u32x8};

/// Words side by side, one for each corner.
pub(super) trait Words:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// Floats of the same bits.
    type Floats: Copy + Add<Output = Self::Floats>;

    fn splat(word: u32) -> Self;
    fn of(floats: Self::Floats) -> Self;
    fn floats(self) -> Self::Floats;
    /// `yes` where these are the same, else `no`.
    fn choose(self, other: Self, yes: Self, no: Self) -> Self;
}

macro_rules! words {
    ($words:ty, $floats:ty) => {
        impl Words for $words {
            type Floats = $floats;

            #[inline(always)]
            fn splat(word: u32) -> Self {
                <$words>::splat(word)
            }

            #[inline(always)]
            fn of(floats: $floats) -> Self {
                bytemuck::cast(floats)
            }

            #[inline(always)]
            fn floats(self) -> $floats {
                bytemuck::cast(self)
            }

            #[inline(always)]
            fn choose(self, other: Self, yes: Self, no: Self) -> Self {
                self.cmp_eq(other).blend(yes, no)
            }
        }
    };
}

words!(u32x4, f32x4);
words!(u32x8, f32x8);

#[inline(always)]
fn rotate<W: Words>(x: W, bits: u32) -> W {
    (x << bits) | (x >> (32 - bits))
}

/// What lookup3 starts from, for so many words of key.
#[inline(always)]
fn seed<W: Words>(words: u32) -> W {
    W::splat(super::hash::seed(words))
}

/// `hash::finish` of as many keys.
#[inline(always)]
fn finish<W: Words>(mut a: W, mut b: W, mut c: W) -> W {
    c = (c ^ b) - rotate(b, 14);
    a = (a ^ c) - rotate(c, 11);
    b = (b ^ a) - rotate(a, 25);
    c = (c ^ b) - rotate(b, 16);
    a = (a ^ c) - rotate(c, 4);
    b = (b ^ a) - rotate(a, 14);
    (c ^ b) - rotate(b, 24)
}

/// Hashes of two words each.
#[inline(always)]
pub(super) fn words_2<W: Words>(x: W, y: W) -> W {
    let start = seed::<W>(2);
    finish(start + x, start + y, start)
}

/// Hashes of three words each.
#[inline(always)]
pub(super) fn words_3<W: Words>(x: W, y: W, z: W) -> W {
    let start = seed::<W>(3);
    finish(start + x, start + y, start + z)
}

/// Hashes of four words each, as `hash::words_4` mixes them.
#[inline(always)]
pub(super) fn words_4<W: Words>(x: W, y: W, z: W, w: W) -> W {
    let start = seed::<W>(4);
    let (mut a, mut b, mut c) = (start + x, start + y, start + z);
    a = (a - c) ^ rotate(c, 4);
    c = c + b;
    b = (b - a) ^ rotate(a, 6);
    a = a + c;
    c = (c - b) ^ rotate(b, 8);
    b = b + a;
    a = (a - c) ^ rotate(c, 16);
    c = c + b;
    b = (b - a) ^ rotate(a, 19);
    a = a + c;
    c = (c - b) ^ rotate(b, 4);
    b = b + a;
    finish(a + w, b, c)
}

/// `yes` where none of these bits of the hash is set, else `no`.
#[inline(always)]
fn unless<W: Words>(hash: W, mask: u32, yes: W, no: W) -> W {
    (hash & W::splat(mask)).choose(W::splat(0), yes, no)
}

/// `value`, with its sign changed if this bit of the hash is set.
#[inline(always)]
fn signed<W: Words>(value: W, hash: W, bit: u32) -> W::Floats {
    (value ^ ((hash << (31 - bit)) & W::splat(1 << 31))).floats()
}

/// Gradients of the plane: twice as steep along one axis.
#[inline(always)]
pub(super) fn gradient_2<W: Words>(hash: W, x: W::Floats, y: W::Floats) -> W::Floats {
    let (x, y) = (W::of(x), W::of(y));
    let u = unless(hash, 4, x, y);
    let v = unless(hash, 4, y, x).floats();
    signed(u, hash, 0) + signed(W::of(v + v), hash, 1)
}

/// Gradients of space: the twelve edges of the cube, four of them twice.
#[inline(always)]
pub(super) fn gradient_3<W: Words>(hash: W, [x, y, z]: [W::Floats; 3]) -> W::Floats {
    let (x, y, z) = (W::of(x), W::of(y), W::of(z));
    let u = unless(hash, 8, x, y);
    let other = (hash & W::splat(13)).choose(W::splat(12), x, z);
    let v = unless(hash, 12, y, other);
    signed(u, hash, 0) + signed(v, hash, 1)
}

/// Gradients of four dimensions: edges of the cube there, of which one axis is left out.
#[inline(always)]
pub(super) fn gradient_4<W: Words>(hash: W, [x, y, z, w]: [W::Floats; 4]) -> W::Floats {
    let (x, y, z, w) = (W::of(x), W::of(y), W::of(z), W::of(w));
    // Of 0 to 31, these are the numbers below 24, 16 and 8.
    let u = (hash & W::splat(24)).choose(W::splat(24), y, x);
    let v = unless(hash, 16, y, z);
    let s = unless(hash, 24, z, w);
    signed(u, hash, 0) + signed(v, hash, 1) + signed(s, hash, 2)
}
