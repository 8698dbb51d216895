//! The boundary of a transmitting solid (Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007).

use super::microfacet::{Facet, Facets, shares_of, transmitting_facet};
use super::{LobeSample, LobeValue};
use crate::scene::graph::ShaderRules;
use crate::shading::spread::{Ggx, Spread};
use crate::shading::tables::{self, facet_blend, refract};
use crate::shading::thin_film::Film;
use glam::{Vec2, Vec3};
use std::fmt::Debug;

/// Reflection and refraction at facets.
#[derive(Clone, Copy, Debug)]
pub struct Glass<S = Ggx, F = ()> {
    /// Weight of what goes through, with what further scatterings give back.
    pub weight: Vec3,
    /// Weight of what is reflected.
    pub reflected: Vec3,
    /// Reflectance at normal incidence, tinted.
    pub f0: Vec3,
    /// Colour of what goes through.
    pub tint: Vec3,
    /// n(beyond)/n(here): the index from outside, its inverse from inside.
    pub eta: f32,
    /// Reflectance of `eta` at normal incidence.
    pub true_f0: f32,
    /// The facets.
    pub facets: Facets<S>,
    /// What lies on it.
    pub film: F,
}

/// What lies on a boundary.
pub trait Covering: Copy + Debug {
    /// The reflectance where something does, for a relative index and a reflectance at normal incidence.
    fn reflectance(&self, cos: f32, eta: f32, f0: Vec3) -> Option<Vec3>;
}

impl Covering for () {
    #[inline(always)]
    fn reflectance(&self, _: f32, _: f32, _: Vec3) -> Option<Vec3> {
        None
    }
}

impl Covering for Film {
    fn reflectance(&self, cos: f32, eta: f32, f0: Vec3) -> Option<Vec3> {
        Some(self.over_dielectric(cos, eta, f0))
    }
}

impl Glass {
    /// Shares of an albedo that are reflected and that go through, as Cycles tells them in its passes of colours.
    pub(super) fn colors(&self, albedo: Vec3) -> [Vec3; 2] {
        let facets = &self.facets;
        let view = (facets.cos(), facets.alpha().mean_roughness());
        let blend = facet_blend(view, self.eta, ShaderRules::Before53);
        let reflectance = self.f0 + (Vec3::ONE - self.f0) * blend;
        let transmitted = self.weight * self.tint * (Vec3::ONE - reflectance);
        shares_of(
            albedo,
            self.tint,
            (self.reflected * reflectance, transmitted),
        )
    }
}

impl<S: Spread> Glass<S> {
    /// The same under a film.
    #[cold]
    pub fn under(self, film: Film) -> Glass<S, Film> {
        let Self {
            weight,
            reflected,
            f0,
            tint,
            eta,
            true_f0,
            facets,
            film: (),
        } = self;
        Glass {
            weight,
            reflected,
            f0,
            tint,
            eta,
            true_f0,
            facets,
            film,
        }
    }
}

impl<S: Spread, F: Covering> Glass<S, F> {
    /// Whether light goes straight through.
    #[inline]
    pub(super) fn is_straight(&self) -> bool {
        tables::is_straight(self.eta)
    }

    #[inline]
    pub(super) fn facet(&self, cos_h: f32) -> Facet {
        let ways = (self.reflected, self.weight * self.tint);
        let plain = transmitting_facet(cos_h, (self.eta, self.f0, self.true_f0), ways);
        match self.film.reflectance(cos_h, self.eta, self.f0) {
            None => plain,
            Some(reflectance) => Facet {
                reflectance: ways.0 * reflectance,
                transmittance: ways.1 * (Vec3::ONE - reflectance),
                cos_t: plain.cos_t,
            },
        }
    }

    /// Value and density.
    #[inline(always)]
    pub fn evaluate(&self, smooth: Vec3, wi_world: Vec3, transmitted: bool) -> LobeValue {
        let facets = &self.facets;
        let (wo, wi) = (facets.wo(), facets.local(wi_world));
        if (wi.z < 0.0) != transmitted
            || wi.z == 0.0
            || facets.is_behind_smooth(smooth, wi_world, transmitted)
        {
            return LobeValue::ZERO;
        }
        if !transmitted {
            return match (wo + wi).try_normalize() {
                Some(h) => self.reflect(&self.facet(wo.dot(h)), h, wi),
                None => LobeValue::ZERO,
            };
        }
        match self.refracting(wi) {
            Some(h) if self.is_drawn(h, wi) => self.refract(&self.facet(wo.dot(h)), h, wi),
            _ => LobeValue::ZERO,
        }
    }

