//! Lights: sample, pdf, evaluate; the choice between them.
//!
//! One file a kind. A light's geometry lives here, free of scene and textures; `world::lights`
//! puts them together.

pub mod area;
pub mod choice;
pub mod closed;
pub mod ellipse;
pub mod environment;
pub mod estimate;
pub mod lamp;
pub mod quad;
pub mod rectangle;
pub mod spherical_triangle;
pub mod sun;
pub mod tree;
pub mod triangle;

use glam::Vec3;

/// A direction to a light with its density (per solid angle, given the light).
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    /// From the lit point towards the light, unit length.
    pub wi: Vec3,
    /// Density; 0 for a light without extent (`delta`).
    pub pdf: f32,
}

/// A light that a ray meets.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Along the ray.
    pub distance: f32,
    /// Radiance towards the ray's origin.
    pub radiance: Vec3,
    /// Density with which light sampling finds the direction from the lit point, given the light.
    pub pdf: f32,
}

/// The power heuristic with exponent 2 (Veach, *Robust Monte Carlo Methods for Light Transport
/// Simulation*, 1997, §9.2.4), as a ratio so that large densities do not overflow.
#[inline]
pub fn power_heuristic(taken: f32, other: f32) -> f32 {
    if taken <= 0.0 {
        return 0.0;
    }
    let ratio = other / taken;
    1.0 / (1.0 + ratio * ratio)
}
