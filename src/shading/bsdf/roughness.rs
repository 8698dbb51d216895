//! How rough a surface is to what it scatters to a direction.

use super::Bsdf;
use crate::shading::BsdfFeatures;
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// The root of the mean α² of the lobes that scatter to a direction, weighted by their densities there; 1 of lobes without
    /// facets.
    pub fn roughness_towards(&self, wi: Vec3) -> f32 {
        let transmitted = self.is_beyond(wi);
        let (mut all, mut sum) = (0.0, 0.0);
        let mut add = |pdf: f32, alpha: f32| {
            all += pdf;
            sum += pdf * alpha * alpha;
        };
        if !transmitted {
            let of = self.base().evaluate((self.smooth(), false), wi);
            add((1.0 - self.p_others()) * of.pdf, 1.0);
        }
        for entry in self.others() {
            if !entry.is_delta {
                let of = entry.lobe.evaluate::<K>(self.smooth(), wi, transmitted);
                add(entry.p * of.pdf, entry.lobe.alpha());
            }
        }
        if all > 0.0 { (sum / all).sqrt() } else { 0.0 }
    }
}
