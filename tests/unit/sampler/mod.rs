use super::*;

/// The first 2^k samples of each replicate are a (0, k, 2)-net: each elementary interval holds
/// exactly one point.
#[test]
fn blocks_of_a_pixel_are_nets_in_every_elementary_interval() {
    for seed in 0..4 {
        for k in [2u32, 4, 6, 8] {
            let sequence = Sequence::new(seed);
            for (px, py, bounce) in [(0, 0, 0), (17, 5, 1), (1000, 77, 9)] {
                let points: Vec<Vec2> = (0..1 << k)
                    .map(|s| sequence.sampler(px, py, 2 * s + seed % 2))
                    .map(|sampler| sampler.pair(Dimension::Bsdf, bounce))
                    .collect();
                for a in 0..=k {
                    let (nx, ny) = (1u32 << a, 1u32 << (k - a));
                    let mut seen = vec![false; 1 << k];
                    for p in &points {
                        let cell =
                            (p.x * nx as f32) as usize + nx as usize * (p.y * ny as f32) as usize;
                        assert!(!seen[cell], "seed {seed} k {k} a {a}");
                        seen[cell] = true;
                    }
                }
            }
        }
    }
}

/// The first two of a triple are the pair, and the first 2^k samples of a replicate are a
/// (1, k, 3)-net: each elementary interval of volume 2^(1 − k) holds two points.
#[test]
fn triples_are_nets_of_quality_one() {
    for (seed, k) in [(0, 4u32), (1, 6), (2, 7)] {
        let sequence = Sequence::new(seed);
        let samplers: Vec<_> = (0..1 << k)
            .map(|s| sequence.sampler(12, 7, 2 * s + seed % 2))
            .collect();
        let points: Vec<Vec3> = samplers
            .iter()
            .map(|s| s.triple(Dimension::Light, 3))
            .collect();
        for (s, p) in samplers.iter().zip(&points) {
            assert_eq!(s.pair(Dimension::Light, 3), p.truncate());
        }
        for a in 0..k {
            for b in 0..k - a {
                let n = [1usize << a, 1 << b, 1 << (k - 1 - a - b)];
                let mut seen = vec![0; n.iter().product()];
                for p in &points {
                    let cell: [usize; 3] = std::array::from_fn(|i| (p[i] * n[i] as f32) as usize);
                    seen[cell[0] + n[0] * (cell[1] + n[1] * cell[2])] += 1;
                }
                assert!(
                    seen.iter().all(|&count| count == 2),
                    "seed {seed} k {k} {n:?}"
                );
            }
        }
    }
}

/// Samples that a choice picks are still evenly spread: with two choices of 7/8 and 1/8, the
/// variance of the mean of a step over the larger one's samples is far below that of a random
/// subset's, p(1 − p)/n.
#[test]
fn a_choice_leaves_the_rest_stratified() {
    let (n, trials) = (256, 64);
    let mut square = 0.0;
    for seed in 0..trials {
        let sequence = Sequence::new(seed);
        let hits = (0..n)
            .map(|s| sequence.sampler(2, 9, s).triple(Dimension::Bsdf, 0))
            .filter(|p| p.z < 0.875 && p.x < 0.5 && p.y < 0.25)
            .count();
        square += (hits as f64 / f64::from(n) - 0.875 / 8.0).powi(2);
    }
    let random = 0.875 / 8.0 * (1.0 - 0.875 / 8.0) / f64::from(n);
    assert!(square / f64::from(trials) < random / 8.0);
}

