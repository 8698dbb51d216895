//! What a BSDF scatters, in shares of the light.

use super::{Bsdf, BsdfFeatures, Entry};
use crate::math::average;
use crate::shading::closure::Lobe;
use glam::Vec3;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Shares of light that are scattered diffusely, reflected otherwise, and let through: what passes divide
    /// their light by.
    pub fn colors(&self) -> [Vec3; 3] {
        let mut sums = [self.lambert.color, Vec3::ZERO, Vec3::ZERO];
        for Entry { lobe, albedo, .. } in self.others() {
            if lobe.is_diffuse() {
                sums[0] += *albedo;
                continue;
            }
            let [reflected, transmitted] = lobe.colors(*albedo);
            sums[1] += reflected;
            sums[2] += transmitted;
        }
        sums
    }

    /// The lobes, but Lambert's, that scatter light diffusely at the surface, not below it.
    fn diffuse(&self) -> impl Iterator<Item = &Entry> {
        let is = |lobe: &Lobe| lobe.is_diffuse() && !matches!(lobe, Lobe::Below(_));
        self.others().iter().filter(move |entry| is(&entry.lobe))
    }

    /// The share of light that is scattered diffusely at the surface.
    pub fn diffuse_color(&self) -> Vec3 {
        let others = self.diffuse().map(|entry| entry.albedo);
        others.fold(self.lambert.color, |sum, albedo| sum + albedo)
    }

    /// The mean normal of what does; that of the surface where nothing does.
    pub fn diffuse_normal(&self) -> Vec3 {
        let lambert = self.normal() * average(self.lambert.color);
        let sum = self.diffuse().fold(lambert, |sum, entry| {
            sum + entry.lobe.normal() * average(entry.albedo)
        });
        sum.try_normalize().unwrap_or(self.normals.shading)
    }
}
