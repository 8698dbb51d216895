//! A thin sheet that light goes through without being bent: glTF's transmission without a volume.

use super::glass::chosen;
use super::microfacet::{Facet, Facets, transmitting_facet};
use super::{LobeSample, LobeValue};
use glam::{Vec2, Vec3};

/// Reflection, and the same lobe mirrored to the other side.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Weight of what goes through, with what further scatterings give back.
    pub weight: Vec3,
    /// Weight of what is reflected.
    pub reflected: Vec3,
    /// Reflectance at normal incidence, tinted.
    pub f0: Vec3,
    /// Colour of what goes through.
    pub tint: Vec3,
    /// The index.
    pub eta: f32,
    /// Reflectance of `eta` at normal incidence.
    pub true_f0: f32,
    /// The facets.
    pub facets: Facets,
}

impl Sheet {
    #[inline]
    pub(super) fn facet(&self, cos_h: f32) -> Facet {
        transmitting_facet(
            cos_h,
            (self.eta, self.f0, self.true_f0),
            (self.reflected, self.weight * self.tint),
        )
    }

    /// Value and density.
    #[inline]
    pub fn evaluate(&self, smooth: Vec3, wi_world: Vec3, transmitted: bool) -> LobeValue {
        let facets = &self.facets;
        let (wo, mut wi) = (facets.wo(), facets.local(wi_world));
        if (wi.z < 0.0) != transmitted
            || wi.z == 0.0
            || facets.is_behind_smooth(smooth, wi_world, transmitted)
        {
            return LobeValue::ZERO;
        }
        wi.z = wi.z.abs();
        match (wo + wi).try_normalize() {
            Some(h) => self.at(&self.facet(wo.dot(h)), h, wi, transmitted),
            None => LobeValue::ZERO,
        }
    }

    /// For the direction on the viewer's side.
    #[inline]
    fn at(&self, f: &Facet, h: Vec3, mirrored: Vec3, transmitted: bool) -> LobeValue {
        let (value, pdf) = self.facets.reflect(h, mirrored);
        let way = chosen(f, f.p_reflect(), transmitted);
        LobeValue {
            value: way.value * value,
            pdf: way.pdf * pdf,
        }
    }

    /// Draws a direction.
    #[inline]
    pub fn sample(&self, smooth: Vec3, u: Vec2, choice: f32) -> Option<LobeSample> {
        let facets = &self.facets;
        let wo = facets.wo();
        let (h, cos_h) = facets.sample_normal(u)?;
        let f = self.facet(cos_h);
        let p_reflect = f.p_reflect();
        let transmitted = choice >= p_reflect;
        let reflected = h * (2.0 * cos_h) - wo;
        if reflected.z <= 0.0 {
            return None;
        }
        let wi = facets.world(if transmitted {
            Vec3::new(reflected.x, reflected.y, -reflected.z)
        } else {
            reflected
        });
        let delta = facets.is_smooth();
        let of = if delta {
            chosen(&f, p_reflect, transmitted)
        } else if facets.is_behind_smooth(smooth, wi, transmitted) {
            return None;
        } else {
            self.at(&f, h, reflected, transmitted)
        };
        Some(LobeSample {
            wi,
            transmitted,
            delta,
            of,
        })
    }
}
