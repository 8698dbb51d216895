//! Lobes of fibres, which know no side of a surface.

use super::{Bsdf, BsdfValue};
use crate::shading::closure::BsdfFeatures;
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Whether some lobe is of fibres.
    #[inline(always)]
    pub(super) fn has_fibres(&self) -> bool {
        K::TRANSMISSION && self.has_fibres
    }

    /// [`Self::evaluate_sampled`], where some lobe is of fibres.
    #[cold]
    #[inline(never)]
    pub(super) fn evaluate_sampled_fibres(&self, wi: Vec3) -> BsdfValue {
        let beyond = self.is_beyond(wi);
        let mut sums = self.sums(usize::MAX, wi, beyond);
        for entry in self.others().iter().filter(|entry| !entry.is_delta) {
            if beyond || entry.is_of_fibres {
                let of = entry.lobe.evaluate_backs::<K>(self.smooth(), wi);
                sums.add(of, entry.p, entry.is_diffuse);
            }
        }
        // What they have too much of is taken away: rounding may leave less than nothing.
        sums.others.value = sums.others.value.max(Vec3::ZERO);
        sums.others.pdf = sums.others.pdf.max(0.0);
        sums.total(K::FACETS)
    }

    /// The share of what is not scattered diffusely to a direction that passes have among what goes through.
    #[inline]
    pub fn through(&self, wi: Vec3) -> Vec3 {
        let beyond = self.is_beyond(wi);
        if self.has_fibres() {
            return self.through_with_fibres(wi, beyond);
        }
        if beyond { Vec3::ONE } else { Vec3::ZERO }
    }

    #[cold]
    #[inline(never)]
    fn through_with_fibres(&self, wi: Vec3, beyond: bool) -> Vec3 {
        let others = || self.others().iter().filter(|entry| !entry.is_diffuse);
        let mut kinds = others().map(|entry| entry.lobe.is_through(beyond));
        let first = kinds.next().unwrap_or(beyond);
        if kinds.all(|kind| kind == first) {
            return if first { Vec3::ONE } else { Vec3::ZERO };
        }
        let (mut through, mut all) = (Vec3::ZERO, Vec3::ZERO);
        for entry in others().filter(|entry| !entry.is_delta) {
            let value = entry.lobe.evaluate::<K>(self.smooth(), wi, beyond).value;
            all += value;
            if entry.lobe.is_through(beyond) {
                through += value;
            }
        }
        through / all.max(Vec3::splat(f32::MIN_POSITIVE))
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/bsdf/fibres.rs"]
mod tests;
