//! Indices of refraction by wavelength (KHR_materials_dispersion), and the wavelength that a path takes.
//!
//! Light is red, green and blue here. A path that meets a surface whose index depends on the wavelength draws one, and from
//! there on counts for what the three colours see of it. In the mean over the wavelengths each colour counts 1, so that
//! light which is not spread keeps its colour.

use super::thin_film::{CIE_1931, FIRST, STEP};
use crate::math::primaries::WorkingSpace;
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Bins of the spectrum.
const BINS: usize = CIE_1931.len();

/// The wavelength of Fraunhofer's d line (nanometres), for which the index is given.
#[cfg(test)]
const D_LINE: f32 = 587.56;

/// The index for a wavelength in nanometres, by Cauchy's two terms.
///
/// KHR_materials_dispersion: dispersion is 20 over the Abbe number V = (n_d − 1)/(n_F − n_C), so that
/// n(λ) = n_d + (n_d − 1)/V · (523655/λ² − 1.5168), and at least 1.
#[inline]
pub fn index_at(ior: f32, dispersion: f32, wavelength: f32) -> f32 {
    let over_abbe = dispersion / 20.0;
    let curve = 523_655.0 / (wavelength * wavelength) - 1.5168;
    ((ior - 1.0).max(0.0) * over_abbe)
        .mul_add(curve, ior)
        .max(1.0)
}

/// What the primaries of a space see of each wavelength.
#[derive(Debug)]
pub struct Spectrum {
    /// Up to the end of each bin; the last is 1.
    cumulative: [f32; BINS],
    /// What a path of that wavelength counts.
    weights: [Vec3; BINS],
}

/// The wavelength of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength {
    /// Nanometres.
    pub nanometres: f32,
    /// What it counts for red, green and blue: the three sum to 3.
    pub weight: Vec3,
}

impl Spectrum {
    /// Of a space, made once.
    pub fn of(space: WorkingSpace) -> &'static Self {
        static SPECTRA: [OnceLock<Spectrum>; 3] = [const { OnceLock::new() }; 3];
        let place = WorkingSpace::ALL.iter().position(|s| *s == space);
        SPECTRA[place.unwrap_or(0)].get_or_init(|| Self::new(space))
    }

    fn new(space: WorkingSpace) -> Self {
        // Pure colours lie outside of the primaries' triangle. A path cannot count less than nothing: they go to its border.
        let seen = |xyz: &[f64; 3]| (space.from_xyz() * DVec3::from(*xyz)).max(DVec3::ZERO);
        let whole: DVec3 = CIE_1931.iter().map(seen).sum();
        // Each colour sums to 1 over the bins. Bins are drawn by what all three see.
        let shares = CIE_1931.each_ref().map(|xyz| seen(xyz) / whole);
        let mut sum = 0.0;
        let cumulative = shares.map(|share| {
            sum += share.element_sum() / 3.0;
            sum as f32
        });
        let weights = shares.map(|share| match share.element_sum() {
            all if all > 0.0 => (3.0 * share / all).as_vec3(),
            _ => Vec3::ONE,
        });
        Self {
            cumulative,
            weights,
        }
    }

    /// The wavelength for a number in [0, 1).
    pub fn sample(&self, u: f32) -> Wavelength {
        let bin = self.cumulative.partition_point(|&end| end <= u);
        let bin = bin.min(BINS - 1);
        let start = if bin == 0 {
            0.0
        } else {
            self.cumulative[bin - 1]
        };
        let width = self.cumulative[bin] - start;
        let within = if width > 0.0 {
            ((u - start) / width).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let middle = FIRST as f32 + STEP as f32 * bin as f32;
        Wavelength {
            nanometres: middle + STEP as f32 * (within - 0.5),
            weight: self.weights[bin],
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/shading/dispersion.rs"]
mod tests;
