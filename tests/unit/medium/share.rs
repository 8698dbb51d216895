use super::*;
use crate::sampler::hashed;

/// What is met over the bound, by the share of the way.
type Medium = &'static dyn Fn(f32) -> f32;

/// How often combs are finer is what it is said to be.
#[test]
fn orders_have_their_probabilities() {
    let numbers = 1_000_000;
    let mut counts = [0u32; FINEST as usize + 1];
    let mut said = [0.0f32; FINEST as usize + 1];
    for i in 0..numbers {
        let (order, probability) = order((i as f32 + 0.5) / numbers as f32);
        counts[order as usize] += 1;
        said[order as usize] = probability;
    }
    for (order, probability) in said.into_iter().enumerate() {
        let found = counts[order] as f32 / numbers as f32;
        // One number more or less, and the rounding of numbers to 2⁻²⁴.
        assert!(
            (found - probability).abs() <= 2e-6,
            "{order}: {found} {probability}"
        );
    }
}

/// Few places see nothing of an edge, of a thin sheet, or of a wave: the finer combs make up for it.
#[test]
fn combs_are_right_in_the_mean() {
    let media: [(&str, Medium, f64); 4] = [
        ("an edge", &|x| f32::from(x > 0.37) * 2.0, 0.63 * 2.0),
        (
            "a sheet",
            &|x| f32::from((0.3..0.32).contains(&x)) * 40.0,
            0.02 * 40.0,
        ),
        ("a slope", &|x| 3.0 * x, 1.5),
        (
            "a wave",
            &|x| 1.0 + (40.0 * x).sin(),
            1.0 + (1.0 - 40f64.cos()) / 40.0,
        ),
    ];
    for (name, over, mean) in media {
        for depth in [0.5, 2.0, 4.0f32] {
            let samples = 200_000;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for sample in 0..samples {
                let mut count = 0;
                let mut draw = || {
                    count += 1;
                    hashed(sample, 7, count)
                };
                let found = by_combs(depth, &mut draw, |at| Vec3::splat(over(at / depth)));
                sum += found.x;
                squares += found.x.powi(2);
            }
            let n = f64::from(samples);
            let (found, expected) = (sum / n, (-mean * f64::from(depth)).exp());
            let error = ((squares / n - found * found) / n).sqrt();
            // Four and a half standard errors, of fixed numbers.
            assert!(
                (found - expected).abs() < 4.5 * error + 1e-6,
                "{name} of {depth}: {found} ± {error}, {expected}"
            );
        }
    }
}
