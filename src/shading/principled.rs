//! Blender's Principled BSDF, and glTF's metallic-roughness as a case of it: which lobes lie on which, and how much light
//! each leaves to those below (CYCLES.md has the order; albedos by tables).

use super::bsdf::{Bsdf, Changes};
use super::closure::microfacet::Reflectance;
use super::closure::{
    Below, BelowInputs, BsdfFeatures, Facets, Glass, Lobe, Reflection, RoughDiffuse, Sheet,
    rough_diffuse,
};
use super::dielectrics::{Dielectrics, layer_ior};
use super::dispersion::index_at;
use super::fresnel::{self, Fresnel};
use super::ggx::Alpha;
use super::tables::{
    Estimate, LutCoordinate, Reflection as Albedos, albedo_below_one, layer_albedo, metal_estimate,
};
use super::thin_film::{Film, Filmed};
use crate::math::sqr;
use crate::scene::graph::{Distribution, ShaderRules, Subsurface, WalkMethod};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// The sockets of a Principled BSDF at a point.
#[derive(Clone, Copy, Debug)]
pub struct Principled {
    /// Linear base colour.
    pub base_color: Vec3,
    /// 0..=1.
    pub metallic: f32,
    /// Perceptual roughness 0..=1 (α = roughness²).
    pub roughness: f32,
    /// Index of refraction of the solid.
    pub ior: f32,
    /// How much of it depends on the wavelength: 20 over the Abbe number.
    pub dispersion: f32,
    /// Scales the reflectance at normal incidence.
    pub specular: f32,
    /// Tints the reflectance at normal incidence.
    pub specular_color: Vec3,
    /// That tints the reflectance of metals at grazing angles, too.
    pub edge_tint: bool,
    /// Whose version it follows.
    pub rules: ShaderRules,
    /// Facets scatter once ("GGX"), without what further scatterings give back.
    pub once: bool,
    /// Share of transmission instead of diffusion.
    pub transmission: f32,
    /// Transmits without refraction.
    pub thin_walled: bool,
    /// The sheet is a pane of Blender's, with reflections between its sides.
    pub pane: bool,
    /// Share of the diffuse base that goes on below the surface and out on both sides, as in a thin sheet.
    pub subsurface: f32,
    /// How much more of it comes out behind than before, −1..=1.
    pub subsurface_anisotropy: f32,
    /// Its colour.
    pub subsurface_color: Vec3,
    /// How it goes on there instead, if it comes out where it may: the base colour is its colour.
    pub below: Option<Subsurface>,
    /// How far by channel, in units of the scale.
    pub subsurface_radius: Vec3,
    /// In metres.
    pub subsurface_scale: f32,
    /// Index of refraction where it enters skin.
    pub skin_ior: f32,
    /// Roughness of the diffuse base, 0..=1.
    pub diffuse_roughness: f32,
    /// How much longer highlights are along the tangent, 0..=1. What is transmitted has it from 5.3 on.
    pub anisotropy: f32,
    /// Turns of the tangent about the normal.
    pub anisotropy_rotation: f32,
    /// What lies on it.
    pub film: Film,
}

impl Default for Principled {
    /// Blender's default values.
    fn default() -> Self {
        Self {
            base_color: Vec3::splat(0.8),
            metallic: 0.0,
            roughness: 0.5,
            ior: 1.5,
            dispersion: 0.0,
            specular: 1.0,
            specular_color: Vec3::ONE,
            edge_tint: true,
            rules: ShaderRules::default(),
            once: false,
            transmission: 0.0,
            thin_walled: false,
            pane: false,
            subsurface: 0.0,
            subsurface_anisotropy: 0.0,
            subsurface_color: Vec3::splat(0.8),
            below: None,
            subsurface_radius: Vec3::new(1.0, 0.2, 0.1),
            subsurface_scale: 0.005,
            skin_ior: 1.4,
            diffuse_roughness: 0.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            film: Film::NONE,
        }
    }
}

