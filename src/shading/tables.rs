//! Directional albedos of rough surfaces, tabulated: what a single scattering at the microfacets
//! loses is put back by scaling (Turquin, *Practical multiple scattering compensation for
//! microfacet models*, 2019; the average Fresnel term after Kulla and Conty, *Revisiting
//! Physically Based Shading at Imageworks*, 2017).
//!
//! The tables are integrated when a scene first needs them, not shipped.

use super::{fresnel, ggx};
use crate::math::mix;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Points of the grid along each axis.
const GRID: usize = 32;
/// Points along each axis of the quadrature over visible normals.
const NODES: usize = 48;

/// A function of (cosθ, roughness) on a grid; cosθ is spaced by its square root, where the
/// functions bend most, and read bilinearly.
#[derive(Clone, Debug)]
pub struct Table {
    values: Vec<f32>,
}

impl Table {
    fn tabulate(f: impl Fn(f32, f32) -> f32 + Sync) -> Self {
        let step = 1.0 / (GRID - 1) as f32;
        let values = (0..GRID * GRID)
            .into_par_iter()
            .map(|i| {
                let cos = ((i % GRID) as f32 * step).powi(2);
                f(cos.max(1e-6), (i / GRID) as f32 * step)
            })
            .collect();
        Self { values }
    }

    /// Reads the table.
    #[inline]
    pub fn read(&self, cos: f32, roughness: f32) -> f32 {
        let cell = |x: f32| {
            let x = x.clamp(0.0, 1.0) * (GRID - 1) as f32;
            let i = (x as usize).min(GRID - 2);
            (i, x - i as f32)
        };
        let (i, s) = cell(cos.max(0.0).sqrt());
        let (j, t) = cell(roughness);
        let at = |i: usize, j: usize| self.values[j * GRID + i];
        mix(
            mix(at(i, j), at(i + 1, j), s),
            mix(at(i, j + 1), at(i + 1, j + 1), s),
            t,
        )
    }

    /// ∫ 2μ·table dμ for a roughness.
    fn average(&self, roughness: f32) -> f32 {
        let n = 256;
        (0..n)
            .map(|k| {
                let mu = (k as f32 + 0.5) / n as f32;
                2.0 * mu * self.read(mu, roughness)
            })
            .sum::<f32>()
            / n as f32
    }
}

/// Integrates a weight over the visible normals at a view direction: `weight(wo, h)` is averaged.
fn over_visible_normals(cos: f32, roughness: f32, weight: impl Fn(Vec3, Vec3) -> f32) -> f32 {
    let alpha = (roughness * roughness).max(ggx::SMOOTH_ALPHA);
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let mut sum = 0f64;
    for i in 0..NODES * NODES {
        let u = Vec2::new(
            ((i % NODES) as f32 + 0.5) / NODES as f32,
            ((i / NODES) as f32 + 0.5) / NODES as f32,
        );
        let h = ggx::sample_visible_normal(wo, alpha, 1.0, u);
        sum += f64::from(weight(wo, h));
    }
    (sum / (NODES * NODES) as f64) as f32
}

/// G2/G1 for a reflected direction: the estimator's weight with reflectance 1 (0 below the surface).
fn reflection_weight(wo: Vec3, h: Vec3, alpha: f32) -> f32 {
    let wi = h * (2.0 * wo.dot(h)) - wo;
    if wi.z <= 0.0 {
        0.0
    } else {
        ggx::g2(wo, wi, alpha) / ggx::g1(wo, alpha)
    }
}

/// Albedos of GGX with reflectance 1.
#[derive(Debug)]
pub struct Reflection {
    directional: Table,
    average: Vec<f32>,
}

impl Reflection {
    /// The one table, made at first use.
    pub fn get() -> &'static Self {
        static TABLE: OnceLock<Reflection> = OnceLock::new();
        TABLE.get_or_init(|| {
            let directional = Table::tabulate(|cos, roughness| {
                let alpha = (roughness * roughness).max(ggx::SMOOTH_ALPHA);
                over_visible_normals(cos, roughness, |wo, h| reflection_weight(wo, h, alpha))
            });
            let average = (0..GRID)
                .map(|j| directional.average(j as f32 / (GRID - 1) as f32))
                .collect();
            Self {
                directional,
                average,
            }
        })
    }

    /// Single-scattering albedo at a view cosine.
    #[inline]
    pub fn directional(&self, cos: f32, roughness: f32) -> f32 {
        self.directional.read(cos, roughness)
    }

    /// Its cosine-weighted mean.
    #[inline]
    pub fn average(&self, roughness: f32) -> f32 {
        let x = roughness.clamp(0.0, 1.0) * (GRID - 1) as f32;
        let i = (x as usize).min(GRID - 2);
        mix(self.average[i], self.average[i + 1], x - i as f32)
    }

    /// By what a single-scattering lobe with mean reflectance `f_average` is scaled so that the
    /// energy of further scatterings is there: 1 + F_ms (1 − E)/E with
    /// F_ms = F̄ E_avg / (1 − F̄ (1 − E_avg)).
    #[inline]
    pub fn compensation(&self, cos: f32, roughness: f32, f_average: Vec3) -> Vec3 {
        let e = self.directional(cos, roughness);
        let e_average = self.average(roughness);
        let f_ms = f_average * e_average / (Vec3::ONE - f_average * (1.0 - e_average));
        Vec3::ONE + f_ms * ((1.0 - e) / e)
    }
}

