//! The layered surface: (metal | dielectric over diffuse | rough transmission), as Blender's
//! Principled BSDF and glTF's metallic-roughness describe it.
//!
//! All microfacet lobes of a surface share one normal and one roughness, so they are one lobe with
//! a summed reflectance R(h) and a transmittance T(h): one visible normal is drawn, then reflection
//! or transmission is chosen by their means. The other lobe is diffuse. Densities are those of the
//! whole mixture.
//!
//! Directions `wo` (to the viewer) and `wi` (to the light) point away from the surface.

use super::tables::{self, Place, Reflection, Rows, refract};
use super::{fresnel, ggx, normal};
use crate::math::{Frame, average, mix, sqr, warp};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};
use std::marker::PhantomData;

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

impl SurfaceParameters {
    /// Makes facets at least as rough as `alpha`. The energy that multiple scattering gives back follows,
    /// so that a white surface stays white.
    #[inline]
    pub fn roughen(&mut self, alpha: f32) {
        if self.roughness * self.roughness < alpha {
            self.roughness = alpha.sqrt();
        }
    }
}

/// Albedo tables of the dielectrics that a material needs, in the order of the specular factor:
/// one where the factor is constant, more where a texture varies it.
#[derive(Debug)]
pub struct Dielectrics {
    /// Tables of the reflecting coat at specular factors over 0..=`max_specular`, or one for the
    /// constant factor, or none where nobody reads them.
    coat: Vec<tables::Dielectric>,
    /// Greatest specular factor.
    max_specular: f32,
    /// Tables of the transmitting solid.
    solid: Option<tables::Solid>,
}

/// Tables over a textured specular factor: evenly spaced over its square root, about as the
/// distance of the index from 1 grows.
const SPECULAR_STEPS: usize = 7;
/// The least of them as a share of the greatest: the tables have no limit at 0, where the
/// reflectance is a spike at grazing views, but hardly change below this either.
const LEAST_SPECULAR: f32 = 1e-4;

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
        Self::needed(ior, specular, textured, (true, transmits), Rows::ALL)
    }

    /// As far as the coat and the solid are rough somewhere (what is smooth reads no table), for some roughnesses.
    pub fn needed(
        ior: f32,
        specular: f32,
        textured: bool,
        (coat, solid): (bool, bool),
        rows: Rows,
    ) -> Self {
        let ior = fresnel::bounded_ior(ior);
        let coat = if !coat {
            Vec::new()
        } else if textured && specular > 0.0 {
            (0..SPECULAR_STEPS)
                .map(|i| sqr(i as f32 / (SPECULAR_STEPS - 1) as f32).max(LEAST_SPECULAR))
                .map(|share| tables::Dielectric::new(coat_ior(ior, specular * share), rows))
                .collect()
        } else {
            vec![tables::Dielectric::new(coat_ior(ior, specular), rows)]
        };
        Self {
            coat,
            max_specular: specular,
            solid: solid.then(|| tables::Solid::new(ior, rows)),
        }
    }

    /// (effective cosine at this place or the view's own, mean blend) for a specular factor.
    #[inline]
    fn coat(&self, specular: f32, cos: f32, place: Option<Place>) -> (f32, f32) {
        let at = |i: usize| {
            let table = &self.coat[i];
            (
                place.map_or(cos, |p| table.effective_cosine(p)),
                table.average_blend(),
            )
        };
        match self.coat.len() {
            0 => return (cos, 0.0),
            1 => return at(0),
            _ => {}
        }
        let x =
            (specular / self.max_specular).clamp(0.0, 1.0).sqrt() * (self.coat.len() - 1) as f32;
        let i = (x as usize).min(self.coat.len() - 2);
        let (a, b, t) = (at(i), at(i + 1), x - i as f32);
        (mix(a.0, b.0, t), mix(a.1, b.1, t))
    }
}

/// The dielectric coat over the diffuse base.
#[derive(Clone, Copy, Debug)]
struct Coat {
    weight: Vec3,
    f0: Vec3,
    eta: f32,
    /// Reflectance of `eta` at normal incidence; `f0` is tinted.
    true_f0: f32,
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
    /// The weight of what it reflects.
    reflected: Vec3,
    f0: Vec3,
    tint: Vec3,
    /// n(beyond)/n(here); the index from outside, its inverse from inside.
    eta: f32,
    /// Reflectance of `eta` at normal incidence; `f0` is tinted.
    true_f0: f32,
    thin: bool,
}

/// Reflectance and transmittance of the facets at one angle.
#[derive(Clone, Copy, Debug)]
struct Facet {
    reflectance: Vec3,
    transmittance: Vec3,
    cos_t: f32,
}

/// What surfaces of a scene may be, known when a kernel is compiled: what they are not has no code. Where it is all there,
/// the bits are the same.
pub trait Kinds {
    /// Metals, glass, and reflections of dielectrics: all that facets do.
    const FACETS: bool;
    /// Glass; it calls for facets too.
    const TRANSMISSION: bool;
    /// Normals of vertices.
    const SMOOTH: bool;
    /// Normal maps.
    const BUMPS: bool;
}

/// Surfaces of all kinds.
#[derive(Clone, Copy, Debug)]
pub struct AllKinds;

impl Kinds for AllKinds {
    const FACETS: bool = true;
    const TRANSMISSION: bool = true;
    const SMOOTH: bool = true;
    const BUMPS: bool = true;
}

/// The BSDF at a point, seen from `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<K = AllKinds> {
    kinds: PhantomData<K>,
    /// Frame of the microfacets' mean normal (bent, so that reflections leave the surface).
    frame: Frame,
    /// Normal of the diffuse lobe.
    normal: Vec3,
    /// Smooth normal that a bumped one softens its terminator against; equal to `normal` without a bump.
    smooth: Vec3,
    /// Geometric normal on the side of `wo`.
    geometric: Vec3,
    /// The view in `frame`.
    view: ggx::View,
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

