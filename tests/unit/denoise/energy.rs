use super::*;
use approx::assert_relative_eq;

fn grey(values: impl IntoIterator<Item = f32>) -> Vec<f32> {
    values.into_iter().flat_map(|v| [v, v, v, 0.5]).collect()
}

fn mean(data: &[f32], channel: usize) -> f64 {
    let values = data.iter().skip(channel).step_by(4);
    values.map(|&v| f64::from(v)).sum::<f64>() / (data.len() / 4) as f64
}

#[test]
fn factors_by_hand() {
    let block = |noisy, denoised, variance| Block {
        noisy,
        denoised,
        variance,
        own_variance: variance,
        pixels: 256.0,
    };
    // Off by 0.1 with a deviation of 0.05: three quarters are certain.
    assert_relative_eq!(factor(&block(1.0, 0.9, 0.0025)), 1.0 + 0.075 / 0.9);
    // Within the noise, nothing is.
    assert_eq!(factor(&block(1.0, 0.9, 0.02)), 1.0);
    assert_eq!(factor(&block(1.0, 0.0, 0.0)), 1.0);
    assert_eq!(factor(&block(1.0, 0.1, 0.0)), 2.0);
    assert_eq!(factor(&block(0.1, 1.0, 0.0)), 0.5);
}

#[test]
fn factors_are_interpolated_between_the_middles_of_blocks() {
    assert_eq!(between(0, 3), (0, 1, 0.0));
    let (first, second, share) = between(15, 3);
    assert_eq!((first, second), (0, 1));
    // 15.5 is 7.5 beyond the first middle, 8.
    assert_relative_eq!(share, 7.5 / 16.0);
    assert_eq!(between(47, 3).0, 2);
    assert_eq!(between(3, 1), (0, 0, 0.0));
}

#[test]
fn the_mean_of_each_channel_is_that_of_the_noisy_picture() {
    let noisy: Vec<f32> = (0..32 * 32)
        .flat_map(|i| [1.0 + (i % 7) as f32, 0.5, (i % 3) as f32, 1.0])
        .collect();
    let mut denoised: Vec<f32> = (0..32 * 32)
        .flat_map(|i| [3.0 + (i % 2) as f32, 0.4, 1.1, 0.25])
        .collect();
    let variances = vec![0.1; 32 * 32];
    let pair = Pair {
        size: (32, 32),
        noisy: &noisy,
        variances: Some(&variances),
    };
    give_back(&pair, &mut denoised);
    for channel in 0..3 {
        assert_relative_eq!(
            mean(&denoised, channel),
            mean(&noisy, channel),
            epsilon = 1e-6
        );
    }
    assert!(
        denoised
            .iter()
            .skip(3)
            .step_by(4)
            .all(|&alpha| alpha == 0.25)
    );
}

/// A block that is certainly too dark gets its light back, without an edge at its side: neighbours differ by less than the
/// step between the blocks over their distance.
#[test]
fn blocks_are_restored_without_edges() {
    let noisy = grey(vec![1.0; 48 * 16]);
    let mut denoised = grey((0..48 * 16).map(|i| if i % 48 < 16 { 0.8 } else { 1.0 }));
    let variances = vec![0.0; 48 * 16];
    let pair = Pair {
        size: (48, 16),
        noisy: &noisy,
        variances: Some(&variances),
    };
    let before = denoised.clone();
    give_back(&pair, &mut denoised);
    let factors: Vec<f32> = (0..48).map(|x| denoised[4 * x] / before[4 * x]).collect();
    assert!(factors[0] / factors[47] > 1.24, "{factors:?}");
    let steps = factors.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.fold(0.0, f32::max) < 0.25 / 15.0, "{factors:?}");
    let blocks = pair.blocks(&denoised);
    assert!((blocks[0].denoised - 1.0).abs() < 0.06, "{blocks:?}");
}
