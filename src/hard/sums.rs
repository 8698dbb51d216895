//! Sums over samples: without drift, in any order, and each pixel for itself.

use super::{Case, Effort, Finding};
use crate::film::pixel::{FirstHit, Pixel};
use crate::render::RenderError;
use crate::sampler::hashed;
use glam::Vec3;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "many-samples",
        about: "2^24 samples a pixel, each 0.1: their sum in f32 stalls at 2^21 (where half an ulp is 0.125), their mean must stay 0.1.",
        run: many_samples,
    },
    Case {
        name: "order-of-samples",
        about: "Samples from 1e-12 to 1e12 in any order and in parts give the same bits.",
        run: order_of_samples,
    },
];

/// Each rounding of f64 loses 2^-53 of the sum and the rest keeps it: the bound is f32's last rounding of the value.
fn many_samples(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples: u32 = effort.of(1 << 22, 1 << 24, 1 << 24);
    let mut pixel = Pixel::default();
    for number in 0..samples {
        pixel.add(number, Vec3::splat(0.1), &FirstHit::default());
    }
    let (value, mean) = (f64::from(0.1f32), pixel.mean().x);
    Ok(vec![
        Finding::new("mean radiance", value, mean, value * f64::EPSILON),
        Finding::at_most(
            "estimated variance of the mean",
            (value * f64::EPSILON).powi(2),
            pixel.variance().map_or(f64::NAN, |v| v.max_element()),
        ),
    ])
}

fn order_of_samples(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let samples: u32 = effort.of(1 << 12, 1 << 16, 1 << 20);
    let value = |number: u32| Vec3::splat(10f32.powf(24.0 * hashed(1, number, 0) - 12.0));
    let sum = |numbers: &mut dyn Iterator<Item = u32>| {
        let mut pixel = Pixel::default();
        numbers.for_each(|number| pixel.add(number, value(number), &FirstHit::default()));
        pixel
    };
    let forward = sum(&mut (0..samples));
    let backward = sum(&mut (0..samples).rev());
    let mut joined = sum(&mut (samples / 3..samples));
    joined.join(&sum(&mut (0..samples / 3)));
    let differs = |other: Pixel| u64::from(other.mean().as_vec3() != forward.mean().as_vec3());
    Ok(vec![
        Finding::none("sums that differ backwards", differs(backward)),
        Finding::none("sums that differ in parts", differs(joined)),
    ])
}
