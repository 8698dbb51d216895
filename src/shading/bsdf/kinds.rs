//! What lobes have of lights that some kinds of rays do not see, as Cycles' light sampling tells them.

use super::{Bsdf, Sums};
use crate::scene::{RayKind, Visibility};
use crate::shading::closure::{BsdfFeatures, LobeValue};
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// The part of the value, and of its diffuse part, that is due to lobes which see a light; `backs`: as in
    /// [`Self::evaluate_sampled`].
    #[cold]
    #[inline(never)]
    pub fn seen_by_light(&self, light: Visibility, wi: Vec3, backs: bool) -> (Vec3, Vec3) {
        let transmitted = self.is_beyond(wi);
        if !transmitted && self.is_below(wi) && !(backs && self.is_seen_by_bump(wi)) {
            return (Vec3::ZERO, Vec3::ZERO);
        }
        let mut sums = Sums::ZERO;
        let mut add = |of: LobeValue, is_diffuse: bool| sums.add(of, 1.0, is_diffuse);
        if !transmitted && light.sees(RayKind::Diffuse) {
            add(self.value_of_base(wi), true);
        }
        for entry in self.others() {
            if entry.is_delta || !entry.lobe.is_lit(light, transmitted) {
                continue;
            }
            let of = entry.lobe.evaluate::<K>(self.smooth(), wi, transmitted);
            add(of, entry.is_diffuse);
            if (transmitted || entry.is_of_fibres) && backs {
                add(
                    entry.lobe.evaluate_backs::<K>(self.smooth(), wi),
                    entry.is_diffuse,
                );
            }
        }
        // What fibres have too much of is taken away: rounding may leave less than nothing.
        let (diffuse, others) = (sums.diffuse.value, sums.others.value.max(Vec3::ZERO));
        (diffuse + others, diffuse)
    }
}
