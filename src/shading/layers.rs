//! What lies over a Principled BSDF's base: sheen, and below it a coat. Each leaves to what is below what it does not reflect.

use super::bsdf::{Bsdf, Changes};
use super::closure::{AllFeatures, BsdfFeatures, Facets, Lobe, Normals, Reflection, Sheen};
use super::dielectrics::Dielectrics;
use super::fresnel::{self, Fresnel};
use super::ggx::Alpha;
use super::principled::Principled;
use super::tables::{LutCoordinate, Reflection as Albedos, layer_albedo};
use crate::math::sqr;
use crate::scene::graph::ShaderRules;
use glam::Vec3;

/// A clear coat at a point.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// Its share.
    pub weight: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Index of refraction, at least 1.
    pub ior: f32,
    /// Colour of what goes through it straight.
    pub tint: Vec3,
    /// Its own normal.
    pub normal: Vec3,
}

/// Fibres at a point.
#[derive(Clone, Copy, Debug)]
pub struct Fibres {
    /// Their share.
    pub weight: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Colour.
    pub tint: Vec3,
}

/// What lies over the base at a point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Layers {
    /// The clear coat.
    pub coat: Option<Coat>,
    /// The fibres above it.
    pub fibres: Option<Fibres>,
    /// Whose version they follow.
    pub rules: ShaderRules,
}

impl Layers {
    /// The share of light from below that they let through to a viewer, as a colour: of what the base emits.
    pub fn transmittance(&self, normal: Vec3, wo: Vec3) -> Vec3 {
        let normals = Normals {
            geometric: normal,
            curved: normal,
            smooth: normal,
            shading: normal,
        };
        let mut above = Bsdf::<AllFeatures>::new(normals, wo, false, Changes::NONE);
        let (rest, tint) = above.add_layers(1.0, self, normal);
        tint * rest
    }
}

/// Layers of less weight are not there, as in Cycles.
const LEAST_WEIGHT: f32 = 1e-5;

impl<K: BsdfFeatures> Bsdf<K> {
    /// Adds the lobes of a Principled BSDF with layers.
    #[cold]
    #[inline(never)]
    pub fn add_layered(
        &mut self,
        weight: f32,
        (p, layers): (&Principled, &Layers),
        tables: &Dielectrics,
        (normal, tangent): (Vec3, Option<Vec3>),
    ) {
        let (rest, tint) = self.add_layers(weight, layers, normal);
        if rest <= 0.0 {
            return;
        }
        if tint == Vec3::ONE {
            self.add_principled(rest, p, tables, (normal, tangent));
            return;
        }
        let changes = self.changes();
        let mut below = Self::new(*self.normals(), self.wo(), self.is_inside(), changes);
        below.add_principled(rest, p, tables, (normal, tangent));
        self.add_all(&below, tint);
    }

    /// Adds what lies over a base: what is left to it, and the colour of what comes from it to the viewer.
    fn add_layers(&mut self, weight: f32, layers: &Layers, normal: Vec3) -> (f32, Vec3) {
        let coat = layers.coat.as_ref().filter(|c| c.weight > LEAST_WEIGHT);
        let fibres = layers.fibres.filter(|f| f.weight > LEAST_WEIGHT);
        let mut rest = weight;
        if let Some(fibres) = fibres {
            let normal = match coat {
                Some(coat) => normal.lerp(coat.normal, coat.weight.min(1.0)).normalize(),
                None => normal,
            };
            rest *= self.add_fibres(rest, fibres, normal);
        }
        let Some(coat) = coat else {
            return (rest, Vec3::ONE);
        };
        let (albedo, cos) = self.add_coat(rest, coat, layers.rules);
        let way = through(coat, cos);
        if layers.rules == ShaderRules::Since53 && way != Vec3::ONE {
            // What the coat covers gives the coat's light and its own through the coat; the rest its own.
            let left = Vec3::ONE - (Vec3::ONE - way * (1.0 - albedo)) * coat.weight;
            return (rest, left.clamp(Vec3::ZERO, Vec3::ONE));
        }
        let tint = Vec3::ONE.lerp(way, coat.weight).max(Vec3::ZERO);
        (rest * (1.0 - coat.weight * albedo).max(0.0), tint)
    }

    /// Adds fibres; the share of what is left to what lies below.
    fn add_fibres(&mut self, weight: f32, fibres: Fibres, normal: Vec3) -> f32 {
        let color = fibres.tint * fibres.weight;
        let Some(lobe) = Sheen::new(color * weight, fibres.roughness, normal, self.wo()) else {
            return 1.0;
        };
        self.add(Lobe::Sheen(lobe), lobe.albedo());
        (1.0 - lobe.albedo().max_element() / weight).max(0.0)
    }

    /// Adds the coat; what it reflects of the light on it, and the cosine of the view to it.
    fn add_coat(&mut self, weight: f32, coat: &Coat, rules: ShaderRules) -> (f32, f32) {
        let alpha = Alpha::isotropic(sqr(coat.roughness));
        let roughened = self.roughened(alpha);
        let facets = Facets::new(self.normals(), coat.normal, None, self.wo(), roughened);
        let cos = facets.cos();
        if !self.keeps_reflections() || coat.ior <= 1.0 {
            return (0.0, cos);
        }
        let f0 = fresnel::f0_from_ior(coat.ior);
        let average = f0 + (1.0 - f0) * fresnel::average_blend(coat.ior, f0);
        let reflectances = [f0, average].map(Vec3::splat);
        let albedos =
            (!alpha.is_smooth()).then(|| Albedos::at(LutCoordinate::new(cos, coat.roughness)));
        let gain = albedos.map_or(Vec3::ONE, |all| all.compensation(reflectances[1]));
        // A coat that is seen from behind reflects nothing, but darkens what is below as one seen along it.
        let view = (cos.max(0.0), coat.roughness);
        // From 5.3 on the base does not see what masking takes of the coat's light.
        let masked = albedos.as_ref().filter(|_| rules == ShaderRules::Before53);
        let albedo = layer_albedo(view, (coat.ior, rules), reflectances, masked);
        if cos <= 0.0 {
            return (albedo.max_element(), cos);
        }
        let share = weight * coat.weight;
        let fresnel = Fresnel::Dielectric {
            f0: Vec3::splat(f0),
            eta: coat.ior,
            true_f0: f0,
        };
        self.add(
            Lobe::Reflection(Reflection {
                weight: gain * share,
                facets,
                fresnel,
            }),
            albedo * share,
        );
        (albedo.max_element(), cos)
    }

    /// Adds the lobes of another BSDF, times a colour.
    fn add_all(&mut self, other: &Self, tint: Vec3) {
        let lambert = other.lambert();
        if lambert.color != Vec3::ZERO {
            self.add_lambert(lambert.color * tint, lambert.normal);
        }
        for (lobe, albedo) in other.lobes() {
            self.add(lobe.scaled(tint), albedo * tint);
        }
    }
}

/// The colour of what goes through the coat to the viewer, where it is there: by its way in it, as Cycles has it.
fn through(coat: &Coat, cos: f32) -> Vec3 {
    if coat.tint == Vec3::ONE {
        return Vec3::ONE;
    }
    let sine = (1.0 - sqr(cos)).max(0.0) / sqr(coat.ior.max(1.0));
    let way = 1.0 / (1.0 - sine).sqrt().max(1e-6);
    coat.tint.powf(way)
}

#[cfg(test)]
#[path = "../../tests/unit/shading/layers.rs"]
mod tests;
