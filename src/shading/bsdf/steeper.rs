//! Blender's Shadow Terminator, Shading Offset: light that grazes a surface counts less.

use super::{Bsdf, Sums};
use crate::shading::closure::BsdfFeatures;
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Whether light that grazes the surface counts less.
    #[inline(always)]
    pub(super) fn is_steeper(&self) -> bool {
        K::BUMPS && self.changes.steeper != 1.0
    }

    // Apart: a look at each lobe costs others half a percent of their instructions.
    #[cold]
    #[inline(never)]
    pub(super) fn steeper_sums(&self, left_out: usize, wi: Vec3, transmitted: bool) -> Sums {
        self.sums_by::<true>(left_out, wi, transmitted)
    }
}

/// What of reflected light is left where its angle θ to a lobe's normal counts as m·θ: cos(m·θ) / cos(θ), and nothing beyond a
/// quarter turn. Against edges of triangles in soft shadows, as Cycles has it (`shift_cos_in`).
#[cold]
pub(super) fn steepened(cos: f32, steeper: f32) -> f32 {
    if cos <= 0.0 {
        return 1.0;
    }
    let cos = cos.min(1.0);
    ((cos.acos() * steeper).cos() / cos).max(0.0)
}
