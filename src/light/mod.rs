//! Lights: sample, pdf, radiance; the choice between them.
//!
//! [`Light`] is the enum of all kinds, each of which has a file. [`LightSet`] holds the lights of a scene and chooses between
//! them. It owns all that it needs: what emissive triangles emit comes through [`emissive::EmissiveSurface`].

pub mod area;
pub mod closed;
pub mod computed;
pub mod coplanar;
pub mod ellipse;
pub mod emissive;
pub mod environment;
pub mod estimate;
pub mod finder;
pub mod from_scene;
pub mod groups;
pub mod kinds;
pub mod lamp;
pub mod lanes;
pub mod light_sampler;
pub mod linking;
pub mod pivot;
pub mod portal;
pub mod program;
pub mod quad;
pub mod rectangle;
pub mod rules;
pub mod set;
pub mod spherical_triangle;
pub mod sun;
pub mod texels;
pub mod tree;
pub mod triangle;
pub mod two_bounds;

pub use groups::LightGroups;
pub use kinds::{Light, LightSample, LightSampleContext};
pub use linking::Linking;
pub use pivot::Pivot;
pub use rules::Rules;
pub use set::{Along, Drawn, LightChoice, LightSet, LightSetBuilder, Shadows, Source};

use glam::Vec3;

/// A direction to a light with its density (per solid angle, given the light).
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    /// From the lit point towards the light, unit length.
    pub wi: Vec3,
    /// Density; 0 for a light without extent (`delta`).
    pub pdf: f32,
}

/// A point of a light that a ray hits.
#[derive(Clone, Copy, Debug)]
pub struct LightHit {
    /// Along the ray; infinite for a light at infinity.
    pub distance: f32,
    /// Radiance towards the ray's origin.
    pub radiance: Vec3,
    /// Where, as the light's density reads it: by coordinates of its own, on a triangle of a mesh by the world's.
    pub on: Vec3,
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
