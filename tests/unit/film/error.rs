use super::*;
use crate::sampler::hashed;

const WIDTH: usize = 96;

/// A normal number of mean 0 and variance 1 (Box and Muller 1958).
fn normal(key: u32, pixel: u32) -> f64 {
    let (u, v) = (
        f64::from(hashed(key, pixel, 1)),
        f64::from(hashed(key, pixel, 2)),
    );
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Pixels of a truth with noise of a standard deviation, each from two replicates; and their true relMSE.
fn picture(truth: impl Fn(usize, usize) -> f64, deviation: f64, key: u32) -> (Vec<Noisy>, f64) {
    let mut error = 0.0;
    let pixels = (0..WIDTH * WIDTH)
        .map(|i| {
            let r = truth(i % WIDTH, i / WIDTH);
            // The halves have twice the variance of their mean.
            let half = |k| r + deviation * 2f64.sqrt() * normal(key + k, i as u32);
            let (a, b) = (half(0), half(1));
            let mean = 0.5 * (a + b);
            error += (mean - r).powi(2) / (r * r + REL_MSE_OFFSET) / (WIDTH * WIDTH) as f64;
            Noisy {
                mean: DVec3::splat(mean),
                variance: DVec3::splat(0.25 * (a - b).powi(2)),
                ..Noisy::default()
            }
        })
        .collect();
    (pixels, error)
}

/// Flat, sloped and edged pictures with normal noise: the estimate is the true error within 5 %, and 95 % of
/// the intervals contain it (106 or less of 120 have a probability of 0.003).
#[test]
fn normal_noise_is_told_as_it_is() {
    type Truth = fn(usize, usize) -> f64;
    let truths: [(&str, Truth); 3] = [
        ("flat", |_, _| 0.5),
        ("slope", |x, y| 0.1 + 0.01 * (x + 2 * y) as f64),
        (
            "edges",
            |x, y| if (x / 12 + y / 9) % 2 == 0 { 0.2 } else { 1.5 },
        ),
    ];
    let mut inside = 0;
    for (name, truth) in truths {
        for deviation in [0.01, 0.05] {
            let (mut true_sum, mut told) = (0.0, 0.0);
            for key in 0..20 {
                let (pixels, error) = picture(truth, deviation, 10 * key);
                let (_, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
                let estimate = sums.estimate().unwrap();
                true_sum += error;
                told += estimate.error.powi(2);
                let range = estimate.low..=estimate.high;
                inside += u32::from(range.contains(&error.sqrt()));
            }
            let ratio = (told / true_sum).sqrt();
            assert!((ratio - 1.0).abs() < 0.05, "{name} {deviation}: {ratio}");
        }
    }
    assert!(inside > 106, "{inside}");
}

/// A firefly is an error as large as itself, not one of 100 %, to the factor in the error to which its truth is
/// known: neighbours of 0.5 and one of 10 in 25.
#[test]
fn a_firefly_is_told_as_large_as_it_is() {
    let (mut pixels, _) = picture(|_, _| 0.5, 0.01, 7);
    let spike = 400.0;
    pixels[40 * WIDTH + 30] = Noisy {
        mean: DVec3::splat(spike),
        variance: DVec3::splat(spike * spike),
        ..Noisy::default()
    };
    let (errors, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
    let expected = spike * spike / (0.25 + REL_MSE_OFFSET);
    let known = expected.sqrt() / f64::from(errors[40 * WIDTH + 30]).sqrt();
    assert!((1.0..1.8).contains(&known), "{known}");
    // It says nothing about its neighbours.
    let neighbour = f64::from(errors[40 * WIDTH + 31]);
    assert!((1e-6..0.01).contains(&neighbour), "{neighbour}");
    let whole = sums.estimate().unwrap();
    let expected = (expected / (WIDTH * WIDTH) as f64).sqrt() / known;
    assert!((whole.error / expected - 1.0).abs() < 0.01);
    // One pixel is all there is to go by.
    assert!(whole.high / whole.low > 4.0);
}

/// Bands with their neighbours' rows give what the whole gives.
#[test]
fn bands_are_parts_of_the_whole() {
    let (pixels, _) = picture(|x, y| 0.01 * (x + y) as f64, 0.03, 3);
    let (whole, sums) = relative_errors(&pixels, WIDTH, 0, WIDTH);
    let (mut parts, mut joined) = (Vec::new(), ErrorSums::default());
    for (from, to) in [(0, 32), (32, 64), (64, WIDTH)] {
        let (above, below) = (from.min(REACH), (WIDTH - to).min(REACH));
        let rows = &pixels[(from - above) * WIDTH..(to + below) * WIDTH];
        let (errors, sums) = relative_errors(rows, WIDTH, above, to - from);
        parts.extend(errors);
        joined.join(&sums);
    }
    assert_eq!(parts, whole);
    let (a, b) = (joined.estimate().unwrap(), sums.estimate().unwrap());
    assert!((a.error / b.error - 1.0).abs() < 1e-12);
}

#[test]
fn nothing_and_certainty_are_no_error() {
    assert_eq!(ErrorSums::default().estimate(), None);
    let black = vec![Noisy::default(); 30];
    let (errors, sums) = relative_errors(&black, 6, 0, 5);
    assert!(errors.iter().all(|&e| e == 0.0));
    let estimate = sums.estimate().unwrap();
    assert_eq!(
        (estimate.error, estimate.low, estimate.high),
        (0.0, 0.0, 0.0)
    );
}

#[test]
fn pooling_is_a_mean_over_what_is_around() {
    let mut values = vec![0f32; 20 * 16];
    values[6 * 20 + 10] = 48.0;
    let pooled = |values: &[f32], width| super::pooled(values, width, 3);
    let means = pooled(&values, 20);
    let at = |x: usize, y: usize| means[y * 20 + x];
    assert_eq!([at(10, 6), at(13, 9), at(14, 6)], [0.0, 1.0, 0.0]);
    assert_eq!(pooled(&[3.0; 10], 5), [3.0; 10]);
    assert_eq!(pooled(&[3.0], 1), [3.0]);
}

/// A noisy half and a quiet one: each is told apart where all that share its target look into one of them alone, but
/// for what the wide neighbourhood says. A firefly has no say in its own samples.
#[test]
fn samples_are_decided_near() {
    let side = 96;
    let mut errors: Vec<f32> = (0..side * side)
        .map(|i| if i % side < 48 { 1.0 } else { 0.0 })
        .collect();
    let at = |of: &[f32], x: usize| of[48 * side + x];
    let by_halves = deciding(&errors, side);
    assert!((at(&by_halves, 48 - NEAR - SHARED) - 1.0).abs() < 1e-6);
    let wide = pooled_of(Kind::Next, &errors, side, WIDE, DOUBTS);
    let beyond = at(&by_halves, 58);
    assert!(beyond > at(&wide, 58 + SHARED) && beyond < at(&wide, 58 - SHARED));
    assert_eq!(at(&by_halves, 48 + WIDE + SHARED), 0.0);
    errors[48 * side + 19] = 1000.0;
    let after = deciding(&errors, side);
    assert_eq!(at(&by_halves, 19), at(&after, 19));
    assert!(at(&after, 18) > at(&by_halves, 18));
}

/// One of the 16 pixels that these look at has all the error: a mean of 1 with a standard error of √15 / 4. Where all
/// have the same, there is no doubt.
#[test]
fn a_mean_that_few_make_is_doubted() {
    let mut errors = vec![0f32; 64];
    errors[2 * 8 + 2] = 16.0;
    let with = |doubts| pooled_of(Kind::Next, &errors, 8, 8, doubts)[3 * 8 + 2];
    assert_eq!(with(0.0), 1.0);
    assert!((f64::from(with(2.0)) - (1.0 + 2.0 * 15f64.sqrt() / 4.0)).abs() < 1e-6);
    assert_eq!(pooled_of(Kind::Next, &[3.0; 64], 8, 8, 2.0), [3.0; 64]);
}

/// A pixel of 0.1 of which one half met a bright sample does not take that for its own light, nor is it taken
/// for less than black.
#[test]
fn one_bright_sample_is_an_error() {
    let (a, b) = (8.1, 0.1);
    let pixel = Noisy {
        mean: DVec3::splat(0.5 * (a + b)),
        variance: DVec3::splat(0.25 * (a - b) * (a - b)),
        ..Noisy::default()
    };
    let expected = 16.0 / (b * b + REL_MSE_OFFSET);
    assert!((f64::from(pixel.own_error()) / expected - 1.0).abs() < 1e-6);
    let dark = Noisy {
        mean: DVec3::splat(0.01),
        variance: DVec3::splat(0.01),
        ..pixel
    };
    assert_eq!(dark.own_error(), 1.0);
}

/// Bands of one sample's errors 4 and 9, each as wide as a wide neighbourhood, with as many samples as they are told to
/// have for a target of 1, come to a mean error of 1, but for what is given beyond need: the wide neighbourhood takes the bands
/// of 4 for 6.5 at their edges, for 4 in their middle and so for 5.2 on average. That makes 4 / 5.2 of the error of
/// half of the pixels: an eighth less of the whole.
#[test]
fn neighbours_share_a_target_at_least_cost() {
    let band = 2 * WIDE + 1;
    let side = 6 * band;
    let kind = |i: usize| (i % side / band).is_multiple_of(2);
    let errors: Vec<f32> = (0..side * side)
        .map(|i| if kind(i) { 4.0 } else { 9.0 })
        .collect();
    let wanted = deciding(&errors, side);
    let mut mean = 0.0;
    // Whole periods far from the ends, both kinds of columns.
    let columns = 2 * band..4 * band;
    for x in columns.clone() {
        for y in 60..62 {
            let i = y * side + x;
            mean += errors[i] / wanted[i] / (2 * columns.len()) as f32;
        }
    }
    assert!((0.875..=1.0).contains(&mean), "{mean}");
}

/// Each kind sees the next one alone, so that it takes four steps to come back.
#[test]
fn what_a_pixel_says_comes_back_after_four_steps() {
    let side = 64;
    let start = 30 * side + 30;
    let mut seen: Vec<f32> = vec![0.0; side * side];
    seen[start] = 1.0;
    for step in 1..=4 {
        seen = deciding(&seen, side);
        assert_eq!(seen[start] > 0.0, step == 4, "{step}");
    }
    let next = |values: &[f32], width| pooled_of(Kind::Next, values, width, 4, 1.0);
    assert_eq!(next(&[3.0; 35], 7), [3.0; 35]);
    assert_eq!(next(&[3.0], 1), [3.0]);
}

/// What lies beyond an edge of the features has no say.
#[test]
fn features_keep_sides_apart() {
    let (mut pixels, _) = picture(|x, _| if x < 48 { 0.05 } else { 5.0 }, 0.004, 5);
    for (i, pixel) in pixels.iter_mut().enumerate() {
        let side = if i % WIDTH < 48 { 0.2 } else { 0.8 };
        pixel.features[0] = Vec3::splat(side);
    }
    // A spike of one half on the dark side, beside the edge.
    pixels[50 * WIDTH + 47] = Noisy {
        mean: DVec3::splat(2.0),
        variance: DVec3::splat(4.0),
        features: [Vec3::splat(0.2), Vec3::ZERO],
    };
    let (errors, _) = relative_errors(&pixels, WIDTH, 0, WIDTH);
    let (told, expected) = (
        f64::from(errors[50 * WIDTH + 47]),
        4.0 / (0.0025 + REL_MSE_OFFSET),
    );
    // Beside 0.05, its own share in the mean leaves a quarter of a doubt.
    assert!((0.4..1.1).contains(&(told / expected)), "{told} {expected}");
}
