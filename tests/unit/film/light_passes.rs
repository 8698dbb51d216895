use super::*;

#[test]
fn what_is_put_in_comes_out_and_grey_channels_are_filled() {
    let mut path = PathPasses::default();
    let colors = [Vec3::new(0.5, 0.25, 0.0), Vec3::splat(0.04), Vec3::ZERO];
    // A surface that it passes, and the one behind it.
    path.first_colors(Vec3::splat(0.25), || colors);
    path.first_colors(Vec3::splat(0.75), || colors);
    path.first_surface(|| Vec2::new(0.25, 0.75));
    path.first_scattering(Vec3::new(0.6, 0.4, 0.1), Vec3::new(0.3, 0.3, 0.0), || {
        Vec3::ZERO
    });
    path.scattered(Vec3::new(6.0, 4.0, 1.0), false);
    path.scattered(Vec3::new(0.6, 0.4, 0.1), true);
    path.emission(Vec3::X);
    path.environment(Vec3::Y);
    let mut pixel = PixelPasses::default();
    pixel.add(&path);
    pixel.add(&PathPasses::default());
    let near = |a: DVec3, b: [f64; 3]| (a - DVec3::from(b)).length() < 1e-5;
    // 3/0.5, 3/0.25, and their mean where the colour has no blue.
    assert!(near(pixel.light(0, false), [6.0, 12.0, 9.0]));
    assert!(near(pixel.light(0, true), [0.6, 1.2, 0.9]));
    assert!(near(pixel.light(1, false), [75.0, 25.0, 25.0]));
    assert!(near(pixel.light(2, false), [0.0; 3]));
    assert!(near(pixel.color(0, 0.5), [0.25, 0.125, 0.0]));
    assert!(near(pixel.emission(0.5), [0.5, 0.0, 0.0]));
    assert!(near(pixel.environment(0.5), [0.0, 0.5, 0.0]));
    assert_eq!(pixel.uv(0.5), [0.125, 0.375, 0.5]);
}
