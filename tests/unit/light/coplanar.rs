use super::*;
use crate::scene::{AreaShape, Light, LightKind, Links, Visibility};
use glam::{DAffine3, DMat3};

fn area(turn: DMat3, place: DVec3) -> Light {
    let kind = LightKind::Area {
        shape: AreaShape::Rectangle,
        size: [1.0, 1.0],
        power: 1.0,
        normalize: true,
        spread: std::f32::consts::PI,
    };
    Light {
        name: "lamp".into(),
        color: [1.0; 3],
        kind,
        world_from_light: DAffine3::from_mat3_translation(turn, place),
        visibility: Visibility::ALL,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links: Links::default(),
        graph: None,
    }
}

/// Of three lamps in one plane a ray finds the first that it meets, whichever these are; one above them hides nothing.
#[test]
fn the_first_lamp_in_a_plane_is_found() {
    // Its bright side looks down.
    let down = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let places = [(0.0, 3.0), (1.0, 3.0), (2.0, 3.0), (0.0, 3.1)];
    let planes = places.map(|(x, y)| Plane::of(&area(down, DVec3::new(x, y, 0.0)), DVec3::ZERO));
    let found = Coplanar::new(&planes).unwrap();
    let ray = (
        Vec3::new(0.1, 0.0, 0.2),
        Vec3::new(0.1, 0.9, 0.3).normalize(),
    );
    let hidden = |meets: fn(u32) -> bool| [0, 1, 2, 3].map(|i| found.is_hidden(i, ray, meets));
    assert_eq!(hidden(|_| true), [false, true, true, false]);
    assert_eq!(hidden(|lamp| lamp != 0), [false, false, true, false]);
    assert!(Coplanar::new(&planes[2..]).is_none());
}

/// Lamps of which the one is a few roundings further hide each other where rounding says so, and never both.
#[test]
fn rounding_decides_between_turned_lamps() {
    let turn = DMat3::from_rotation_x(-1.2) * DMat3::from_rotation_z(0.3);
    let along = turn * DVec3::new(1.0, 2.0, 0.0);
    let planes =
        [DVec3::Y, DVec3::Y + along].map(|place| Plane::of(&area(turn, place), DVec3::ZERO));
    let found = Coplanar::new(&planes).unwrap();
    for k in 0..200 {
        let from = Vec3::new(k as f32 * 0.013, -1.0, k as f32 * -0.007);
        let ray = (
            from,
            Vec3::new(0.2, 0.9, 0.1 + k as f32 * 0.001).normalize(),
        );
        let hidden = [0, 1].map(|lamp| found.is_hidden(lamp, ray, |_| true));
        assert!(hidden != [true, true], "{ray:?}");
    }
}
