//! What is kept of each pixel while samples come in.

use glam::{DVec3, Vec3};

/// Features of a path's first hit; zero where nothing was hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstHit {
    /// Distance along the view axis, metres; [`NO_DEPTH`] where nothing was hit.
    pub depth: f32,
    /// World position, Sundog's axes.
    pub position: DVec3,
    /// Shading normal, Sundog's axes.
    pub normal: Vec3,
    /// Albedo of the surface.
    pub albedo: Vec3,
}

/// Depth of nothing: what Blender's depth pass holds there.
pub const NO_DEPTH: f32 = 1e10;

/// Sums of a pixel. f64: 2^24 samples lose no digit of an f32.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pixel {
    /// Sum of radiance.
    pub radiance: DVec3,
    /// Sum of normals.
    pub normal: DVec3,
    /// Sum of albedos.
    pub albedo: DVec3,
    /// First sample's depth and position: means of them would be of no surface.
    pub depth: f32,
    /// See `depth`.
    pub position: Vec3,
    /// Samples that came in.
    pub samples: u32,
}

impl Pixel {
    /// Adds a sample.
    #[inline]
    pub fn add(&mut self, radiance: Vec3, first: &FirstHit) {
        self.radiance += radiance.as_dvec3();
        self.normal += first.normal.as_dvec3();
        self.albedo += first.albedo.as_dvec3();
        if self.samples == 0 {
            self.depth = first.depth;
            self.position = first.position.as_vec3();
        }
        self.samples += 1;
    }
}
