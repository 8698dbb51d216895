//! Blender's shaders of one lobe: Translucent, Refraction, Glass, Metallic, Sheen, Toon and Ray Portal BSDF, Subsurface Scattering.
//! Those of hair: [`super::fibres`].

use super::bsdf::Bsdf;
use super::closure::microfacet::Reflectance;
use super::closure::{
    BelowInputs, BsdfFeatures, Facets, Glass, Lobe, Phong, Portal, Reflection, Sheen, Toon,
    Translucent, Velvet,
};
use super::dielectrics::Dielectrics;
use super::fresnel::{self, Fresnel};
use super::ggx::Alpha;
use super::principled::{glossy_alpha, principled_alpha, turned};
use super::program::{Evaluation, Place, Root, reflected};
use super::spread::{Beckmann, Spread};
use super::tables::{LutCoordinate, Reflection as Albedos, Solids, metal_estimate};
use super::thin_film::{Film, Filmed};
use crate::math::primaries::WorkingSpace;
use crate::math::sqr;
use crate::scene::graph::node::{
    glass, metallic, ray_portal, sheen, subsurface, toon, translucent,
};
use crate::scene::graph::{Distribution, ShaderRules, SimpleBsdf};
use glam::Vec3;

/// A shader, ready to be read.
#[derive(Clone, Copy, Debug)]
pub struct SimpleValues<'a> {
    /// Which.
    pub kind: SimpleBsdf,
    /// Its sockets.
    pub sockets: &'a [Root],
    /// Its share of the surface.
    pub weight: f32,
    /// The space of its colours.
    pub space: WorkingSpace,
    /// Index of refraction of the solid on the other side; 0: of air.
    pub other_side: f32,
}

impl SimpleValues<'_> {
    /// The film on it, whose index stands in the socket after that of its thickness.
    fn film<P: Place>(&self, at: &mut Evaluation<'_, P>, thickness: usize) -> Film {
        Film {
            thickness: at.number(&self.sockets[thickness]),
            ior: at.number(&self.sockets[thickness + 1]).max(1e-5),
            space: self.space,
        }
    }
}

/// Which lobe it is as it is, and which under a film.
type Kinds<A, B> = (fn(A) -> Lobe, fn(B) -> Lobe);

impl<S: Spread> Reflection<S> {
    /// The same metal under a film.
    fn under(self, film: Film) -> Reflection<S, Filmed> {
        Reflection {
            weight: self.weight,
            facets: self.facets,
            fresnel: Filmed::metal(film, &self.fresnel),
        }
    }
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// Adds the lobe of a shader.
    #[cold]
    #[inline(never)]
    pub fn add_simple<P: Place>(
        &mut self,
        of: &SimpleValues<'_>,
        at: &mut Evaluation<'_, P>,
        tables: &Dielectrics,
        frame: (Vec3, Option<Vec3>),
    ) {
        let (sockets, weight, normal) = (of.sockets, of.weight, frame.0);
        match of.kind {
            SimpleBsdf::Translucent => {
                let color = reflected(at.color(&sockets[translucent::COLOR])) * weight;
                let normal = self.normals().bent(normal, self.wo());
                self.add(Lobe::Translucent(Translucent { color, normal }), color);
            }
            SimpleBsdf::Refraction { distribution } => match distribution {
                Distribution::Beckmann => {
                    self.add_glass(
                        of,
                        at,
                        None,
                        frame,
                        (Lobe::BeckmannGlass, Lobe::BeckmannFilmGlass),
                    );
                }
                _ => self.add_glass(of, at, None, frame, (Lobe::Glass, Lobe::FilmGlass)),
            },
            SimpleBsdf::Glass { distribution, .. } => match distribution {
                Distribution::Beckmann => {
                    self.add_glass(
                        of,
                        at,
                        Some(None),
                        frame,
                        (Lobe::BeckmannGlass, Lobe::BeckmannFilmGlass),
                    );
                }
                _ => {
                    let solid = tables.solid.as_ref();
                    let solid = solid.filter(|_| distribution == Distribution::MultiscatterGgx);
                    self.add_glass(of, at, Some(solid), frame, (Lobe::Glass, Lobe::FilmGlass));
                }
            },
            SimpleBsdf::Metallic { distribution, .. } => match distribution {
                Distribution::Beckmann => {
                    self.add_metal(
                        of,
                        at,
                        frame,
                        (Lobe::BeckmannReflection, Lobe::BeckmannFilmReflection),
                    );
                }
                _ => self.add_metal(of, at, frame, (Lobe::Reflection, Lobe::FilmReflection)),
            },
            SimpleBsdf::Sheen { velvet } => {
                let color = reflected(at.color(&sockets[sheen::COLOR])) * weight;
                let roughness = at.number(&sockets[sheen::ROUGHNESS]);
                if velvet {
                    let lobe = Velvet::new(color, roughness, normal, self.wo());
                    self.add(Lobe::Velvet(lobe), color);
                } else if let Some(lobe) = Sheen::new(color, roughness, normal, self.wo()) {
                    self.add(Lobe::Sheen(lobe), lobe.albedo());
                }
            }
            SimpleBsdf::Subsurface(what) => {
                let number =
                    |at: &mut Evaluation<'_, P>, socket: usize| at.number(&sockets[socket]);
                let scale = number(at, subsurface::SCALE);
                let inputs = BelowInputs {
                    color: reflected(at.color(&sockets[subsurface::COLOR])),
                    radius: at.color(&sockets[subsurface::RADIUS]) * scale,
                    alpha: number(at, subsurface::ROUGHNESS).clamp(0.0, 1.0),
                    ior: number(at, subsurface::IOR),
                    anisotropy: number(at, subsurface::ANISOTROPY),
                };
                self.add_below(weight, &inputs, what, normal);
            }
            SimpleBsdf::RayPortal { moves } => {
                let color = reflected(at.color(&sockets[ray_portal::COLOR])) * weight;
                let portal = Portal {
                    weight: color,
                    position: moves.then(|| at.color(&sockets[ray_portal::POSITION])),
                    direction: at.color(&sockets[ray_portal::DIRECTION]),
                    normal,
                };
                self.add(Lobe::Portal(portal), color);
            }
            SimpleBsdf::Hair { transmits } => self.add_hair(of, at, transmits),
            SimpleBsdf::PrincipledHair(fibre) => self.add_principled_hair(of, at, tables, fibre),
            SimpleBsdf::Toon { glossy } => {
                let color = reflected(at.color(&sockets[toon::COLOR])) * weight;
                let sizes = (
                    at.number(&sockets[toon::SIZE]),
                    at.number(&sockets[toon::SMOOTH]),
                );
                if (!glossy || self.keeps_reflections())
                    && let Some(lobe) = Toon::new(color, sizes, normal, self.wo(), glossy)
                {
                    self.add(Lobe::Toon(lobe), color);
                }
            }
        }
    }

