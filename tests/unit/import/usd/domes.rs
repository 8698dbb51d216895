use super::*;

fn near(found: [f64; 2], expected: [f64; 2]) {
    let gap = (glam::DVec2::from(found) - glam::DVec2::from(expected)).length();
    assert!(gap < 1e-9, "{found:?} is not {expected:?}");
}

/// UsdLux: latitude as Y and longitude as X; its middle is +Z, its left +X and its top +Y.
#[test]
fn maps_have_latitudes_and_longitudes() {
    for (way, place) in [
        (DVec3::Z, [0.5, 0.5]),
        (DVec3::X, [0.25, 0.5]),
        (DVec3::NEG_X, [0.75, 0.5]),
    ] {
        near(Layout::LatLong.place(way).0, place);
    }
    near([0.0, Layout::LatLong.place(DVec3::Y).0[1]], [0.0, 0.0]);
}

/// A sphere at the origin that is seen from far away on +Z: the law of reflection gives the direction of each of its points.
#[test]
fn balls_reflect_the_directions() {
    for [x, y] in [[0.0, 0.0], [0.5, 0.0], [-0.3, 0.6], [0.0, -0.95]] {
        let normal = DVec3::new(x, y, (1.0f64 - x * x - y * y).sqrt());
        let way = 2.0 * normal.z * normal - DVec3::Z;
        let (place, _) = Layout::MirroredBall.place(way);
        near(place, [0.5 + 0.5 * x, 0.5 - 0.5 * y]);
    }
}

#[test]
fn angular_images_have_the_angle_as_their_radius() {
    for (way, place) in [
        (DVec3::Z, [0.5, 0.5]),
        (DVec3::X, [0.75, 0.5]),
        (DVec3::Y, [0.5, 0.25]),
        (DVec3::new(1.0, 0.0, 1.0).normalize(), [0.625, 0.5]),
    ] {
        near(Layout::Angular.place(way).0, place);
    }
}

/// Folded to a cube and seen from inside: neighbours in the cross meet at the same direction, the back at both of its ends.
#[test]
fn crosses_fold_to_cubes() {
    let middles = [
        (DVec3::Y, [1, 0]),
        (DVec3::X, [0, 1]),
        (DVec3::Z, [1, 1]),
        (DVec3::NEG_X, [2, 1]),
        (DVec3::NEG_Y, [1, 2]),
        (DVec3::NEG_Z, [1, 3]),
    ];
    for (way, [column, row]) in middles {
        let place = [
            (f64::from(column) + 0.5) / 3.0,
            (f64::from(row) + 0.5) / 4.0,
        ];
        near(Layout::VerticalCross.place(way).0, place);
    }
    let at = |x: f64, y: f64, z: f64| Layout::VerticalCross.place(DVec3::new(x, y, z)).0;
    let e = 1e-12;
    for (one, other) in [
        (at(0.2, 1.0, 1.0 - e), at(0.2, 1.0 - e, 1.0)),
        (at(0.2, -1.0, 1.0 - e), at(0.2, -1.0 + e, 1.0)),
        (at(0.2, -1.0, -1.0 + e), at(0.2, -1.0 + e, -1.0)),
        (at(1.0, 0.2, 1.0 - e), at(1.0 - e, 0.2, 1.0)),
        (at(-1.0, 0.2, 1.0 - e), at(-1.0 + e, 0.2, 1.0)),
    ] {
        near(one, other);
    }
}

fn image(width: u32, height: u32, color: impl Fn(u32, u32) -> f32) -> Image {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let values: Vec<f32> = texels.flat_map(|(x, y)| [color(x, y); 3]).collect();
    Image {
        name: "i".into(),
        width,
        height,
        channels: 3,
        pixels: Pixels::from(values),
    }
}

/// What is drawn anew at the same size is the same.
#[test]
fn maps_stay_what_they_are() {
    let before = image(8, 4, |x, y| (3 * x + 7 * y) as f32);
    let after = upright(&before, Layout::LatLong).unwrap();
    for (a, b) in numbers(&before)
        .unwrap()
        .iter()
        .zip(numbers(&after).unwrap())
    {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn crosses_become_maps_as_long_as_four_sides() {
    let cross = image(12, 16, |x, y| ((y / 4) * 3 + x / 4) as f32);
    let map = upright(&cross, Layout::VerticalCross).unwrap();
    assert_eq!((map.width, map.height), (16, 8));
    let at = |x: usize, y: usize| numbers(&map).unwrap()[3 * (y * 16 + x)];
    // The middle is the side in the middle; its left is the side on the left.
    assert_eq!(
        [at(8, 4), at(4, 4), at(12, 4), at(0, 4)],
        [4.0, 3.0, 5.0, 10.0]
    );
    assert_eq!([at(3, 0), at(3, 7)], [1.0, 7.0]);
}

#[test]
fn domes_add_up() {
    let plain = |radiance: f64| Placed {
        image: None,
        radiance: [radiance; 3],
        turn: DMat3::IDENTITY,
    };
    let both = sum(vec![plain(1.0), plain(0.5)]).unwrap();
    assert!(both.image.is_none());
    assert_eq!(both.radiance, [1.5; 3]);
    let turn = DMat3::from_rotation_z(0.5 * PI);
    let shown = Placed {
        image: Some(image(4, 2, |x, _| x as f32)),
        radiance: [2.0; 3],
        turn,
    };
    let both = sum(vec![plain(1.0), shown]).unwrap();
    assert_eq!(both.turn, turn);
    let map = both.image.unwrap();
    let row: Vec<f32> = numbers(&map).unwrap()[..12]
        .iter()
        .step_by(3)
        .copied()
        .collect();
    for (found, expected) in row.iter().zip([1.0, 3.0, 5.0, 7.0]) {
        assert!((found - expected).abs() < 1e-5, "{row:?}");
    }
    assert!(sum(Vec::new()).is_none());
}
