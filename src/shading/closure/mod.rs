//! Closures: the lobes of BSDFs, one file each. [`super::Bsdf`] mixes them.
//!
//! A lobe knows its weight, its own normal and its view. Directions `wo` (to the viewer) and `wi` (to the light) point away
//! from the surface, in world space. A new lobe is a file here, a variant of [`Lobe`], and a case of its test.

pub mod ashikhmin;
pub mod below;
pub mod chiang;
pub mod diffuse;
pub mod glass;
pub mod hair;
pub mod huang;
pub mod microfacet;
pub mod portal;
pub mod rough_diffuse;
pub mod sheen;
mod sheen_table;
pub mod sheet;
pub mod toon;
pub mod translucent;

#[cfg(test)]
#[path = "../../../tests/unit/shading/closure/mod.rs"]
mod tests;

pub use ashikhmin::{Phong, Velvet};
pub use below::{Below, BelowInputs};
pub use chiang::{Chiang, Fibre};
pub use diffuse::Diffuse;
pub use glass::Glass;
pub use hair::Hair;
pub use huang::{FacetFibre, FibrePlace, Huang};
pub use microfacet::{Facets, Reflection};
pub use portal::Portal;
pub use rough_diffuse::RoughDiffuse;
pub use sheen::Sheen;
pub use sheet::Sheet;
pub use toon::Toon;
pub use translucent::Translucent;

use super::Scattering;
use super::normal;
use super::spread::{Beckmann, Ggx, Spread};
use super::thin_film::{Film, Filmed};
use crate::scene::{RayKind, Visibility};
use glam::{Vec2, Vec3};

/// The normals at a point.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    /// Of the triangle, on the side of the viewer.
    pub geometric: Vec3,
    /// Interpolated from the corners, on the same side.
    pub curved: Vec3,
    /// The same, or what a displacement that is a bump makes of it: the normal of shaders that have none of their own.
    pub smooth: Vec3,
    /// With the normal map.
    pub shading: Vec3,
}

impl Normals {
    /// A lobe's own normal, bent so far that it mirrors a view to above the surface: as in Cycles also where nothing is mirrored.
    #[inline(always)]
    pub fn bent(&self, normal: Vec3, wo: Vec3) -> Vec3 {
        if normal == self.geometric {
            normal
        } else {
            normal::bend_for_reflection(self.geometric, wo, normal)
        }
    }
}

/// Value and density of a lobe for two directions.
#[derive(Clone, Copy, Debug)]
pub struct LobeValue {
    /// The lobe's weight · BSDF · |cos|.
    pub value: Vec3,
    /// Density with which the lobe's sampling finds the direction, per solid angle.
    pub pdf: f32,
}

impl LobeValue {
    /// No light.
    pub const ZERO: Self = Self {
        value: Vec3::ZERO,
        pdf: 0.0,
    };
}

/// A direction drawn from a lobe.
#[derive(Clone, Copy, Debug)]
pub struct LobeSample {
    /// Direction to go on.
    pub wi: Vec3,
    /// It goes through the surface.
    pub transmitted: bool,
    /// The direction could not have been found otherwise. Then `of` has the weight times the probability of this choice, and
    /// that probability.
    pub delta: bool,
    /// Value and density.
    pub of: LobeValue,
}

impl LobeSample {
    /// A direction on the side of the viewer; `None` if its density is 0.
    #[inline]
    pub(super) fn reflected(wi: Vec3, of: LobeValue) -> Option<Self> {
        (of.pdf > 0.0).then_some(Self {
            wi,
            transmitted: false,
            delta: false,
            of,
        })
    }

    /// A direction on the other side; `None` if its density is 0.
    #[inline]
    pub(super) fn transmitted(wi: Vec3, of: LobeValue) -> Option<Self> {
        Self::reflected(wi, of).map(|sample| Self {
            transmitted: true,
            ..sample
        })
    }
}

/// What a kernel knows of the surfaces of its scenes when it is compiled; the bits are the same with and without.
pub trait BsdfFeatures {
    /// Anything but Lambertian lobes.
    const FACETS: bool;
    /// Lobes that let light through.
    const TRANSMISSION: bool;
    /// Normals of vertices.
    const SMOOTH: bool;
    /// Normals that differ from the smooth one: normal maps, and lobes with normals of their own.
    const BUMPS: bool;
}

