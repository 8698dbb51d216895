//! From where a surface is lit, for the choice between lights.

use super::Bsdf;
use crate::shading::closure::BsdfFeatures;
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Normal for the estimate of which lights matter, `None` where light from both sides does; and Cycles' for the same, with whether
    /// light from both sides does.
    #[inline]
    pub fn receiving(&self) -> (Option<Vec3>, (Vec3, bool)) {
        (
            self.receiving_normal(),
            (self.smooth(), self.is_lit_behind()),
        )
    }

    pub(super) fn receiving_normal(&self) -> Option<Vec3> {
        let normal = self.normal();
        let bent = K::BUMPS && (normal != self.smooth() || normal != self.normals.shading);
        let agree = !self.is_lit_behind() && !bent && (!K::FACETS || self.agrees);
        agree.then_some(normal)
    }

    /// Whether some lobe is lit from the other side.
    #[inline(always)]
    fn is_lit_behind(&self) -> bool {
        K::TRANSMISSION && self.is_lit_behind
    }
}