/// What a surface did to a path, as Cycles tells rays apart: diffuse and glossy reflection, and what
/// goes through to the other side (rough, clear or thin).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scattering {
    /// Reflected by the diffuse lobe.
    Diffuse,
    /// Reflected by facets or a mirror.
    Glossy,
    /// Went through.
    Transmission,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Direction to go on, world space.
    pub wi: Vec3,
    /// BSDF · |cos| / density.
    pub weight: Vec3,
    /// The part of `weight` that is due to the diffuse lobe.
    pub diffuse: Vec3,
    /// Density per solid angle; meaningless if `delta`.
    pub pdf: f32,
    /// Whether the direction could not have been found otherwise.
    pub delta: bool,
    /// The lobe that was drawn; `Transmission` if `wi` is on the other side of the surface.
    pub scattering: Scattering,
    /// Weight and density for an estimate of the drawn lobe alone, beside which the other has its own: the lobe's
    /// part of the BSDF over the density with which the lobe is drawn and gives the direction.
    pub alone: (Vec3, f32),
}

/// The value of the BSDF for two directions.
#[derive(Clone, Copy, Debug)]
pub struct BsdfValue {
    /// BSDF · |cos|.
    pub value: Vec3,
    /// The part of `value` that is due to the diffuse lobe. The rest is glossy on the viewer's side of
    /// the surface and transmission beyond it.
    pub diffuse: Vec3,
    /// Density with which [`Bsdf::sample`] finds the direction, per solid angle.
    pub pdf: f32,
    /// The part of `pdf` that is due to the diffuse lobe.
    pub diffuse_pdf: f32,
}