/// The errors of two replicates have no correlation: its coefficient over n independent seeds has a
/// standard deviation of 1/√n; 5 σ. (Halves of one net fail here: where one errs upwards, the other
/// errs downwards.)
#[test]
fn replicates_err_independently() {
    let (n, seeds) = (16u32, 4096u32);
    let error = |seed, replicate| {
        let sequence = Sequence::new(seed);
        let sum: f64 = (0..n)
            .map(|s| sequence.sampler(5, 6, 2 * s + replicate))
            .map(|sampler| sampler.pair(Dimension::Light, 1))
            .map(|p| f64::from(u8::from(p.x * p.x + p.y * p.y < 1.0)))
            .sum();
        sum / f64::from(n) - std::f64::consts::FRAC_PI_4
    };
    let (mut product, mut squares) = (0.0, [0.0; 2]);
    for seed in 0..seeds {
        let [a, b] = [error(seed, 0), error(seed, 1)];
        product += a * b;
        squares[0] += a * a;
        squares[1] += b * b;
    }
    let correlation = product / f64::sqrt(squares[0] * squares[1]);
    assert!(
        correlation.abs() < 5.0 / f64::from(seeds).sqrt(),
        "{correlation}"
    );
}

/// χ² test of uniformity over pixels at a fixed sample: 64 cells, so 63 degrees of freedom;
/// the 1e-6 quantile is 131 (Wilson–Hilferty). Points of one picture are a net, so the
/// statistic is in fact far smaller than that; a defect of the hashes would make it large.
#[test]
fn numbers_are_uniform_over_seeds() {
    let mut cells = [0f64; 64];
    let n = 16_384;
    for seed in 0..n {
        let p = Sequence::new(seed)
            .sampler(3, 5, 0)
            .pair(Dimension::Bsdf, 1);
        cells[(p.x * 8.0) as usize + 8 * (p.y * 8.0) as usize] += 1.0;
    }
    let expected = f64::from(n) / 64.0;
    let chi2: f64 = cells
        .iter()
        .map(|c| (c - expected).powi(2) / expected)
        .sum();
    assert!(chi2 < 131.0, "{chi2}");
}

/// Different names and bounces are uncorrelated: the correlation coefficient of n
/// independent pairs has a standard deviation of 1/√n; 5 σ over all pairs of dimensions.
#[test]
fn dimensions_are_uncorrelated() {
    use Dimension::*;
    let n = 4096u32;
    let sequence = Sequence::new(11);
    let names = [
        (Filter, 0),
        (Bsdf, 0),
        (Light, 0),
        (Roulette, 0),
        (Bsdf, 1),
        (Light, 1),
    ];
    let columns: Vec<Vec<f64>> = names
        .iter()
        .flat_map(|&(d, b)| {
            (0..3).map(move |axis| {
                (0..n)
                    .map(|s| f64::from(sequence.sampler(9, 4, s).triple(d, b)[axis]) - 0.5)
                    .collect()
            })
        })
        .collect();
    for i in 0..columns.len() {
        for j in 0..i {
            let r: f64 = columns[i]
                .iter()
                .zip(&columns[j])
                .map(|(a, b)| a * b * 12.0)
                .sum::<f64>()
                / f64::from(n);
            assert!(r.abs() < 5.0 / f64::from(n).sqrt(), "{i} {j}: {r}");
        }
    }
}

#[test]
fn a_smooth_integral_converges_faster_than_random() {
    // ∫ sin(πx)·sin(πy) = 4/π²; the error of scrambled nets falls as N^-1.5.
    let error = |n: u32| {
        let mut square = 0f64;
        let trials = 32;
        for seed in 0..trials {
            let sequence = Sequence::new(seed);
            let mean: f64 = (0..n)
                .map(|s| {
                    let p = sequence.sampler(1, 2, s).pair(Dimension::Bsdf, 0);
                    (f64::from(p.x) * std::f64::consts::PI).sin()
                        * (f64::from(p.y) * std::f64::consts::PI).sin()
                })
                .sum::<f64>()
                / f64::from(n);
            square += (mean - 4.0 / std::f64::consts::PI.powi(2)).powi(2);
        }
        (square / f64::from(trials)).sqrt()
    };
    let slope = (error(4096) / error(64)).log2() / 6.0;
    assert!(slope < -1.2, "{slope}");
}

#[test]
fn indices_above_two_to_the_32_keep_their_places() {
    let sequence = Sequence::new(0);
    let p = sequence
        .sampler(4095, 4095, (1 << 24) - 1)
        .pair(Dimension::Filter, 0);
    assert!((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y));
    assert_ne!(
        p,
        sequence
            .sampler(4095, 4094, (1 << 24) - 1)
            .pair(Dimension::Filter, 0)
    );
}

