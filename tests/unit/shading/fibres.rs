use super::*;

/// Chiang et al., eq. 9: the root of what is absorbed is the colour's logarithm over a polynomial of the roughness.
#[test]
fn colors_become_absorption() {
    for (roughness, color) in [(0.3, 0.5), (0.1, 0.02), (0.9, 0.7)] {
        let x: f64 = roughness;
        let scale = 5.969 - 0.215 * x + 2.532 * x * x - 10.73 * x.powi(3)
            + 5.574 * x.powi(4)
            + 0.245 * x.powi(5);
        let expected = (f64::ln(color) / scale).powi(2);
        let found = f64::from(absorption_of_color(Vec3::splat(color as f32), roughness as f32).x);
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }
    assert_eq!(absorption_of_color(Vec3::ONE, 0.3), Vec3::ZERO);
    assert!(absorption_of_color(Vec3::ZERO, 0.3).is_finite());
}

/// Blender's manual has a table of melanin: the amount is 1 − e^−concentration, and black hair is bounded.
#[test]
fn melanin_becomes_absorption() {
    let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-5;
    assert_eq!(absorption_of_melanin(0.0, 0.5), Vec3::ZERO);
    // A concentration of 1.
    let one = 1.0 - (-1f32).exp();
    assert!(near(
        absorption_of_melanin(one, 0.0),
        Vec3::new(0.506, 0.841, 1.653)
    ));
    assert!(near(
        absorption_of_melanin(one, 1.0),
        Vec3::new(0.343, 0.733, 1.924)
    ));
    assert!(near(
        absorption_of_melanin(one, 0.25),
        Vec3::new(0.46525, 0.814, 1.72075)
    ));
    let black = absorption_of_melanin(1.0, 0.0).x;
    assert!((black - 1e4f32.ln() * 0.506).abs() < 1e-4, "{black}");
    assert_eq!(absorption_of_melanin(2.0, 0.0).x, black);
}
