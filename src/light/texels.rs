//! The texels of an environment's image.

use crate::ffi::values::Values;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Linear texels of three channels.
#[derive(Clone, Debug)]
pub enum Texels {
    /// Shared with the scene's image if that has them so.
    Plain(Arc<Values<f32>>),
    /// The same numbers in a third of the memory: looking a texel up is waiting for memory.
    Packed(Vec<SharedExponent>),
}

/// Three numbers of eight bits with one exponent, as Radiance's files have them (Ward, *Real Pixels*, Graphics Gems II, 1991).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedExponent(u32);

impl SharedExponent {
    /// What is added to the exponent.
    const BIAS: i32 = 128;
    /// The least one whose unit is a normal number of f32: its stored exponent is 1.
    const LEAST: i32 = Self::TO_UNIT as i32 + 1;
    /// From the exponent to that of the unit as f32 stores it: both biases, and the eight bits.
    const TO_UNIT: u32 = 128 + 8 - 127;

    /// `None` if the numbers are not these, to the last bit.
    fn of(color: Vec3) -> Option<Self> {
        let largest = color.max_element();
        let exponent = match largest {
            0.0 => Self::LEAST,
            // The largest one is below 2 to this power, and not below half of that.
            _ => (largest.to_bits() >> 23) as i32 - 126 + Self::BIAS,
        };
        if !(color.is_finite() && (Self::LEAST..256).contains(&exponent)) {
            return None;
        }
        let exponent = exponent as u32;
        let units = color / Self::unit(exponent);
        let whole = units.cmpge(Vec3::ZERO).all() && units == units.floor();
        let [r, g, b] = units.to_array().map(|unit| unit as u32);
        let packed = Self(r | g << 8 | b << 16 | exponent << 24);
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        // Zeros may have a sign.
        (whole && bits(packed.unpacked()) == bits(color)).then_some(packed)
    }

    #[inline]
    fn unit(exponent: u32) -> f32 {
        f32::from_bits((exponent - Self::TO_UNIT) << 23)
    }

    #[inline]
    fn unpacked(self) -> Vec3 {
        let byte = |shift: u32| (self.0 >> shift & 0xff) as f32;
        Vec3::new(byte(0), byte(8), byte(16)) * Self::unit(self.0 >> 24)
    }
}

/// Larger images stay as they are: a packed one is beside that of the scene.
const MOST_PACKED: usize = 1 << 25;

impl Texels {
    #[inline]
    pub(super) fn at(&self, index: usize) -> Vec3 {
        match self {
            Self::Plain(channels) => Vec3::from_slice(&channels[3 * index..]),
            Self::Packed(texels) => texels[index].unpacked(),
        }
    }

    /// Packed, if all of them can be.
    pub(super) fn packed(self) -> Self {
        let packed = match &self {
            Self::Plain(channels)
                if channels.len() <= 3 * MOST_PACKED && !channels.are_in_file() =>
            {
                channels
                    .par_chunks_exact(3)
                    .map(|texel| SharedExponent::of(Vec3::from_slice(texel)))
                    .collect()
            }
            _ => None,
        };
        packed.map_or(self, Self::Packed)
    }
}

impl From<Arc<Values<f32>>> for Texels {
    fn from(channels: Arc<Values<f32>>) -> Self {
        Self::Plain(channels)
    }
}

impl From<Vec<Vec3>> for Texels {
    fn from(texels: Vec<Vec3>) -> Self {
        let channels: Vec<f32> = texels.iter().flat_map(Vec3::to_array).collect();
        Self::Plain(Arc::new(channels.into()))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/texels.rs"]
mod tests;
