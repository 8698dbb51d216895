use super::*;
use approx::assert_relative_eq;

/// Grey pixels of these values, opaque.
fn grey(values: impl IntoIterator<Item = f32>) -> Vec<f32> {
    values.into_iter().flat_map(|v| [v, v, v, 1.0]).collect()
}

/// Two blocks side by side, of 16 × 16 and 4 × 16 pixels: 1 in the first, 3 in the second.
fn two_blocks() -> (Vec<f32>, Vec<f32>) {
    let column = |i: usize| i % 20;
    let noisy = grey((0..320).map(|i| if column(i) < 16 { 1.0 } else { 3.0 }));
    let variances = (0..320).map(|i| if column(i) < 16 { 0.25 } else { 1.0 });
    (noisy, variances.collect())
}

#[test]
fn shifts_and_intervals_by_hand() {
    let (noisy, variances) = two_blocks();
    let pair = Pair {
        size: (20, 16),
        noisy: &noisy,
        variances: Some(&variances),
    };
    // The first block becomes a tenth darker, the second stays.
    let denoised = grey((0..320).map(|i| if i % 20 < 16 { 0.9 } else { 3.0 }));
    let shift = pair.shift(&denoised).unwrap();
    // Means: (256 · 1 + 64 · 3) / 320 = 1.4, and 0.08 less.
    assert_relative_eq!(shift.mean, -0.08 / 1.4, epsilon = 1e-6);
    // Variance of the mean: (256 · 0.25 + 64 · 1) / 320² = 0.00125, with 3 · 128² / (256 · 0.0625 + 64) − 2 = 612.4 degrees of freedom.
    let interval = 1.963_84 * 0.00125_f64.sqrt() / 1.4;
    assert_relative_eq!(shift.mean_interval, interval, epsilon = 1e-5);
    // The first block: pixels in and about it have the variance (256 · 0.25 + 64 · 1) / 320 = 0.4, so its mean has √0.4 / 16; and each of
    // two holds with the chance √0.95, which is 2.2365 deviations.
    let largest = BlockShift {
        x: 0,
        y: 0,
        shift: shift.largest.shift,
        interval: shift.largest.interval,
    };
    assert_eq!(shift.largest, largest);
    assert_relative_eq!(largest.shift, -0.1, epsilon = 1e-6);
    let interval = 2.2365 * 0.4_f64.sqrt() / 16.0;
    assert_relative_eq!(largest.interval, interval, epsilon = 2e-5);
    assert_eq!((shift.blocks, shift.beyond), (2, 0.5));
}

#[test]
fn a_dark_block_is_measured_against_the_picture() {
    let noisy = grey((0..512).map(|i| if i % 32 < 16 { 1.0 } else { 0.0 }));
    let variances = vec![0.0; 512];
    let pair = Pair {
        size: (32, 16),
        noisy: &noisy,
        variances: Some(&variances),
    };
    let denoised = grey((0..512).map(|i| if i % 32 < 16 { 1.0 } else { 0.01 }));
    let shift = pair.shift(&denoised).unwrap();
    // The mean is 0.5, and a tenth of it 0.05.
    assert_eq!((shift.largest.x, shift.largest.y), (16, 0));
    assert_relative_eq!(shift.largest.shift, 0.2, epsilon = 1e-5);
}

#[test]
fn nothing_is_told_of_black_or_of_unknown_noise() {
    let (noisy, variances) = two_blocks();
    let black = vec![0.0; noisy.len()];
    let pair = |noisy, variances| Pair {
        size: (20, 16),
        noisy,
        variances,
    };
    assert_eq!(pair(&black, Some(&variances[..])).shift(&black), None);
    assert_eq!(pair(&noisy, None).shift(&noisy), None);
}

/// With noise that is rare and bright, and a denoiser that knows the truth: what is told of blocks is noise alone. Each interval of 95 %
/// holds, and that of the block which is chosen among all.
#[test]
fn intervals_of_blocks_hold_in_ninety_five_of_a_hundred() {
    use proptest::prelude::Rng;
    let mut rng = proptest::test_runner::TestRng::deterministic_rng(
        proptest::test_runner::RngAlgorithm::ChaCha,
    );
    // Each replicate has four samples of 0 or, one of ten, 10.
    let mut next = move || {
        let samples = (0..4).map(|_| f64::from(rng.next_u32().is_multiple_of(10)));
        samples.sum::<f64>() * 2.5
    };
    let denoised = grey(vec![1.0; 64 * 64]);
    let (mut largest, mut within) = (0, 0.0);
    let pictures = 400;
    for _ in 0..pictures {
        let mut variances = Vec::new();
        let noisy = grey((0..64 * 64).map(|_| {
            let [a, b] = [next(), next()];
            variances.push(((a - b) / 2.0).powi(2) as f32);
            ((a + b) / 2.0) as f32
        }));
        let pair = Pair {
            size: (64, 64),
            noisy: &noisy,
            variances: Some(&variances),
        };
        let shift = pair.shift(&denoised).unwrap();
        largest += u32::from(shift.largest.shift.abs() <= shift.largest.interval);
        within += 1.0 - shift.beyond;
    }
    // 380 with a deviation of 4.4, or more, as the larger of two variances is taken.
    assert!(largest >= 366, "{largest} of {pictures}");
    let within = within / f64::from(pictures);
    assert!((0.935..0.965).contains(&within), "{within}");
}

/// The interval is one of 95 %: of pictures whose noise has the stated variance, and a denoiser that knows the truth but makes it
/// 3 % darker.
#[test]
fn intervals_hold_in_ninety_five_of_a_hundred() {
    use proptest::prelude::Rng;
    let mut rng = proptest::test_runner::TestRng::deterministic_rng(
        proptest::test_runner::RngAlgorithm::ChaCha,
    );
    let mut next = move || f64::from(rng.next_u32()) / 4_294_967_296.0;
    let denoised = grey(vec![0.97; 400]);
    let mut held = 0;
    for _ in 0..1000 {
        // Noise of an even distribution, and its variance as two samples tell it.
        let mut variances = Vec::new();
        let noisy = grey((0..400).map(|_| {
            let [a, b] = [next(), next()].map(|v| 0.5 + v);
            variances.push(((a - b) / 2.0).powi(2) as f32);
            ((a + b) / 2.0) as f32
        }));
        let pair = Pair {
            size: (20, 20),
            noisy: &noisy,
            variances: Some(&variances),
        };
        let shift = pair.shift(&denoised).unwrap();
        held += u32::from((shift.mean + 0.03).abs() <= shift.mean_interval);
    }
    // 950 with a deviation of 7.
    assert!((925..=975).contains(&held), "{held} of 1000");
}

#[test]
fn words() {
    let (noisy, variances) = two_blocks();
    let pair = Pair {
        size: (20, 16),
        noisy: &noisy,
        variances: Some(&variances),
    };
    let denoised = grey((0..320).map(|i| if i % 20 < 16 { 0.9 } else { 3.0 }));
    assert_eq!(
        pair.shift(&denoised).unwrap().words(),
        "brightness shift -5.71 % ± 4.96 %, largest block -10.00 % ± 8.84 %"
    );
}
