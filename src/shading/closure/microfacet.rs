//! Facets, and the reflection from them.

use super::{LobeSample, LobeValue, Normals};
use crate::math::{Frame, average};
use crate::shading::fresnel::{self, Fresnel};
use crate::shading::ggx::{self, Alpha};
use crate::shading::spread::{Ggx, Spread};
use glam::{Vec2, Vec3};
use std::fmt::Debug;
use std::marker::PhantomData;

/// Facets about a lobe's own normal, seen from a view.
#[derive(Clone, Copy, Debug)]
pub struct Facets<S = Ggx> {
    spread: PhantomData<S>,
    /// About the mean normal, bent so that mirrored views leave the surface; x along the tangent.
    frame: Frame,
    view: ggx::View,
    alpha: Alpha,
    bound: f32,
}

/// Reflectance and transmittance of the facets at one angle.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    pub(super) reflectance: Vec3,
    pub(super) transmittance: Vec3,
    pub(super) cos_t: f32,
}

impl Facet {
    /// Share of reflection among what a facet scatters.
    #[inline]
    pub(super) fn p_reflect(&self) -> f32 {
        let (r, t) = (average(self.reflectance), average(self.transmittance));
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }
}

impl<S: Spread> Facets<S> {
    /// About a normal, with the tangent for anisotropic ones. What they reflect below the surface is not drawn.
    #[inline(always)]
    pub fn new(
        normals: &Normals,
        normal: Vec3,
        tangent: Option<Vec3>,
        wo: Vec3,
        alpha: Alpha,
    ) -> Self {
        let bent = normals.bent(normal, wo);
        let frame = match tangent {
            Some(tangent) => Frame::from_normal_and_tangent(bent, tangent),
            None => Frame::from_normal(bent),
        };
        let local = frame.to_local(wo);
        Self {
            spread: PhantomData,
            frame,
            view: ggx::View::new(local, &alpha),
            alpha,
            bound: ggx::reflection_bound(local, &alpha),
        }
    }

    /// The same with all visible facets, for what lets light through.
    #[inline]
    pub fn unbounded(mut self) -> Self {
        self.bound = 1.0;
        self
    }

    /// Cosine of the view.
    #[inline]
    pub fn cos(&self) -> f32 {
        self.view.wo.z
    }

    /// The facets' mean normal.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.frame.z
    }

    /// The widths of their slopes.
    #[inline]
    pub(super) fn alpha(&self) -> &Alpha {
        &self.alpha
    }

    /// Whether the facets are a mirror.
    #[inline]
    pub fn is_smooth(&self) -> bool {
        self.alpha.is_smooth()
    }

    /// A bumped normal must not see light from the other side of the smooth surface, nor transmit to its own.
    #[inline]
    pub(super) fn is_behind_smooth(&self, smooth: Vec3, wi: Vec3, transmitted: bool) -> bool {
        let normal = self.frame.z;
        let is_across = || wi.dot(smooth) * normal.dot(smooth) < 0.0;
        normal != smooth && is_across() != transmitted
    }

    /// The view in the facets' frame.
    #[inline]
    pub(super) fn wo(&self) -> Vec3 {
        self.view.wo
    }

    /// To the facets' frame.
    #[inline]
    pub(super) fn local(&self, v: Vec3) -> Vec3 {
        self.frame.to_local(v)
    }

    /// From the facets' frame.
    #[inline]
    pub(super) fn world(&self, v: Vec3) -> Vec3 {
        self.frame.to_world(v).normalize()
    }

    /// Draws a visible facet: its normal and the cosine of the view to it.
    #[inline]
    pub(super) fn sample_normal(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let h = if self.is_smooth() {
            Vec3::Z
        } else {
            S::sample(&self.view, &self.alpha, self.bound, u)
        };
        let cos_h = self.view.wo.dot(h);
        (cos_h > 0.0).then_some((h, cos_h))
    }

    /// The density of reflections by all visible facets over that of [`Self::sample_normal`].
    #[inline]
    pub(super) fn share_of_all(&self) -> f32 {
        S::share_of_all(&self.view, self.bound)
    }

    /// D·G₂/(4 cosθ) and the density for the reflection at facets with normal `h` to `wi`.
    #[inline]
    pub(super) fn reflect(&self, h: Vec3, wi: Vec3) -> (f32, f32) {
        let d = ggx::d(h, &self.alpha);
        (
            0.25 * d * S::masking(h, wi, &self.view, &self.alpha),
            d * S::reflection_density(h, &self.view, &self.alpha, self.bound),
        )
    }

    /// The same for refraction by the relative index `eta`; also for facets of which `wo` or `wi` sees the back.
    #[inline]
    pub(super) fn refract(&self, h: Vec3, wi: Vec3, eta: f32) -> (f32, f32) {
        let (cos_o, cos_i) = (self.view.wo.dot(h), wi.dot(h));
        // Walter et al., eq. 17: the Jacobian of the half vector. Radiance is not scaled by η², as in
        // Cycles: what enters a solid leaves it again.
        let sum = cos_o + eta * cos_i;
        let ratio = eta / sum;
        let common = ggx::d(h, &self.alpha) * (cos_o * cos_i).abs() * ratio * ratio;
        (
            common * S::masking(h, wi, &self.view, &self.alpha),
            common * S::visible(h, &self.view, &self.alpha),
        )
    }

    /// Shares of an albedo that are reflected and that go through, by means over some of the angles under which facets are
    /// seen, the more the rougher the surface: so neither is zero where such light can be.
    pub(super) fn colors(
        &self,
        albedo: Vec3,
        tint: Vec3,
        facet: impl Fn(f32) -> Facet,
    ) -> [Vec3; 2] {
        let (mut reflected, mut transmitted) = (Vec3::ZERO, Vec3::ZERO);
        let alpha = self.alpha.xy.max_element();
        for (cos, share) in [
            (self.view.wo.z.max(0.0), 1.0 - alpha),
            (0.5, 0.5 * alpha),
            (1.0, 0.5 * alpha),
        ] {
            let f = facet(cos);
            reflected += f.reflectance * share;
            transmitted += f.transmittance * share;
        }
        shares_of(albedo, tint, (reflected, transmitted))
    }
}

