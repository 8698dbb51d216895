use super::*;

#[test]
fn measured_values_are_met_and_beyond_them_it_is_dark() {
    let profile = IesProfile {
        around: vec![0.0, PI, TAU],
        down: vec![0.0, 0.5, 1.0],
        strengths: vec![4.0, 2.0, 1.0, 4.0, 3.0, 2.0, 4.0, 2.0, 1.0],
    };
    assert!(profile.is_sane());
    let toward = |around: f32, down: f32| {
        // The angle about the axis is 0 at −Y and grows toward −X.
        let (sin, cos) = (around - PI).sin_cos();
        profile.of(Vec3::new(sin * down.sin(), cos * down.sin(), -down.cos()))
    };
    assert!((toward(1.0, 1e-4) - 4.0).abs() < 1e-2);
    assert!((toward(1e-3, 0.5) - 2.0).abs() < 1e-2);
    assert!((toward(PI, 0.5) - 3.0).abs() < 1e-2);
    assert_eq!(toward(1.0, 1.01), 0.0);
}
