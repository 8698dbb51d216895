use super::*;
use crate::film::Passes;
use crate::film::pixel::FirstHit;
use crate::render::tile::{Kept, tiles};
use glam::Vec3;

/// Pixels with so many samples, whose two halves have these values.
fn scene(samples: u32, of: impl Fn(u32, u32) -> (f32, f32)) -> (Region, Vec<Mutex<Tile>>) {
    let region = Region {
        x0: 3,
        y0: 5,
        x1: 67,
        y1: 45,
    };
    let tiles = tiles(region, Kept::of(Passes::COMBINED, (0, &[], false), true));
    for tile in &tiles {
        let mut tile = locked(tile);
        let (x0, y0, width) = (tile.x, tile.y, tile.width);
        let Tile { pixels, halves, .. } = &mut *tile;
        for (i, (pixel, half)) in (0..).zip(pixels.iter_mut().zip(halves)) {
            let (first, second) = of(x0 + i % width, y0 + i / width);
            for number in 0..samples {
                let in_half = number / 2 % 2 == 1;
                let value = Vec3::splat(if in_half { second } else { first });
                pixel.add(number % 2 == 1, value, &FirstHit::default());
                if in_half {
                    *half += value.as_dvec3();
                }
            }
            pixel.until = samples;
        }
    }
    (region, tiles)
}

fn rule(threshold: f64, min_samples: u32) -> NoiseThreshold {
    NoiseThreshold {
        threshold,
        min_samples,
    }
}

/// Pixels that go on, with how many samples.
fn more(tiles: &[Mutex<Tile>]) -> Vec<(u32, u32, u32)> {
    let mut all = Vec::new();
    for tile in tiles {
        let tile = locked(tile);
        for (i, pixel) in (0..).zip(&tile.pixels) {
            if pixel.until > pixel.samples {
                let (x, y) = (tile.x + i % tile.width, tile.y + i / tile.width);
                all.push((x, y, pixel.until - pixel.samples));
            }
        }
    }
    all.sort_unstable();
    all
}

/// The values are what Cycles' rules give (`Integrator::get_adaptive_sampling`, `AdaptiveSampling::need_filter`): 0.1, 0.01 and
/// 0.001 let 32, 64 and 128 samples be the least, and it looks at each 16th sample beyond.
#[test]
fn the_first_look_is_where_cycles_has_it() {
    for (threshold, min_samples, first) in [
        (0.1, 0, 48),
        (0.01, 0, 80),
        (0.001, 0, 144),
        (0.01, 1, 16),
        (0.01, 14, 16),
        (0.01, 15, 32),
        (0.01, 16, 32),
        (0.01, 64, 80),
        (1e-9, 0, 8032),
    ] {
        let found = rule(threshold, min_samples).first_look();
        assert_eq!(found, first, "{threshold} {min_samples}");
    }
}

#[test]
fn a_pixel_that_goes_on_takes_those_around_it_along() {
    // In the corner of four tiles, and at the picture's rim.
    let noisy = [(34, 36), (3, 20)];
    let of = |x, y| {
        if noisy.contains(&(x, y)) {
            (0.2, 0.4)
        } else {
            (0.3, 0.3)
        }
    };
    let (region, tiles) = scene(80, of);
    assert_eq!(rule(0.01, 0).plan(&tiles, region, 1000), Ok(()));
    let mut expected = Vec::new();
    for (x, y) in noisy {
        for near in x.saturating_sub(1).max(3)..=x + 1 {
            expected.extend((y - 1..=y + 1).map(|row| (near, row, 16)));
        }
    }
    expected.sort_unstable();
    assert_eq!(more(&tiles), expected);
    // The last round is as long as there are samples left.
    assert_eq!(rule(0.01, 0).plan(&tiles, region, 85), Ok(()));
    assert!(more(&tiles).iter().all(|&(_, _, samples)| samples == 5));
    assert_eq!(rule(0.01, 0).plan(&tiles, region, 80), Err(Stop::Samples));
}

/// By hand: grey pixels with halves a and b have 3 |a − b| / 2 against 1e-4 + √(3 (a + b) / 2), or without the root above 1.
#[test]
fn the_measure_is_cycles_own() {
    for (a, b) in [(0.1f32, 0.102f32), (0.8, 0.83), (3.0, 3.5), (0.0, 1e-6)] {
        let (low, high) = (f64::from(a), f64::from(b));
        let sum = 1.5 * (low + high);
        let size = if sum < 1.0 { sum.sqrt() } else { sum };
        let error = 1.5 * (high - low) / (1e-4 + size);
        let (region, tiles) = scene(80, |_, _| (a, b));
        let above = rule(error / 5.0 * 1.001, 0).plan(&tiles, region, 1000);
        assert_eq!(above, Err(Stop::NoiseThreshold), "{a} {b}");
        let below = rule(error / 5.0 * 0.999, 0).plan(&tiles, region, 1000);
        assert_eq!(below, Ok(()), "{a} {b}");
    }
}

/// After a render that was no multiple of 16 samples, looks are where they are otherwise.
#[test]
fn the_next_look_is_at_a_multiple_of_16() {
    let (region, tiles) = scene(100, |_, _| (0.1, 0.5));
    assert_eq!(rule(0.01, 0).plan(&tiles, region, 1000), Ok(()));
    assert!(more(&tiles).iter().all(|&(_, _, samples)| samples == 12));
}
