use super::*;

fn turned(angle: f64, scale: DVec3, translation: DVec3) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_y(angle), translation)
}

#[test]
fn the_parts_of_a_transform_make_it_again() {
    let skewed = DMat3::from_cols(
        DVec3::new(1.5, 0.2, -0.3),
        DVec3::new(0.4, -2.0, 0.1),
        DVec3::new(0.3, 0.5, 0.7),
    );
    for matrix3 in [DMat3::IDENTITY, skewed, -skewed, skewed * 1e-3] {
        let transform = DAffine3 {
            matrix3,
            translation: DVec3::new(3.0, -2.0, 1.0),
        };
        let again = Decomposed::new(&transform).to_affine();
        assert!(
            again.abs_diff_eq(transform, 1e-12),
            "{again:?} {transform:?}"
        );
    }
}

#[test]
fn rotations_go_along_the_arc_and_the_rest_along_a_line() {
    let from = turned(0.0, DVec3::ONE, DVec3::ZERO);
    let to = turned(2.0, DVec3::splat(3.0), DVec3::X * 4.0);
    let parts = decompose(&[from, to]);
    let middle = at(&parts, 0.25);
    assert!(middle.abs_diff_eq(turned(0.5, DVec3::splat(1.5), DVec3::X), 1e-12));
    assert!(at(&parts, 0.0).abs_diff_eq(from, 1e-12));
    assert!(at(&parts, 1.0).abs_diff_eq(to, 1e-12));
}

#[test]
fn from_step_to_step_rotations_take_the_shorter_way() {
    // In four steps around: each is less than half a turn.
    let steps: Vec<DAffine3> = (0..=4)
        .map(|i| turned(f64::from(i) * 1.5, DVec3::ONE, DVec3::ZERO))
        .collect();
    let parts = decompose(&steps);
    for i in 0..=16 {
        let time = i as f32 / 16.0;
        let expected = turned(f64::from(time) * 6.0, DVec3::ONE, DVec3::ZERO);
        assert!(at(&parts, time).abs_diff_eq(expected, 1e-12), "{time}");
    }
}

#[test]
fn what_is_pressed_to_a_point_turns_as_its_neighbour() {
    let nothing = DAffine3 {
        matrix3: DMat3::ZERO,
        translation: DVec3::ZERO,
    };
    let parts = decompose(&[nothing, turned(1.0, DVec3::splat(2.0), DVec3::ZERO)]);
    let half = at(&parts, 0.5);
    assert!(half.abs_diff_eq(turned(1.0, DVec3::ONE, DVec3::ZERO), 1e-12));
}

#[test]
fn times_lie_between_two_steps() {
    assert_eq!(step(0.0, 3), (0, 0.0));
    assert_eq!(step(0.5, 3), (1, 0.0));
    assert_eq!(step(0.75, 3), (1, 0.5));
    assert_eq!(step(1.0, 3), (1, 1.0));
}
