//! Indices of refraction by wavelength (KHR_materials_dispersion), and the wavelength that a path takes.
//!
//! Light is red, green and blue here. A path that meets a surface whose index depends on the wavelength draws one, and from
//! there on counts for what the three colours see of it in daylight (van de Ruit and Eisemann, *Metameric: Spectral Uplifting via
//! Controllable Color Constraints*, 2023, eq. 1). In the mean over the wavelengths each colour counts 1, so that light which
//! is not spread keeps its colour.

use super::thin_film::{CIE_1931, FIRST, STEP};
use crate::math::primaries::WorkingSpace;
use glam::{DVec3, Vec3};
use std::sync::OnceLock;

/// Steps between the table's wavelengths.
const STEPS: usize = CIE_1931.len() - 1;

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

/// What the primaries of a space see of daylight by its wavelengths.
#[derive(Debug)]
pub struct Spectrum {
    /// The probability of all wavelengths up to the end of each step; the last is 1.
    cumulative: [f32; STEPS],
    /// What a path of that wavelength counts at both ends of each step.
    weights: [[Vec3; 2]; STEPS],
}

/// The wavelength of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength {
    /// Nanometres.
    pub nanometres: f32,
    /// What it counts for red, green and blue. Pure colours lie outside of the primaries' triangle: some count less than nothing.
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
        // Linear between the table's wavelengths, as in Cycles 5.3. Each colour sums to 1.
        let seen = |i: usize| space.from_xyz() * (DVec3::from(CIE_1931[i]) * D65[i]);
        let steps: [[DVec3; 2]; STEPS] = std::array::from_fn(|i| [seen(i), seen(i + 1)]);
        let whole: DVec3 = steps.iter().map(|[a, b]| (a + b) / 2.0).sum();
        let shares = steps.map(|ends| ends.map(|end| end / whole));
        let seen_of = |[a, b]: [DVec3; 2]| (a.abs() + b.abs()).element_sum() / 2.0;
        let all: f64 = shares.iter().map(|ends| seen_of(*ends)).sum();
        let mut sum = 0.0;
        let cumulative = shares.map(|ends| {
            sum += seen_of(ends) / all;
            sum as f32
        });
        let weights = shares.map(|ends| {
            let probability = seen_of(ends) / all;
            ends.map(|end| (end / probability.max(f64::MIN_POSITIVE)).as_vec3())
        });
        Self {
            cumulative,
            weights,
        }
    }

    /// The wavelength for a number in [0, 1).
    pub fn sample(&self, u: f32) -> Wavelength {
        let step = self.cumulative.partition_point(|&end| end <= u);
        let step = step.min(STEPS - 1);
        let start = if step == 0 {
            0.0
        } else {
            self.cumulative[step - 1]
        };
        let width = self.cumulative[step] - start;
        let within = if width > 0.0 {
            ((u - start) / width).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let [first, last] = self.weights[step];
        Wavelength {
            nanometres: FIRST as f32 + STEP as f32 * (step as f32 + within),
            weight: first.lerp(last, within),
        }
    }
}

/// The relative power of the CIE's standard illuminant D65 (CIE 015:2018, table 5; doi 10.25039/CIE.DS.hjfjmt59), by the
/// wavelengths of [`CIE_1931`].
#[rustfmt::skip]
static D65: [f64; 81] = [
    49.9755, 52.3118, 54.6482, 68.7015, 82.7549, 87.1204, 91.486, 92.4589, 93.4318,
    90.057, 86.6823, 95.7736, 104.865, 110.936, 117.008, 117.41, 117.812, 116.336,
    114.861, 115.392, 115.923, 112.367, 108.811, 109.082, 109.354, 108.578, 107.802,
    106.296, 104.79, 106.239, 107.689, 106.047, 104.405, 104.225, 104.046, 102.023,
    100.0, 98.1671, 96.3342, 96.0611, 95.788, 92.2368, 88.6856, 89.3459, 90.0062,
    89.8026, 89.5991, 88.6489, 87.6987, 85.4936, 83.2886, 83.4939, 83.6992, 81.863,
    80.0268, 80.1207, 80.2146, 81.2462, 82.2778, 80.281, 78.2842, 74.0027, 69.7213,
    70.6652, 71.6091, 72.979, 74.349, 67.9765, 61.604, 65.7448, 69.8856, 72.4863,
    75.087, 69.3398, 63.5927, 55.0054, 46.4182, 56.6118, 66.8054, 65.0941, 63.3828,
];

#[cfg(test)]
#[path = "../../tests/unit/shading/dispersion.rs"]
mod tests;
