//! Fibres whose boundary is of facets, with a round or elliptic section: Huang, Hullin and Hanika, *A Microfacet-based Hair Scattering
//! Model*, 2022; Blender's Principled Hair BSDF of that model.
//!
//! Figure 5 of the paper names the angles: φ of directions, γ of places on the ellipse. What is behind the first boundary is drawn,
//! in evaluations too, so that values of directions are estimates: a generator's numbers hang on the place and on the directions. Their
//! density has no formula: 1 stands for it, as in Cycles, where lights and directions share what they find.

mod draw;
mod evaluate;
mod section;

use super::LobeValue;
use crate::math::{Frame, mix};
use crate::shading::fresnel;
use crate::shading::ggx::{self, Alpha};
use crate::shading::tables::{LutCoordinate, Solids, refract};
use glam::{Vec2, Vec3};
use section::Section;
use std::f32::consts::PI;

/// A fibre's numbers.
#[derive(Clone, Copy, Debug)]
pub struct FacetFibre {
    /// What it absorbs on a radius of way.
    pub absorption: Vec3,
    /// α of its facets, 0.001 to 1.
    pub roughness: f32,
    /// Tilt of the scales, radians, toward the root.
    pub tilt: f32,
    /// Index of refraction.
    pub ior: f32,
    /// The lesser axis of its section over the greater one.
    pub aspect: f32,
    /// By what R, TT and TRT are scaled.
    pub ways: Vec3,
}

/// Where a fibre is seen.
#[derive(Clone, Copy, Debug)]
pub struct FibrePlace {
    /// Along the fibre, unit length.
    pub tangent: Vec3,
    /// The greater axis of the section; 0 where it is across the view.
    pub axis: Vec3,
    /// The smooth normal.
    pub normal: Vec3,
    /// Sine of the angle across flat strands; 0 elsewhere.
    pub across: f32,
    /// Half of a pixel over the radius: from 1 on all of the width is one.
    pub coverage: f32,
    /// A number of the place.
    pub seed: u32,
    /// Light that is sampled does not reach it on one side of its frame, as in Cycles on meshes from 5.0 on.
    pub masked: bool,
}

impl FibrePlace {
    /// The frame of a section of an aspect ratio, its lesser axis over its greater one, and the offset of the view across it.
    fn frame(&self, mut aspect: f32, wo: Vec3) -> (Frame, f32, f32) {
        let y = self.tangent;
        let across = y.cross(wo).try_normalize();
        let offset = if self.across != 0.0 {
            -self.across
        } else {
            -across.map_or(0.0, |x| x.dot(self.normal))
        };
        let mut x = across;
        if self.axis != Vec3::ZERO && aspect != 1.0 {
            let axis = self.axis.cross(y).normalize_or_zero();
            x = y.cross(axis).try_normalize().or(x);
            // As in Cycles, where the axes are turned twice: the greater one is the same.
            aspect = aspect.min(1.0 / aspect);
        }
        let x = x.unwrap_or_else(|| Frame::from_normal(y).x);
        let frame = Frame {
            x,
            y,
            z: x.cross(y),
        };
        (frame, aspect, offset.clamp(-1.0, 1.0))
    }

    /// Whether a view meets the section, and does not pass beside it, as on a flat strand that is wider than it.
    pub fn is_seen(&self, aspect: f32, wo: Vec3) -> bool {
        let (frame, aspect, offset) = self.frame(aspect, wo);
        offset.abs() < Section::new(aspect, frame.to_local(wo)).radius()
    }
}

/// Cosines that energies are kept for, by their roots.
const ENERGIES: usize = 8;

