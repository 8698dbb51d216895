use super::*;

#[test]
fn measured_values_are_met_and_beyond_them_it_is_dark() {
    let profile = IesProfile {
        around: vec![0.0, PI, TAU],
        down: vec![0.0, 0.5, 1.0],
        strengths: vec![4.0, 2.0, 1.0, 4.0, 3.0, 2.0, 4.0, 2.0, 1.0],
        beyond: Beyond::Same,
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

#[test]
fn before_version_5_curves_end_toward_0() {
    let profile = |version| IesProfile {
        // Closed, also in single precision.
        around: vec![0.0, 7.0],
        down: vec![0.0, 0.5, 1.0],
        strengths: vec![2.0; 6],
        beyond: Beyond::of(version),
    };
    let at = |down: f32, version| profile(version).of(Vec3::new(0.0, down.sin(), -down.cos()));
    let (old, new) = (CyclesVersion::new(4, 5), CyclesVersion::new(5, 0));
    assert!((at(0.75, new) - 2.0).abs() < 1e-5);
    // The last of four values has a weight of −1/16 half-way between the middle ones.
    assert!((at(0.75, old) - 2.125).abs() < 1e-5, "{}", at(0.75, old));
    // Beyond the pole comes what is before it.
    assert!((at(0.25, old) - 2.0).abs() < 1e-5);
}
