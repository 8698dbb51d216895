use super::*;

/// A linear function of the place, in an array whose first axis goes fastest.
fn slope(size: IVec3) -> Grid {
    let mut values = Vec::new();
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                values.push(1.0 + x as f32 * 0.5 + y as f32 * 0.25 - z as f32 * 0.125);
            }
        }
    }
    Grid::dense("slope", (1, size), &values, DAffine3::IDENTITY).expect("a few points")
}

fn places() -> impl Iterator<Item = Vec3> {
    (0..500u32).map(|n| {
        let part = |k: u32| (n.wrapping_mul(k) >> 8) as f32 / (1 << 24) as f32;
        Vec3::new(
            part(2_654_435_761),
            part(2_246_822_519),
            part(3_266_489_917),
        )
    })
}

#[test]
fn both_interpolations_keep_what_is_linear() {
    let grid = slope(IVec3::new(20, 12, 9));
    for place in places() {
        let place = Vec3::ONE + place * Vec3::new(17.0, 9.0, 6.0);
        let known = 1.0 + place.dot(Vec3::new(0.5, 0.25, -0.125));
        for how in [Interpolation::Linear, Interpolation::Cubic] {
            let found = grid.sample(place, how);
            // 64 products and sums of numbers up to 12.
            assert!(
                (found.x - known).abs() < 1e-4,
                "{place} {how:?}: {found} {known}"
            );
            assert_eq!(found.w, 1.0);
        }
    }
}

#[test]
fn what_is_drawn_is_linear_in_the_mean() {
    let grid = slope(IVec3::splat(4));
    let count = 40_000;
    let corner = Vec3::new(1.25, 0.5, 2.75);
    let sum: f64 = (0..count)
        .map(|i| {
            let place = corner + Vec3::X * (i as f32 * 1e-6);
            f64::from(grid.sample(place, Interpolation::Drawn).x)
        })
        .sum();
    let known = f64::from(
        grid.sample(corner + Vec3::X * 0.02, Interpolation::Linear)
            .x,
    );
    // Five times the deviation of a mean of numbers that differ by 0.4 or so.
    assert!(
        (sum / f64::from(count) - known).abs() < 0.01,
        "{sum} {known}"
    );
}

#[test]
fn ranges_hold_all_that_is_found_within() {
    let grid = slope(IVec3::new(30, 30, 30));
    for (size, how) in [
        (1.0, Interpolation::Linear),
        (1.0, Interpolation::Cubic),
        (25.0, Interpolation::Linear),
    ] {
        for corner in places().take(40) {
            let low = corner * 34.0 - 2.0;
            let (least, most) = grid.range(low, low + size, how);
            for inner in places() {
                let found = grid.sample(low + inner * size, how).x;
                assert!(
                    found >= least.x - 1e-5 && found <= most.x + 1e-5,
                    "{low} {how:?}"
                );
            }
        }
    }
    // Where nothing is set, that is known.
    let far = Vec3::splat(100.0);
    assert_eq!(
        grid.range(far, far + 5.0, Interpolation::Cubic),
        (Vec4::ZERO, Vec4::ZERO)
    );
}

#[test]
fn far_apart_points_take_no_table() {
    let mut grid = Grid::new("far", 1, Vec4::ZERO, DAffine3::IDENTITY, true);
    for origin in [IVec3::splat(-1 << 30), IVec3::splat(1 << 30)] {
        grid.add_leaf(origin);
    }
    grid.finish_topology().expect("two leaves");
    grid.push_leaf(&[0.5; LEAF_POINTS]);
    grid.push_leaf(&[2.0; LEAF_POINTS]);
    assert_eq!(grid.value(IVec3::splat((1 << 30) + 7)).x, 2.0);
    assert_eq!(grid.value(IVec3::splat(-1 << 30)).x, 0.5);
    assert_eq!(grid.value(IVec3::ZERO).x, 0.0);
    assert!(grid.bytes() < 1 << 16);
}
