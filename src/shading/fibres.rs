//! Blender's shaders of fibres: Hair BSDF and Principled Hair BSDF.

use super::bsdf::Bsdf;
use super::closure::chiang::color_scale;
use super::closure::{BsdfFeatures, Chiang, FacetFibre, Fibre, FibrePlace, Hair, Huang, Lobe};
use super::dielectrics::Dielectrics;
use super::fresnel;
use super::program::{Evaluation, Place, Root, Strand, reflected};
use super::simple::SimpleValues;
use crate::scene::graph::node::{hair, principled_hair as inputs};
use crate::scene::graph::{HairColoring, HairFibre, HairModel};
use glam::{Vec2, Vec3};

/// What eumelanin and pheomelanin absorb on a radius of way (d'Eon et al., *An Energy-Conserving Hair Reflectance Model*, 2011,
/// by the constants that Cycles documents).
const EUMELANIN: Vec3 = Vec3::new(0.506, 0.841, 1.653);
const PHEOMELANIN: Vec3 = Vec3::new(0.343, 0.733, 1.924);

/// What a fibre absorbs of which much reflects a colour, by its roughness around (Chiang et al., eq. 9).
pub fn absorption_of_color(color: Vec3, roughness: f32) -> Vec3 {
    // Of black the logarithm would be infinite.
    let logarithms = color.max(Vec3::splat(f32::MIN_POSITIVE)).map(f32::ln);
    let root = logarithms / color_scale(roughness);
    root * root
}

/// What a fibre absorbs for an amount of melanin from 0 to 1, as the eye has it, and the share of it that is red.
pub fn absorption_of_melanin(amount: f32, redness: f32) -> Vec3 {
    let melanin = -(1.0 - amount).max(1e-4).ln();
    EUMELANIN * (melanin * (1.0 - redness)) + PHEOMELANIN * (melanin * redness)
}

/// The sockets of a fibre, read.
struct Read {
    absorption: Vec3,
    /// Along the fibre and around it.
    roughness: Vec2,
    ior: f32,
    tilt: f32,
}

impl Read {
    fn new<P: Place>(
        of: HairFibre,
        sockets: &[Root],
        at: &mut Evaluation<'_, P>,
        strand: &Strand,
    ) -> Self {
        let random = if of.own_random && strand.is_strand {
            strand.random
        } else {
            at.number(&sockets[inputs::RANDOM])
        };
        // From one less the half to one more.
        let varied = |by: f32| 1.0 + 2.0 * (random - 0.5) * by;
        let factor = varied(at.number(&sockets[inputs::RANDOM_ROUGHNESS]));
        let along = at.number(&sockets[inputs::ROUGHNESS]) * factor;
        let around = match of.model {
            HairModel::Chiang => at.number(&sockets[inputs::RADIAL_ROUGHNESS]) * factor,
            HairModel::Huang => along,
        };
        let absorption = match of.coloring {
            HairColoring::Absorption => at.color(&sockets[inputs::ABSORPTION]).max(Vec3::ZERO),
            HairColoring::Reflectance => {
                absorption_of_color(reflected(at.color(&sockets[inputs::COLOR])), around)
            }
            HairColoring::Melanin => {
                let varied = varied(at.number(&sockets[inputs::RANDOM_COLOR]).clamp(0.0, 1.0));
                let melanin = at.number(&sockets[inputs::MELANIN]) * varied;
                let redness = at.number(&sockets[inputs::MELANIN_REDNESS]);
                let tint = reflected(at.color(&sockets[inputs::TINT]));
                let both =
                    absorption_of_melanin(melanin, redness) + absorption_of_color(tint, around);
                both.max(Vec3::ZERO)
            }
        };
        Self {
            absorption,
            roughness: Vec2::new(along, around),
            ior: fresnel::bounded_ior(match of.model {
                // Its square alone counts, as in Cycles.
                HairModel::Chiang => at.number(&sockets[inputs::IOR]).abs(),
                HairModel::Huang => at.number(&sockets[inputs::IOR]),
            }),
            // Toward the root.
            tilt: -at.number(&sockets[inputs::OFFSET]),
        }
    }
}

impl FibrePlace {
    /// Of a strand or a mesh, where its smooth normal is that.
    pub fn of(strand: &Strand, normal: Vec3) -> Self {
        let axis = match strand.is_strand && strand.normal == Vec3::ZERO {
            true => some_axis(strand.tangent),
            false => strand.normal,
        };
        Self {
            tangent: strand.tangent,
            axis,
            normal,
            across: strand.across,
            coverage: strand.coverage,
            seed: strand.seed,
            masked: false,
        }
    }
}

