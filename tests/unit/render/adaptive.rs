use super::*;
use crate::film::pixel::FirstHit;
use crate::render::Region;
use crate::render::tile::{Kept, tiles};

/// Pixels with 32 samples and squared errors by their number.
fn scene(error: impl Fn(usize) -> f32) -> Vec<Mutex<Tile>> {
    let tiles = tiles(Region::full(64, 40), Kept::default());
    for tile in &tiles {
        let mut tile = locked(tile);
        let pixels = tile.pixels.len();
        for pixel in &mut tile.pixels {
            for number in 0..32 {
                pixel.add(number % 2 == 1, glam::Vec3::ONE, &FirstHit::default());
            }
            pixel.until = 32;
        }
        tile.deciding = (0..pixels).map(&error).collect();
    }
    tiles
}

fn more(tiles: &[Mutex<Tile>]) -> Vec<u32> {
    let of = |tile: &Mutex<Tile>| -> Vec<u32> {
        let tile = locked(tile);
        tile.pixels.iter().map(|p| p.until - p.samples).collect()
    };
    tiles.iter().flat_map(of).collect()
}

#[test]
fn all_below_the_target_is_the_end() {
    let tiles = scene(|_| 0.0099);
    assert_eq!(plan(&tiles, 0.1, 1000), Err(Stop::PixelError));
    let tiles = scene(|i| if i == 7 { 0.0101 } else { 0.0099 });
    assert_eq!(plan(&tiles, 0.1, 32), Err(Stop::Samples));
    assert_eq!(plan(&tiles, 0.1, 1000), Ok(()));
    let more = more(&tiles);
    // A quarter of what they have, at least; one pixel in each of four tiles.
    assert_eq!(more.iter().filter(|&&m| m == 8).count(), 4);
    assert_eq!(more.iter().sum::<u32>(), 32);
}

#[test]
fn a_round_spends_half_where_the_error_is_largest() {
    // Errors over three decades: the budget brings the largest down and leaves the rest.
    let tiles = scene(|i| 10f32.powf(-3.0 * (i % 101) as f32 / 100.0));
    assert_eq!(plan(&tiles, 0.001, 100_000), Ok(()));
    let more = more(&tiles);
    let (pixels, spent) = (more.len() as u32, more.iter().sum::<u32>());
    let budget = 16 * pixels;
    assert!(
        spent >= budget && spent < budget * 104 / 100,
        "{spent} {budget}"
    );
    let of = |i: usize| more[i];
    assert!(
        of(0) == 32 && of(50) <= of(40) && of(100) == 0,
        "{:?}",
        &more[..101]
    );
}

#[test]
fn what_is_not_finite_goes_on() {
    let tiles = scene(|i| if i == 0 { f32::INFINITY } else { 0.0 });
    assert_eq!(plan(&tiles, 0.1, 1000), Ok(()));
    assert_eq!(more(&tiles)[0], 32);
}