/// Surfaces of all kinds.
#[derive(Clone, Copy, Debug)]
pub struct AllFeatures;

impl BsdfFeatures for AllFeatures {
    const FACETS: bool = true;
    const TRANSMISSION: bool = true;
    const SMOOTH: bool = true;
    const BUMPS: bool = true;
}

/// A lobe beside the Lambertian one.
#[derive(Clone, Copy, Debug)]
pub enum Lobe {
    /// Lambertian reflection about another normal.
    Diffuse(Diffuse),
    /// Rough diffuse reflection.
    RoughDiffuse(RoughDiffuse),
    /// Reflection from facets: metals, glossy surfaces, the dielectric layer over a diffuse base.
    Reflection(Reflection),
    /// The boundary of a transmitting solid.
    Glass(Glass),
    /// A thin transmitting sheet.
    Sheet(Sheet),
    /// Reflection from facets of Beckmann's distribution.
    BeckmannReflection(Reflection<Beckmann>),
    /// The boundary of a solid with them.
    BeckmannGlass(Glass<Beckmann>),
    /// Reflection from facets under a thin film.
    FilmReflection(Reflection<Ggx, Filmed>),
    /// The boundary of a solid under a thin film.
    FilmGlass(Glass<Ggx, Film>),
    /// Reflection from facets of Beckmann's distribution under a thin film.
    BeckmannFilmReflection(Reflection<Beckmann, Filmed>),
    /// The boundary of a solid with them.
    BeckmannFilmGlass(Glass<Beckmann, Film>),
    /// Reflection from facets of a Phong distribution.
    Phong(Phong),
    /// A layer of fibres.
    Sheen(Sheen),
    /// Facets that stand on end.
    Velvet(Velvet),
    /// A cone of light that counts.
    Toon(Toon),
    /// Diffuse transmission.
    Translucent(Translucent),
    /// Light that goes on below the surface.
    Below(Below),
    /// What meets it goes on elsewhere.
    Portal(Portal),
    /// A highlight of fibres.
    Hair(Hair),
    /// Fibres by the ways of light through them.
    Chiang(Chiang),
    /// Fibres whose boundary is of facets.
    Huang(Huang),
}

/// Keeps what seldom happens out of the loops of what mostly does.
#[cold]
#[inline(never)]
fn seldom<T>(what: impl FnOnce() -> T) -> T {
    what()
}

impl Lobe {
    /// Value and density for a direction to the light; `transmitted` if it is beyond the surface. None of a mirror's.
    #[inline(always)]
    pub fn evaluate<K: BsdfFeatures>(
        &self,
        smooth: Vec3,
        wi: Vec3,
        transmitted: bool,
    ) -> LobeValue {
        match self {
            Self::Diffuse(l) if !transmitted => l.evaluate((smooth, l.normal != smooth), wi),
            Self::RoughDiffuse(l) if !transmitted => l.evaluate(smooth, wi),
            Self::Reflection(l) if !transmitted => l.evaluate(smooth, wi),
            Self::Sheen(l) if !transmitted => l.evaluate(smooth, wi),
            Self::BeckmannReflection(l) if !transmitted => l.evaluate(smooth, wi),
            Self::FilmReflection(l) if !transmitted => l.evaluate(smooth, wi),
            Self::BeckmannFilmReflection(l) if !transmitted => seldom(|| l.evaluate(smooth, wi)),
            Self::Phong(l) if !transmitted => l.evaluate(smooth, wi),
            Self::Velvet(l) if !transmitted => l.evaluate(smooth, wi),
            Self::Toon(l) if !transmitted => l.evaluate(smooth, wi),
            Self::Translucent(l) if K::TRANSMISSION && transmitted => l.evaluate(wi),
            Self::BeckmannGlass(l) if K::TRANSMISSION => l.evaluate(smooth, wi, transmitted),
            Self::FilmGlass(l) if K::TRANSMISSION => l.evaluate(smooth, wi, transmitted),
            Self::BeckmannFilmGlass(l) if K::TRANSMISSION => {
                seldom(|| l.evaluate(smooth, wi, transmitted))
            }
            Self::Glass(l) if K::TRANSMISSION => l.evaluate(smooth, wi, transmitted),
            Self::Sheet(l) if K::TRANSMISSION => l.evaluate(smooth, wi, transmitted),
            Self::Hair(l) if K::TRANSMISSION => seldom(|| l.evaluate(wi)),
            Self::Chiang(l) if K::TRANSMISSION => seldom(|| l.evaluate(wi)),
            Self::Huang(l) if K::TRANSMISSION => seldom(|| l.evaluate(wi)),
            _ => LobeValue::ZERO,
        }
    }