/// The axis of sections of strands without normals, as in Cycles, where it hangs on Blender's axes.
fn some_axis(tangent: Vec3) -> Vec3 {
    let t = Vec3::new(tangent.x, -tangent.z, tangent.y);
    let z = if t.x != t.y || t.x != t.z {
        Vec3::new(t.z - t.y, t.x - t.z, t.y - t.x)
    } else {
        Vec3::new(t.z - t.y, t.x + t.z, -t.y - t.x)
    };
    let axis = t.cross(z).normalize_or_zero();
    Vec3::new(axis.x, axis.z, -axis.y)
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// Adds the lobe of a Hair BSDF.
    pub(super) fn add_hair<P: Place>(
        &mut self,
        of: &SimpleValues<'_>,
        at: &mut Evaluation<'_, P>,
        transmits: bool,
    ) {
        let (sockets, strand) = (of.sockets, at.place().strand());
        let color = reflected(at.color(&sockets[hair::COLOR])) * of.weight;
        let mut offset = -at.number(&sockets[hair::OFFSET]);
        let given = at.color(&sockets[hair::TANGENT]);
        let tangent = if given != Vec3::ZERO {
            // It stands outside, but is a direction that does not hang on the side that is seen.
            if self.is_inside() { -given } else { given }
        } else if strand.is_strand {
            strand.tangent
        } else {
            // As in Cycles on meshes.
            offset = 0.0;
            strand.second
        };
        let roughness = Vec2::new(
            at.number(&sockets[hair::ROUGHNESS_U]),
            at.number(&sockets[hair::ROUGHNESS_V]),
        );
        let smooth = self.normals().smooth;
        let normal = match strand.is_strand {
            true => smooth,
            false => self.normals().bent(smooth, self.wo()),
        };
        let frame = (normal, tangent);
        if let Some(lobe) = Hair::new(color, frame, self.wo(), (offset, roughness), transmits) {
            self.add(Lobe::Hair(lobe), color);
        }
    }

    /// Adds the lobe of a Principled Hair BSDF.
    pub(super) fn add_principled_hair<P: Place>(
        &mut self,
        of: &SimpleValues<'_>,
        at: &mut Evaluation<'_, P>,
        tables: &Dielectrics,
        fibre: HairFibre,
    ) {
        let (sockets, strand) = (of.sockets, at.place().strand());
        let read = Read::new(fibre, sockets, at, &strand);
        let weight = Vec3::splat(of.weight);
        let is_masked = fibre.is_masked && !strand.is_strand;
        let least = self.changes().least_alpha;
        match fibre.model {
            HairModel::Chiang => {
                let coat = at.number(&sockets[inputs::COAT]).clamp(0.0, 1.0);
                let of = Fibre {
                    absorption: read.absorption,
                    roughness: read.roughness,
                    first: 1.0 - coat,
                    tilt: read.tilt,
                    ior: read.ior,
                };
                let place = (strand.tangent, self.normals().geometric, strand.across);
                let lobe = Chiang::new(weight, &of, place, self.wo(), (least, is_masked));
                if lobe.lets_in(of.ior) {
                    self.add(Lobe::Chiang(lobe), lobe.albedo());
                }
            }
            HairModel::Huang => {
                let mut number = |socket: usize| at.number(&sockets[socket]).max(0.0);
                let of = FacetFibre {
                    absorption: read.absorption,
                    roughness: read.roughness.x.clamp(0.001, 1.0).max(least),
                    tilt: read.tilt,
                    ior: read.ior,
                    aspect: number(inputs::ASPECT_RATIO).max(1e-3),
                    ways: Vec3::new(
                        number(inputs::REFLECTION),
                        number(inputs::TRANSMISSION),
                        number(inputs::SECONDARY_REFLECTION),
                    ),
                };
                let place = FibrePlace {
                    masked: is_masked,
                    ..FibrePlace::of(&strand, self.normals().smooth)
                };
                let lobe = Huang::new(weight, &of, &place, self.wo(), tables.solid.as_ref());
                // Without an index Cycles divides by 0, and the fibre is black.
                let has_index = of.ior > fresnel::LEAST_IOR;
                if of.ways != Vec3::ZERO && !lobe.is_beside() && has_index {
                    self.add(Lobe::Huang(lobe), lobe.albedo() * weight);
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/shading/fibres.rs"]
mod tests;
