use super::*;

fn ray(direction: Vec3) -> CameraRay {
    CameraRay {
        origin: Vec3::ZERO,
        direction: direction.normalize(),
        near: 0.0,
        far: f32::INFINITY,
        time: 0.0,
    }
}

const EYE: Eye = Eye {
    offset: 0.5,
    convergence: 4.0,
    pole_merge: None,
};

#[test]
fn an_eye_is_beside_each_direction_and_sees_what_the_middle_sees_at_the_convergence() {
    for direction in [-Vec3::Z, Vec3::X, Vec3::new(1.0, 1.0, -1.0)] {
        let middle = ray(direction);
        let seen = EYE.sees(middle, Vec3::Y);
        assert!((seen.origin.length() - 0.5).abs() < 1e-6);
        assert!(seen.origin.dot(middle.direction).abs() < 1e-6);
        assert!(seen.origin.y.abs() < 1e-6);
        // To the right of it: ahead is −Z.
        let right = middle.direction.cross(Vec3::Y);
        assert!(seen.origin.dot(right) > 0.0);
        let distance = (middle.direction * 4.0 - seen.origin).length();
        let met = seen.origin + seen.direction * distance;
        assert!(met.distance(middle.direction * 4.0) < 1e-5);
    }
    let parallel = Eye {
        convergence: f32::INFINITY,
        ..EYE
    };
    let middle = ray(Vec3::X);
    assert_eq!(parallel.sees(middle, Vec3::Y).direction, middle.direction);
}

#[test]
fn at_the_poles_both_eyes_are_one() {
    let merged = Eye {
        pole_merge: Some([0.5, 1.0]),
        ..EYE
    };
    let offset = |altitude: f32| {
        let (sin, cos) = altitude.sin_cos();
        let seen = merged.sees(ray(Vec3::new(0.0, sin, -cos)), Vec3::Y);
        seen.origin.length()
    };
    assert!((offset(0.4) - 0.5).abs() < 1e-6);
    // Half-way through a quarter of the wave.
    assert!((offset(0.75) - 0.5 * 0.5f32.sqrt()).abs() < 1e-5);
    assert_eq!(offset(1.2), 0.0);
    // Straight up there is no right.
    assert_eq!(EYE.sees(ray(Vec3::Y), Vec3::Y).origin, Vec3::ZERO);
}
