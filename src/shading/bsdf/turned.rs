//! Diffuse lobes whose normal is turned away from the smooth one, as Cycles weighs them.

use super::Bsdf;
use crate::shading::closure::{BsdfFeatures, LobeValue};
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Whether a diffuse lobe draws a direction where it has no light (`bump_shadowing_term`), as its normal is turned away.
    #[inline(always)]
    pub(super) fn is_lost(&self, normal: Vec3, of: LobeValue) -> bool {
        K::BUMPS && self.changes.behind && of.value == Vec3::ZERO && normal.dot(self.smooth()) < 0.0
    }

    /// What other lobes' directions know of a diffuse one. In Cycles they do not know of directions that are lost, although these
    /// know of them: light that both find counts more often than once.
    #[inline(always)]
    pub(super) fn known(&self, normal: Vec3, of: LobeValue) -> LobeValue {
        if self.is_lost(normal, of) {
            LobeValue::ZERO
        } else {
            of
        }
    }
}
