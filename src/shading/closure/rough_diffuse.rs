//! Rough diffuse reflection: Fujii's Oren and Nayar model, with the energy of further scatterings as in OpenPBR
//! (Portsmouth, Kutz and Hill, *EON: A Practical Energy-Preserving Rough Diffuse BRDF*, JCGT 14(1), 2025).

use super::{LobeSample, LobeValue};
use crate::math::{Frame, warp};
use crate::scene::graph::ShaderRules;
use crate::shading::normal;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// Below this roughness the surface is Lambertian, as in Cycles.
pub const LEAST_ROUGHNESS: f32 = 1e-5;

/// A diffuse surface of V-shaped grooves.
#[derive(Clone, Copy, Debug)]
pub struct RoughDiffuse {
    /// Weight of the lobe.
    pub(super) weight: Vec3,
    /// Albedo of the grooves.
    color: Vec3,
    /// The lobe's own normal.
    pub normal: Vec3,
    wo: Vec3,
    a: f32,
    b: f32,
    /// What further scatterings bring, for this view.
    multiple: Vec3,
}

/// Fujii's integral of the groove term over all directions of light.
///
/// s/c·(1 − s³) is written with c = cosθ over (1 + s): 1 − s³ = (1 − s)(1 + s + s²) and (1 − s) = c²/(1 + s), so that nothing
/// divides by a grazing cosine, and the value there is π/2 − 2/3.
fn groove_albedo(cos: f32) -> f32 {
    let c = cos.clamp(0.0, 1.0);
    let s = ((1.0 - c) * (1.0 + c)).sqrt();
    s * (c.acos() - 2.0 / 3.0 - s * c) + 2.0 / 3.0 * s * c * (1.0 + s + s * s) / (1.0 + s)
}

/// Mean of [`groove_albedo`] over the cosine-weighted hemisphere, as the paper rounds it.
const AVERAGE_GROOVE_ALBEDO: f32 = (2.0 * PI - 5.6) / 3.0;
/// [`groove_albedo`] at grazing directions, its greatest value.
const GRAZING_GROOVE_ALBEDO: f32 = FRAC_PI_2 - 2.0 / 3.0;

impl RoughDiffuse {
    /// For a roughness of 0..=1, seen from `wo`.
    pub fn new(
        weight: Vec3,
        color: Vec3,
        (roughness, rules): (f32, ShaderRules),
        normal: Vec3,
        wo: Vec3,
    ) -> Self {
        let sigma = roughness.clamp(0.0, 1.0);
        let a = 1.0 / (PI + sigma * GRAZING_GROOVE_ALBEDO);
        let b = sigma * a;
        let mut lobe = Self {
            weight,
            color,
            normal,
            wo,
            a,
            b,
            multiple: Vec3::ZERO,
        };
        let missing = lobe.missing_on_average();
        let scale = FRAC_1_PI * (1.0 - missing) / missing * lobe.missing(normal.dot(wo));
        // The paper has the colour twice, and Cycles until 5.2 three times: 4 to 7 % less at a colour of 0.2 to 0.5.
        // All but one are 1 at most: colours above 1 come of images that are brightened.
        let kept = color.min(Vec3::ONE);
        let again = match rules {
            ShaderRules::Before53 => kept * kept,
            ShaderRules::Since53 => kept,
        };
        let further = color * again / (Vec3::ONE - kept * missing);
        lobe.multiple = further * scale;
        lobe
    }

    /// What single scattering from white grooves lacks of an albedo of 1, for a cosine. As a difference from grazing
    /// directions, where nothing lacks: 1 − aπ − b·G(c) would cancel.
    #[inline]
    fn missing(&self, cos: f32) -> f32 {
        self.b * (GRAZING_GROOVE_ALBEDO - groove_albedo(cos)).max(0.0)
    }

    /// Its cosine-weighted mean.
    fn missing_on_average(&self) -> f32 {
        self.b * (GRAZING_GROOVE_ALBEDO - AVERAGE_GROOVE_ALBEDO)
    }

    /// Albedo for the view, the weight included.
    pub fn albedo(&self) -> Vec3 {
        let single = self.color * (1.0 - self.missing(self.normal.dot(self.wo)));
        self.weight * (single + self.multiple * (PI * self.missing_on_average()))
    }

    /// Value and density.
    pub fn evaluate(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        let cos = wi.dot(self.normal);
        if cos <= 0.0 {
            return LobeValue::ZERO;
        }
        let cos_o = self.normal.dot(self.wo).max(0.0);
        let mut t = wi.dot(self.wo) - cos * cos_o;
        if t > 0.0 {
            t /= cos.max(cos_o);
        }
        // a ≥ b, and t ≥ −1: never below 0 but for roundings.
        let single = self.color * (self.a + self.b * t).max(0.0);
        let multiple = self.multiple * self.missing(cos);
        let mut value = self.weight * (single + multiple) * cos;
        if self.normal != smooth {
            value *= normal::bump_shadowing(smooth, self.normal, wi);
        }
        LobeValue {
            value,
            pdf: warp::cosine_hemisphere_pdf(cos),
        }
    }

    /// Draws a direction by the cosine.
    pub fn sample(&self, smooth: Vec3, u: Vec2) -> Option<LobeSample> {
        let wi = Frame::from_normal(self.normal).to_world(warp::cosine_hemisphere(u));
        let of = self.evaluate(smooth, wi);
        LobeSample::reflected(wi, of)
    }

    /// π · BSDF. Single scattering has at most a + b/cosθ of the colour, which grows toward grazing views; further scatterings
    /// at most 0.34.
    pub fn max_sample_weight(&self) -> f32 {
        let cos = self.normal.dot(self.wo).max(f32::MIN_POSITIVE);
        let most = PI * (self.a + self.b / cos) + 0.35;
        (self.weight * self.color).max_element() * most
    }
}