    /// Whether light sampling brings it light that some kinds of rays see, as in Cycles: glass has what either of its kinds sees, what
    /// goes through diffusely is diffuse, and facets that stand on end are glossy. `transmitted`: from beyond the surface.
    pub fn is_lit(&self, light: Visibility, transmitted: bool) -> bool {
        let [diffuse, glossy, through] =
            [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission].map(|k| light.sees(k));
        match self {
            Self::Translucent(_) => diffuse,
            Self::Velvet(_) => glossy,
            _ if self.is_glass() => glossy || through,
            Self::Sheet(_) if transmitted => through,
            Self::Sheet(_) => glossy,
            _ if self.is_diffuse() => diffuse,
            _ if self.is_of_fibres() && !self.is_through(transmitted) => glossy,
            _ if self.transmits() => through,
            _ => glossy,
        }
    }

    /// Whether it is glass that reflects.
    #[inline]
    fn is_glass(&self) -> bool {
        let reflected = match self {
            Self::BeckmannGlass(l) => l.reflected,
            Self::FilmGlass(l) => l.reflected,
            Self::BeckmannFilmGlass(l) => l.reflected,
            Self::Glass(l) => l.reflected,
            _ => Vec3::ZERO,
        };
        reflected != Vec3::ZERO
    }

    /// The density of reflections where all visible facets are drawn, over that of those which are drawn.
    #[inline]
    pub fn share_of_all_facets(&self) -> f32 {
        match self {
            Self::Reflection(l) => l.facets.share_of_all(),
            Self::BeckmannReflection(l) => l.facets.share_of_all(),
            Self::FilmReflection(l) => l.facets.share_of_all(),
            Self::BeckmannFilmReflection(l) => l.facets.share_of_all(),
            _ => 1.0,
        }
    }

