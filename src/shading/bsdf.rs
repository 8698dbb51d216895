//! The layered surface: (metal | dielectric over diffuse | rough transmission), as Blender's
//! Principled BSDF and glTF's metallic-roughness describe it.
//!
//! All microfacet lobes of a surface share one normal and one roughness, so they are one lobe with
//! a summed reflectance R(h) and a transmittance T(h): one visible normal is drawn, then reflection
//! or transmission is chosen by their means. The other lobe is diffuse. Densities are those of the
//! whole mixture.
//!
//! Directions `wo` (to the viewer) and `wi` (to the light) point away from the surface.

use super::tables::{self, Reflection, refract};
use super::{fresnel, ggx, normal};
use crate::math::{Frame, average, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// What a material says at one point, textures looked up.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceParameters {
    /// Linear base colour.
    pub base_color: Vec3,
    /// 0..=1.
    pub metallic: f32,
    /// Perceptual roughness 0..=1 (α = roughness²).
    pub roughness: f32,
    /// Index of refraction of the solid.
    pub ior: f32,
    /// Scales the reflectance at normal incidence.
    pub specular: f32,
    /// Tints the reflectance at normal incidence.
    pub specular_color: Vec3,
    /// Share of transmission instead of diffusion.
    pub transmission: f32,
    /// Transmits without refraction.
    pub thin_walled: bool,
}

/// Albedo tables of the dielectrics that a material needs, in the order of the specular factor:
/// one where the factor is constant, more where a texture varies it.
#[derive(Debug)]
pub struct Dielectrics {
    /// Tables of the reflecting coat at specular factors evenly spaced over 0..=`max_specular`,
    /// or one for the constant factor.
    coat: Vec<tables::Dielectric>,
    /// Greatest specular factor.
    max_specular: f32,
    /// Tables of the transmitting solid.
    solid: Option<tables::Dielectric>,
}

/// Tables over a textured specular factor.
const SPECULAR_STEPS: usize = 9;

/// The index of refraction whose reflectance at normal incidence is `specular` times that of `ior`.
fn coat_ior(ior: f32, specular: f32) -> f32 {
    if specular == 1.0 {
        return ior;
    }
    let adjusted = fresnel::ior_from_f0(fresnel::f0_from_ior(ior) * specular);
    if ior < 1.0 { 1.0 / adjusted } else { adjusted }
}

impl Dielectrics {
    /// Tables for a material with a constant or textured specular factor.
    pub fn new(ior: f32, specular: f32, textured: bool, transmits: bool) -> Self {
        let coat = if textured {
            (0..SPECULAR_STEPS)
                .map(|i| coat_ior(ior, specular * i as f32 / (SPECULAR_STEPS - 1) as f32))
                .map(|ior| tables::Dielectric::new(ior, false))
                .collect()
        } else {
            vec![tables::Dielectric::new(coat_ior(ior, specular), false)]
        };
        Self {
            coat,
            max_specular: specular,
            solid: transmits.then(|| tables::Dielectric::new(ior, true)),
        }
    }

    /// (blend at this view, mean blend) for a specular factor.
    fn coat_blend(&self, specular: f32, cos: f32, roughness: f32) -> (f32, f32) {
        let at = |i: usize| {
            (
                self.coat[i].blend(cos, roughness),
                self.coat[i].average_blend(),
            )
        };
        if self.coat.len() == 1 || self.max_specular <= 0.0 {
            return at(0);
        }
        let x = (specular / self.max_specular).clamp(0.0, 1.0) * (self.coat.len() - 1) as f32;
        let i = (x as usize).min(self.coat.len() - 2);
        let (a, b, t) = (at(i), at(i + 1), x - i as f32);
        (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t)
    }
}

/// The dielectric coat over the diffuse base.
#[derive(Clone, Copy, Debug)]
struct Coat {
    weight: Vec3,
    f0: Vec3,
    eta: f32,
}

/// The metal.
#[derive(Clone, Copy, Debug)]
struct Metal {
    weight: Vec3,
    f0: Vec3,
}

