//! Diffuse lobes whose normal is turned away from the smooth one, as Cycles weighs them.

use super::Bsdf;
use crate::shading::closure::{BsdfFeatures, LobeValue};
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Whether the normal of a diffuse lobe is. Such a lobe draws directions in which it has no light (`bump_shadowing_term`).
    #[inline(always)]
    pub(super) fn is_turned(&self, normal: Vec3) -> bool {
        K::BUMPS && self.changes.behind && normal.dot(self.smooth()) < 0.0
    }

    /// What other lobes' directions know of a diffuse one. In Cycles they do not know of directions without light, although these
    /// know of them: light that both find counts more often than once.
    #[inline(always)]
    pub(super) fn known(&self, normal: Vec3, of: LobeValue) -> LobeValue {
        if of.value == Vec3::ZERO && self.is_turned(normal) {
            LobeValue::ZERO
        } else {
            of
        }
    }

    /// Adds the density of a direction of the base that [`Self::known`] has left out: it is drawn all the same.
    #[cold]
    #[inline(never)]
    pub(super) fn add_lost(&self, wi: Vec3, sum: &mut LobeValue) {
        let own = self.value_of_base(wi);
        if own.value == Vec3::ZERO {
            sum.pdf += (1.0 - self.p_others()) * own.pdf;
        }
    }
}