/// With one sequence the first 2^k samples of a pixel are a (0, k, 2)-net, all of them together.
#[test]
fn all_samples_of_one_sequence_are_nets() {
    for (k, planned) in [
        (1u32, Some(2)),
        (2, Some(4)),
        (4, None),
        (5, Some(1000)),
        (8, Some(u32::MAX)),
    ] {
        let sequence = Sequence::of(k, Sequences::One { planned });
        let points: Vec<Vec2> = (0..1 << k)
            .map(|s| sequence.sampler(17, 5, s).pair(Dimension::Light, 2))
            .collect();
        for a in 0..=k {
            let (columns, rows) = (1u32 << a, 1u32 << (k - a));
            let mut seen = vec![false; 1 << k];
            for p in &points {
                let (x, y) = (p.x * columns as f32, p.y * rows as f32);
                let cell = x as usize + columns as usize * y as usize;
                assert!(!seen[cell], "k {k} a {a}");
                seen[cell] = true;
            }
        }
    }
}

/// Mean squares over seeds of a mean over n points on lights at a bounce less the truth, and of the error that the halves tell.
fn errors(
    sequences: Sequences,
    n: u32,
    bounce: u32,
    (f, truth): (impl Fn(Vec2) -> f64, f64),
) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for seed in 0..SEEDS {
        let sequence = Sequence::of(seed, sequences);
        let mut halves = [0.0; 2];
        for s in 0..n {
            let value = f(sequence.sampler(5, 6, s).pair(Dimension::Light, bounce));
            halves[usize::from(sequence.is_second(5, 6, s))] += value;
        }
        let [a, b] = halves;
        squares[0] += ((a + b) / f64::from(n) - truth).powi(2);
        squares[1] += ((a - b) / f64::from(n)).powi(2);
    }
    squares.map(|square| square / f64::from(SEEDS))
}

const SEEDS: u32 = 4096;

/// One sequence errs less than two, as halves of a net have more than half of its points' variance; and what its halves tell
/// is no less than its error. The mean square of N normal numbers has a relative deviation of √(2/N), 2.2 % of 4096: 5 σ of
/// the ratio of two are 16 %.
#[test]
fn one_sequence_errs_less_than_two_and_tells_no_less() {
    use std::f64::consts::{FRAC_PI_4, PI};
    const MARGIN: f64 = 0.16;
    let smooth = |p: Vec2| (PI * f64::from(p.x)).sin() * (PI * f64::from(p.y)).sin();
    let disc = |p: Vec2| f64::from(u8::from(p.length_squared() < 1.0));
    for n in [16, 64] {
        let integrands: [(&dyn Fn(Vec2) -> f64, f64); 2] =
            [(&smooth, 4.0 / (PI * PI)), (&disc, FRAC_PI_4)];
        for integrand in integrands {
            let [two, told_of_two] = errors(Sequences::Two, n, 1, integrand);
            for bounce in [0, 1] {
                let sequences = Sequences::One { planned: Some(n) };
                let [one, told] = errors(sequences, n, bounce, integrand);
                assert!(one < two * (1.0 - MARGIN), "{n}: {one} {two}");
                assert!(told > one * (1.0 - MARGIN), "{n}: {told} {one}");
            }
            assert!(
                (told_of_two / two - 1.0).abs() < MARGIN,
                "{n}: {told_of_two} {two}"
            );
        }
    }
}

/// Both halves of one sequence have as many samples, but for one, whatever their number: of each two samples one is in each.
#[test]
fn halves_of_one_sequence_are_as_large() {
    let sequence = Sequence::of(
        3,
        Sequences::One {
            planned: Some(1000),
        },
    );
    for pair in 0..2048 {
        let halves = [0, 1].map(|s| sequence.is_second(7, 4, 2 * pair + s));
        assert_ne!(halves[0], halves[1], "{pair}");
    }
}