impl Principled {
    /// As light of a wavelength sees it (nanometres; 0: as light of all colours does).
    #[inline]
    pub fn seen_in(self, wavelength: f32) -> Self {
        if wavelength <= 0.0 || self.dispersion <= 0.0 || self.thin_walled {
            return self;
        }
        let ior = fresnel::bounded_ior(self.ior);
        Self {
            ior: index_at(ior, self.dispersion, wavelength),
            ..self
        }
    }

    /// As a surface is whose other side is in something of an index; 0: in air. A film stays as thick for light.
    #[inline]
    pub fn beside(self, other_side: f32) -> Self {
        if other_side <= 0.0 || self.thin_walled {
            return self;
        }
        Self {
            ior: fresnel::bounded_ior(self.ior) / other_side,
            film: self.film.beside(other_side),
            ..self
        }
    }
}

/// α along and across the tangent, for a perceptual roughness, as in the Principled BSDF of Blender and of Burley 2012.
#[inline]
pub(super) fn principled_alpha(roughness: f32, anisotropy: f32) -> Alpha {
    let alpha = sqr(roughness);
    if anisotropy == 0.0 {
        return Alpha::isotropic(alpha);
    }
    let aspect = (1.0 - 0.9 * anisotropy.clamp(0.0, 1.0)).sqrt();
    Alpha::anisotropic(Vec2::new(
        (alpha / aspect).min(1.0),
        (alpha * aspect).min(1.0),
    ))
}

/// α along and across the tangent of Blender's Glossy BSDF and, from 5.3 on, Glass BSDF; `anisotropy` −1..=1.
#[inline]
pub(super) fn glossy_alpha(roughness: f32, anisotropy: f32) -> Alpha {
    let alpha = sqr(roughness);
    let a = anisotropy.clamp(-0.99, 0.99);
    if a.abs() <= 1e-4 {
        return Alpha::isotropic(alpha);
    }
    let (x, y) = if a < 0.0 {
        (alpha / (1.0 + a), alpha * (1.0 + a))
    } else {
        (alpha * (1.0 - a), alpha / (1.0 - a))
    };
    Alpha::anisotropic(Vec2::new(x, y).min(Vec2::ONE))
}

/// The colour of light that crosses the boundary of a solid, which it does twice: half the tint each time.
#[inline]
fn half_tint(base_color: Vec3) -> Vec3 {
    let base = base_color.min(Vec3::ONE);
    Vec3::new(base.x.sqrt(), base.y.sqrt(), base.z.sqrt())
}