/// A fibre, as a view sees it.
#[derive(Clone, Copy, Debug)]
pub struct Huang {
    /// Weight of the lobe.
    pub(super) weight: Vec3,
    /// x along the greater axis or across the view, y along the fibre.
    frame: Frame,
    /// To the viewer, in the frame.
    wo: Vec3,
    of: FacetFibre,
    section: Section,
    /// Offset across the fibre, −1 to 1.
    offset: f32,
    coverage: f32,
    seed: u32,
    is_masked: bool,
    /// What a boundary's single scatterings leave of light, from outside and from within.
    energies: [[f32; ENERGIES]; 2],
}

/// O'Neill, *PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number Generation*, 2014.
struct Numbers(u32);

impl Numbers {
    fn new(seed: u32, direction: Vec3) -> Self {
        let bits = direction.to_array().map(f32::to_bits);
        let mut numbers = Self(seed);
        for bits in bits {
            numbers.0 ^= bits;
            numbers.next();
        }
        numbers
    }

    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        // 24 bits are all that a number below 1 keeps.
        (((word >> 22) ^ word) >> 8) as f32 / (1u32 << 24) as f32
    }

    fn pair(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }
}

/// Light that meets a boundary from one side, drawn.
struct Crossing {
    /// The facet.
    facet: Vec3,
    /// Cosine of the view to the mean normal, tilted.
    cos: f32,
    reflectance: f32,
    /// What goes through; 0 if nothing does.
    through: Vec3,
}

impl Huang {
    /// For a view of a place.
    pub fn new(
        weight: Vec3,
        of: &FacetFibre,
        place: &FibrePlace,
        wo: Vec3,
        solid: Option<&Solids>,
    ) -> Self {
        let mut of = *of;
        of.roughness = of.roughness.clamp(0.001, 1.0);
        let (frame, offset);
        (frame, of.aspect, offset) = place.frame(of.aspect, wo);
        let rough = of.roughness.sqrt();
        let energy = |i: usize, inside: bool| {
            let root = i as f32 / (ENERGIES - 1) as f32;
            let at = LutCoordinate::new(root * root, rough);
            solid.map_or(1.0, |solid| {
                1.0 / solid.compensation(at, (of.ior, inside), Vec3::ONE).x
            })
        };
        let wo = frame.to_local(wo);
        Self {
            weight,
            frame,
            wo,
            section: Section::new(of.aspect, wo),
            of,
            offset,
            coverage: place.coverage,
            seed: place.seed,
            is_masked: place.masked,
            energies: [false, true].map(|inside| std::array::from_fn(|i| energy(i, inside))),
        }
    }

    /// Whether the view passes beside the section, as on a flat strand that is wider than it.
    pub fn is_beside(&self) -> bool {
        self.offset.abs() >= self.section.radius()
    }

    /// Along the fibre, as denoisers are told.
    pub fn normal(&self) -> Vec3 {
        self.frame.y
    }

    /// Whether it is seen that wide that a pixel has but a part of its width.
    fn is_near(&self) -> bool {
        self.section.radius() > self.coverage
    }

    /// By what single scatterings are scaled for those that follow them, at a boundary that is met from outside or from within.
    fn scale(&self, cos: f32, inside: bool) -> f32 {
        let place = cos.clamp(0.0, 1.0).sqrt() * (ENERGIES - 1) as f32;
        let i = (place as usize).min(ENERGIES - 2);
        let energies = &self.energies[usize::from(inside)];
        1.0 / mix(energies[i], energies[i + 1], place - i as f32)
    }

    /// A visible facet about a mean normal.
    fn facet(&self, view: Vec3, mean: Vec3, u: Vec2) -> Vec3 {
        let frame = Frame::from_normal(mean);
        let alpha = Alpha::isotropic(self.of.roughness);
        frame.to_world(ggx::sample_visible_normal(
            frame.to_local(view),
            &alpha,
            1.0,
            u,
        ))
    }