/// The transmitting solid or sheet.
#[derive(Clone, Copy, Debug)]
struct Glass {
    weight: Vec3,
    f0: Vec3,
    tint: Vec3,
    ior: f32,
    /// n(beyond)/n(here); `ior` from outside, its inverse from inside.
    eta: f32,
    thin: bool,
}

/// Reflectance and transmittance of the facets at one angle.
#[derive(Clone, Copy, Debug)]
struct Facet {
    reflectance: Vec3,
    transmittance: Vec3,
    cos_t: f32,
}

/// The BSDF at a point, seen from `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    /// Frame of the microfacets' mean normal (bent, so that reflections leave the surface).
    frame: Frame,
    /// Normal of the diffuse lobe.
    normal: Vec3,
    /// Smooth normal that a bumped one softens its terminator against; equal to `normal` without a bump.
    smooth: Vec3,
    /// Geometric normal on the side of `wo`.
    geometric: Vec3,
    wo: Vec3,
    alpha: f32,
    bound: f32,
    diffuse: Vec3,
    coat: Option<Coat>,
    metal: Option<Metal>,
    glass: Option<Glass>,
    /// Probability of the microfacet lobe.
    p_facet: f32,
    /// Diffuse colour plus mean reflectance: what denoisers call albedo.
    albedo: Vec3,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Direction to go on, world space.
    pub wi: Vec3,
    /// BSDF · |cos| / density.
    pub weight: Vec3,
    /// Density per solid angle; meaningless if `delta`.
    pub pdf: f32,
    /// Whether the direction could not have been found otherwise.
    pub delta: bool,
    /// Whether `wi` is on the other side of the surface.
    pub transmitted: bool,
}

/// The value of the BSDF for two directions.
#[derive(Clone, Copy, Debug)]
pub struct BsdfValue {
    /// BSDF · |cos|.
    pub value: Vec3,
    /// Density with which [`Bsdf::sample`] finds the direction, per solid angle.
    pub pdf: f32,
}

const NOTHING: BsdfValue = BsdfValue {
    value: Vec3::ZERO,
    pdf: 0.0,
};

/// The normals at a point.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    /// Of the triangle, on the side of the viewer.
    pub geometric: Vec3,
    /// Interpolated, on the same side.
    pub smooth: Vec3,
    /// With the normal map.
    pub shading: Vec3,
}

