use super::*;

#[test]
fn each_axis_is_the_middle_of_its_face() {
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    for (number, axis) in axes.into_iter().enumerate() {
        assert_eq!(place(axis), (number, Vec2::splat(0.5)));
    }
}

#[test]
fn faces_are_seen_upright_from_inside() {
    // Looking along an axis with up above, what lies to the right is in the right half, what lies above in the upper one.
    for forward in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z] {
        let right = forward.cross(Vec3::Y);
        let (_, at) = place(forward + 0.5 * right + 0.25 * Vec3::Y);
        assert!(
            (at - Vec2::new(0.75, 0.375)).length() < 1e-6,
            "{forward}: {at}"
        );
    }
    // Looking up, the cube map's +Z is below; mirrored, its −X is to the right.
    let (face, at) = place(Vec3::new(-0.5, 1.0, 0.25));
    assert!(
        face == 2 && (at - Vec2::new(0.75, 0.625)).length() < 1e-6,
        "{at}"
    );
    let (face, at) = place(Vec3::new(-0.5, -1.0, 0.25));
    assert!(
        face == 3 && (at - Vec2::new(0.75, 0.375)).length() < 1e-6,
        "{at}"
    );
}

#[test]
fn the_panorama_shows_each_face_where_it_is() {
    let faces: Vec<Face> = (0..6)
        .map(|number| Face {
            size: 8,
            colors: vec![Vec3::splat(number as f32); 64],
        })
        .collect();
    let image = panorama(&faces);
    let Pixels::F32(values) = &image.pixels else {
        panic!("radiance is floats");
    };
    let at = |u: f32, v: f32| {
        let (x, y) = ((u * 32.0) as usize, (v * 16.0) as usize);
        values[3 * (y * 32 + x)]
    };
    // +X in the middle, then clockwise seen from above: +Z, −X at the edges, −Z; +Y on top.
    assert_eq!((at(0.5, 0.5), at(0.75, 0.5)), (0.0, 4.0));
    assert_eq!((at(0.01, 0.5), at(0.25, 0.5)), (1.0, 5.0));
    assert_eq!((at(0.5, 0.01), at(0.5, 0.99)), (2.0, 3.0));
}

#[test]
fn packed_light_is_unpacked() {
    let image = |pixels: Pixels, channels| Image {
        name: String::new(),
        width: 1,
        height: 1,
        channels,
        pixels,
    };
    let face = Face::new(&image(vec![255u8, 255, 255, 51].into(), 4)).unwrap();
    assert!((face.colors[0] - Vec3::splat(5.0)).length() < 1e-5);
    let face = Face::new(&image(vec![128u8, 0, 255].into(), 3)).unwrap();
    assert!((face.colors[0].x - 0.2159).abs() < 1e-4);
    let odd = Image {
        width: 2,
        ..image(vec![0u8; 6].into(), 3)
    };
    assert!(Face::new(&odd).is_none());
}