/// A tangent turned about the normal.
#[inline]
pub fn turned(tangent: Vec3, normal: Vec3, turns: f32) -> Vec3 {
    if turns == 0.0 {
        return tangent;
    }
    let (sin, cos) = (turns * TAU).sin_cos();
    tangent * cos + normal.cross(tangent) * sin + normal * (normal.dot(tangent) * (1.0 - cos))
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// A surface of one Principled BSDF.
    #[inline]
    pub fn principled(
        p: &Principled,
        tables: &Dielectrics,
        normals: super::Normals,
        wo: Vec3,
        inside: bool,
    ) -> Self {
        let mut bsdf = Self::new(normals, wo, inside, Changes::NONE);
        bsdf.add_principled(1.0, p, tables, (normals.shading, None));
        bsdf.finish();
        bsdf
    }

    /// Adds the lobes of a Principled BSDF whose weight is not zero.
    #[inline]
    pub fn add_principled(
        &mut self,
        weight: f32,
        p: &Principled,
        tables: &Dielectrics,
        (normal, tangent): (Vec3, Option<Vec3>),
    ) {
        if !K::FACETS {
            self.add_lambert(p.base_color * weight, normal);
            return;
        }
        let specular = if self.keeps_reflections() {
            p.specular
        } else {
            0.0
        };
        let mut rest = weight * (1.0 - p.metallic);
        // A dielectric without specular reflects nothing. (What is not a number goes on, to be counted.)
        if p.metallic <= 0.0 && p.transmission <= 0.0 && specular <= 0.0 && !p.film.is_there() {
            if rest > 0.0 {
                self.add_base(rest, p, normal);
            }
            return;
        }
        let tangent = tangent
            .filter(|_| p.anisotropy != 0.0)
            .map(|t| turned(t, normal, p.anisotropy_rotation));
        let alpha = match tangent {
            Some(_) => principled_alpha(p.roughness, p.anisotropy),
            None => Alpha::isotropic(sqr(p.roughness)),
        };
        let roughened = self.roughened(alpha);
        let facets = Facets::new(self.normals(), normal, tangent, self.wo(), roughened);
        let cos = facets.cos().max(0.0);
        let ior = fresnel::bounded_ior(p.ior);
        // A mirror loses nothing.
        let mean = match tangent {
            Some(_) => alpha.mean_roughness(),
            None => p.roughness,
        };
        let place = (!alpha.is_smooth()).then(|| LutCoordinate::new(cos, mean));
        // Solid glass has a table of its own.
        let is_solid =
            K::TRANSMISSION && p.metallic <= 0.0 && p.transmission >= 1.0 && !p.thin_walled;
        let albedos = place.filter(|_| !is_solid && !p.once).map(Albedos::at);
        let compensation =
            |f_average: Vec3| albedos.map_or(Vec3::ONE, |r| r.compensation(f_average));
        let single_scattering = || albedos.map_or(1.0, |r| r.directional);

        if p.metallic > 0.0 {
            let f0 = p.base_color.min(Vec3::ONE);
            let share = weight * p.metallic;
            let metal = if p.edge_tint {
                Fresnel::metal(f0, p.specular_color)
            } else {
                Fresnel::Schlick { f0 }
            };
            let gain = compensation(metal.average());
            let scattered = gain * (single_scattering() * share);
            if p.film.is_there() {
                let filmed = Filmed::metal(p.film, &metal);
                self.add_filmed(filmed, facets, gain * share, scattered);
            } else {
                self.add_reflection(
                    Reflection {
                        weight: gain * share,
                        facets,
                        fresnel: metal,
                    },
                    metal_estimate(&metal, (cos, mean), p.rules) * scattered,
                );
            }
        }
        if K::TRANSMISSION && p.transmission > 0.0 && rest > 0.0 {
            let share = p.transmission * rest;
            rest *= 1.0 - p.transmission;
            if p.thin_walled && (p.pane || p.film.is_there()) {
                self.add_pane(share, p, ior, normal);
            } else {
                // Until 5.2 anisotropy is of what reflects alone.
                let spread_alike = p.rules == ShaderRules::Before53 || p.thin_walled;
                let unlike = tangent.filter(|_| spread_alike);
                let clear = match unlike {
                    Some(_) => self.isotropic_facets(normal, sqr(p.roughness)),
                    None => facets,
                };
                let gain = if p.thin_walled {
                    Vec3::splat(1.0 / single_scattering())
                } else {
                    let place = match unlike {
                        Some(_) => place.map(|_| LutCoordinate::new(cos, p.roughness)),
                        None => place,
                    };
                    let solid = tables.solid.as_ref().zip(place).filter(|_| !p.once);
                    solid.map_or(Vec3::ONE, |(t, at)| {
                        t.compensation(at, (ior, self.is_inside()), half_tint(p.base_color))
                    })
                };
                self.add_transmission(share, p, (ior, clear.unbounded()), gain);
            }
        }
        if rest <= 0.0 {
            return;
        }
        let mut below = rest;
        let eta = layer_ior(ior, specular);
        let is_filmed = p.film.is_there() && self.keeps_reflections();
        if eta != 1.0 || is_filmed {
            let true_f0 = fresnel::f0_from_ior(eta);
            let f0 = (p.specular_color * true_f0).min(Vec3::ONE);
            let average = f0 + (Vec3::ONE - f0) * fresnel::average_blend(eta, true_f0);
            let compensation = compensation(average);
            let (view, all) = ((cos, mean), albedos.as_ref());
            let mut albedo = if eta < 1.0 && tables.below_one == Estimate::Exact {
                albedo_below_one(view, eta, [f0, average], all)
            } else {
                layer_albedo(view, (eta, p.rules), [f0, average], all)
            };
            if is_filmed {
                let (filmed, share) = (Filmed::Dielectric(p.film, eta, f0), compensation * rest);
                let scattered = share * single_scattering();
                albedo = self.add_filmed(filmed, facets, share, scattered) / rest;
            } else {
                self.add_reflection(
                    Reflection {
                        weight: compensation * rest,
                        facets,
                        fresnel: Fresnel::Dielectric { f0, eta, true_f0 },
                    },
                    albedo * rest,
                );
            }
            below *= (1.0 - albedo.max_element()).max(0.0);
        }
        self.add_base(below, p, normal);
    }

    /// Adds what lies under all that reflects and transmits.
    #[inline]
    fn add_base(&mut self, weight: f32, p: &Principled, normal: Vec3) {
        let mut rest = weight;
        if K::TRANSMISSION && p.subsurface > 0.0 {
            let share = weight * p.subsurface;
            match p.below {
                Some(what) => self.add_subsurface(share, p, what, normal),
                None => self.add_thin_subsurface(share, p, normal),
            }
            rest *= 1.0 - p.subsurface;
        }
        self.add_diffuse(rest, p.base_color, (p.diffuse_roughness, p.rules), normal);
    }

    /// Adds the part of the base that goes on below the surface.
    #[cold]
    #[inline(never)]
    fn add_subsurface(&mut self, weight: f32, p: &Principled, what: Subsurface, normal: Vec3) {
        let ior = match what.method {
            WalkMethod::Skin => p.skin_ior,
            _ => layer_ior(fresnel::bounded_ior(p.ior), p.specular),
        };
        let inputs = BelowInputs {
            color: p.base_color.min(Vec3::ONE),
            radius: p.subsurface_radius * p.subsurface_scale,
            alpha: sqr(p.roughness),
            ior,
            anisotropy: p.subsurface_anisotropy,
        };
        self.add_below(weight, &inputs, what, normal);
    }

    /// Adds what goes on below the surface, or scatters on it where there is no way for it.
    pub(super) fn add_below(
        &mut self,
        weight: f32,
        inputs: &BelowInputs,
        what: Subsurface,
        normal: Vec3,
    ) {
        let weight = inputs.color * weight;
        if what.diffuse_behind_diffuse && self.changes().diffused {
            self.add_lambert(weight, normal);
            return;
        }
        let normals = (self.normals(), normal);
        let (lobe, at_surface) = Below::new(weight, inputs, what, normals, self.wo());
        if let Some(lobe) = lobe.filter(|lobe| lobe.weight != Vec3::ZERO) {
            self.add(Lobe::Below(lobe), lobe.weight);
        }
        if at_surface != Vec3::ZERO {
            self.add_lambert(at_surface, normal);
        }
    }

    /// Adds facets under a thin film; what they reflect of `scattered` for this view.
    #[cold]
    #[inline(never)]
    pub(super) fn add_filmed(
        &mut self,
        filmed: Filmed,
        facets: Facets,
        weight: Vec3,
        scattered: Vec3,
    ) -> Vec3 {
        // A view below the bent normal sees no facet.
        if !self.keeps_reflections() || facets.cos() <= 0.0 {
            return Vec3::ZERO;
        }
        let albedo = filmed.reflectance(facets.cos()) * scattered;
        let lobe = Reflection {
            weight,
            facets,
            fresnel: filmed,
        };
        self.add(Lobe::FilmReflection(lobe), albedo);
        albedo
    }

    #[cold]
    #[inline(never)]
    fn isotropic_facets(&self, normal: Vec3, alpha: f32) -> Facets {
        let alpha = self.roughened(Alpha::isotropic(alpha));
        Facets::new(self.normals(), normal, None, self.wo(), alpha)
    }

    /// Adds the boundary of a solid, or a sheet. `gain`: what further scatterings give back.
    #[inline]
    fn add_transmission(
        &mut self,
        share: f32,
        p: &Principled,
        (ior, facets): (f32, Facets),
        gain: Vec3,
    ) {
        let base = p.base_color.min(Vec3::ONE);
        let true_f0 = fresnel::f0_from_ior(ior);
        let f0 = (p.specular_color * true_f0).min(Vec3::ONE);
        let [reflects, transmits] = self.keeps_caustics();
        let weight = gain * share;
        let reflected = if reflects { weight } else { Vec3::ZERO };
        let kept = |tint: Vec3| if transmits { tint } else { Vec3::ZERO };
        if (!reflects && !transmits) || facets.cos() <= 0.0 {
            return;
        }
        let lobe = if p.thin_walled {
            Lobe::Sheet(Sheet {
                weight,
                reflected,
                f0,
                tint: kept(base),
                eta: ior,
                true_f0,
                facets,
            })
        } else {
            let glass = Glass {
                weight,
                reflected,
                f0,
                tint: kept(half_tint(p.base_color)),
                eta: if self.is_inside() { 1.0 / ior } else { ior },
                true_f0,
                facets,
                film: (),
            };
            if p.film.is_there() {
                Lobe::FilmGlass(glass.under(p.film.seen_from(self.is_inside(), ior)))
            } else {
                Lobe::Glass(glass)
            }
        };
        self.add(lobe, Vec3::splat(share));
    }

    /// Adds Blender's Diffuse BSDF, or a Principled BSDF's base.
    #[inline]
    pub fn add_diffuse(
        &mut self,
        weight: f32,
        color: Vec3,
        rough: (f32, ShaderRules),
        normal: Vec3,
    ) {
        if K::FACETS && rough.0 >= rough_diffuse::LEAST_ROUGHNESS {
            self.add_rough_diffuse(weight, color, rough, normal);
        } else {
            self.add_lambert(color * weight, normal);
        }
    }

    #[cold]
    fn add_rough_diffuse(
        &mut self,
        weight: f32,
        color: Vec3,
        rough: (f32, ShaderRules),
        normal: Vec3,
    ) {
        if weight > 0.0 && color != Vec3::ZERO {
            let lobe = RoughDiffuse::new(Vec3::splat(weight), color, rough, normal, self.wo());
            self.add(Lobe::RoughDiffuse(lobe), lobe.albedo());
        }
    }

    /// Adds Blender's Glossy BSDF: facets of one colour at all angles.
    #[inline]
    pub fn add_glossy(
        &mut self,
        weight: f32,
        color: Vec3,
        (roughness, anisotropy): (f32, f32),
        (normal, tangent): (Vec3, Option<Vec3>),
        distribution: Distribution,
    ) {
        if !K::FACETS || color == Vec3::ZERO || weight <= 0.0 {
            return;
        }
        let alpha = if tangent.is_some() {
            glossy_alpha(roughness, anisotropy)
        } else {
            Alpha::isotropic(sqr(roughness))
        };
        let roughened = self.roughened(alpha);
        if matches!(
            distribution,
            Distribution::Beckmann | Distribution::AshikhminShirley
        ) {
            self.add_other_glossy(color * weight, &roughened, (normal, tangent), distribution);
            return;
        }
        let facets = Facets::new(self.normals(), normal, tangent, self.wo(), roughened);
        let (mut gain, mut single) = (Vec3::ONE, 1.0);
        if !alpha.is_smooth() {
            let at = Albedos::at(LutCoordinate::new(
                facets.cos().max(0.0),
                alpha.mean_roughness(),
            ));
            single = at.directional;
            if distribution == Distribution::MultiscatterGgx {
                gain = at.compensation(color);
            }
        }
        self.add_reflection(
            Reflection {
                weight: color * gain * weight,
                facets,
                fresnel: Fresnel::Constant,
            },
            color * gain * (single * weight),
        );
    }

    /// Adds a reflecting lobe, unless this path leaves caustics out.
    #[inline]
    pub(super) fn add_reflection(&mut self, lobe: Reflection, albedo: Vec3) {
        // A view below the bent normal sees no facet.
        if self.keeps_reflections() && lobe.facets.cos() > 0.0 {
            self.add(Lobe::Reflection(lobe), albedo);
        }
    }
}
