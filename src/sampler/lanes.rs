//! The hashes of a point's coordinates on the processor's vectors of four words: the same bits as one by one, as the compiler makes of them
//! now and then, by what stands around them.

use glam::Vec4;
use wide::{i32x4, u32x4};

/// Four words.
pub(super) type Words = u32x4;

/// [`super::mix32`].
#[inline(always)]
pub(super) fn mix32(mut x: Words) -> Words {
    x = x ^ (x >> 16);
    x = x * Words::splat(0x7feb_352d);
    x = x ^ (x >> 15);
    x = x * Words::splat(0x846c_a68b);
    x ^ (x >> 16)
}

/// [`super::owen_64`] for 32 digits.
#[inline(always)]
pub(super) fn owen_32(mut x: Words, seed: Words) -> Words {
    x = x ^ (x * Words::splat(0x3d20_adea));
    x += seed;
    x = x * ((seed >> 16) | Words::splat(1));
    x = x ^ (x * Words::splat(0x0552_6c56));
    x ^ (x * Words::splat(0x53a2_2864))
}

/// Words whose digits stand in reverse order as numbers in [0, 1): [`super::unit`].
#[inline(always)]
pub(super) fn units(mut x: Words) -> Vec4 {
    let swap = |x: Words, by: u32, mask: u32| {
        let mask = Words::splat(mask);
        ((x >> by) & mask) | ((x & mask) << by)
    };
    x = swap(x, 1, 0x5555_5555);
    x = swap(x, 2, 0x3333_3333);
    x = swap(x, 4, 0x0f0f_0f0f);
    x = swap(x, 8, 0x00ff_00ff);
    x = (x >> 16) | (x << 16);
    let digits: i32x4 = bytemuck::cast(x >> 8);
    let units: [f32; 4] = digits.round_float().to_array();
    Vec4::from(units) * (1.0 / 16_777_216.0)
}

#[cfg(test)]
#[path = "../../tests/unit/sampler/lanes.rs"]
mod tests;