    /// Adds refraction, with reflection if there is something for `reflection`: the table of what further scatterings give back,
    /// if they do.
    fn add_glass<P: Place, S: Spread>(
        &mut self,
        of: &SimpleValues<'_>,
        at: &mut Evaluation<'_, P>,
        reflection: Option<Option<&Solids>>,
        (normal, tangent): (Vec3, Option<Vec3>),
        (plain, filmed): Kinds<Glass<S>, Glass<S, Film>>,
    ) {
        let color = reflected(at.color(&of.sockets[glass::COLOR]));
        let roughness = at.number(&of.sockets[glass::ROUGHNESS]);
        // Cycles squares that of the Refraction BSDF before it bounds it.
        let roughness = match of.kind {
            SimpleBsdf::Refraction { .. } => roughness.abs(),
            _ => roughness,
        };
        let roughness = roughness.clamp(0.0, 1.0);
        let mut ior = fresnel::bounded_ior(at.number(&of.sockets[glass::IOR]));
        if of.other_side > 0.0 {
            ior /= of.other_side;
        }
        let tangent = tangent.map(|t| turned(t, normal, at.number(&of.sockets[glass::ROTATION])));
        let alpha = match tangent {
            Some(_) => glossy_alpha(roughness, at.number(&of.sockets[glass::ANISOTROPY])),
            None => Alpha::isotropic(sqr(roughness)),
        };
        let roughened = self.roughened(alpha);
        let facets = Facets::new(self.normals(), normal, tangent, self.wo(), roughened);
        let [reflects, transmits] = self.keeps_caustics();
        if facets.cos() <= 0.0 || !(transmits || reflects && reflection.is_some()) {
            return;
        }
        let place =
            (!alpha.is_smooth()).then(|| LutCoordinate::new(facets.cos(), alpha.mean_roughness()));
        let gain = match reflection.flatten().zip(place) {
            Some((solid, place)) => solid.compensation(place, (ior, self.is_inside()), color),
            None => Vec3::ONE,
        };
        let true_f0 = fresnel::f0_from_ior(ior);
        let weight = gain * of.weight;
        let lobe = Glass {
            weight,
            reflected: match reflection {
                Some(_) if reflects => weight * color,
                _ => Vec3::ZERO,
            },
            f0: reflection.map_or(Vec3::ZERO, |_| Vec3::splat(true_f0)),
            tint: if transmits { color } else { Vec3::ZERO },
            eta: if self.is_inside() { 1.0 / ior } else { ior },
            // With 1 no angle reflects more than at normal incidence, which is nothing.
            true_f0: if reflection.is_some() { true_f0 } else { 1.0 },
            facets: facets.unbounded(),
            film: (),
        };
        let film = match of.kind {
            SimpleBsdf::Glass { .. } => of.film(at, glass::THIN_FILM_THICKNESS),
            _ => Film::NONE,
        };
        let film = match of.other_side {
            other_side if other_side > 0.0 => film.beside(other_side),
            _ => film,
        };
        let film = film.seen_from(self.is_inside(), ior);
        let lobe = if film.is_there() {
            filmed(lobe.under(film))
        } else {
            plain(lobe)
        };
        self.add(lobe, Vec3::splat(of.weight));
    }