impl Bsdf {
    /// Compiles the lobes whose weight is not zero. `inside`: the viewer is behind the surface.
    /// `TRANSMISSION` says at compile time whether any material transmits.
    #[inline]
    pub fn new<const TRANSMISSION: bool>(
        p: &SurfaceParameters,
        tables: &Dielectrics,
        normals: Normals,
        wo: Vec3,
        inside: bool,
    ) -> Self {
        let facet_normal = if normals.shading == normals.geometric {
            normals.shading
        } else {
            normal::bend_for_reflection(normals.geometric, wo, normals.shading)
        };
        let frame = Frame::from_normal(facet_normal);
        let local = frame.to_local(wo);
        let cos = local.z.max(0.0);
        let alpha = p.roughness * p.roughness;
        let reflection = Reflection::get();

        let mut rest = 1.0 - p.metallic;
        let mut facet_albedo = Vec3::ZERO;
        let metal = (p.metallic > 0.0).then(|| {
            let f0 = p.base_color.min(Vec3::ONE);
            let weight = reflection.compensation(cos, p.roughness, fresnel::schlick_average(f0))
                * p.metallic;
            facet_albedo += fresnel::schlick(f0, cos) * p.metallic;
            Metal { weight, f0 }
        });
        let mut glass = None;
        if TRANSMISSION && p.transmission > 0.0 && rest > 0.0 {
            let base = p.base_color.min(Vec3::ONE);
            let share = p.transmission * rest;
            let f0 = (p.specular_color * fresnel::f0_from_ior(p.ior)).min(Vec3::ONE);
            let (tint, single) = if p.thin_walled {
                (base, reflection.directional(cos, p.roughness))
            } else {
                // Light crosses the boundary of a solid twice: half the tint each time.
                let tint = Vec3::new(base.x.sqrt(), base.y.sqrt(), base.z.sqrt());
                (
                    tint,
                    tables
                        .solid
                        .as_ref()
                        .map_or(1.0, |t| t.both(cos, p.roughness, inside)),
                )
            };
            glass = Some(Glass {
                weight: Vec3::splat(share / single),
                f0,
                tint,
                ior: p.ior,
                eta: if inside && !p.thin_walled {
                    1.0 / p.ior
                } else {
                    p.ior
                },
                thin: p.thin_walled,
            });
            facet_albedo += Vec3::splat(share);
            rest *= 1.0 - p.transmission;
        }
        let mut diffuse = Vec3::ZERO;
        let mut coat = None;
        if rest > 0.0 {
            let eta = coat_ior(p.ior, p.specular);
            let mut below = rest;
            if eta != 1.0 {
                let base_f0 = fresnel::f0_from_ior(eta);
                let f0 = (p.specular_color * base_f0).min(Vec3::ONE);
                let (blend, average_blend) = tables.coat_blend(p.specular, cos, p.roughness);
                let compensation = reflection.compensation(
                    cos,
                    p.roughness,
                    f0 + (Vec3::ONE - f0) * average_blend,
                );
                // Mean reflectance of this view: single scattering times compensation.
                let albedo = (f0 + (Vec3::ONE - f0) * blend)
                    * (compensation * reflection.directional(cos, p.roughness));
                coat = Some(Coat {
                    weight: compensation * rest,
                    f0,
                    eta,
                });
                facet_albedo += albedo * rest;
                below *= (1.0 - albedo.max_element()).max(0.0);
            }
            diffuse = p.base_color * below;
        }
        let has_facets = cos > 0.0 && (metal.is_some() || glass.is_some() || coat.is_some());
        let (a, b) = (average(facet_albedo), average(diffuse));
        let p_facet = if !has_facets {
            0.0
        } else if b <= 0.0 {
            1.0
        } else {
            // A lobe whose albedo is estimated too low must not starve.
            (a / (a + b)).clamp(0.05, 0.95)
        };
        Self {
            frame,
            normal: normals.shading,
            smooth: normals.smooth,
            geometric: normals.geometric,
            wo,
            alpha,
            bound: if glass.is_some() {
                1.0
            } else {
                ggx::reflection_bound(local, alpha)
            },
            diffuse,
            coat,
            metal,
            glass,
            p_facet,
            albedo: diffuse + facet_albedo,
        }
    }

    /// Diffuse colour plus mean reflectance and transmittance.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// Whether some light could be found by sampling lights (not only by sampling the BSDF).
    #[inline]
    pub fn is_samplable(&self) -> bool {
        self.diffuse != Vec3::ZERO || (self.p_facet > 0.0 && !self.is_smooth())
    }

    /// Normal for the estimate of which lights matter: `None` where light from both sides does.
    #[inline]
    pub fn receiving_normal(&self) -> Option<Vec3> {
        (self.glass.is_none() && self.normal == self.smooth && self.frame.z == self.normal)
            .then_some(self.normal)
    }

    #[inline]
    fn is_smooth(&self) -> bool {
        self.alpha <= ggx::SMOOTH_ALPHA
    }

    /// Index so near to 1 that refraction does not bend: the half vector of transmission vanishes
    /// as η − 1, and with it the Jacobian's digits; 1e-4 leaves ten bits.
    #[inline]
    fn glass_is_straight(glass: &Glass) -> bool {
        !glass.thin && (glass.eta - 1.0).abs() < 1e-4
    }

