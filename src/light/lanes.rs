//! Numbers of several emitters side by side, on the processor's vectors.

use glam::Vec3;
pub use wide::f32x8 as Lanes;

/// So many stand side by side.
pub const LANES: usize = 8;

/// Vectors, a coordinate after the other.
#[derive(Clone, Copy, Debug)]
pub struct Lanes3(pub [Lanes; 3]);

impl Lanes3 {
    /// One for each lane.
    #[inline]
    pub fn of(vectors: [Vec3; LANES]) -> Self {
        Self([0, 1, 2].map(|axis| Lanes::from(vectors.map(|v| v[axis]))))
    }

    /// The same in all lanes.
    #[inline]
    pub fn splat(v: Vec3) -> Self {
        Self([v.x, v.y, v.z].map(Lanes::splat))
    }

    /// In the order of [`Vec3::dot`]: the same bits.
    #[inline]
    pub fn dot(&self, other: &Self) -> Lanes {
        let (Self([ax, ay, az]), Self([bx, by, bz])) = (*self, *other);
        ax * bx + ay * by + az * bz
    }

    /// Lane by lane.
    #[inline]
    pub fn minus(&self, other: &Self) -> Self {
        Self([0, 1, 2].map(|axis| self.0[axis] - other.0[axis]))
    }

    /// Each times a number.
    #[inline]
    pub fn times(&self, by: Lanes) -> Self {
        Self(self.0.map(|lanes| lanes * by))
    }
}

/// A mask of lanes.
pub fn mask(lanes: [bool; LANES]) -> Lanes {
    Lanes::from(lanes.map(|set| f32::from_bits(if set { u32::MAX } else { 0 })))
}

/// Sines from 0 to 1.
#[inline]
pub fn sin_from_cos(cos: Lanes) -> Lanes {
    (Lanes::ONE - cos * cos).fast_max(Lanes::ZERO).sqrt()
}
