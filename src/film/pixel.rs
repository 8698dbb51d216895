//! What is kept of each pixel while samples come in.

use super::sum::{ColorSum, FixedSum};
use crate::math::LUMINANCE;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Features of a path's first hit; zero where nothing was hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstHit {
    /// Shading normal, Sundog's axes.
    pub normal: Vec3,
    /// Albedo of the surface.
    pub albedo: Vec3,
    /// The camera looked past everything, or at a hole: this sample is no part of the picture.
    pub transparent: bool,
}

impl FirstHit {
    /// Of no ray.
    pub const NONE: Self = Self {
        normal: Vec3::ZERO,
        albedo: Vec3::ZERO,
        transparent: false,
    };

    /// Whether all of it is.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.normal.is_finite() && self.albedo.is_finite()
    }
}

/// What the ray through the middle of a pixel meets.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CenterSample {
    /// Distance along the view axis, metres; [`NO_DEPTH`] where nothing was met.
    pub depth: f32,
    /// World position, Sundog's axes.
    pub position: Vec3,
}

impl Default for CenterSample {
    fn default() -> Self {
        Self {
            depth: NO_DEPTH,
            position: Vec3::ZERO,
        }
    }
}

/// Depth of nothing: what Blender's depth pass holds there.
pub const NO_DEPTH: f32 = 1e10;

/// Sums of a pixel. What is in it does not depend on the order in which samples came in, but for the last
/// bits of `second`, which only the error estimate sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Pixel {
    /// Radiance.
    pub radiance: ColorSum,
    /// Radiance of the samples of the second replicate, or of the second half of those of one sequence (see [`crate::sampler`]).
    second: DVec3,
    /// Normals.
    pub normal: FixedSum,
    /// Albedos.
    pub albedo: FixedSum,
    /// Of one ray alone: means of depths and positions would be of no surface.
    pub middle: CenterSample,
    /// Samples that are no part of the picture.
    pub transparent: u32,
    /// Samples that came in.
    pub samples: u32,
    /// Those of them that belong to the second replicate.
    seconds: u32,
    /// Samples that it is to have at the end of the pass that is under way.
    pub until: u32,
}

impl Pixel {
    /// Adds a sample; `second`: of the second replicate.
    #[inline]
    pub fn add(&mut self, second: bool, radiance: Vec3, first: &FirstHit) {
        self.radiance.add(radiance);
        if second {
            self.second += radiance.as_dvec3();
            self.seconds += 1;
        }
        self.normal.add(first.normal);
        self.albedo.add(first.albedo);
        self.transparent += u32::from(first.transparent);
        self.samples += 1;
    }

    /// Adds other samples of the same pixel.
    pub fn join(&mut self, other: &Self) {
        self.radiance.join(&other.radiance);
        self.second += other.second;
        self.normal.join(&other.normal);
        self.albedo.join(&other.albedo);
        if self.samples == 0 {
            self.middle = other.middle;
        }
        self.transparent += other.transparent;
        self.samples += other.samples;
        self.seconds += other.seconds;
        self.until = self.samples;
    }

    /// Whether it can be what samples of at most this number have made: for one that comes from a file.
    pub fn is_sound(&self, most: u32) -> bool {
        // A sample is a f32; twice as much leaves room for what sums have rounded.
        let bounded = |sum: DVec3, samples: u32| {
            let most = 2.0 * f64::from(f32::MAX) * f64::from(samples);
            sum.abs().cmple(DVec3::splat(most)).all()
        };
        bounded(self.radiance.total(), self.samples)
            && bounded(self.second, self.seconds)
            && self.samples <= most
            && self.seconds <= self.samples
            && self.transparent <= self.samples
    }

    /// Mean radiance; black without samples.
    pub fn mean(&self) -> DVec3 {
        self.radiance.total() / f64::from(self.samples.max(1))
    }

    /// Mean radiance of the samples of one replicate, an independent picture with about half the samples;
    /// `None` if there are none.
    pub fn replicate(&self, second: bool) -> Option<DVec3> {
        let (sum, samples) = if second {
            (self.second, self.seconds)
        } else {
            (
                self.radiance.total() - self.second,
                self.samples - self.seconds,
            )
        };
        (samples > 0).then(|| sum / f64::from(samples))
    }

    /// Estimate of the variance of the mean radiance; `None` as long as a replicate has no sample.
    ///
    /// The means a and b of the replicates are independent and unbiased, so (a − b)² has the expectation
    /// var(a) + var(b). For variances in inverse proportion to the numbers n and m of samples, the mean of all
    /// has var(a − b) · n m / (n + m)²: for equal halves the known ((a − b) / 2)². Halves of one sequence differ by more: there
    /// it is too large.
    pub fn variance(&self) -> Option<DVec3> {
        let (difference, share) = self.difference()?;
        Some(difference * difference * share)
    }

    /// The same of the luminance.
    pub fn luminance_variance(&self) -> Option<f64> {
        let (difference, share) = self.difference()?;
        let difference = difference.dot(DVec3::from(LUMINANCE));
        Some(difference * difference * share)
    }

    /// The difference of the replicates, and what of its square is the variance of the mean.
    fn difference(&self) -> Option<(DVec3, f64)> {
        let difference = self.replicate(false)? - self.replicate(true)?;
        let share = f64::from(self.seconds) / f64::from(self.samples);
        Some((difference, share * (1.0 - share)))
    }
}

#[cfg(test)]
#[path = "../../tests/unit/film/pixel.rs"]
mod tests;