    /// Light from `view` at a boundary with a mean normal, of an index behind it over that before it.
    fn cross(&self, view: Vec3, mean: Vec3, eta: f32, u: Vec2) -> Crossing {
        let facet = self.facet(view, mean, u);
        let found = fresnel::dielectric(view.dot(facet).abs(), eta);
        Crossing {
            facet,
            cos: view.dot(mean),
            reflectance: found.reflectance,
            through: match found.cos_t {
                cos if cos > 0.0 => refract(view, facet, cos, eta),
                _ => Vec3::ZERO,
            },
        }
    }

    /// What is left of light after the way between two places of the section.
    fn left(&self, direction: Vec3, way: f32) -> Vec3 {
        let slant = section::cos_theta(direction).max(1e-6);
        (-self.of.absorption * (way / slant)).exp()
    }

    /// What denoisers and passes take for its colour: a geometric series of a smooth round fibre, as Cycles estimates it.
    pub fn albedo(&self) -> Vec3 {
        let h = self.offset;
        let normal = Vec3::new(h, 0.0, (1.0 - h * h).max(0.0).sqrt());
        let found = fresnel::dielectric(normal.dot(self.wo).abs(), self.of.ior);
        let f = found.reflectance;
        let within = refract(self.wo, normal, found.cos_t, self.of.ior);
        let slant = (1.0 - within.y * within.y).max(1e-6);
        let a = (self.of.absorption * (-2.0 * found.cos_t / slant)).exp();
        let below = (Vec3::ONE - a * f).max(Vec3::splat(1e-6));
        (a - a * (2.0 * f) + Vec3::splat(f)) / below
    }

    /// Masking and shadowing of both directions over that of the first.
    fn masked_after(&self, cos_in: f32, cos_out: f32) -> f32 {
        let (a, b) = (self.lambda(cos_in), self.lambda(cos_out));
        (1.0 + a) / (1.0 + a + b)
    }

    fn masked(&self, cos_in: f32, cos_out: f32) -> f32 {
        1.0 / (1.0 + self.lambda(cos_in) + self.lambda(cos_out))
    }

    /// Smith's Λ by a cosine.
    fn lambda(&self, cos: f32) -> f32 {
        let tan2 = (1.0 / (cos * cos) - 1.0).max(0.0);
        0.5 * ((1.0 + self.of.roughness * self.of.roughness * tan2).sqrt() - 1.0)
    }

    /// The distribution of facets by the cosine of one to the mean normal.
    fn facets(&self, cos: f32) -> f32 {
        let alpha2 = self.of.roughness * self.of.roughness;
        let cos2 = (cos * cos).min(1.0);
        let below = 1.0 - cos2 + alpha2 * cos2;
        alpha2 / (PI * below * below)
    }

    /// Value and density. The value is an estimate.
    pub fn evaluate(&self, wi: Vec3) -> LobeValue {
        LobeValue {
            value: self.value(self.frame.to_local(wi)) * self.weight,
            pdf: 1.0,
        }
    }

    /// What that has too much of where Cycles samples a light: nothing, but on one side on meshes.
    pub fn evaluate_backs(&self, smooth: Vec3, wi: Vec3) -> LobeValue {
        let normal = self.frame.x;
        if self.is_masked && smooth.dot(wi) * smooth.dot(normal) * normal.dot(wi) < 0.0 {
            let LobeValue { value, pdf } = self.evaluate(wi);
            return LobeValue {
                value: -value,
                pdf: -pdf,
            };
        }
        LobeValue::ZERO
    }

    /// Bound of the value of samples: the mean of the channels decides, each boundary gives back what its single scatterings lose.
    pub fn max_sample_weight(&self) -> f32 {
        let [outer, inner] = self.energies.map(|of| {
            of.into_iter()
                .fold(0f32, |most, energy| most.max(1.0 / energy))
        });
        let most = self.of.ways.max_element().max(1.0);
        3.0 * outer * inner * inner * most * self.weight.max_element()
    }
}

/// A direction mirrored at a facet.
fn mirror(view: Vec3, facet: Vec3) -> Vec3 {
    facet * (2.0 * view.dot(facet)) - view
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/closure/huang.rs"]
mod tests;
