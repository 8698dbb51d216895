use super::*;
use crate::math::warp::grid;

#[test]
fn irradiance_does_not_depend_on_the_angle() {
    for angle in [0f32, 1e-5, 0.00918, 0.5, 3.0] {
        let sun = Sun::new(Vec3::Y, Vec3::splat(3.0), angle);
        let n = 64;
        let mut sum = 0f64;
        for u in grid(n) {
            let d = sun.sample(u);
            sum += f64::from(sun.arriving().x * d.wi.y);
            if !sun.is_delta() {
                let by_radiance = sun.radiance().x / d.pdf;
                assert!((sun.arriving().x / by_radiance - 1.0).abs() < 1e-6);
            }
        }
        let found = sum / f64::from(n * n);
        assert!((found / 3.0 - 1.0).abs() < 1e-3, "{angle}: {found}");
    }
}

#[test]
fn a_sun_is_behind_a_normal_with_all_of_its_disc() {
    let sun = Sun::new(Vec3::NEG_Z, Vec3::ONE, 20f32.to_radians());
    for (degrees, behind) in [
        (0.0, true),
        (79.9, true),
        (80.1, false),
        (90.0, false),
        (180.0, false),
    ] {
        let (sine, cosine) = f32::sin_cos(f32::to_radians(degrees));
        assert_eq!(
            sun.is_behind(Vec3::new(sine, 0.0, cosine)),
            behind,
            "{degrees}"
        );
    }
}