    fn add_metal<P: Place, S: Spread>(
        &mut self,
        of: &SimpleValues<'_>,
        at: &mut Evaluation<'_, P>,
        (normal, tangent): (Vec3, Option<Vec3>),
        (plain, filmed): Kinds<Reflection<S>, Reflection<S, Filmed>>,
    ) {
        let SimpleBsdf::Metallic {
            conductor,
            distribution,
        } = of.kind
        else {
            return;
        };
        let sockets = of.sockets;
        let metal = if conductor {
            Fresnel::Conductor {
                n: reflected(at.color(&sockets[metallic::IOR])),
                k: reflected(at.color(&sockets[metallic::EXTINCTION])),
            }
        } else {
            let color = reflected(at.color(&sockets[metallic::BASE_COLOR])).min(Vec3::ONE);
            Fresnel::metal(color, at.color(&sockets[metallic::EDGE_TINT]))
        };
        let roughness = at.number(&sockets[metallic::ROUGHNESS]).clamp(0.0, 1.0);
        let anisotropy = at.number(&sockets[metallic::ANISOTROPY]);
        let turns = at.number(&sockets[metallic::ROTATION]);
        let tangent = tangent.filter(|_| anisotropy > 0.0);
        let tangent = tangent.map(|t| turned(t, normal, turns));
        let alpha = match tangent {
            Some(_) => principled_alpha(roughness, anisotropy),
            None => Alpha::isotropic(sqr(roughness)),
        };
        let roughened = self.roughened(alpha);
        let facets = Facets::new(self.normals(), normal, tangent, self.wo(), roughened);
        let cos = facets.cos().max(0.0);
        let (mut gain, mut single) = (Vec3::ONE, 1.0);
        if !alpha.is_smooth() {
            let albedos = Albedos::at(LutCoordinate::new(cos, alpha.mean_roughness()));
            single = albedos.directional;
            if distribution == Distribution::MultiscatterGgx {
                gain = albedos.compensation(metal.average());
            }
        }
        let film = of.film(at, metallic::THIN_FILM_THICKNESS);
        let reflectance = if film.is_there() {
            Filmed::metal(film, &metal).reflectance(cos)
        } else {
            metal_estimate(&metal, (cos, alpha.mean_roughness()), ShaderRules::Before53)
        };
        let albedo = reflectance * gain * (single * of.weight);
        let lobe = Reflection {
            weight: gain * of.weight,
            facets,
            fresnel: metal,
        };
        // A view below the bent normal sees no facet.
        if self.keeps_reflections() && facets.cos() > 0.0 {
            let lobe = if film.is_there() {
                filmed(lobe.under(film))
            } else {
                plain(lobe)
            };
            self.add(lobe, albedo);
        }
    }

    /// Adds reflection of one colour from facets that are not those of GGX.
    #[cold]
    pub(super) fn add_other_glossy(
        &mut self,
        color: Vec3,
        alpha: &Alpha,
        (normal, tangent): (Vec3, Option<Vec3>),
        distribution: Distribution,
    ) {
        let (lobe, cos) = if distribution == Distribution::AshikhminShirley {
            let lobe = Phong::new(color, self.normals(), (normal, tangent), self.wo(), alpha);
            (Lobe::Phong(lobe), lobe.cos())
        } else {
            let facets =
                Facets::<Beckmann>::new(self.normals(), normal, tangent, self.wo(), *alpha);
            let lobe = Reflection {
                weight: color,
                facets,
                fresnel: Fresnel::Constant,
            };
            (Lobe::BeckmannReflection(lobe), facets.cos())
        };
        // A view below the bent normal sees no facet.
        if self.keeps_reflections() && cos > 0.0 {
            self.add(lobe, color);
        }
    }
}
