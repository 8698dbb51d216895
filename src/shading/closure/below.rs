//! Light that goes on below the surface: where a path enters, and what it walks through there. Where it comes out again is
//! the path's affair ([`crate::medium::walk`], [`crate::medium::profile`]); no direction is drawn here, and no light found by its own.

use super::Normals;
use crate::math::{Frame, sqr, warp};
use crate::scene::graph::{Subsurface, WalkMethod};
use crate::shading::ggx::{self, Alpha};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Radii below it are none, as in Cycles, metres.
const LEAST_RADIUS: f32 = 1e-8;

/// Light that goes on below the surface.
#[derive(Clone, Copy, Debug)]
pub struct Below {
    /// Weight of the lobe, the colour included.
    pub weight: Vec3,
    /// The colour that the surface shows: what half of all space, filled alike, gives back of even light.
    pub color: Vec3,
    /// By the method: the mean free path, what stands for it, or the length of the profile, metres.
    pub radius: Vec3,
    /// Mean cosine of a scattering.
    pub anisotropy: f32,
    /// What the numbers stand for.
    pub method: WalkMethod,
    /// The lobe's own normal.
    pub normal: Vec3,
    /// Of the facets that refract it.
    pub alpha: f32,
    /// Index of refraction.
    pub ior: f32,
}

/// What an artist says of it.
#[derive(Clone, Copy, Debug)]
pub struct BelowInputs {
    /// Colour, 0..=1.
    pub color: Vec3,
    /// Radius times scale, metres.
    pub radius: Vec3,
    /// α of the facets where light enters.
    pub alpha: f32,
    /// Index of refraction, where the method has none of its own.
    pub ior: f32,
    /// Mean cosine of a scattering.
    pub anisotropy: f32,
}

impl Below {
    /// The lobe of a weight (with the colour in it), and the weight of what scatters at the surface itself: channels without a
    /// radius.
    pub fn new(
        weight: Vec3,
        inputs: &BelowInputs,
        what: Subsurface,
        (normals, normal): (&Normals, Vec3),
        wo: Vec3,
    ) -> (Option<Self>, Vec3) {
        let radius = inputs.radius.max(Vec3::ZERO);
        let goes_on = radius.cmpge(Vec3::splat(LEAST_RADIUS));
        let at_surface = Vec3::select(goes_on, Vec3::ZERO, weight);
        if !goes_on.any() {
            return (None, at_surface);
        }
        let most = if what.method == WalkMethod::RandomWalk {
            0.99
        } else {
            0.9
        };
        let least = if what.never_backward { 0.0 } else { -0.99 };
        let ior = inputs.ior.clamp(1.01, 3.8);
        // Above 1 d'Eon's mapping falls again, and so the walk gives back less than its colour.
        let color = inputs.color.max(Vec3::ZERO);
        let radius = Vec3::select(goes_on, radius, Vec3::ZERO);
        let radius = match what.method {
            WalkMethod::RandomWalk => radius,
            WalkMethod::Legacy | WalkMethod::Burley => radius * (0.25 * FRAC_1_PI),
            WalkMethod::Skin => radius * skin_share(color.min(Vec3::ONE), ior),
        };
        let lobe = Self {
            weight: Vec3::select(goes_on, weight, Vec3::ZERO),
            color,
            radius,
            anisotropy: inputs.anisotropy.clamp(least, most),
            method: what.method,
            normal: normals.bent(normal, wo),
            alpha: if what.method == WalkMethod::Skin {
                1.0
            } else {
                inputs.alpha
            },
            ior,
        };
        (Some(lobe), at_surface)
    }

    /// Whether the fit of before 5.2 tells the medium of the colour; else d'Eon's mapping.
    pub fn is_fitted(&self) -> bool {
        self.method != WalkMethod::RandomWalk
    }

    /// Whether a profile says where light comes out, without a walk.
    pub fn has_profile(&self) -> bool {
        self.method == WalkMethod::Burley
    }

    /// Draws the direction in which a walk enters; `choice` in 0..1 decides how. `None` where it would leave.
    ///
    /// By the refraction of visible facets. As in Cycles none is reflected or shadowed: the colour tells of what comes back
    /// in all.
    pub fn enter(&self, geometric: Vec3, wo: Vec3, u: Vec2, choice: f32) -> Option<Vec3> {
        let is_diffuse = self.method == WalkMethod::Skin && choice < 0.5;
        let direction = if is_diffuse {
            Frame::from_normal(-self.normal).to_world(warp::cosine_hemisphere(u))
        } else {
            let frame = Frame::from_normal(self.normal);
            let local = frame.to_local(wo);
            if local.z <= 0.0 {
                return None;
            }
            let alpha = Alpha::isotropic(self.alpha);
            let facet = if alpha.is_smooth() {
                Vec3::Z
            } else {
                ggx::sample_visible_normal(local, &alpha, 1.0, u)
            };
            let inverse = 1.0 / self.ior;
            let cos = local.dot(facet);
            // The index is above 1: all is refracted.
            let cos_t = (1.0 - sqr(inverse) * (1.0 - sqr(cos)).max(0.0)).sqrt();
            let refracted = facet * (inverse * cos - cos_t) - local * inverse;
            frame.to_world(refracted).normalize()
        };
        (direction.dot(geometric) < 0.0).then_some(direction)
    }
}

/// What the radius of Skin is multiplied by: √(3(1 − α')), with α' the reduced albedo by which the dipole of a medium of this
/// index gives the colour back (Jensen et al., *A Practical Model for Subsurface Light Transport*, 2001, equations 2 to 4 and
/// the diffuse reflectance of a dipole).
fn skin_share(color: Vec3, ior: f32) -> Vec3 {
    let inverse = 1.0 / ior;
    let reflected = inverse * (0.71 - 1.44 * inverse) + 0.668 + 0.0636 * ior;
    let boundary = 4.0 / 3.0 * (1.0 + reflected) / (1.0 - reflected);
    let share = |color: f32| (3.0 * (1.0 - reduced_albedo(color, boundary))).sqrt();
    Vec3::new(share(color.x), share(color.y), share(color.z))
}

/// The reduced albedo whose dipole reflects a share.
fn reduced_albedo(reflectance: f32, boundary: f32) -> f32 {
    if reflectance < 1e-4 {
        return 0.0;
    }
    if reflectance >= 0.995 {
        return 0.999_999;
    }
    let dipole = |albedo: f32| {
        let s = (3.0 * (1.0 - albedo)).sqrt();
        0.5 * albedo * (1.0 + (-boundary * s).exp()) * (-s).exp()
    };
    // Twelve halvings, as in Cycles: what is left of the interval is 2.4e-4.
    let (mut low, mut high, mut middle) = (0.0, 1.0, 0.5);
    for _ in 0..12 {
        middle = 0.5 * (low + high);
        if dipole(middle) < reflectance {
            low = middle;
        } else {
            high = middle;
        }
    }
    middle
}

#[cfg(test)]
#[path = "../../../tests/unit/shading/closure/below.rs"]
mod tests;