    #[inline]
    fn facet(&self, cos_h: f32) -> Facet {
        let mut f = Facet {
            reflectance: Vec3::ZERO,
            transmittance: Vec3::ZERO,
            cos_t: 0.0,
        };
        if let Some(m) = &self.metal {
            f.reflectance += m.weight * fresnel::schlick(m.f0, cos_h);
        }
        if let Some(c) = &self.coat {
            let true_f = fresnel::dielectric(cos_h, c.eta).reflectance;
            let blend = fresnel::grazing_blend(true_f, fresnel::f0_from_ior(c.eta));
            f.reflectance += c.weight * (c.f0 + (Vec3::ONE - c.f0) * blend);
        }
        if let Some(g) = &self.glass {
            let true_f = fresnel::dielectric(cos_h, g.eta);
            let blend = fresnel::grazing_blend(true_f.reflectance, fresnel::f0_from_ior(g.ior));
            let reflectance = if true_f.reflectance >= 1.0 {
                Vec3::ONE
            } else {
                g.f0 + (Vec3::ONE - g.f0) * blend
            };
            f.reflectance += g.weight * reflectance;
            f.transmittance = g.weight * g.tint * (Vec3::ONE - reflectance);
            f.cos_t = true_f.cos_t;
        }
        f
    }

    /// Share of reflection among what a facet scatters.
    #[inline]
    fn p_reflect(f: &Facet) -> f32 {
        let (r, t) = (average(f.reflectance), average(f.transmittance));
        if r + t > 0.0 { r / (r + t) } else { 1.0 }
    }

    /// BSDF · |cos| and the density for a direction to the light.
    #[inline]
    pub fn evaluate(&self, wi: Vec3) -> BsdfValue {
        let transmitted = wi.dot(self.geometric) < 0.0;
        let mut result = NOTHING;
        if !transmitted && self.diffuse != Vec3::ZERO {
            let cos = wi.dot(self.normal);
            if cos > 0.0 {
                let mut value = self.diffuse * (cos * FRAC_1_PI);
                if self.normal != self.smooth {
                    value *= normal::bump_shadowing(self.smooth, self.normal, wi);
                }
                result.value += value;
                result.pdf += (1.0 - self.p_facet) * warp::cosine_hemisphere_pdf(cos);
            }
        }
        if self.p_facet > 0.0 && !self.is_smooth() {
            let v = self.evaluate_facets(wi, transmitted);
            result.value += v.value;
            result.pdf += self.p_facet * v.pdf;
        }
        result
    }

