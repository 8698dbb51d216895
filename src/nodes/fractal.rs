//! Sums and products of octaves of noise: fractal Brownian motion and Musgrave's multifractals (Ebert et al., "Texturing and
//! Modeling: A Procedural Approach", chapter 16), as Blender's Noise Texture has them.

use super::perlin::Noise;
use super::{fused, mix};

/// How the octaves of a fractal follow each other.
#[derive(Clone, Copy)]
pub(super) struct Octaves {
    /// How many there are after the first; a fraction counts the last one in part.
    pub detail: f32,
    /// The amplitude of each beside the one before it.
    pub roughness: f32,
    /// The frequency of each beside the one before it.
    pub lacunarity: f32,
}

/// From this octave on, scales are infinite and sums NaN: more octaves change nothing.
const MOST_OCTAVES: f32 = 128.0;

impl Octaves {
    /// The number of the last whole octave.
    fn last(self) -> i32 {
        self.detail.min(MOST_OCTAVES) as i32
    }

    /// What counts of the octave after it.
    fn fraction(self) -> f32 {
        self.detail - self.detail.floor()
    }

    /// Fractal Brownian motion; normalised, it is between 0 and 1.
    #[inline(always)]
    pub(super) fn fbm<P: Noise>(self, p: P, normalize: bool) -> f32 {
        let mut scale = 1.0;
        let mut amplitude = 1.0;
        let mut greatest = 0.0;
        let mut sum = 0.0;
        for _ in 0..=self.last() {
            sum = fused((p * scale).signed_noise(), amplitude, sum);
            greatest += amplitude;
            amplitude *= self.roughness;
            scale *= self.lacunarity;
        }
        let value = |sum: f32, greatest: f32| {
            if normalize {
                0.5 * sum / greatest + 0.5
            } else {
                sum
            }
        };
        let fraction = self.fraction();
        if fraction == 0.0 {
            return value(sum, greatest);
        }
        let more = fused((p * scale).signed_noise(), amplitude, sum);
        mix(
            value(sum, greatest),
            value(more, greatest + amplitude),
            fraction,
        )
    }

    /// The product of octaves around 1.
    #[inline(always)]
    pub(super) fn multifractal<P: Noise>(self, mut p: P) -> f32 {
        let mut value = 1.0;
        let mut power = 1.0;
        for _ in 0..=self.last() {
            value *= power * p.signed_noise() + 1.0;
            power *= self.roughness;
            p = p * self.lacunarity;
        }
        let fraction = self.fraction();
        if fraction != 0.0 {
            value *= fraction * power * p.signed_noise() + 1.0;
        }
        value
    }

    /// Octaves that count more where the ground is high.
    #[inline(always)]
    pub(super) fn hetero_terrain<P: Noise>(self, mut p: P, offset: f32) -> f32 {
        let mut power = self.roughness;
        let mut value = offset + p.signed_noise();
        p = p * self.lacunarity;
        for _ in 1..=self.last() {
            value += (p.signed_noise() + offset) * power * value;
            power *= self.roughness;
            p = p * self.lacunarity;
        }
        let fraction = self.fraction();
        if fraction != 0.0 {
            value += fraction * ((p.signed_noise() + offset) * power * value);
        }
        value
    }

    /// Each octave weighs as much as the ones before it were high.
    #[inline(always)]
    pub(super) fn hybrid_multifractal<P: Noise>(self, mut p: P, offset: f32, gain: f32) -> f32 {
        // Below this weight, later octaves are left out.
        const LEAST: f32 = 0.001;
        let mut power = 1.0;
        let mut value = 0.0;
        let mut weight = 1.0_f32;
        for _ in 0..=self.last() {
            if weight.is_nan() || weight <= LEAST {
                break;
            }
            weight = weight.min(1.0);
            let signal = (p.signed_noise() + offset) * power;
            power *= self.roughness;
            value += weight * signal;
            weight *= gain * signal;
            p = p * self.lacunarity;
        }
        let fraction = self.fraction();
        if fraction != 0.0 && weight > LEAST {
            let signal = (p.signed_noise() + offset) * power;
            value += fraction * weight.min(1.0) * signal;
        }
        value
    }

    /// Ridges where the noise crosses zero; a fraction of an octave does not count here.
    #[inline(always)]
    pub(super) fn ridged_multifractal<P: Noise>(self, mut p: P, offset: f32, gain: f32) -> f32 {
        let ridge = |noise: f32| {
            let height = offset - noise.abs();
            height * height
        };
        let mut power = self.roughness;
        let mut signal = ridge(p.signed_noise());
        let mut value = signal;
        for _ in 1..=self.last() {
            p = p * self.lacunarity;
            let weight = (signal * gain).clamp(0.0, 1.0);
            signal = ridge(p.signed_noise()) * weight;
            value += signal * power;
            power *= self.roughness;
        }
        value
    }
}
