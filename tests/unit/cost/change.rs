use super::*;
use crate::sampler::hashed;

/// Pictures of one value in each pixel with noise of the standard deviation √(1/12) (uniform numbers).
fn pictures(value: f32, seed: u32) -> Vec<Vec<f32>> {
    (0..3)
        .map(|round| {
            (0..3 * 4000)
                .map(|i| value - 0.5 + hashed(seed, round, i))
                .collect()
        })
        .collect()
}

/// Differences of independent pictures: their noise is 1/6 in the square, the change that is looked for 0, 1/10
/// or 1/2. The interval holds it in 95 of 100 trials; of 100 trials that is 95 ± 2.2, so at least 86. It is
/// not much too wide either: more than half as long again would make that 99.7, and more.
#[test]
fn a_change_is_found_below_its_noise() {
    for (change, seed) in [(0.0f32, 0), (0.1, 1000), (0.5, 2000)] {
        let truth = f64::from(change) * f64::from(change);
        let (mut held, mut sum, mut spread) = (0, 0.0, 0.0);
        for trial in 0..100 {
            let with = pictures(1.0, seed + 2 * trial);
            let without = pictures(1.0 + change, seed + 2 * trial + 1);
            let flat = vec![1.0; with[0].len()];
            let (square, deviation) = change_square(&with, &without, &flat);
            held += u32::from((square - truth).abs() < TWO_SIDED_95 * deviation);
            sum += square / 100.0;
            spread += deviation / 100.0;
        }
        assert!(held >= 86, "{change}: {held}");
        // The mean of 100 trials: without bias.
        assert!(
            (sum - truth).abs() < 0.4 * spread,
            "{change}: {sum} {spread}"
        );
        assert!(spread < 0.01, "{spread}");
    }
}

#[test]
fn weights_are_those_of_rel_mse() {
    let weights = weights(&[vec![2.0; 3], vec![4.0; 3]]);
    assert!((weights[0] - 1.0 / 9.01).abs() < 1e-12);
}