    /// What Cycles adds where a light is sampled beyond the surface: its formula does not ask whether both directions see
    /// the facets from the right sides. Nothing that draws directions finds this light. It matters at grazing angles: half of
    /// the sun's light in a rough ball is of this kind.
    #[inline]
    pub fn evaluate_backs(&self, smooth: Vec3, wi_world: Vec3) -> LobeValue {
        let facets = &self.facets;
        let wi = facets.local(wi_world);
        if wi.z >= 0.0 || facets.is_smooth() || facets.is_behind_smooth(smooth, wi_world, true) {
            return LobeValue::ZERO;
        }
        match self.refracting(wi) {
            Some(h) if !self.is_drawn(h, wi) => {
                self.refract(&self.facet(facets.wo().dot(h).abs()), h, wi)
            }
            _ => LobeValue::ZERO,
        }
    }

    /// Half vector of refraction (Walter et al., eq. 16), turned to the side of the viewer.
    #[inline]
    fn refracting(&self, wi: Vec3) -> Option<Vec3> {
        if self.is_straight() {
            return None;
        }
        let h = (self.facets.wo() + wi * self.eta).try_normalize()?;
        Some(if h.z < 0.0 { -h } else { h })
    }

    /// Whether a facet that is drawn refracts so: `wo` sees its front, `wi` its back.
    #[inline]
    fn is_drawn(&self, h: Vec3, wi: Vec3) -> bool {
        self.facets.wo().dot(h) > 0.0 && wi.dot(h) < 0.0
    }

    #[inline]
    fn reflect(&self, f: &Facet, h: Vec3, wi: Vec3) -> LobeValue {
        let (value, pdf) = self.facets.reflect(h, wi);
        LobeValue {
            value: f.reflectance * value,
            pdf: f.p_reflect() * pdf,
        }
    }

    #[inline]
    fn refract(&self, f: &Facet, h: Vec3, wi: Vec3) -> LobeValue {
        let (value, pdf) = self.facets.refract(h, wi, self.eta);
        LobeValue {
            value: f.transmittance * value,
            pdf: (1.0 - f.p_reflect()) * pdf,
        }
    }

    /// Draws a direction.
    #[inline(always)]
    pub fn sample(&self, smooth: Vec3, u: Vec2, choice: f32) -> Option<LobeSample> {
        let facets = &self.facets;
        let wo = facets.wo();
        let (h, cos_h) = facets.sample_normal(u)?;
        let f = self.facet(cos_h);
        let p_reflect = f.p_reflect();
        let transmitted = choice >= p_reflect;
        let straight = transmitted && self.is_straight();
        let local = if !transmitted {
            h * (2.0 * cos_h) - wo
        } else if straight {
            -wo
        } else {
            refract(wo, h, f.cos_t, self.eta)
        };
        if (local.z < 0.0) != transmitted || local.z == 0.0 {
            return None;
        }
        let wi = facets.world(local);
        let delta = straight || facets.is_smooth();
        let of = if delta {
            chosen(&f, p_reflect, transmitted)
        } else if facets.is_behind_smooth(smooth, wi, transmitted) {
            return None;
        } else if transmitted {
            self.refract(&f, h, local)
        } else {
            self.reflect(&f, h, local)
        };
        Some(LobeSample {
            wi,
            transmitted,
            delta,
            of,
        })
    }
}

/// Colour and probability of one of a facet's two ways.
#[inline]
pub(super) fn chosen(f: &Facet, p_reflect: f32, transmitted: bool) -> LobeValue {
    if transmitted {
        LobeValue {
            value: f.transmittance,
            pdf: 1.0 - p_reflect,
        }
    } else {
        LobeValue {
            value: f.reflectance,
            pdf: p_reflect,
        }
    }
}
