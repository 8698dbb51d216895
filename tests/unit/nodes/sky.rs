use super::*;

fn sky(sun: Option<SunDisc>) -> Sky {
    let (width, height) = (8, 16);
    let texel = |i: usize| Vec3::new((i % width) as f32, (i / width) as f32, 1.0);
    Sky {
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
        start: FRAC_PI_2,
        sun,
        sought: None,
    }
}

#[test]
fn texels_are_read_at_their_middles() {
    let sky = sky(None);
    for (column, row) in [(0usize, 0usize), (3, 7), (5, 8), (7, 15)] {
        let (x, y) = ((column as f32 + 0.5) / 8.0, 1.0 - (row as f32 + 0.5) / 16.0);
        let half = 2.0 * y - 1.0;
        let elevation = (half * half).copysign(half) * FRAC_PI_2;
        let azimuth = -TAU * x - FRAC_PI_2;
        let (sin, cos) = elevation.sin_cos();
        let found = sky.of(Vec3::new(cos * azimuth.cos(), cos * azimuth.sin(), sin));
        let awaited = Vec3::new(column as f32, row as f32, 1.0);
        assert!((found - awaited).length() < 1e-3, "{found} {awaited}");
    }
}

#[test]
fn the_sun_lies_over_the_sky_and_ends_at_its_edge_and_the_horizon() {
    let sun = SunDisc {
        direction: Vec3::X,
        half_angle: 0.1,
        elevations: [-0.1, 0.1],
        colors: [Vec3::splat(100.0), Vec3::splat(300.0)],
        horizon: -0.02,
        covers: false,
    };
    let (with, without) = (sky(Some(sun)), sky(None));
    let more = |elevation: f32, azimuth: f32| {
        let (sin, cos) = elevation.sin_cos();
        let d = Vec3::new(cos * azimuth.cos(), cos * azimuth.sin(), sin);
        (with.of(d) - without.of(d)).x
    };
    assert!((more(0.0, 0.0) - 200.0).abs() < 0.1, "{}", more(0.0, 0.0));
    let limb = 250.0 * (1.0 - 0.6 * (1.0 - 0.75f32.sqrt()));
    assert!((more(0.05, 0.0) - limb).abs() < 0.1);
    assert_eq!(more(0.0, 0.11), 0.0);
    assert_eq!(more(-0.03, 0.0), 0.0);
    let before = sky(Some(SunDisc {
        covers: true,
        ..sun
    }));
    let beside = without.of(Vec3::X).x;
    assert!(beside > 1.0 && (before.of(Vec3::X).x - 200.0).abs() < 0.1);
    assert_eq!(before.of(-Vec3::X), without.of(-Vec3::X));
}

#[test]
fn what_the_sun_lacks_of_a_colour_the_sky_may_lend() {
    let without = sky(None);
    let sun = |blue: f32| SunDisc {
        direction: Vec3::X,
        half_angle: 0.1,
        elevations: [-0.1, 0.1],
        colors: [Vec3::new(9.0, 5.0, blue); 2],
        horizon: -1.0,
        covers: false,
    };
    let at = |blue: f32| sky(Some(sun(blue))).of(Vec3::X);
    assert!((without.of(Vec3::X) + Vec3::new(9.0, 5.0, -0.25) - at(-0.25)).length() < 1e-4);
    assert_eq!(at(-7.0).z, 0.0);
}
