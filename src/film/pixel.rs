//! What is kept of each pixel while samples come in.

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

/// What the ray through the middle of a pixel meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Middle {
    /// Distance along the view axis, metres; [`NO_DEPTH`] where nothing was met.
    pub depth: f32,
    /// World position, Sundog's axes.
    pub position: Vec3,
}

impl Default for Middle {
    fn default() -> Self {
        Self {
            depth: NO_DEPTH,
            position: Vec3::ZERO,
        }
    }
}

/// Depth of nothing: what Blender's depth pass holds there.
pub const NO_DEPTH: f32 = 1e10;

/// Sums of a pixel. f64: 2^24 samples lose no digit of an f32.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pixel {
    /// Sum of radiance.
    pub radiance: DVec3,
    /// The same over every other sample.
    pub half: DVec3,
    /// Sum of normals.
    pub normal: DVec3,
    /// Sum of albedos.
    pub albedo: DVec3,
    /// Of one ray alone: means of depths and positions would be of no surface.
    pub middle: Middle,
    /// Samples that are no part of the picture.
    pub transparent: u32,
    /// Samples that came in.
    pub samples: u32,
}

impl Pixel {
    /// Adds a sample.
    #[inline]
    pub fn add(&mut self, radiance: Vec3, first: &FirstHit) {
        self.radiance += radiance.as_dvec3();
        if self.samples % 2 == 1 {
            self.half += radiance.as_dvec3();
        }
        self.normal += first.normal.as_dvec3();
        self.albedo += first.albedo.as_dvec3();
        self.transparent += u32::from(first.transparent);
        self.samples += 1;
    }

    /// Estimate of the squared error of the mean radiance over (mean² + 0.01), summed over the channels;
    /// `None` below two samples.
    ///
    /// The samples with even and with odd numbers are two estimates a and b of one value; were they
    /// independent, ((a − b)/2)² would have the expectation of the variance of their mean (a + b)/2.
    /// They are halves of one set of stratified points, whose errors partly cancel: the estimate is too
    /// large rather than too small, except where light is found so rarely that no sample has met it yet.
    pub fn relative_square_error(&self) -> Option<f64> {
        let (b, n) = (self.samples / 2, self.samples);
        if b == 0 {
            return None;
        }
        let a = f64::from(n - b);
        let difference = (self.radiance - self.half) / a - self.half / f64::from(b);
        let mean = self.radiance / f64::from(n);
        // Of halves of unequal size the mean is not in the middle: var(mean) = var(a − b) · a b / n².
        let variance = difference * difference * (a * f64::from(b) / f64::from(n).powi(2));
        Some((variance / (mean * mean + 0.01)).element_sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of independent samples the estimate has the expectation of the true squared error: variance of a
    /// uniform number 1/12, over n, three channels. 20 000 pixels; its standard deviation is √2 of itself
    /// each, so 5 σ are 5 % of it (the mean² in the denominator is nearly constant for n = 64 and 65).
    #[test]
    fn the_error_estimate_has_the_right_expectation() {
        use crate::sampler::hashed;
        for n in [64u32, 65] {
            let mut sum = 0.0;
            let pixels = 20_000;
            for p in 0..pixels {
                let mut pixel = Pixel::default();
                assert_eq!(pixel.relative_square_error(), None);
                for s in 0..n {
                    let v = Vec3::new(hashed(1, p, s), hashed(2, p, s), hashed(3, p, s));
                    pixel.add(v, &FirstHit::default());
                }
                sum += pixel.relative_square_error().unwrap() / f64::from(pixels);
            }
            let expected = 3.0 / 12.0 / f64::from(n) / (0.25 + 0.01);
            assert!((sum / expected - 1.0).abs() < 0.05, "{n}: {sum} {expected}");
        }
    }
}