/// Each half of the first 2^k points on lights is a (2, k - 1, 2)-net: 4 points are in every elementary interval of area 2^(3 - k).
/// (That holds for k up to 12 at least, by the ranks of the matrices.)
#[test]
fn lights_of_each_half_of_one_sequence_are_nets() {
    for (k, planned) in [(5u32, None), (8, Some(256)), (10, Some(1 << 20))] {
        let sequence = Sequence::of(k, Sequences::One { planned });
        for a in 0..=k - 3 {
            let (columns, rows) = (1u32 << a, 1u32 << (k - 3 - a));
            let mut counts = vec![[0; 2]; 1 << (k - 3)];
            for s in 0..1 << k {
                let p = sequence.sampler(9, 31, s).triple(Dimension::Light, 0);
                let (x, y) = (p.x * columns as f32, p.y * rows as f32);
                let half = usize::from(sequence.is_second(9, 31, s));
                counts[x as usize + columns as usize * y as usize][half] += 1;
            }
            assert!(counts.iter().all(|&of| of == [4, 4]), "k {k} a {a}");
        }
    }
}

/// The error of light at the first surface is told by halves of one sequence within twice what it is, where random halves tell
/// it seven times too large: a disc on a lamp, 256 samples. The ratio of two mean squares of 4096 numbers is 16 % off at 5 σ.
#[test]
fn halves_of_one_sequence_tell_light_nearly_as_it_errs() {
    let disc = |p: Vec2| f64::from(u8::from((p - 0.5).length_squared() < 0.1));
    let truth = std::f64::consts::PI * 0.1;
    let planned = Some(256);
    let [error, told] = errors(Sequences::One { planned }, 256, 0, (disc, truth));
    assert!(told / error < 4.0 * 1.16, "{told} {error}");
    let [error, random] = errors(Sequences::One { planned }, 256, 1, (disc, truth));
    assert!(random / error > 10.0, "{random} {error}");
}

/// Of one sequence the samples of 2^j × 2^j pixels together are a net, too, as many as are planned of each: that is what makes the
/// errors of neighbours differ. Beyond what is planned each pixel has nets of its own.
#[test]
fn neighbours_are_nets_together() {
    for (planned, log) in [(1u32, 0u32), (3, 2), (16, 4)] {
        let sequence = Sequence::of(
            9,
            Sequences::One {
                planned: Some(planned),
            },
        );
        for (block, side) in [(0, 1u32), (0, 2), (0, 4), (1, 1), (1, 2)] {
            let samples = (block << log)..((block + 1) << log);
            let points: Vec<Vec2> = (0..side * side)
                .flat_map(|i| {
                    samples
                        .clone()
                        .map(move |s| (8 + i % side, 20 + i / side, s))
                })
                .map(|(x, y, s)| sequence.sampler(x, y, s).pair(Dimension::Bsdf, 1))
                .collect();
            let bits = points.len().ilog2();
            for a in 0..=bits {
                let (columns, rows) = (1u32 << a, 1u32 << (bits - a));
                let mut seen = vec![false; points.len()];
                for p in &points {
                    let (x, y) = (p.x * columns as f32, p.y * rows as f32);
                    let cell = x as usize + columns as usize * y as usize;
                    assert!(
                        !seen[cell],
                        "{planned} planned, block {block}, side {side}, {a}"
                    );
                    seen[cell] = true;
                }
            }
        }
    }
}

/// What a path decides at surfaces behind each other is independent: it passes many as often as the product of their shares, whatever
/// the evenness of each. Binomial, 4 σ: evenness can only take from the variance.
#[test]
fn choices_behind_each_other_are_independent() {
    const LAYERS: u32 = 60;
    let sequence = Sequence::of(3, Sequences::One { planned: None });
    for share in [0.5f32, 0.95] {
        let layers = if share < 0.9 { 6 } else { LAYERS };
        let (mut passed, mut all) = (0u32, 0u32);
        for place in 0..96 * 64u32 {
            for sample in 0..8 {
                let sampler = sequence.sampler(place % 96, place / 96, sample);
                let passes =
                    |layer: u32| sampler.triple_behind(Dimension::Bsdf, 0, layer).z < share;
                passed += u32::from((0..layers).all(passes));
                all += 1;
            }
        }
        let p = f64::from(share).powi(layers as i32);
        let sigma = (p * (1.0 - p) * f64::from(all)).sqrt();
        let z = (f64::from(passed) - p * f64::from(all)) / sigma;
        println!(
            "{share}: {passed} of {all}, {:.1} expected, z {z:.2}",
            p * f64::from(all)
        );
        assert!(z.abs() < 4.0, "{share}: {z}");
    }
}