    /// What [`Self::evaluate`] leaves out of light that is sampled beyond the surface, or has too much, as Cycles has it.
    #[inline]
    pub fn evaluate_backs<K: BsdfFeatures>(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        match self {
            Self::Translucent(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::BeckmannGlass(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::FilmGlass(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::BeckmannFilmGlass(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::Glass(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::Hair(l) if K::TRANSMISSION => l.evaluate_backs(wi),
            Self::Chiang(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            Self::Huang(l) if K::TRANSMISSION => l.evaluate_backs(smooth, wi),
            _ => LobeValue::ZERO,
        }
    }

    /// What [`Self::evaluate`] leaves out of light that is sampled before the surface, as Cycles has it.
    #[inline]
    pub fn evaluate_before<K: BsdfFeatures>(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        match self {
            Self::Translucent(l) if K::TRANSMISSION => l.evaluate_before(smooth, wi),
            _ => LobeValue::ZERO,
        }
    }

    /// Draws a direction; `choice` in 0..1 decides between reflection and transmission.
    #[inline(always)]
    pub fn sample<K: BsdfFeatures>(
        &self,
        smooth: Vec3,
        u: Vec2,
        choice: f32,
    ) -> Option<LobeSample> {
        match self {
            Self::Diffuse(l) => l.sample(smooth, u),
            Self::RoughDiffuse(l) => l.sample(smooth, u),
            Self::Reflection(l) => l.sample(smooth, u),
            Self::Sheen(l) => l.sample(smooth, u),
            Self::BeckmannReflection(l) => l.sample(smooth, u),
            Self::FilmReflection(l) => l.sample(smooth, u),
            Self::BeckmannFilmReflection(l) => seldom(|| l.sample(smooth, u)),
            Self::Phong(l) => l.sample(smooth, u),
            Self::Velvet(l) => l.sample(smooth, u),
            Self::Toon(l) => l.sample(smooth, u),
            Self::Translucent(l) if K::TRANSMISSION => l.sample(u),
            Self::BeckmannGlass(l) if K::TRANSMISSION => l.sample(smooth, u, choice),
            Self::FilmGlass(l) if K::TRANSMISSION => l.sample(smooth, u, choice),
            Self::BeckmannFilmGlass(l) if K::TRANSMISSION => seldom(|| l.sample(smooth, u, choice)),
            Self::Glass(l) if K::TRANSMISSION => l.sample(smooth, u, choice),
            Self::Sheet(l) if K::TRANSMISSION => l.sample(smooth, u, choice),
            Self::Hair(l) if K::TRANSMISSION => seldom(|| l.sample(u)),
            Self::Chiang(l) if K::TRANSMISSION => seldom(|| l.sample(u, choice)),
            Self::Huang(l) if K::TRANSMISSION => seldom(|| l.sample(u, choice)),
            _ => None,
        }
    }

    /// The kind of what the lobe does on the viewer's side.
    #[inline]
    pub fn is_diffuse(&self) -> bool {
        if let Self::Toon(l) = self {
            return !l.is_glossy();
        }
        matches!(
            self,
            Self::Diffuse(_)
                | Self::RoughDiffuse(_)
                | Self::Sheen(_)
                | Self::Velvet(_)
                | Self::Below(_)
        )
    }

    /// Whether light sampling brings it light from the other side.
    #[inline]
    pub fn is_lit_behind(&self) -> bool {
        match self {
            Self::Hair(l) => l.is_through(),
            _ => self.transmits(),
        }
    }

    /// Whether it is of fibres: those know no side of a surface, and a sample of theirs says `transmitted` of its way through them.
    #[inline]
    pub fn is_of_fibres(&self) -> bool {
        matches!(self, Self::Hair(_) | Self::Chiang(_) | Self::Huang(_))
    }

    /// Whether passes have its light among what goes through; `beyond`: it is from beyond the surface. Those of Cycles have all of a
    /// Principled Hair BSDF among reflections.
    #[inline]
    pub fn is_through(&self, beyond: bool) -> bool {
        match self {
            Self::Hair(l) => l.is_through(),
            Self::Chiang(_) | Self::Huang(_) => false,
            _ => beyond,
        }
    }

    /// What a sample of the lobe did to its path.
    #[inline]
    pub fn scattering(&self, transmitted: bool) -> Scattering {
        match self {
            _ if transmitted => Scattering::Transmission,
            _ if self.is_diffuse() => Scattering::Diffuse,
            _ => Scattering::Glossy,
        }
    }

    /// Whether all directions are found by sampling the lobe alone.
    #[inline]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Diffuse(_)
            | Self::RoughDiffuse(_)
            | Self::Sheen(_)
            | Self::Velvet(_)
            | Self::Toon(_)
            | Self::Translucent(_)
            | Self::Hair(_)
            | Self::Chiang(_)
            | Self::Huang(_) => false,
            Self::Reflection(l) => l.facets.is_smooth(),
            Self::BeckmannReflection(l) => l.facets.is_smooth(),
            Self::BeckmannGlass(l) => l.facets.is_smooth(),
            Self::FilmReflection(l) => l.facets.is_smooth(),
            Self::BeckmannFilmReflection(l) => l.facets.is_smooth(),
            Self::FilmGlass(l) => l.facets.is_smooth(),
            Self::BeckmannFilmGlass(l) => l.facets.is_smooth(),
            Self::Phong(l) => l.is_smooth(),
            Self::Glass(l) => l.facets.is_smooth(),
            Self::Sheet(l) => l.facets.is_smooth(),
            Self::Below(_) | Self::Portal(_) => true,
        }
    }

    /// Whether light goes through straight on, or bent by one angle alone, although what is reflected does not.
    #[inline]
    pub fn is_straight(&self) -> bool {
        match self {
            Self::Glass(l) => l.is_straight(),
            Self::BeckmannGlass(l) => l.is_straight(),
            Self::FilmGlass(l) => l.is_straight(),
            Self::BeckmannFilmGlass(l) => l.is_straight(),
            _ => false,
        }
    }

    /// Whether light goes through.
    #[inline]
    pub fn transmits(&self) -> bool {
        matches!(
            self,
            Self::Glass(_)
                | Self::BeckmannGlass(_)
                | Self::FilmGlass(_)
                | Self::BeckmannFilmGlass(_)
                | Self::Sheet(_)
                | Self::Translucent(_)
                | Self::Hair(_)
                | Self::Chiang(_)
                | Self::Huang(_)
        )
    }

    /// The lobe's own normal.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        match self {
            Self::Diffuse(l) => l.normal,
            Self::RoughDiffuse(l) => l.normal,
            Self::Sheen(l) => l.normal(),
            Self::Velvet(l) => l.normal(),
            Self::Toon(l) => l.normal(),
            Self::BeckmannReflection(l) => l.facets.normal(),
            Self::BeckmannGlass(l) => l.facets.normal(),
            Self::FilmReflection(l) => l.facets.normal(),
            Self::BeckmannFilmReflection(l) => l.facets.normal(),
            Self::FilmGlass(l) => l.facets.normal(),
            Self::BeckmannFilmGlass(l) => l.facets.normal(),
            Self::Phong(l) => l.facets.normal(),
            Self::Translucent(l) => l.normal,
            Self::Reflection(l) => l.facets.normal(),
            Self::Glass(l) => l.facets.normal(),
            Self::Sheet(l) => l.facets.normal(),
            Self::Below(l) => l.normal,
            Self::Portal(l) => l.normal,
            Self::Hair(l) => l.normal(),
            Self::Chiang(l) => l.normal(),
            Self::Huang(l) => l.normal(),
        }
    }

    /// α of the facets, the geometric mean of both; 0 of mirrors and clear glass, and 1 of lobes without facets.
    pub fn alpha(&self) -> f32 {
        let alpha = match self {
            Self::Below(_) => return 1.0,
            Self::Portal(_) => return 0.0,
            _ if self.is_delta() => return 0.0,
            Self::Reflection(l) => l.facets.alpha(),
            Self::Glass(l) => l.facets.alpha(),
            Self::Sheet(l) => l.facets.alpha(),
            Self::BeckmannReflection(l) => l.facets.alpha(),
            Self::BeckmannGlass(l) => l.facets.alpha(),
            Self::FilmReflection(l) => l.facets.alpha(),
            Self::BeckmannFilmReflection(l) => l.facets.alpha(),
            Self::FilmGlass(l) => l.facets.alpha(),
            Self::BeckmannFilmGlass(l) => l.facets.alpha(),
            Self::Phong(l) => l.facets.alpha(),
            Self::Diffuse(_)
            | Self::RoughDiffuse(_)
            | Self::Sheen(_)
            | Self::Velvet(_)
            | Self::Toon(_)
            | Self::Translucent(_)
            | Self::Hair(_)
            | Self::Chiang(_)
            | Self::Huang(_) => return 1.0,
        };
        (alpha.xy.x * alpha.xy.y).sqrt()
    }

    /// Share of the albedo that is reflected, and that goes through; both without tint if `albedo` is.
    pub fn colors(&self, albedo: Vec3) -> [Vec3; 2] {
        match self {
            Self::Diffuse(_)
            | Self::RoughDiffuse(_)
            | Self::Reflection(_)
            | Self::BeckmannReflection(_)
            | Self::FilmReflection(_)
            | Self::BeckmannFilmReflection(_)
            | Self::Phong(_)
            | Self::Sheen(_)
            | Self::Velvet(_)
            | Self::Toon(_)
            | Self::Below(_)
            | Self::Chiang(_)
            | Self::Huang(_) => [albedo, Vec3::ZERO],
            Self::Hair(l) if !l.is_through() => [albedo, Vec3::ZERO],
            Self::Hair(_) => [Vec3::ZERO, albedo],
            Self::Translucent(_) | Self::Portal(_) => [Vec3::ZERO, albedo],
            Self::Glass(l) => l.colors(albedo),
            Self::BeckmannGlass(l) => l.facets.colors(albedo, l.tint, |cos| l.facet(cos)),
            Self::FilmGlass(l) => l.facets.colors(albedo, l.tint, |cos| l.facet(cos)),
            Self::BeckmannFilmGlass(l) => l.facets.colors(albedo, l.tint, |cos| l.facet(cos)),
            Self::Sheet(l) => l.facets.colors(albedo, l.tint, |cos| l.facet(cos)),
        }
    }

    /// What a boundary scatters of light that comes from the view, tinted, by a facet along its normal: `albedo` of those is without
    /// tint. As Cycles draws lobes by it (`bsdf_microfacet_estimate_albedo`), what is clamped hangs on it.
    pub fn passed_on(&self) -> Option<Vec3> {
        let facet = match self {
            Self::Glass(l) => l.facet(l.facets.cos()),
            Self::BeckmannGlass(l) => l.facet(l.facets.cos()),
            Self::FilmGlass(l) => l.facet(l.facets.cos()),
            Self::BeckmannFilmGlass(l) => l.facet(l.facets.cos()),
            Self::Sheet(l) => l.facet(l.facets.cos()),
            _ => return None,
        };
        Some(facet.reflectance + facet.transmittance)
    }

    /// The same lobe with another weight.
    #[must_use]
    pub fn scaled(mut self, by: Vec3) -> Self {
        match &mut self {
            Self::Diffuse(l) => l.color *= by,
            Self::RoughDiffuse(l) => l.weight *= by,
            Self::Reflection(l) => l.weight *= by,
            Self::BeckmannReflection(l) => l.weight *= by,
            Self::FilmReflection(l) => l.weight *= by,
            Self::BeckmannFilmReflection(l) => l.weight *= by,
            Self::Phong(l) => l.weight *= by,
            Self::Velvet(l) => l.weight *= by,
            Self::Glass(Glass {
                weight, reflected, ..
            })
            | Self::BeckmannGlass(Glass {
                weight, reflected, ..
            })
            | Self::FilmGlass(Glass {
                weight, reflected, ..
            })
            | Self::BeckmannFilmGlass(Glass {
                weight, reflected, ..
            })
            | Self::Sheet(Sheet {
                weight, reflected, ..
            }) => {
                *weight *= by;
                *reflected *= by;
            }
            Self::Sheen(l) => *l = l.scaled(by),
            Self::Toon(l) => l.weight *= by,
            Self::Translucent(l) => l.color *= by,
            Self::Below(l) => l.weight *= by,
            Self::Portal(l) => l.weight *= by,
            Self::Hair(l) => l.weight *= by,
            Self::Chiang(l) => l.weight *= by,
            Self::Huang(l) => l.weight *= by,
        }
        self
    }

    /// Bound of the value over the density of samples, each choice by its probability.
    pub fn max_sample_weight(&self) -> f32 {
        match self {
            Self::Diffuse(l) => l.color.max_element(),
            Self::RoughDiffuse(l) => l.max_sample_weight(),
            Self::Sheen(l) => l.albedo().max_element(),
            Self::Toon(l) => l.weight.max_element(),
            Self::Translucent(l) => l.color.max_element(),
            Self::Reflection(l) => l.weight.max_element(),
            Self::BeckmannReflection(l) => Beckmann::EXCESS * l.weight.max_element(),
            Self::FilmReflection(l) => l.weight.max_element(),
            Self::BeckmannFilmReflection(l) => Beckmann::EXCESS * l.weight.max_element(),
            Self::FilmGlass(l) => 3.0 * l.weight.max(l.reflected).max_element(),
            Self::BeckmannFilmGlass(l) => {
                3.0 * Beckmann::EXCESS * l.weight.max(l.reflected).max_element()
            }
            Self::Phong(l) => l.weight.max_element(),
            Self::Velvet(l) => l.max_sample_weight(),
            // The choice is by the mean of the channels, of which each is at most three times the mean.
            Self::Glass(l) => 3.0 * l.weight.max(l.reflected).max_element(),
            Self::BeckmannGlass(l) => {
                3.0 * Beckmann::EXCESS * l.weight.max(l.reflected).max_element()
            }
            Self::Sheet(l) => 3.0 * l.weight.max(l.reflected).max_element(),
            Self::Hair(l) => l.weight.max_element(),
            Self::Chiang(l) => l.max_sample_weight(),
            Self::Huang(l) => l.max_sample_weight(),
            // None is drawn.
            Self::Below(_) | Self::Portal(_) => 0.0,
        }
    }
}
