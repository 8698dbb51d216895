use super::*;

const SENSOR: Vec2 = Vec2::new(36.0, 24.0);

fn all() -> [Panorama; 6] {
    [
        Panorama::FisheyeEquidistant { fov: 3.0 },
        Panorama::FisheyeEquisolid {
            lens: 10.5,
            fov: PI,
            sensor: SENSOR,
        },
        // Blender's own numbers.
        Panorama::FisheyePolynomial {
            coefficients: [-1.2e-5, -0.02, -3.35e-6, 3.1e-6, -2.6e-8],
            fov: PI,
            sensor: SENSOR,
        },
        Panorama::MirrorBall,
        Panorama::CubeFace,
        Panorama::CentralCylindrical {
            longitude: [-1.0, 2.5],
            height: [-0.5, 1.5],
        },
    ]
}

#[test]
fn places_come_back_from_their_directions() {
    for panorama in all() {
        let mut seen = 0;
        for i in 0..20 {
            for j in 0..20 {
                let place = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / 20.0;
                let Some(direction) = panorama.direction(place) else {
                    continue;
                };
                seen += 1;
                assert!((direction.length() - 1.0).abs() < 1e-5, "{panorama:?}");
                let back = panorama.place(direction);
                assert!(
                    (back - place).length() < 1e-3,
                    "{panorama:?} {place} {back}"
                );
            }
        }
        assert!(seen > 150, "{panorama:?}");
    }
}

#[test]
fn the_middle_is_ahead_and_up_is_up() {
    for panorama in &all()[..5] {
        let ahead = panorama.direction(Vec2::splat(0.5)).unwrap();
        assert!(
            (ahead - Vec3::NEG_Z).length() < 1e-3,
            "{panorama:?} {ahead}"
        );
        let up = panorama.direction(Vec2::new(0.5, 0.6)).unwrap();
        let right = panorama.direction(Vec2::new(0.6, 0.5)).unwrap();
        assert!(up.y > 0.04 && right.x > 0.04, "{panorama:?} {up} {right}");
    }
}

#[test]
fn corners_of_fisheyes_are_empty() {
    // That of the polynomial is larger than its sensor.
    let all = all();
    for panorama in [all[0], all[1], all[3]] {
        assert_eq!(panorama.direction(Vec2::splat(0.01)), None, "{panorama:?}");
    }
}