    #[inline]
    fn evaluate_facets(&self, wi_world: Vec3, transmitted: bool) -> BsdfValue {
        let (wo, wi) = (self.frame.to_local(self.wo), self.frame.to_local(wi_world));
        if wo.z <= 0.0 || (wi.z < 0.0) != transmitted || wi.z == 0.0 {
            return NOTHING;
        }
        // A bumped normal must not see light from behind the smooth surface.
        if self.normal != self.smooth && (wi_world.dot(self.smooth) < 0.0) != transmitted {
            return NOTHING;
        }
        if !transmitted {
            let Some(h) = (wo + wi).try_normalize() else {
                return NOTHING;
            };
            let f = self.facet(wo.dot(h));
            let pdf = Self::p_reflect(&f) * ggx::reflection_pdf(wo, h, self.alpha, self.bound);
            let value = f.reflectance
                * (ggx::d(h, self.alpha) * ggx::g2(wo, wi, self.alpha) / (4.0 * wo.z));
            return BsdfValue { value, pdf };
        }
        let Some(g) = &self.glass else { return NOTHING };
        if g.thin {
            let mirrored = Vec3::new(wi.x, wi.y, -wi.z);
            let Some(h) = (wo + mirrored).try_normalize() else {
                return NOTHING;
            };
            let f = self.facet(wo.dot(h));
            let pdf =
                (1.0 - Self::p_reflect(&f)) * ggx::reflection_pdf(wo, h, self.alpha, self.bound);
            let value = f.transmittance
                * (ggx::d(h, self.alpha) * ggx::g2(wo, mirrored, self.alpha) / (4.0 * wo.z));
            return BsdfValue { value, pdf };
        }
        if Self::glass_is_straight(g) {
            return NOTHING;
        }
        // Half vector of refraction (Walter et al., *Microfacet Models for Refraction through Rough
        // Surfaces*, EGSR 2007, eq. 16), turned to the side of the viewer.
        let half = -(wo + wi * g.eta);
        let Some(mut h) = half.try_normalize() else {
            return NOTHING;
        };
        if h.z < 0.0 {
            h = -h;
        }
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return NOTHING;
        }
        let f = self.facet(cos_o);
        // eq. 17: the Jacobian of the half vector. Radiance is not scaled by η², as in Cycles: what
        // enters a solid leaves it again.
        let jacobian = g.eta * g.eta * -cos_i / (cos_o + g.eta * cos_i).powi(2);
        let common = ggx::d(h, self.alpha) * cos_o * jacobian / wo.z;
        BsdfValue {
            value: f.transmittance * (common * ggx::g2(wo, wi, self.alpha)),
            pdf: (1.0 - Self::p_reflect(&f)) * common * ggx::g1(wo, self.alpha),
        }
    }

    /// Draws a direction. `u_lobe` chooses the lobe (x) and between reflection and transmission (y).
    #[inline]
    pub fn sample(&self, u_lobe: Vec2, u: Vec2) -> Option<BsdfSample> {
        if u_lobe.x >= self.p_facet {
            if self.diffuse == Vec3::ZERO {
                return None;
            }
            let wi = Frame::from_normal(self.normal).to_world(warp::cosine_hemisphere(u));
            return self.finish(wi, false);
        }
        let wo = self.frame.to_local(self.wo);
        let smooth = self.is_smooth();
        let h = if smooth {
            Vec3::Z
        } else {
            ggx::sample_visible_normal(wo, self.alpha, self.bound, u)
        };
        let cos_h = wo.dot(h);
        if cos_h <= 0.0 {
            return None;
        }
        let f = self.facet(cos_h);
        let p_reflect = Self::p_reflect(&f);
        let transmitted = u_lobe.y >= p_reflect;
        let reflected = h * (2.0 * cos_h) - wo;
        let (wi, straight) = match &self.glass {
            Some(g) if transmitted && g.thin => {
                (Vec3::new(reflected.x, reflected.y, -reflected.z), false)
            }
            Some(g) if transmitted && Self::glass_is_straight(g) => (-wo, true),
            Some(g) if transmitted => (refract(wo, h, f.cos_t, g.eta), false),
            _ => (reflected, false),
        };
        if (wi.z < 0.0) != transmitted || wi.z == 0.0 {
            return None;
        }
        let world = self.frame.to_world(wi).normalize();
        if (world.dot(self.geometric) < 0.0) != transmitted {
            return None;
        }
        if smooth || straight {
            let (color, p) = if transmitted {
                (f.transmittance, 1.0 - p_reflect)
            } else {
                (f.reflectance, p_reflect)
            };
            let p = p * self.p_facet;
            return Some(BsdfSample {
                wi: world,
                weight: color / p,
                pdf: 0.0,
                delta: true,
                transmitted,
            });
        }
        self.finish(world, transmitted)
    }

    /// The weight of a sampled direction under the whole mixture.
    #[inline]
    fn finish(&self, wi: Vec3, transmitted: bool) -> Option<BsdfSample> {
        if (wi.dot(self.geometric) < 0.0) != transmitted {
            return None;
        }
        let v = self.evaluate(wi);
        (v.pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: v.value / v.pdf,
            pdf: v.pdf,
            delta: false,
            transmitted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Dimension, Sequence};

    fn plain() -> SurfaceParameters {
        SurfaceParameters {
            base_color: Vec3::ONE,
            metallic: 0.0,
            roughness: 0.5,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            transmission: 0.0,
            thin_walled: false,
        }
    }

    fn normals(n: Vec3) -> Normals {
        Normals {
            geometric: n,
            smooth: n,
            shading: n,
        }
    }

    fn direction(cos: f32) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    /// Mean weight of sampled directions: the albedo. 2^14 points of a net.
    fn albedo(p: &SurfaceParameters, cos: f32, inside: bool) -> f64 {
        let tables = Dielectrics::new(p.ior, p.specular, false, p.transmission > 0.0);
        let bsdf = Bsdf::new::<true>(p, &tables, normals(Vec3::Z), direction(cos), inside);
        let n = 1 << 14;
        let sequence = Sequence::new(n, 5);
        let mut sum = 0f64;
        for i in 0..n {
            let s = sequence.sampler(0, 0, i);
            if let Some(x) =
                bsdf.sample(s.pair(Dimension::Lobe, 0), s.pair(Dimension::Direction, 0))
            {
                sum += f64::from(average(x.weight));
            }
        }
        sum / f64::from(n)
    }

    /// White furnace: a white surface of every lobe and roughness returns all light.
    #[test]
    fn white_surfaces_return_all_light() {
        let mut worst = (0f64, String::new());
        for roughness in [0.0f32, 1e-3, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0] {
            for cos in [0.03f32, 0.1, 0.25, 0.5, 0.8, 1.0] {
                let base = SurfaceParameters {
                    roughness,
                    ..plain()
                };
                let cases = [
                    (
                        "metal",
                        SurfaceParameters {
                            metallic: 1.0,
                            ..base
                        },
                        false,
                    ),
                    ("dielectric", base, false),
                    (
                        "half metal",
                        SurfaceParameters {
                            metallic: 0.5,
                            ..base
                        },
                        false,
                    ),
                    (
                        "diffuse",
                        SurfaceParameters {
                            specular: 0.0,
                            ..base
                        },
                        false,
                    ),
                    (
                        "glass",
                        SurfaceParameters {
                            transmission: 1.0,
                            ..base
                        },
                        false,
                    ),
                    (
                        "glass from inside",
                        SurfaceParameters {
                            transmission: 1.0,
                            ..base
                        },
                        true,
                    ),
                    (
                        "thin glass",
                        SurfaceParameters {
                            transmission: 1.0,
                            thin_walled: true,
                            ..base
                        },
                        false,
                    ),
                    (
                        "diamond",
                        SurfaceParameters {
                            transmission: 1.0,
                            ior: 2.4,
                            ..base
                        },
                        false,
                    ),
                    (
                        "half glass",
                        SurfaceParameters {
                            transmission: 0.5,
                            ..base
                        },
                        false,
                    ),
                ];
                for (name, p, inside) in cases {
                    let found = albedo(&p, cos, inside);
                    let error = (found - 1.0).abs();
                    if error > worst.0 {
                        worst = (
                            error,
                            format!("{name}, roughness {roughness}, cos {cos}: {found}"),
                        );
                    }
                }
            }
        }
        println!("worst: {worst:?}");
        assert!(worst.0 < 1e-2, "{worst:?}");
    }

    /// The density integrates to the probability that a sample comes back, and value = weight·pdf.
    #[test]
    fn densities_integrate_to_the_share_of_samples() {
        for (p, cos, inside) in [
            (
                SurfaceParameters {
                    metallic: 1.0,
                    ..plain()
                },
                0.5f32,
                false,
            ),
            (plain(), 0.3, false),
            (
                SurfaceParameters {
                    transmission: 1.0,
                    ..plain()
                },
                0.7,
                false,
            ),
            (
                SurfaceParameters {
                    transmission: 1.0,
                    ..plain()
                },
                0.7,
                true,
            ),
            (
                SurfaceParameters {
                    transmission: 1.0,
                    thin_walled: true,
                    ..plain()
                },
                0.4,
                false,
            ),
        ] {
            let tables = Dielectrics::new(p.ior, p.specular, false, true);
            let bsdf = Bsdf::new::<true>(&p, &tables, normals(Vec3::Z), direction(cos), inside);
            let n = 1 << 14;
            let sequence = Sequence::new(n, 2);
            let mut came_back = 0f64;
            for i in 0..n {
                let s = sequence.sampler(0, 0, i);
                came_back += f64::from(
                    bsdf.sample(s.pair(Dimension::Lobe, 0), s.pair(Dimension::Direction, 0))
                        .is_some(),
                );
            }
            came_back /= f64::from(n);
            let m = 1 << 17;
            let sequence = Sequence::new(m, 3);
            let mut integral = 0f64;
            for i in 0..m {
                let wi = warp::sphere(sequence.sampler(0, 0, i).pair(Dimension::Direction, 0));
                integral += f64::from(bsdf.evaluate(wi).pdf);
            }
            integral *= 2.0 * std::f64::consts::TAU / f64::from(m);
            assert!(
                (integral - came_back).abs() < 0.01,
                "{p:?} inside {inside}: {integral} {came_back}"
            );
        }
    }
}
