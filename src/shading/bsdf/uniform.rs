//! Directions that know nothing of the lobes, for studies.

use super::{Bsdf, BsdfSample, Entry, Scattering};
use crate::math::{Frame, warp};
use crate::shading::closure::BsdfFeatures;
use glam::Vec3;
use std::f32::consts::PI;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Draws a direction that knows nothing of the lobes: uniformly from the hemisphere above the surface, or
    /// from the sphere where light is let through. For studies; `pdf` stays that of [`sample`](Self::sample).
    /// What no such direction would meet (mirrors, clear glass) is drawn as ever, with a probability of its own.
    #[cold]
    #[inline(never)]
    pub fn sample_uniform(&self, u: Vec3) -> Option<BsdfSample> {
        let p_delta: f32 = self.others().iter().map(Self::p_delta).sum();
        if u.z < p_delta {
            return self.sample_delta(u);
        }
        let mut local = warp::sphere(u.truncate());
        // On coarse meshes some directions above the surface are below the triangle.
        let below = self.transmits() || self.smooth() != self.normals.geometric;
        if !below {
            local.z = local.z.abs();
        }
        let wi = Frame::from_normal(self.normals.geometric).to_world(local);
        let choice = (u.z - p_delta) / (1.0 - p_delta);
        let mut s = self.sample_towards(wi, choice)?;
        let solid_angle = if below { 4.0 } else { 2.0 } * PI;
        // The directions' own density in place of the lobes'.
        let scale = solid_angle / (1.0 - p_delta) * s.pdf;
        s.weight *= scale;
        s.diffuse *= scale;
        s.alone.0 *= scale;
        Some(s)
    }

    /// A direction that something else has drawn, as if [`sample`](Self::sample) had. A number chooses the kind.
    pub fn sample_towards(&self, wi: Vec3, choice: f32) -> Option<BsdfSample> {
        let v = self.evaluate(wi);
        if v.pdf <= 0.0 {
            return None;
        }
        // One of the kinds that could have brought it here, as probable as each is.
        let p_diffuse = v.diffuse_pdf / v.pdf;
        let beyond = self.is_beyond(wi);
        let (scattering, part, p) = if choice < p_diffuse {
            (Scattering::Diffuse, v.diffuse, p_diffuse)
        } else if beyond {
            (Scattering::Transmission, v.value, 1.0)
        } else {
            (Scattering::Glossy, v.value - v.diffuse, 1.0 - p_diffuse)
        };
        Some(BsdfSample {
            wi,
            weight: v.value / v.pdf,
            diffuse: v.diffuse / v.pdf,
            pdf: v.pdf,
            delta: false,
            beyond,
            scattering,
            alone: (part / (v.pdf * p), v.pdf * p),
            is_as_diffuse: false,
            is_translucent: false,
            alpha: 1.0,
        })
    }

    /// How probable [`Self::sample_uniform`] draws a lobe by itself: mirrors as ever; of what is straight only in part, half of
    /// the draws are tried so.
    pub(super) fn p_delta(entry: &Entry) -> f32 {
        match (entry.is_delta, entry.lobe.is_straight()) {
            (true, _) => entry.p,
            (false, true) => 0.5 * entry.p,
            (false, false) => 0.0,
        }
    }

    /// Draws one of the directions that no other could be, for [`Self::sample_uniform`].
    #[cold]
    #[inline(never)]
    fn sample_delta(&self, u: Vec3) -> Option<BsdfSample> {
        let mut choice = u.z;
        for (i, entry) in self.others().iter().enumerate() {
            let p = Self::p_delta(entry);
            if choice < p {
                let found = self.sample_lobe(i, entry, u.truncate(), choice / p);
                let mut s = found.filter(|s| s.delta)?;
                let scale = entry.p / p;
                s.weight *= scale;
                s.alone.0 *= scale;
                return Some(s);
            }
            choice -= p;
        }
        None
    }
}
