//! Features for denoisers: albedo, normal and depth of what a pixel shows, followed through mirrors and clear glass.
//!
//! As Cycles has them since 2.90 (`denoising_passes.h`): a surface that scatters widely says what it is; one that mirrors hands
//! the question on along the path, tinted by what it mirrors; between the two there is no step.

use super::light_passes::PassSink;
use super::sum::{ColorSum, FixedSum};
use crate::math::average;
use crate::math::warp::smoothstep;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Facets of this α and wider count as diffuse ones; those of 0 as mirrors.
const DIFFUSE_ALPHA: f32 = 0.15;
/// A surface whose diffuse lobes have this share of its albedo says all of the features.
const DIFFUSE_SHARE: f32 = 0.5;
/// Where less than this is handed on, nothing is.
const LEAST_HANDED_ON: f32 = 1e-4;

/// What the lobes of a surface are to denoisers.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceFeatures {
    normal: Vec3,
    diffuse: Vec3,
    specular: Vec3,
    weight: f32,
    diffuse_weight: f32,
}

impl SurfaceFeatures {
    /// Adds a lobe with its normal, its albedo, and the α of its facets (1 if it has none).
    #[inline]
    pub fn add(&mut self, normal: Vec3, albedo: Vec3, alpha: f32) {
        let weight = average(albedo);
        let diffuse = smoothstep(alpha / DIFFUSE_ALPHA);
        self.normal += normal * weight;
        self.diffuse += albedo * diffuse;
        self.specular += albedo * (1.0 - diffuse);
        self.weight += weight;
        self.diffuse_weight += weight * diffuse;
    }
}

/// Features that a path gathers.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathFeatures {
    /// What surfaces further on say counts so much; none once it is 0, and from the beginning unless it is followed.
    throughput: Vec3,
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    met: bool,
}

impl PathFeatures {
    /// A path that is followed.
    pub const FOLLOWED: Self = Self {
        throughput: Vec3::ONE,
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: 0.0,
        met: false,
    };

    /// Whether all of it is.
    pub fn is_finite(&self) -> bool {
        self.albedo.is_finite() && self.normal.is_finite() && self.depth.is_finite()
    }

    #[inline]
    fn is_followed(&self) -> bool {
        self.throughput != Vec3::ZERO
    }
}

impl PassSink for PathFeatures {
    #[inline]
    fn branch(&mut self, number: u32) {
        // What denoisers are told follows one path.
        if number > 0 {
            self.throughput = Vec3::ZERO;
        }
    }

    /// A medium scatters the path. Cycles takes that for diffuse, with a normal toward the camera (`film_write_denoising_features_volume`).
    #[inline]
    fn scatter(&mut self, albedo: impl FnOnce() -> Vec3, toward_camera: impl FnOnce() -> Vec3) {
        if self.is_followed() {
            self.albedo += self.throughput * albedo();
            self.normal += toward_camera();
            self.throughput = Vec3::ZERO;
            self.met = true;
        }
    }

    #[inline]
    fn meet(&mut self, distance: f32) {
        if self.is_followed() {
            self.depth += average(self.throughput) * distance;
            self.met = true;
        }
    }

    /// The way to what bounds a volume, and to what lets the path pass, is a part of the depth.
    #[inline]
    fn go_by(&mut self, distance: f32) {
        if self.is_followed() {
            self.depth += average(self.throughput) * distance;
        }
    }

    #[inline]
    fn surface(&mut self, features: impl FnOnce() -> SurfaceFeatures) {
        if !self.is_followed() {
            return;
        }
        let of = features();
        let says = if of.weight > 0.0 {
            let says = smoothstep(of.diffuse_weight / of.weight / DIFFUSE_SHARE);
            self.albedo += self.throughput * of.diffuse * says;
            self.normal += average(self.throughput) * says / of.weight * of.normal;
            says
        } else {
            0.0
        };
        let onward = of.specular * (1.0 - says);
        self.throughput = if onward.max_element() > LEAST_HANDED_ON {
            self.throughput * onward
        } else {
            Vec3::ZERO
        };
    }

    /// Light that a ray has found counts as albedo.
    #[inline]
    fn shine(&mut self, light: Vec3) {
        self.albedo += self.throughput * light;
    }

    #[inline]
    fn pass(&mut self, tint: Vec3) {
        self.throughput *= tint;
    }
}

/// Sums of a pixel's paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelFeatures {
    /// What shines has albedos of any size.
    albedo: ColorSum,
    normal: FixedSum,
    depth: f64,
    /// Paths that have met neither a surface nor what scatters in a volume.
    missed: u64,
}

impl PixelFeatures {
    /// Adds a path.
    pub fn add(&mut self, path: &PathFeatures) {
        self.albedo.add(path.albedo);
        self.normal.add(path.normal);
        self.depth += f64::from(path.depth);
        self.missed += u64::from(!path.met);
    }

    /// Adds the paths of another sum.
    pub fn join(&mut self, other: &Self) {
        self.albedo.join(&other.albedo);
        self.normal.join(&other.normal);
        self.depth += other.depth;
        self.missed += other.missed;
    }

    /// Whether it can be what so many paths have made: for one that comes from a file.
    pub fn is_sound(&self, samples: u32) -> bool {
        self.albedo.total().is_finite()
            && self.depth.is_finite()
            && self.missed <= u64::from(samples)
    }

    /// Mean albedo, given the reciprocal of the number of samples.
    pub fn albedo(&self, scale: f64) -> DVec3 {
        self.albedo.total() * scale
    }

    /// Mean normal in Sundog's axes.
    pub fn normal(&self, scale: f64) -> DVec3 {
        self.normal.total() * scale
    }

    /// Mean length of the paths to what was looked at; `None` where a path has met nothing.
    pub fn depth(&self, scale: f64) -> Option<f64> {
        (self.missed == 0).then_some(self.depth * scale)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/features.rs"]
mod tests;