const NOTHING: BsdfValue = BsdfValue {
    value: Vec3::ZERO,
    diffuse: Vec3::ZERO,
    pdf: 0.0,
    diffuse_pdf: 0.0,
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

impl<K: Kinds> Bsdf<K> {
    /// Compiles the lobes whose weight is not zero. `inside`: the viewer is behind the surface.
    #[inline]
    pub fn new(
        p: &SurfaceParameters,
        tables: &Dielectrics,
        normals: Normals,
        wo: Vec3,
        inside: bool,
    ) -> Self {
        if !K::FACETS {
            return Self::matte(p.base_color, normals);
        }
        let facet_normal = if normals.shading == normals.geometric {
            normals.shading
        } else {
            normal::bend_for_reflection(normals.geometric, wo, normals.shading)
        };
        let frame = Frame::from_normal(facet_normal);
        let local = frame.to_local(wo);
        let cos = local.z.max(0.0);
        let alpha = p.roughness * p.roughness;
        let ior = fresnel::bounded_ior(p.ior);
        // A mirror loses nothing, and reflects as the tables' interface at its own cosine.
        let place = (alpha > ggx::SMOOTH_ALPHA).then(|| Place::new(cos, p.roughness));
        // A dielectric without specular reflects nothing.
        let has_lobe = p.metallic > 0.0 || p.transmission > 0.0 || p.specular > 0.0;
        let reflection = place.filter(|_| has_lobe).map(Reflection::at);
        let compensation =
            |f_average: Vec3| reflection.map_or(Vec3::ONE, |r| r.compensation(f_average));
        let single_scattering = || reflection.map_or(1.0, |r| r.directional);

        let mut rest = 1.0 - p.metallic;
        let mut facet_albedo = Vec3::ZERO;
        let metal = (p.metallic > 0.0).then(|| {
            let f0 = p.base_color.min(Vec3::ONE);
            let weight = compensation(fresnel::schlick_average(f0)) * p.metallic;
            facet_albedo += fresnel::schlick(f0, cos) * p.metallic;
            Metal { weight, f0 }
        });
        let mut glass = None;
        if K::TRANSMISSION && p.transmission > 0.0 && rest > 0.0 {
            let base = p.base_color.min(Vec3::ONE);
            let share = p.transmission * rest;
            let true_f0 = fresnel::f0_from_ior(ior);
            let f0 = (p.specular_color * true_f0).min(Vec3::ONE);
            let (tint, single) = if p.thin_walled {
                (base, single_scattering())
            } else {
                // Light crosses the boundary of a solid twice: half the tint each time.
                let tint = Vec3::new(base.x.sqrt(), base.y.sqrt(), base.z.sqrt());
                (
                    tint,
                    tables
                        .solid
                        .as_ref()
                        .zip(place)
                        .map_or(1.0, |(t, at)| t.both(at, inside)),
                )
            };
            glass = Some(Glass {
                weight: Vec3::splat(share / single),
                reflected: Vec3::splat(share / single),
                f0,
                tint,
                eta: if inside && !p.thin_walled {
                    1.0 / ior
                } else {
                    ior
                },
                true_f0,
                thin: p.thin_walled,
            });
            facet_albedo += Vec3::splat(share);
            rest *= 1.0 - p.transmission;
        }
        let mut diffuse = Vec3::ZERO;
        let mut coat = None;
        if rest > 0.0 {
            let eta = coat_ior(ior, p.specular);
            let mut below = rest;
            if eta != 1.0 {
                let true_f0 = fresnel::f0_from_ior(eta);
                let f0 = (p.specular_color * true_f0).min(Vec3::ONE);
                let (effective_cosine, average_blend) = tables.coat(p.specular, cos, place);
                let blend = fresnel::grazing_blend(
                    fresnel::dielectric(effective_cosine, eta).reflectance,
                    true_f0,
                );
                let compensation = compensation(f0 + (Vec3::ONE - f0) * average_blend);
                // Mean reflectance of this view: single scattering times compensation.
                let albedo = (f0 + (Vec3::ONE - f0) * blend) * (compensation * single_scattering());
                coat = Some(Coat {
                    weight: compensation * rest,
                    f0,
                    eta,
                    true_f0,
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
            kinds: PhantomData,
            frame,
            normal: normals.shading,
            smooth: normals.smooth,
            geometric: normals.geometric,
            view: ggx::View::new(local, alpha),
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

    /// Nothing but the diffuse lobe.
    #[inline]
    fn matte(base_color: Vec3, normals: Normals) -> Self {
        Self {
            kinds: PhantomData,
            // Nobody looks at it.
            frame: Frame {
                x: Vec3::X,
                y: Vec3::Y,
                z: Vec3::Z,
            },
            normal: normals.shading,
            smooth: normals.smooth,
            geometric: normals.geometric,
            view: ggx::View {
                wo: Vec3::Z,
                stretched: 1.0,
            },
            alpha: 1.0,
            bound: 1.0,
            diffuse: base_color,
            coat: None,
            metal: None,
            glass: None,
            p_facet: 0.0,
            albedo: base_color,
        }
    }

    /// Leaves out what facets reflect, and what they let through, unless they keep it. (The coat goes with a specular
    /// factor of 0: nothing of it is then missing from the diffuse lobe below.)
    #[cold]
    pub fn cut(&mut self, [reflects, transmits]: [bool; 2]) {
        if !reflects {
            self.metal = None;
        }
        if let Some(glass) = &mut self.glass {
            if !reflects {
                glass.reflected = Vec3::ZERO;
            }
            if !transmits {
                glass.tint = Vec3::ZERO;
            }
        }
        if !reflects && !transmits {
            self.glass = None;
        }
        if self.metal.is_none() && self.coat.is_none() && self.glass.is_none() {
            self.p_facet = 0.0;
        }
    }

    /// Probability of the facets' lobe.
    #[inline(always)]
    fn p_facet(&self) -> f32 {
        if K::FACETS { self.p_facet } else { 0.0 }
    }

    /// The glass, if there is any.
    #[inline(always)]
    fn glass(&self) -> Option<&Glass> {
        self.glass.as_ref().filter(|_| K::TRANSMISSION)
    }

    /// Normal of the diffuse lobe.
    #[inline(always)]
    fn normal(&self) -> Vec3 {
        if K::BUMPS { self.normal } else { self.smooth() }
    }

    /// Smooth normal.
    #[inline(always)]
    fn smooth(&self) -> Vec3 {
        if K::SMOOTH {
            self.smooth
        } else {
            self.geometric
        }
    }

    /// Whether a normal map has turned the normal.
    #[inline(always)]
    fn is_bumped(&self) -> bool {
        K::BUMPS && self.normal != self.smooth()
    }

    /// Diffuse colour plus mean reflectance and transmittance.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// Shares of light that are scattered diffusely, reflected otherwise, and let through: what passes divide
    /// their light by. The facets' albedo is shared out between reflection and transmission by means over
    /// some of the angles under which facets are seen, the more the rougher the surface: so none is zero
    /// where such light can be.
    pub fn colors(&self) -> [Vec3; 3] {
        let (mut reflected, mut transmitted) = (Vec3::ZERO, Vec3::ZERO);
        if self.p_facet() > 0.0 {
            for (cos, share) in [
                (self.view.wo.z.max(0.0), 1.0 - self.alpha),
                (0.5, 0.5 * self.alpha),
                (1.0, 0.5 * self.alpha),
            ] {
                let f = self.facet(cos);
                reflected += f.reflectance * share;
                transmitted += f.transmittance * share;
            }
            let all = self.albedo - self.diffuse;
            let tint = self.glass().map_or(Vec3::ONE, |g| g.tint);
            for i in 0..3 {
                // Albedos know of no tint.
                let untinted = if tint[i] > 0.0 {
                    transmitted[i] / tint[i]
                } else {
                    0.0
                };
                let sum = reflected[i] + untinted;
                if sum > 0.0 {
                    reflected[i] *= all[i] / sum;
                    transmitted[i] *= all[i] / sum;
                }
            }
        }
        [self.diffuse, reflected, transmitted]
    }

    /// Bound of the weights of [`sample`](Self::sample), to be checked where they arise. The weight of a mixture is at
    /// most the greatest of its lobes', each over its probability: of the diffuse lobe its colour; of facets, where
    /// G₂ ≤ G₁, what they reflect over the share of it in the mean of the channels, of which each is at most 3 times
    /// the mean. The rest is for roundings.
    pub fn greatest_weight(&self) -> f32 {
        let mut facets = 0.0;
        for weight in [
            self.metal.map(|m| m.weight),
            self.coat.map(|c| c.weight),
            self.glass.map(|g| g.weight),
        ] {
            facets += weight.map_or(0.0, |w| w.max_element());
        }
        let over = |weight: f32, p: f32| if p > 0.0 { weight / p } else { 0.0 };
        let diffuse = over(self.diffuse.max_element(), 1.0 - self.p_facet());
        1.001 * diffuse.max(over(3.0 * facets, self.p_facet()))
    }

    /// Whether some light could be found by sampling lights (not only by sampling the BSDF).
    #[inline]
    pub fn is_samplable(&self) -> bool {
        self.diffuse != Vec3::ZERO || (self.p_facet() > 0.0 && !self.is_smooth())
    }

    /// Normal for the estimate of which lights matter: `None` where light from both sides does.
    #[inline]
    pub fn receiving_normal(&self) -> Option<Vec3> {
        let facets_agree = self.p_facet() == 0.0 || self.frame.z == self.normal();
        (self.glass().is_none() && !self.is_bumped() && facets_agree).then_some(self.normal())
    }

    #[inline]
    fn is_smooth(&self) -> bool {
        self.alpha <= ggx::SMOOTH_ALPHA
    }

    #[inline]
    fn glass_is_straight(glass: &Glass) -> bool {
        !glass.thin && tables::is_straight(glass.eta)
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
            let blend = fresnel::grazing_blend(true_f, c.true_f0);
            f.reflectance += c.weight * (c.f0 + (Vec3::ONE - c.f0) * blend);
        }
        if let Some(g) = self.glass() {
            let true_f = fresnel::dielectric(cos_h, g.eta);
            let blend = fresnel::grazing_blend(true_f.reflectance, g.true_f0);
            let reflectance = if true_f.reflectance >= 1.0 {
                Vec3::ONE
            } else {
                g.f0 + (Vec3::ONE - g.f0) * blend
            };
            f.reflectance += g.reflected * reflectance;
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
        if self.is_below(wi) {
            return NOTHING;
        }
        let transmitted = self.is_beyond(wi);
        let mut result = if transmitted {
            NOTHING
        } else {
            self.evaluate_diffuse(wi)
        };
        if self.p_facet() > 0.0 && !self.is_smooth() {
            let v = self.evaluate_facets(wi, transmitted);
            result.value += v.value;
            result.pdf += self.p_facet() * v.pdf;
        }
        result
    }

    /// Whether a direction is beyond the surface, for what lets light through: on the other side of the triangle.
    #[inline]
    pub fn is_beyond(&self, wi: Vec3) -> bool {
        self.glass().is_some() && wi.dot(self.geometric) < 0.0
    }

    /// Whether a direction is below a surface that lets no light through. On the curved surface that the triangles stand
    /// for it is above as long as the smooth normal says so, even where the triangle looks away already: else coarse meshes
    /// have black facets along the terminator, and lose energy.
    #[inline]
    fn is_below(&self, wi: Vec3) -> bool {
        self.glass().is_none() && wi.dot(self.geometric) < 0.0 && wi.dot(self.smooth()) <= 0.0
    }

    /// The diffuse part, its density times the probability of its lobe.
    #[inline]
    fn evaluate_diffuse(&self, wi: Vec3) -> BsdfValue {
        let cos = wi.dot(self.normal());
        if self.diffuse == Vec3::ZERO || cos <= 0.0 {
            return NOTHING;
        }
        let mut value = self.diffuse * (cos * FRAC_1_PI);
        if self.is_bumped() {
            value *= normal::bump_shadowing(self.smooth(), self.normal(), wi);
        }
        let pdf = (1.0 - self.p_facet()) * warp::cosine_hemisphere_pdf(cos);
        BsdfValue {
            value,
            diffuse: value,
            pdf,
            diffuse_pdf: pdf,
        }
    }

    /// A bumped normal must not see light from behind the smooth surface, nor transmit to before it.
    #[inline]
    fn is_behind_smooth(&self, wi: Vec3, transmitted: bool) -> bool {
        self.is_bumped() && (wi.dot(self.smooth()) < 0.0) != transmitted
    }

    #[inline]
    fn evaluate_facets(&self, wi_world: Vec3, transmitted: bool) -> BsdfValue {
        let (wo, wi) = (self.view.wo, self.frame.to_local(wi_world));
        if (wi.z < 0.0) != transmitted
            || wi.z == 0.0
            || self.is_behind_smooth(wi_world, transmitted)
        {
            return NOTHING;
        }
        if !transmitted {
            let Some(h) = (wo + wi).try_normalize() else {
                return NOTHING;
            };
            return self.reflect(&self.facet(wo.dot(h)), h, wi);
        }
        let Some(g) = self.glass() else {
            return NOTHING;
        };
        if g.thin {
            let mirrored = Vec3::new(wi.x, wi.y, -wi.z);
            let Some(h) = (wo + mirrored).try_normalize() else {
                return NOTHING;
            };
            return self.transmit_thin(&self.facet(wo.dot(h)), h, mirrored);
        }
        if Self::glass_is_straight(g) {
            return NOTHING;
        }
        // Half vector of refraction (Walter et al., *Microfacet Models for Refraction through Rough
        // Surfaces*, EGSR 2007, eq. 16), turned to the side of the viewer.
        let Some(mut h) = (wo + wi * g.eta).try_normalize() else {
            return NOTHING;
        };
        if h.z < 0.0 {
            h = -h;
        }
        let cos_o = wo.dot(h);
        if cos_o <= 0.0 || wi.dot(h) >= 0.0 {
            return NOTHING;
        }
        self.refract(&self.facet(cos_o), h, wi, g.eta)
    }

    /// Reflection from facets with normal `h` to `wi`; the density is that of the facets' lobe.
    #[inline]
    fn reflect(&self, f: &Facet, h: Vec3, wi: Vec3) -> BsdfValue {
        let d = ggx::d(h, self.alpha);
        BsdfValue {
            value: f.reflectance * (0.25 * d * self.view.g2_over_cos(wi, self.alpha)),
            diffuse: Vec3::ZERO,
            pdf: Self::p_reflect(f) * d * self.view.reflection_density(self.bound),
            diffuse_pdf: 0.0,
        }
    }

    /// The same through a thin sheet, `mirrored` being where `wi` would reflect to.
    #[inline]
    fn transmit_thin(&self, f: &Facet, h: Vec3, mirrored: Vec3) -> BsdfValue {
        let d = ggx::d(h, self.alpha);
        BsdfValue {
            value: f.transmittance * (0.25 * d * self.view.g2_over_cos(mirrored, self.alpha)),
            diffuse: Vec3::ZERO,
            pdf: (1.0 - Self::p_reflect(f)) * d * self.view.reflection_density(self.bound),
            diffuse_pdf: 0.0,
        }
    }

    /// Refraction to `wi`.
    #[inline]
    fn refract(&self, f: &Facet, h: Vec3, wi: Vec3, eta: f32) -> BsdfValue {
        let (cos_o, cos_i) = (self.view.wo.dot(h), wi.dot(h));
        // Walter et al., eq. 17: the Jacobian of the half vector. Radiance is not scaled by η², as in
        // Cycles: what enters a solid leaves it again.
        let jacobian = eta * eta * -cos_i / sqr(cos_o + eta * cos_i);
        let common = ggx::d(h, self.alpha) * cos_o * jacobian;
        BsdfValue {
            value: f.transmittance * (common * self.view.g2_over_cos(wi, self.alpha)),
            diffuse: Vec3::ZERO,
            pdf: (1.0 - Self::p_reflect(f)) * common * self.view.g1_over_cos(),
            diffuse_pdf: 0.0,
        }
    }

    /// Draws a direction: z chooses the lobe, and between reflection and transmission.
    #[inline]
    pub fn sample(&self, u: Vec3) -> Option<BsdfSample> {
        let (u, choice) = (u.truncate(), u.z);
        if !K::FACETS || choice >= self.p_facet() {
            if self.diffuse == Vec3::ZERO {
                return None;
            }
            let frame = if K::FACETS && self.frame.z == self.normal() {
                self.frame
            } else {
                Frame::from_normal(self.normal())
            };
            let wi = frame.to_world(warp::cosine_hemisphere(u));
            if self.is_below(wi) || self.is_beyond(wi) {
                return None;
            }
            let v = self.evaluate(wi);
            let alone = (v.diffuse / v.diffuse_pdf, v.diffuse_pdf);
            return Self::weigh(wi, Scattering::Diffuse, v, alone);
        }
        let wo = self.view.wo;
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
        let transmitted = choice >= p_reflect * self.p_facet();
        let scattering = if transmitted {
            Scattering::Transmission
        } else {
            Scattering::Glossy
        };
        let reflected = h * (2.0 * cos_h) - wo;
        let (wi, straight) = match self.glass() {
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
        if self.is_below(world) || self.is_beyond(world) != transmitted {
            return None;
        }
        if smooth || straight {
            let (color, p) = if transmitted {
                (f.transmittance, 1.0 - p_reflect)
            } else {
                (f.reflectance, p_reflect)
            };
            let p = p * self.p_facet();
            return Some(BsdfSample {
                wi: world,
                weight: color / p,
                diffuse: Vec3::ZERO,
                pdf: 0.0,
                delta: true,
                scattering,
                alone: (color / p, 0.0),
            });
        }
        if self.is_behind_smooth(world, transmitted) {
            return None;
        }
        let facets = match self.glass() {
            Some(g) if transmitted && g.thin => self.transmit_thin(&f, h, reflected),
            Some(g) if transmitted => self.refract(&f, h, wi, g.eta),
            _ => self.reflect(&f, h, wi),
        };
        let mut v = if transmitted {
            NOTHING
        } else {
            self.evaluate_diffuse(world)
        };
        let facets_pdf = self.p_facet() * facets.pdf;
        v.value += facets.value;
        v.pdf += facets_pdf;
        Self::weigh(
            world,
            scattering,
            v,
            (facets.value / facets_pdf, facets_pdf),
        )
    }

    /// Draws a direction that knows nothing of the lobes: uniformly from the hemisphere above the surface, or
    /// from the sphere where light is let through. For studies; `pdf` stays that of [`sample`](Self::sample).
    /// What no such direction would meet (mirrors, clear glass) is drawn as ever, with a probability of its own.
    #[cold]
    #[inline(never)]
    pub fn sample_uniform(&self, u: Vec3) -> Option<BsdfSample> {
        let straight = self.glass().is_some_and(Self::glass_is_straight);
        let p_delta = match (self.is_smooth(), straight) {
            // Then the rest is the diffuse lobe.
            (true, _) => self.p_facet(),
            (false, true) => 0.5 * self.p_facet(),
            (false, false) => 0.0,
        };
        if u.z < p_delta {
            let within = Vec3::new(u.x, u.y, u.z / p_delta * self.p_facet());
            let mut s = self.sample(within).filter(|s| s.delta)?;
            let scale = self.p_facet() / p_delta;
            s.weight *= scale;
            s.alone.0 *= scale;
            return Some(s);
        }
        let mut local = warp::sphere(u.truncate());
        // On coarse meshes some directions above the surface are below the triangle.
        let below = self.glass().is_some() || self.smooth() != self.geometric;
        if !below {
            local.z = local.z.abs();
        }
        let wi = Frame::from_normal(self.geometric).to_world(local);
        let v = self.evaluate(wi);
        if v.pdf <= 0.0 {
            return None;
        }
        let solid_angle = if below { 4.0 } else { 2.0 } * PI;
        let weight = solid_angle / (1.0 - p_delta);
        // One of the lobes that could have brought it here, as probable as each is.
        let p_diffuse = v.diffuse_pdf / v.pdf;
        let choice = (u.z - p_delta) / (1.0 - p_delta);
        let (scattering, part, p) = if choice < p_diffuse {
            (Scattering::Diffuse, v.diffuse, p_diffuse)
        } else if self.is_beyond(wi) {
            (Scattering::Transmission, v.value, 1.0)
        } else {
            (Scattering::Glossy, v.value - v.diffuse, 1.0 - p_diffuse)
        };
        Some(BsdfSample {
            wi,
            weight: v.value * weight,
            diffuse: v.diffuse * weight,
            pdf: v.pdf,
            delta: false,
            scattering,
            alone: (part * (weight / p), v.pdf * p),
        })
    }

    /// The weight of a sampled direction under the whole mixture.
    #[inline]
    fn weigh(
        wi: Vec3,
        scattering: Scattering,
        v: BsdfValue,
        alone: (Vec3, f32),
    ) -> Option<BsdfSample> {
        (v.pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: v.value / v.pdf,
            diffuse: v.diffuse / v.pdf,
            pdf: v.pdf,
            delta: false,
            scattering,
            alone,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All but glass.
    #[derive(Clone, Copy, Debug)]
    struct Opaque;

    impl Kinds for Opaque {
        const FACETS: bool = true;
        const TRANSMISSION: bool = false;
        const SMOOTH: bool = true;
        const BUMPS: bool = true;
    }
    use crate::sampler::{Dimension, Sequence};
    use rayon::prelude::*;

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

    /// Mean weight of `n` sampled directions: the albedo. Each `run` has its own points, of the kind
    /// that paths draw.
    fn albedo(bsdf: &Bsdf, n: u32, run: u32) -> f64 {
        let sequence = Sequence::new(run);
        let weight = |i| {
            bsdf.sample(sequence.sampler(0, 0, i).triple(Dimension::Bsdf, 0))
                .map_or(0.0, |x| f64::from(average(x.weight)))
        };
        (0..n).into_par_iter().map(weight).sum::<f64>() / f64::from(n)
    }

    fn white_cases(ior: f32) -> [(&'static str, SurfaceParameters, bool); 7] {
        let base = SurfaceParameters { ior, ..plain() };
        let glass = SurfaceParameters {
            transmission: 1.0,
            ..base
        };
        [
            (
                "metal",
                SurfaceParameters {
                    metallic: 1.0,
                    ..base
                },
                false,
            ),
            ("coat over diffuse", base, false),
            (
                "half metal",
                SurfaceParameters {
                    metallic: 0.5,
                    ..base
                },
                false,
            ),
            ("glass", glass, false),
            ("glass from inside", glass, true),
            (
                "thin glass",
                SurfaceParameters {
                    thin_walled: true,
                    ..glass
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
        ]
    }

    /// Directions that know nothing of the lobes have the same means of everything that paths take from a sample:
    /// weights (times a function of the direction), their diffuse part, and each lobe alone. 24 independent runs
    /// each; of about 700 comparisons one beyond 5 σ would come about by chance once in 300 times. (Within 1e-5
    /// where both sides are exact.)
    #[test]
    fn uniform_directions_have_the_same_means() {
        let quantities = |s: &BsdfSample| {
            let weight = average(s.weight);
            let alone = |kind| {
                if s.scattering == kind {
                    average(s.alone.0)
                } else {
                    0.0
                }
            };
            [
                weight * (1.0 + s.wi.x),
                weight * s.wi.z.abs(),
                average(s.diffuse),
                alone(Scattering::Diffuse),
                alone(Scattering::Glossy),
                alone(Scattering::Transmission),
            ]
            .map(f64::from)
        };
        let (runs, n) = (24, 1 << 12);
        let estimate = |draw: &(dyn Fn(Vec3) -> Option<BsdfSample> + Sync), first: u32| {
            let means: Vec<[f64; 6]> = (first..first + runs)
                .into_par_iter()
                .map(|run| {
                    let sequence = Sequence::new(run);
                    let mut sum = [0.0; 6];
                    for i in 0..n {
                        let u = sequence.sampler(0, 0, i).triple(Dimension::Bsdf, 0);
                        let found = draw(u).as_ref().map_or([0.0; 6], quantities);
                        sum = std::array::from_fn(|k| sum[k] + found[k] / f64::from(n));
                    }
                    sum
                })
                .collect();
            let runs = f64::from(runs);
            std::array::from_fn::<_, 6, _>(|k| {
                let mean = means.iter().map(|m| m[k]).sum::<f64>() / runs;
                let square = means.iter().map(|m| sqr((m[k] - mean) as f32)).sum::<f32>();
                (mean, f64::from(square) / (runs * (runs - 1.0)))
            })
        };
        for ior in [1.0f32, 1.5] {
            let tables = Dielectrics::new(ior, 1.0, false, true);
            for (name, p, inside) in white_cases(ior) {
                for roughness in [0.0f32, 0.4, 0.9] {
                    for cos in [0.3, 0.9] {
                        let p = SurfaceParameters { roughness, ..p };
                        let view = direction(cos);
                        let bsdf =
                            Bsdf::<AllKinds>::new(&p, &tables, normals(Vec3::Z), view, inside);
                        let ours = estimate(&|u| bsdf.sample_uniform(u), 0);
                        let usual = estimate(&|u| bsdf.sample(u), 1000);
                        for (k, (a, b)) in ours.iter().zip(&usual).enumerate() {
                            let bound = 5.0 * (a.1 + b.1).sqrt() + 1e-5;
                            assert!(
                                (a.0 - b.0).abs() < bound,
                                "{name} {ior}, roughness {roughness}, cos {cos}, {k}: {} {} {bound}",
                                a.0,
                                b.0
                            );
                        }
                    }
                }
            }
        }
    }

    /// White furnace: a white surface of every lobe and roughness returns all light.
    ///
    /// Weighted by the cosine, as a closed white body sees itself, within 1e-3. A single view within
    /// 5e-3: tables are linear between 40 points, and from inside the albedo has a crest at the
    /// critical angle, E'' ≈ 50, which leaves 50/8·(1/39)² = 4e-3; the rest is for the points.
    #[test]
    fn white_surfaces_return_all_light() {
        // Gauss and Legendre with 5 points for cosθ², which makes the weight uniform.
        let nodes = [
            0.046_910_08f64,
            0.230_765_34,
            0.5,
            0.769_234_66,
            0.953_089_92,
        ];
        let weights = [
            0.118_463_44f64,
            0.239_314_34,
            0.284_444_44,
            0.239_314_34,
            0.118_463_44,
        ];
        for ior in [1.1f32, 1.5, 2.4] {
            let tables = Dielectrics::new(ior, 1.0, false, true);
            for (name, p, inside) in white_cases(ior) {
                for roughness in [0.0f32, 0.02, 0.1, 0.3, 0.55, 0.8, 1.0] {
                    let p = SurfaceParameters { roughness, ..p };
                    let mut mean = 0.0;
                    for (run, (x, weight)) in (0..).zip(nodes.iter().zip(weights)) {
                        let cos = x.sqrt() as f32;
                        let bsdf = Bsdf::<AllKinds>::new(
                            &p,
                            &tables,
                            normals(Vec3::Z),
                            direction(cos),
                            inside,
                        );
                        let found = albedo(&bsdf, 1 << 16, run);
                        assert!(
                            (found - 1.0).abs() < 5e-3,
                            "{name} {ior}, roughness {roughness}, cos {cos}: {found}"
                        );
                        mean += weight * found;
                    }
                    assert!(
                        (mean - 1.0).abs() < 1e-3,
                        "{name} {ior}, roughness {roughness}: {mean}"
                    );
                }
            }
        }
    }

    /// Values and densities summed over all directions are the mean weight of samples and the
    /// share of them that comes back.
    #[test]
    fn values_and_densities_integrate_to_what_samples_find() {
        let tables = Dielectrics::new(1.5, 1.0, false, true);
        for (name, p, inside) in white_cases(1.5) {
            for (roughness, cos) in [(0.5f32, 0.5f32), (0.8, 0.2)] {
                let p = SurfaceParameters {
                    roughness,
                    base_color: Vec3::new(0.9, 0.5, 0.2),
                    ..p
                };
                let bsdf =
                    Bsdf::<AllKinds>::new(&p, &tables, normals(Vec3::Z), direction(cos), inside);
                let n = 1 << 14;
                let sequence = Sequence::new(2);
                let (mut weight, mut came_back) = (0f64, 0f64);
                for i in 0..n {
                    let s = sequence.sampler(0, 0, i);
                    if let Some(x) = bsdf.sample(s.triple(Dimension::Bsdf, 0)) {
                        weight += f64::from(average(x.weight)) / f64::from(n);
                        came_back += 1.0 / f64::from(n);
                        // The same direction looked up has the same value and density, but for the
                        // digits that its half vector loses.
                        let v = bsdf.evaluate(x.wi);
                        assert!((v.pdf / x.pdf - 1.0).abs() < 1e-3, "{name}: {v:?} {x:?}");
                        assert!(
                            (v.value - x.weight * x.pdf).abs().max_element()
                                <= 1e-3 * v.value.max_element(),
                            "{name}: {v:?} {x:?}"
                        );
                    }
                }
                // Midpoints of equal areas of the sphere, half of it by symmetry.
                let (nz, np) = (2048, 128);
                let (mut value, mut density) = (0f64, 0f64);
                for i in 0..nz {
                    let z = (2 * i + 1 - nz) as f32 / nz as f32;
                    let s = (1.0 - z * z).sqrt();
                    for j in 0..np {
                        let (sin, cos) =
                            (std::f32::consts::PI * (j as f32 + 0.5) / np as f32).sin_cos();
                        let v = bsdf.evaluate(Vec3::new(s * cos, s * sin, z));
                        value += f64::from(average(v.value));
                        density += f64::from(v.pdf);
                    }
                }
                let area = 4.0 * std::f64::consts::PI / f64::from(nz * np);
                // Peaks that are some 0.1 wide (α ≥ 0.25), steps of 0.025: second order leaves 2e-3.
                let (value, density) = (value * area, density * area);
                assert!(
                    (value - weight).abs() < 3e-3,
                    "{name}, roughness {roughness}: {value} {weight}"
                );
                assert!(
                    (density - came_back).abs() < 3e-3,
                    "{name}, roughness {roughness}: {density} {came_back}"
                );
            }
        }
    }

    /// f(wo, wi)·cosθi·cosθo is the same both ways for single scattering at facets without
    /// compensation; compensation scales by a function of the view alone.
    #[test]
    fn metal_is_reciprocal_but_for_its_compensation() {
        let p = SurfaceParameters {
            metallic: 1.0,
            roughness: 0.6,
            base_color: Vec3::new(0.8, 0.5, 0.1),
            ..plain()
        };
        let tables = Dielectrics::new(1.5, 1.0, false, false);
        let (a, b) = (direction(0.3), Vec3::new(-0.5, 0.4, 0.6).normalize());
        let both = [(a, b), (b, a)].map(|(wo, wi)| {
            let bsdf = Bsdf::<Opaque>::new(&p, &tables, normals(Vec3::Z), wo, false);
            let place = Place::new(wo.z, p.roughness);
            bsdf.evaluate(wi).value
                / Reflection::at(place).compensation(fresnel::schlick_average(p.base_color))
                * wo.z
        });
        assert!(
            (both[0] - both[1]).abs().max_element() < 1e-5 * both[0].max_element(),
            "{both:?}"
        );
    }

    /// Whatever a file may say: no NaN, no negative value, no energy from nowhere.
    #[test]
    fn extreme_parameters_stay_finite_and_keep_the_energy() {
        let iors = [0.0f32, 1.0, 1.0 + 1.2e-7, 1.001, 1.5, 1000.0, 1e30];
        let roughnesses = [0.0f32, 1e-8, 3.7e-3, 3.8e-3, 0.03, 0.4, 1.0];
        for ior in iors {
            for specular in [1.0f32, 0.0, 1e-6] {
                let tables = Dielectrics::new(ior, specular, false, true);
                for (name, p, inside) in white_cases(ior) {
                    for roughness in roughnesses {
                        for cos in [1.0f32, 0.7, 0.1, 1e-3, 1e-7, 1e-30, 0.0] {
                            let p = SurfaceParameters {
                                roughness,
                                specular,
                                ..p
                            };
                            let bsdf = Bsdf::<AllKinds>::new(
                                &p,
                                &tables,
                                normals(Vec3::Z),
                                direction(cos),
                                inside,
                            );
                            let what = format!(
                                "{name}, ior {ior}, specular {specular}, roughness {roughness}, cos {cos}"
                            );
                            assert!(
                                bsdf.albedo().is_finite() && bsdf.albedo().min_element() >= 0.0,
                                "{what}"
                            );
                            for z in [1e-30f32, 1e-7, 0.2, 1.0, -1e-7, -0.5] {
                                let v = bsdf.evaluate(Vec3::new(-(1.0 - z * z).sqrt(), 0.0, z));
                                assert!(
                                    v.value.is_finite() && v.value.min_element() >= 0.0,
                                    "{what}, light {z}: {v:?}"
                                );
                                assert!(
                                    v.pdf.is_finite() && v.pdf >= 0.0,
                                    "{what}, light {z}: {v:?}"
                                );
                            }
                            let sequence = Sequence::new(9);
                            for i in 0..64 {
                                let s = sequence.sampler(0, 0, i);
                                let Some(x) = bsdf.sample(s.triple(Dimension::Bsdf, 0)) else {
                                    continue;
                                };
                                assert!(
                                    x.weight.is_finite() && x.weight.min_element() >= 0.0,
                                    "{what}: {x:?}"
                                );
                                assert!(
                                    x.pdf.is_finite() && (x.wi.length() - 1.0).abs() < 1e-5,
                                    "{what}: {x:?}"
                                );
                            }
                            if (0.1..1.0).contains(&cos) && specular == 1.0 {
                                // As in the furnace above.
                                let found = albedo(&bsdf, 1 << 13, 0);
                                assert!(found <= 1.0 + 5e-3, "{what}: {found}");
                            }
                        }
                    }
                }
            }
        }
    }

    /// A kernel that knows of no transmission gives the same bits.
    #[test]
    fn kernels_with_and_without_transmission_agree() {
        let tables = Dielectrics::new(1.45, 0.7, false, false);
        let sequence = Sequence::new(4);
        for i in 0..256 {
            let s = sequence.sampler(3, 1, i);
            let (u, v) = (s.pair(Dimension::Lens, 0), s.triple(Dimension::Bsdf, 0));
            let p = SurfaceParameters {
                metallic: u.x,
                roughness: v.y,
                ior: 1.45,
                specular: 0.7,
                base_color: Vec3::new(u.y, v.x, 0.3),
                ..plain()
            };
            let view = direction(1.0 - u.y);
            let special = Bsdf::<Opaque>::new(&p, &tables, normals(Vec3::Z), view, false);
            let general = Bsdf::<AllKinds>::new(&p, &tables, normals(Vec3::Z), view, false);
            assert_eq!(found(&special, v), found(&general, v));
        }
    }

    fn found<K: Kinds>(bsdf: &Bsdf<K>, u: Vec3) -> (Option<(Vec3, Vec3, f32)>, Vec3, f32) {
        let (x, e) = (bsdf.sample(u), bsdf.evaluate(direction(u.x)));
        (x.map(|x| (x.wi, x.weight, x.pdf)), e.value, e.pdf)
    }

    #[test]
    fn kernels_with_and_without_facets_agree_on_matte_surfaces() {
        struct Matte;
        impl Kinds for Matte {
            const FACETS: bool = false;
            const TRANSMISSION: bool = false;
            const SMOOTH: bool = true;
            const BUMPS: bool = true;
        }
        let sequence = Sequence::new(5);
        for (specular, ior) in [(0.0, 1.45), (0.0, 1.0), (1.0, 1.0), (0.5, 1.0)] {
            let tables = Dielectrics::new(ior, specular, false, false);
            for i in 0..256 {
                let s = sequence.sampler(3, 1, i);
                let (u, v) = (s.pair(Dimension::Lens, 0), s.triple(Dimension::Bsdf, 0));
                let p = SurfaceParameters {
                    metallic: 0.0,
                    roughness: v.y,
                    ior,
                    specular,
                    base_color: Vec3::new(u.y, v.x, 0.3),
                    ..plain()
                };
                let tilted = |x: f32, y: f32| Vec3::new(x - 0.5, y - 0.5, 1.0).normalize();
                let normals = Normals {
                    geometric: Vec3::Z,
                    smooth: tilted(v.x, u.x),
                    shading: if i % 2 == 0 {
                        tilted(v.x, u.x)
                    } else {
                        tilted(v.y, u.y)
                    },
                };
                let view = direction(1.0 - u.y);
                let special = Bsdf::<Matte>::new(&p, &tables, normals, view, false);
                let general = Bsdf::<AllKinds>::new(&p, &tables, normals, view, false);
                assert_eq!(found(&special, v), found(&general, v));
                assert_eq!(special.receiving_normal(), general.receiving_normal());
                assert_eq!(special.albedo(), general.albedo());
            }
        }
    }
}