/// What reflected and transmitted light is worth of an albedo, which knows of no tint.
pub(super) fn shares_of(
    albedo: Vec3,
    tint: Vec3,
    (mut reflected, mut transmitted): (Vec3, Vec3),
) -> [Vec3; 2] {
    for i in 0..3 {
        let untinted = if tint[i] > 0.0 {
            transmitted[i] / tint[i]
        } else {
            0.0
        };
        let sum = reflected[i] + untinted;
        if sum > 0.0 {
            reflected[i] *= albedo[i] / sum;
            transmitted[i] *= albedo[i] / sum;
        }
    }
    [reflected, transmitted]
}

/// Light reflected by facets: a metal, a glossy surface, or the dielectric layer over a diffuse base.
#[derive(Clone, Copy, Debug)]
pub struct Reflection<S = Ggx, F = Fresnel> {
    /// Weight of the lobe, with what further scatterings give back.
    pub weight: Vec3,
    /// The facets.
    pub facets: Facets<S>,
    /// How much a facet reflects.
    pub fresnel: F,
}

/// The reflectance of facets by the angle.
pub trait Reflectance: Copy + Debug {
    /// Under an angle to the facet.
    fn reflectance(&self, cos: f32) -> Vec3;
}

impl Reflectance for Fresnel {
    #[inline(always)]
    fn reflectance(&self, cos: f32) -> Vec3 {
        self.reflectance(cos)
    }
}

impl<S: Spread, F: Reflectance> Reflection<S, F> {
    /// Value and density.
    #[inline(always)]
    pub fn evaluate(&self, smooth: Vec3, wi_world: Vec3) -> LobeValue {
        let facets = &self.facets;
        let (wo, wi) = (facets.wo(), facets.local(wi_world));
        if wi.z <= 0.0 || facets.is_behind_smooth(smooth, wi_world, false) {
            return LobeValue::ZERO;
        }
        match (wo + wi).try_normalize() {
            Some(h) => self.at(h, wo.dot(h), wi),
            None => LobeValue::ZERO,
        }
    }

    #[inline]
    fn at(&self, h: Vec3, cos_h: f32, wi: Vec3) -> LobeValue {
        let (value, pdf) = self.facets.reflect(h, wi);
        LobeValue {
            value: self.weight * self.fresnel.reflectance(cos_h) * value,
            pdf,
        }
    }

    /// Draws a direction.
    #[inline(always)]
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let facets = &self.facets;
        let wo = facets.wo();
        let (h, cos_h) = facets.sample_normal(u)?;
        let local = h * (2.0 * cos_h) - wo;
        if local.z <= 0.0 {
            return None;
        }
        let wi = facets.world(local);
        let delta = facets.is_smooth();
        let of = if delta {
            LobeValue {
                value: self.weight * self.fresnel.reflectance(cos_h),
                pdf: 1.0,
            }
        } else if facets.is_behind_smooth(smooth, wi, false) {
            return None;
        } else {
            self.at(h, cos_h, local)
        };
        Some(LobeSample {
            wi,
            transmitted: false,
            delta,
            of,
        })
    }
}

/// A facet of a transmitting boundary at one angle: what it reflects, by the true Fresnel equations blended to a tint at
/// normal incidence, and what it lets through.
#[inline]
pub(super) fn transmitting_facet(
    cos_h: f32,
    (eta, f0, true_f0): (f32, Vec3, f32),
    (reflected, transmitted): (Vec3, Vec3),
) -> Facet {
    let true_f = fresnel::dielectric(cos_h, eta);
    let blend = fresnel::grazing_blend(true_f.reflectance, true_f0);
    let reflectance = if true_f.reflectance >= 1.0 {
        Vec3::ONE
    } else {
        f0 + (Vec3::ONE - f0) * blend
    };
    Facet {
        reflectance: reflected * reflectance,
        transmittance: transmitted * (Vec3::ONE - reflectance),
        cos_t: true_f.cos_t,
    }
}
