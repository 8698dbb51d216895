//! What the values of an image stand for.

use super::{Image, ImageUse, Pixels};
use crate::ffi::values::{Place, Values};
use glam::Vec4;
use std::sync::{Arc, OnceLock};

impl Pixels {
    /// The texel that begins at a value, in RGBA: grey is of all colours, and what has no alpha is opaque.
    #[inline]
    pub fn texel(&self, channels: usize, at: usize) -> Vec4 {
        match self {
            Self::U8(p) => rgba(&p[..], channels, at, from_u8),
            Self::U16(p) => rgba(&p[..], channels, at, from_u16),
            Self::F32(p) => rgba(&p[..], channels, at, |v| v),
        }
    }

    /// Whether the colours are sRGB-encoded.
    pub fn is_encoded(&self, usage: ImageUse) -> bool {
        match usage {
            ImageUse::Color => !matches!(self, Self::F32(_)),
            ImageUse::Codes => true,
            ImageUse::Data => false,
        }
    }

    /// Memory that they take.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::U8(p) => p.len() as u64,
            Self::U16(p) => 2 * p.len() as u64,
            Self::F32(p) => 4 * p.len() as u64,
        }
    }

    /// Memory that they take for good; of those in a scratch file the system keeps what fits.
    pub fn bytes_in_memory(&self) -> u64 {
        if self.are_in_file() { 0 } else { self.bytes() }
    }

    /// Whether they lie in a scratch file.
    pub fn are_in_file(&self) -> bool {
        self.place() == Place::File
    }

    /// The same, bit for bit, in a scratch file.
    ///
    /// # Errors
    /// There is no room for one on a disk.
    pub fn in_file(&self) -> std::io::Result<Self> {
        Ok(match self {
            Self::U8(p) => Self::U8(Arc::new(Values::in_file(p)?)),
            Self::U16(p) => Self::U16(Arc::new(Values::in_file(p)?)),
            Self::F32(p) => Self::F32(Arc::new(Values::in_file(p)?)),
        })
    }

    /// Where they are.
    pub fn place(&self) -> Place {
        match self {
            Self::U8(p) => p.place(),
            Self::U16(p) => p.place(),
            Self::F32(p) => p.place(),
        }
    }

    /// Whether all bits are the same.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::U8(a), Self::U8(b)) => a == b,
            (Self::U16(a), Self::U16(b)) => a == b,
            // Not by value: what is not a number is not itself.
            (Self::F32(a), Self::F32(b)) => {
                bytemuck::cast_slice::<f32, u32>(a) == bytemuck::cast_slice::<f32, u32>(b)
            }
            _ => false,
        }
    }
}

/// What 8 bits stand for.
#[inline]
pub fn from_u8(value: u8) -> f32 {
    f32::from(value) * (1.0 / 255.0)
}

/// What 16 bits stand for.
#[inline]
pub fn from_u16(value: u16) -> f32 {
    f32::from(value) * (1.0 / 65535.0)
}

/// See [`Pixels::texel`].
#[inline]
pub fn rgba<T: Copy>(values: &[T], channels: usize, at: usize, number: impl Fn(T) -> f32) -> Vec4 {
    match (channels, &values[at..at + channels]) {
        (1, &[v]) => {
            let v = number(v);
            Vec4::new(v, v, v, 1.0)
        }
        (2, &[v, a]) => {
            let v = number(v);
            Vec4::new(v, v, v, number(a))
        }
        (3, &[r, g, b]) => Vec4::new(number(r), number(g), number(b), 1.0),
        (_, &[r, g, b, a, ..]) => Vec4::new(number(r), number(g), number(b), number(a)),
        _ => Vec4::ONE,
    }
}

impl Image {
    /// All texels in RGBA, as they are stored (colours may be encoded).
    pub fn texels(&self) -> impl Iterator<Item = Vec4> {
        let channels = self.channels.clamp(1, 4) as usize;
        let count = self.width as usize * self.height as usize;
        (0..count).map(move |i| self.pixels.texel(channels, i * channels))
    }
}

/// Linear colours of encoded ones; alpha stays.
#[inline]
pub fn decoded(value: Vec4) -> Vec4 {
    Vec4::new(
        srgb_to_linear(value.x),
        srgb_to_linear(value.y),
        srgb_to_linear(value.z),
        value.w,
    )
}

/// sRGB to linear (IEC 61966-2-1), tabulated: linear interpolation between 4096 points errs by
/// less than 2e-7 (step² / 8 · max f'' = (1/4096)² / 8 · 3.5).
#[inline]
fn srgb_to_linear(x: f32) -> f32 {
    const STEPS: usize = 4096;
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        (0..=STEPS)
            .map(|i| {
                let x = i as f64 / STEPS as f64;
                (if x <= 0.04045 {
                    x / 12.92
                } else {
                    ((x + 0.055) / 1.055).powf(2.4)
                }) as f32
            })
            .collect()
    });
    if x > 1.0 {
        // What is divided by a lesser opacity than its own.
        return ((x + 0.055) / 1.055).powf(2.4);
    }
    let x = x.clamp(0.0, 1.0) * STEPS as f32;
    let i = (x as usize).min(STEPS - 1);
    let t = x - i as f32;
    table[i] * (1.0 - t) + table[i + 1] * t
}

#[cfg(test)]
#[path = "../../tests/unit/scene/texel.rs"]
mod tests;
