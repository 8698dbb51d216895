//! How rough a surface is to what it scatters to a direction.

use super::{Bsdf, BsdfSample, Sums};
use crate::math::average;
use crate::shading::{BsdfFeatures, Scattering};
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Whether a direction that a lobe has drawn counts as diffuse in Cycles, by a number `u`.
    ///
    /// Beside the diffuse density d a direction is diffuse there by d / (d + s g), where s g is the glossy density: all facets are drawn, and
    /// no lobe has a least share. Here it is by d / (d + g). Exact for one glossy lobe over a Lambertian one; several have one s, their mean.
    pub(super) fn is_as_diffuse(&self, scattering: Scattering, sums: &Sums, u: f32) -> bool {
        let (diffuse, glossy) = (sums.diffuse.pdf, sums.others.pdf);
        if scattering != Scattering::Glossy || diffuse <= 0.0 {
            return false;
        }
        let base = average(self.lambert.color);
        let (mut all, mut drawn) = (0.0, 0.0);
        for entry in self.others.iter().filter(|entry| !entry.is_diffuse) {
            let p = if base > 0.0 {
                entry.importance() * (1.0 - self.p_others) / base
            } else {
                entry.p
            };
            all += entry.p;
            drawn += p * entry.lobe.share_of_all_facets();
        }
        let share = if drawn < all { drawn / all } else { 1.0 };
        u * (diffuse + share * glossy) < diffuse * (1.0 - share)
    }

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

    /// The density of a direction where all visible facets are drawn, as in Cycles, whose Filter Glossy asks for it. Here none is
    /// drawn that reflects below the surface, so that the density of the others is greater.
    pub fn pdf_of_all_facets(&self, sample: &BsdfSample) -> f32 {
        let mut pdf = sample.pdf;
        if sample.scattering == Scattering::Transmission {
            return pdf;
        }
        for entry in self.others().iter().filter(|entry| !entry.is_delta) {
            let share = entry.lobe.share_of_all_facets();
            if share < 1.0 {
                let of = entry.lobe.evaluate::<K>(self.smooth(), sample.wi, false);
                pdf -= entry.p * of.pdf * (1.0 - share);
            }
        }
        pdf.max(0.0)
    }
}