/// The same of numbers about things that are told apart by two words.
#[test]
fn numbers_about_two_things_are_independent_and_each_is_even() {
    let sequence = Sequence::of(5, Sequences::One { planned: None });
    let (mut both, mut all) = (0u32, 0u32);
    for place in 0..96 * 64u32 {
        let about = |sample: u32, what: u32| {
            let sampler = sequence.sampler(place % 96, place / 96, sample);
            sampler.about(Dimension::Opacity, 0, (what, 7))
        };
        // Of sixteen numbers each has a sixteenth of the unit interval.
        let mut numbers: Vec<u32> = (0..16)
            .map(|sample| (16.0 * about(sample, 1)) as u32)
            .collect();
        numbers.sort_unstable();
        assert_eq!(numbers, (0..16).collect::<Vec<_>>());
        for sample in 0..16 {
            both += u32::from(about(sample, 1) < 0.3 && about(sample, 2) < 0.3);
            all += 1;
        }
    }
    let p = 0.3f64 * 0.3;
    let z = (f64::from(both) - p * f64::from(all)) / (p * (1.0 - p) * f64::from(all)).sqrt();
    assert!(z.abs() < 4.0, "{z}");
}

/// A quadruple is a triple and a fourth number, which makes nets of quality 2 with the first and with the second number: the degrees of
/// their polynomials, less one each, add up to it (Niederreiter, 1988). Each half of the samples has as many of its intervals.
#[test]
fn fourth_numbers_are_spread_with_the_places_on_a_light() {
    for (k, planned) in [(6u32, None), (8, Some(256))] {
        let sequence = Sequence::of(k, Sequences::One { planned });
        let samplers: Vec<_> = (0..1 << k).map(|s| sequence.sampler(9, 31, s)).collect();
        let points = samplers.iter().map(|s| s.quadruple(Dimension::Light, 0));
        let points: Vec<Vec4> = points.collect();
        for (s, p) in samplers.iter().zip(&points) {
            assert_eq!(s.triple(Dimension::Light, 0), p.truncate());
        }
        for axis in [0, 1] {
            for a in 0..=k - 2 {
                let (columns, rows) = (1u32 << a, 1u32 << (k - 2 - a));
                let mut counts = vec![0; 1 << (k - 2)];
                for p in &points {
                    let (x, y) = (p.w * columns as f32, p[axis] * rows as f32);
                    counts[x as usize + columns as usize * y as usize] += 1;
                }
                assert!(counts.iter().all(|&of| of == 4), "k {k} axis {axis} a {a}");
            }
        }
        let mut halves = vec![[0; 2]; 1 << (k - 5)];
        for (s, p) in samplers.iter().zip(&points) {
            let interval = (p.w * halves.len() as f32) as usize;
            halves[interval][usize::from(s.is_in_half())] += 1;
        }
        assert!(halves.iter().all(|&of| of == [16, 16]), "k {k}: {halves:?}");
    }
}

/// The numbers of the third coordinate by its recurrence, mₖ = 2 mₖ₋₁ ⊕ 4 mₖ₋₂ ⊕ mₖ₋₂, of the fifth by its, mₖ = 2 mₖ₋₁ ⊕ 8 mₖ₋₃ ⊕
/// mₖ₋₃, and the first digits of the fourth.
#[test]
fn coordinates_have_their_numbers() {
    assert_eq!(numbers(0b11, &[1, 3])[..8], [1, 3, 3, 9, 29, 23, 71, 197]);
    assert_eq!(
        numbers(0b101, &[1, 1, 1])[..8],
        [1, 1, 1, 11, 31, 55, 61, 157]
    );
    assert_eq!(FOURTH, 0x3a74_e9d3);
}
