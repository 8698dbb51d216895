//! Reflection by facets of a Phong distribution (Ashikhmin and Shirley, *An Anisotropic Phong BRDF Model*, 2000), without its
//! Fresnel term, as Cycles has it; and their colleague's velvet (Ashikhmin, Premože and Shirley, *A Microfacet-Based BRDF
//! Generator*, 2000).

use super::microfacet::Facets;
use super::{LobeSample, LobeValue, Normals};
use crate::math::{Frame, sqr, warp};
use crate::shading::ggx::Alpha;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// The exponents' least width: smoother surfaces are mirrors.
const LEAST_ALPHA: f32 = 1e-4;

/// Reflection of one colour.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    /// Weight of the lobe.
    pub weight: Vec3,
    pub(super) facets: Facets,
    /// Exponents along the frame's x and y.
    exponents: Vec2,
}

impl Phong {
    /// For widths as those of GGX.
    pub fn new(
        weight: Vec3,
        normals: &Normals,
        (normal, tangent): (Vec3, Option<Vec3>),
        wo: Vec3,
        alpha: &Alpha,
    ) -> Self {
        let alpha = Alpha::anisotropic(alpha.xy.clamp(Vec2::splat(LEAST_ALPHA), Vec2::ONE));
        let facets = Facets::new(normals, normal, tangent, wo, alpha);
        Self {
            weight,
            facets,
            exponents: 2.0 / (alpha.xy * alpha.xy) - 2.0,
        }
    }

    /// Cosine of the view.
    pub fn cos(&self) -> f32 {
        self.facets.cos()
    }

    /// Whether it is a mirror.
    pub fn is_smooth(&self) -> bool {
        self.facets.alpha().xy.max_element() <= LEAST_ALPHA
    }

    /// Value and density.
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

    fn at(&self, h: Vec3, cos_h: f32, wi: Vec3) -> LobeValue {
        let Vec2 { x, y } = self.exponents;
        let squares = h.truncate() * h.truncate();
        let sine = squares.x + squares.y;
        // cos to the power of the exponent for this azimuth, by the sine: the cosine has no digits near 1.
        let exponent = if sine > 0.0 {
            squares.dot(self.exponents) / sine
        } else {
            x
        };
        let lobe = (0.5 * exponent * (-sine.min(1.0)).ln_1p()).exp();
        // Without light at exponent 0 and a sine of 1.
        let lobe = if lobe.is_nan() { 1.0 } else { lobe };
        let norm = ((x + 1.0) * (y + 1.0)).sqrt() / (8.0 * PI);
        let pdf = norm * lobe / cos_h.max(1e-6);
        let value = self.weight * (pdf * wi.z / self.facets.wo().z.max(wi.z));
        LobeValue { value, pdf }
    }

    /// Draws the normal of a facet, in the facets' frame.
    pub(super) fn draw(&self, u: Vec2) -> Vec3 {
        if self.is_smooth() {
            return Vec3::Z;
        }
        let Vec2 { x, y } = self.exponents;
        // Eq. 6: the azimuth, by quadrants, and the cosine for it.
        let quarter = 4.0 * u.x;
        let part = (FRAC_PI_2 * quarter.fract()).tan();
        let within = (((x + 1.0) / (y + 1.0)).sqrt() * part).atan();
        // Mirrored, so that each quadrant goes from the x axis to the y axis.
        let (sin_phi, cos_phi) = match quarter as u32 {
            0 => within,
            1 => PI - within,
            2 => PI + within,
            _ => TAU - within,
        }
        .sin_cos();
        let exponent = x * sqr(cos_phi) + y * sqr(sin_phi) + 1.0;
        // 1 − cos² by the logarithm, for sharp lobes.
        let log = u.y.max(f32::MIN_POSITIVE).ln() / exponent;
        let sine = (-(2.0 * log).exp_m1()).max(0.0).sqrt();
        Vec3::new(sine * cos_phi, sine * sin_phi, log.exp())
    }

    /// Draws a direction.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let facets = &self.facets;
        let wo = facets.wo();
        let h = self.draw(u);
        // A facet that the view sees from behind sends nothing anywhere by the paper. Cycles turns it round without
        // turning the cosine, so that light comes from between the view's mirror image and the facet's normal, with a
        // weight as if it had been reflected. Rough surfaces get 1 to 2 % of their light so.
        let cos_h = wo.dot(h).abs();
        let local = h * (2.0 * cos_h) - wo;
        if cos_h == 0.0 || local.z <= 0.0 {
            return None;
        }
        let wi = facets.world(local);
        let delta = self.is_smooth();
        let of = if delta {
            let (value, pdf) = (self.weight, 1.0);
            LobeValue { value, pdf }
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

/// Velvet: facets that stand on end.
#[derive(Clone, Copy, Debug)]
pub struct Velvet {
    pub(super) weight: Vec3,
    normal: Vec3,
    wo: Vec3,
    /// 1/σ².
    sharpness: f32,
}

impl Velvet {
    /// For a roughness 0..=1.
    pub fn new(weight: Vec3, roughness: f32, normal: Vec3, wo: Vec3) -> Self {
        Self {
            weight,
            normal,
            wo,
            sharpness: 1.0 / sqr(roughness.clamp(0.01, 1.0)),
        }
    }

    /// The lobe's own normal.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Value and density.
    pub fn evaluate(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        let (cos_o, cos_i) = (self.normal.dot(self.wo), self.normal.dot(wi));
        if cos_o <= 0.0
            || cos_i <= 0.0
            || (self.normal != smooth && wi.dot(smooth) * self.normal.dot(smooth) <= 0.0)
        {
            return LobeValue::ZERO;
        }
        let pdf = 1.0 / TAU;
        let h = (self.wo + wi).normalize_or(self.normal);
        let (cos_n, cos_h) = (self.normal.dot(h), self.wo.dot(h).abs());
        if cos_n >= 1.0 - 1e-5 || cos_h <= 1e-5 {
            let value = Vec3::ZERO;
            return LobeValue { value, pdf };
        }
        let sine = 1.0 - sqr(cos_n);
        let d = (-self.sharpness * sqr(cos_n) / sine).exp() * self.sharpness / (PI * sqr(sine));
        let open = 2.0 * (cos_n / cos_h).max(1e-5);
        let masking = (open * cos_o).min(open * cos_i).min(1.0);
        LobeValue {
            value: self.weight * (0.25 * d * masking / cos_o),
            pdf,
        }
    }

    /// Bound of the value over the density: the greatest density of facets, nothing masked.
    pub(super) fn max_sample_weight(&self) -> f32 {
        let cos_o = self.normal.dot(self.wo).max(1e-6);
        let at = |inverse: f32| sqr(inverse) * (-(inverse - 1.0) * self.sharpness).exp();
        let most = at((2.0 / self.sharpness).max(1.0)) * self.sharpness / PI;
        self.weight.max_element() * FRAC_PI_2 * most / cos_o
    }

    /// Draws a direction of the hemisphere, each alike.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let wi = Frame::from_normal(self.normal).to_world(warp::cone(u, 1.0));
        let of = self.evaluate(smooth, wi);
        LobeSample::reflected(wi, of)
    }
}