/// Albedos of a rough dielectric with one index of refraction.
#[derive(Debug)]
pub struct Dielectric {
    /// Index of refraction, ≥ 1 or < 1.
    pub ior: f32,
    /// How far the mean reflectance has come from normal to grazing incidence:
    /// E(F)/E = F0 + (1 − F0)·blend.
    blend: Table,
    /// Cosine-weighted mean reflectance of the smooth interface, in the same measure.
    average_blend: f32,
    /// Albedo of reflection and transmission together, seen from outside and from inside.
    both: Option<[Table; 2]>,
}

impl Dielectric {
    /// Tabulates; `transmits` makes the tables for light that goes through as well.
    pub fn new(ior: f32, transmits: bool) -> Self {
        let f0 = fresnel::f0_from_ior(ior);
        let blend = Table::tabulate(|cos, roughness| {
            let alpha = (roughness * roughness).max(ggx::SMOOTH_ALPHA);
            let all = over_visible_normals(cos, roughness, |wo, h| reflection_weight(wo, h, alpha));
            let reflected = over_visible_normals(cos, roughness, |wo, h| {
                fresnel::dielectric(wo.dot(h), ior).reflectance * reflection_weight(wo, h, alpha)
            });
            fresnel::grazing_blend(reflected / all, f0)
        });
        let n = 1024;
        let average: f32 = (0..n)
            .map(|k| {
                let mu = (k as f32 + 0.5) / n as f32;
                2.0 * mu * fresnel::dielectric(mu, ior).reflectance / n as f32
            })
            .sum();
        let both = transmits.then(|| {
            [ior, 1.0 / ior].map(|eta| {
                Table::tabulate(|cos, roughness| {
                    let alpha = (roughness * roughness).max(ggx::SMOOTH_ALPHA);
                    over_visible_normals(cos, roughness, |wo, h| {
                        let f = fresnel::dielectric(wo.dot(h), eta);
                        let mut sum = f.reflectance * reflection_weight(wo, h, alpha);
                        if f.reflectance < 1.0 {
                            let wi = refract(wo, h, f.cos_t, eta);
                            if wi.z < 0.0 {
                                sum += (1.0 - f.reflectance) * ggx::g2(wo, wi, alpha)
                                    / ggx::g1(wo, alpha);
                            }
                        }
                        sum
                    })
                })
            })
        });
        Self {
            ior,
            blend,
            average_blend: fresnel::grazing_blend(average, f0),
            both,
        }
    }

    /// How far the mean reflectance at this view and roughness has come from F0 to 1.
    #[inline]
    pub fn blend(&self, cos: f32, roughness: f32) -> f32 {
        self.blend.read(cos, roughness)
    }

    /// The same for the cosine-weighted mean over all directions of the smooth interface.
    pub fn average_blend(&self) -> f32 {
        self.average_blend
    }

    /// Albedo of reflection and transmission together, with nothing absorbed.
    #[inline]
    pub fn both(&self, cos: f32, roughness: f32, inside: bool) -> f32 {
        self.both
            .as_ref()
            .map_or(1.0, |t| t[usize::from(inside)].read(cos, roughness))
    }
}

/// Refracts `wo` at the normal `h` (both on one side); `eta` = n(beyond)/n(here).
#[inline]
pub fn refract(wo: Vec3, h: Vec3, cos_t: f32, eta: f32) -> Vec3 {
    h * (wo.dot(h) / eta - cos_t) - wo / eta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedo_of_a_mirror_is_one_and_of_roughness_one_is_the_published_value() {
        let table = Reflection::get();
        assert!((table.directional(0.5, 0.0) - 1.0).abs() < 1e-4);
        // Quadrature of the same integral by another route (cosine-weighted directions), in f64.
        for (cos, roughness) in [(0.8f32, 1.0f32), (0.3, 0.7), (0.05, 0.5)] {
            let alpha = roughness * roughness;
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let n = 1500;
            let mut sum = 0f64;
            for i in 0..n {
                for j in 0..n {
                    let z = (i as f32 + 0.5) / n as f32;
                    let phi = std::f32::consts::TAU * (j as f32 + 0.5) / n as f32;
                    let s = (1.0 - z * z).sqrt();
                    let wi = Vec3::new(s * phi.cos(), s * phi.sin(), z);
                    let h = (wo + wi).normalize();
                    sum += f64::from(ggx::d(h, alpha) * ggx::g2(wo, wi, alpha) / (4.0 * cos));
                }
            }
            let exact = sum * std::f64::consts::TAU / (n * n) as f64;
            let found = f64::from(table.directional(cos, roughness));
            assert!(
                (found - exact).abs() < 2e-3,
                "{cos} {roughness}: {found} {exact}"
            );
        }
    }
}
