use super::*;

fn at(turn: f32, distance: f32) -> Vec3 {
    Vec3::new(distance * turn.cos(), distance * turn.sin(), 7.0)
}

#[test]
fn the_middle_of_a_side_is_at_its_level() {
    for sides in [3.0, 5.0, 5.4] {
        for roundness in [0.0, 0.3, 1.0] {
            let middle = PI / sides;
            let found = radial_tiling(false, at(middle, 1.5), sides, roundness);
            assert!(
                (found.coordinates - Vec2::new(0.0, 0.5))
                    .abs()
                    .max_element()
                    < 1e-5
            );
            assert!((found.rotation - middle).abs() < 1e-6);
            assert_eq!(found.id, 0.0);
        }
    }
}

#[test]
fn segments_are_normalised_to_their_borders() {
    for (sides, roundness) in [(4.0, 0.0), (4.0, 0.6), (6.0, 1.0), (4.5, 0.0), (4.5, 0.4)] {
        for segment in 0..4 {
            let border = segment as f32 * TAU / sides;
            let before =
                radial_tiling(true, at(border + TAU / sides - 1e-4, 2.0), sides, roundness);
            let after = radial_tiling(true, at(border + 1e-4, 2.0), sides, roundness);
            assert!(
                before.coordinates.x > 0.99 && before.coordinates.x < 1.001,
                "{sides} {before:?}"
            );
            assert!(
                after.coordinates.x < 0.01 && after.coordinates.x > -0.001,
                "{sides} {after:?}"
            );
            assert_eq!((before.id, after.id), (segment as f32, segment as f32));
        }
    }
}

#[test]
fn what_is_no_tiling_is_no_crash() {
    let numbers = [
        0.0,
        -1.0,
        1e30,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        2.5,
    ];
    for x in numbers {
        for y in numbers {
            for normalize in [false, true] {
                radial_tiling(normalize, Vec3::new(x, y, 0.0), y, x);
                radial_tiling(normalize, Vec3::new(1.0, x, 0.0), x, y);
            }
        }
    }
    let origin = radial_tiling(true, Vec3::ZERO, 5.0, 0.5);
    assert_eq!(origin.coordinates.x, 0.5);
}
