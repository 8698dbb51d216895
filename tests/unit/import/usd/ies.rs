use super::*;
use glam::Vec3;

const HEAD: &str = "IESNA:LM-63-1995\n[TEST]\nTILT=NONE\n1 1000 2";

/// Twice as much down as up, in quarters that are mirrored.
#[test]
fn candela_are_multiplied_and_mirrored() {
    let text = format!("{HEAD} 3 2 1 1 0 0 0\n0.5 1 100\n0 90 180\n0, 90\n100 80 50\n100 60 50\n");
    let profile = profile(text.as_bytes(), false, 0.0).unwrap();
    assert_eq!(profile.around.len(), 5);
    assert!((profile.of(Vec3::NEG_Z) - 100.0).abs() < 1e-4);
    // At the end itself it is 0, as in Cycles.
    assert!((profile.of(Vec3::new(1e-3, 0.0, 1.0)) - 50.0).abs() < 0.1);
    let sides: Vec<f32> = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::new(1e-6, -1.0, 0.0)]
        .iter()
        .map(|d| profile.of(*d))
        .collect();
    assert!((sides[0] - sides[2]).abs() < 1e-3 && (sides[1] - sides[3]).abs() < 1e-3);
    assert!((sides[0] - sides[1]).abs() > 19.0, "{sides:?}");
}

/// The mean of 1 + cos θ over the sphere is 1.
#[test]
fn a_normalized_profile_keeps_the_power() {
    let angles: Vec<String> = (0..=180).map(|a| a.to_string()).collect();
    let values: Vec<String> = (0..=180)
        .map(|a| (7.0 * (1.0 + f64::from(a).to_radians().cos())).to_string())
        .collect();
    let text = format!(
        "{HEAD} 181 1 1 1 0 0 0\n1 1 100\n{}\n0\n{}\n",
        angles.join(" "),
        values.join(" ")
    );
    let profile = profile(text.as_bytes(), true, 0.0).unwrap();
    assert!((profile.of(Vec3::NEG_Z) - 2.0).abs() < 1e-3);
    assert!((profile.of(Vec3::X) - 1.0).abs() < 1e-3);
}

#[test]
fn angles_are_rescaled_from_either_end() {
    let text = format!("{HEAD} 2 1 1 1 0 0 0\n1 1 100\n0 180\n0\n1 2\n");
    let down = |scale| profile(text.as_bytes(), false, scale).unwrap().down;
    let near = |angles: Vec<f32>, expected: [f32; 2]| {
        angles
            .iter()
            .zip(expected)
            .all(|(a, b)| (a.to_degrees() - b).abs() < 1e-3)
    };
    assert!(near(down(0.5), [0.0, 90.0]));
    assert!(near(down(-0.5), [90.0, 180.0]));
}

#[test]
fn broken_files_are_told() {
    for text in [
        "",
        "TILT=NONE",
        "TILT=NONE\n1 1 1 2",
        "TILT=NONE\n1 1 1 1e30 1 1 1 0 0 0 1 1 1 0 0 0",
        "TILT=NONE\n1 1 1 2 1 1 1 0 0 0 1 1 1 90 0 0 1 1",
        "TILT=NONE\n1 1 1 2 1 2 1 0 0 0 1 1 1 0 90 0 1 1",
        "TILT=INCLUDE\n1 -5",
        "TILT=NONE\n1 1 nan 2 1 1 1 0 0 0 1 1 1 0 90 0 1 1",
    ] {
        assert!(profile(text.as_bytes(), true, 0.0).is_err(), "{text}");
    }
}
