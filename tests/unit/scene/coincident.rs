use super::*;
use crate::scene::{AreaShape, MeshId, RayKind, Visibility};

fn quad(size: f32, at: [f32; 3]) -> Mesh {
    let [x, y, z] = at;
    Mesh {
        positions: vec![
            [x, y, z],
            [x + size, y, z],
            [x + size, y + size, z],
            [x, y + size, z],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn scene(meshes: Vec<Mesh>, places: &[(u32, DAffine3)]) -> Scene {
    Scene {
        generator: Some("Sundog add-on for Blender".into()),
        instances: places
            .iter()
            .map(|&(mesh, world_from_object)| Instance {
                name: mesh.to_string(),
                mesh: MeshId(mesh),
                world_from_object,
                visibility: Visibility::ALL.without(RayKind::Volume),
                holdout: false,
                info: Default::default(),
                motion: Vec::new(),
            })
            .collect(),
        meshes,
        ..Scene::default()
    }
}

fn marks(found: &Coincident) -> Vec<(u32, &[Overlap])> {
    found.faces.iter().map(|(&i, of)| (i, &of[..])).collect()
}

/// Neighbours in one plane touch and do not overlap; what lies on one of two triangles does not lie on the other.
#[test]
fn flat_faces_that_overlap_are_found_by_triangle() {
    use Overlap::{Flat, None};
    let here = DAffine3::IDENTITY;
    let grid: Vec<Mesh> = (0..30)
        .flat_map(|x| (0..30).map(move |y| quad(1.0, [x as f32, y as f32, 0.25])))
        .collect();
    let places: Vec<_> = (0..900).map(|i| (i, here)).collect();
    assert!(find(&scene(grid.clone(), &places)).is_empty());

    // A small one on the lower triangle of the first.
    let mut with_rug = grid.clone();
    with_rug.push(quad(0.2, [0.7, 0.1, 0.25]));
    let mut more = places.clone();
    more.push((900, here));
    let found = find(&scene(with_rug.clone(), &more));
    assert_eq!(
        marks(&found),
        [(0, &[Flat, None][..]), (900, &[Flat, Flat][..])]
    );
    // Above it, however little, it lies on nothing.
    more[900].1 = DAffine3::from_translation(DVec3::Z * 1e-6);
    assert!(find(&scene(with_rug.clone(), &more)).is_empty());
    // Less than f32 can tell is nothing.
    more[900].1 = DAffine3::from_translation(DVec3::Z * 1e-10);
    assert_eq!(find(&scene(with_rug.clone(), &more)).faces.len(), 2);
    // A floor under all of them, across the grid's cells.
    let mut with_floor = grid;
    with_floor.push(quad(100.0, [-50.0, -50.0, 0.25]));
    more[900].1 = here;
    assert_eq!(find(&scene(with_floor, &more)).faces.len(), 901);
}

/// A crowd in one corner of a wide plane costs what its neighbours cost, not all of it with all of it.
#[test]
fn crowds_of_faces_in_a_wide_plane_are_told_apart() {
    let here = DAffine3::IDENTITY;
    let side = 300;
    let mut crowd = Mesh::default();
    let mut add = |of: Mesh| {
        let first = crowd.positions.len() as u32;
        crowd.positions.extend(of.positions);
        let moved = of.triangles.into_iter().map(|t| t.map(|i| first + i));
        crowd.triangles.extend(moved);
    };
    let size = 1.0 / 4096.0;
    for x in 0..side {
        for y in 0..side {
            add(quad(size, [x as f32 * size, y as f32 * size, 0.25]));
        }
    }
    add(quad(1.0, [4096.0, 4096.0, 0.25]));
    assert!(find(&scene(vec![crowd.clone()], &[(0, here)])).is_empty());

    let rug = quad(size / 8.0, [7.625 * size, 9.125 * size, 0.25]);
    let found = find(&scene(vec![crowd, rug], &[(0, here), (1, here)]));
    let floor = &found.faces[&0];
    let below: Vec<usize> = (0..floor.len())
        .filter(|&i| floor[i] != Overlap::None)
        .collect();
    assert_eq!(below, [2 * (7 * side + 9)]);
    assert_eq!(found.faces[&1], [Overlap::Flat; 2]);
}

/// Turned faces lie on each other where they have the same corners, in one mesh or in two, whichever way they are turned.
#[test]
fn turned_twins_are_found() {
    use Overlap::{None, Turned};
    let turn = DAffine3::from_quat(glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.1));
    let mut double = quad(1.0, [0.0; 3]);
    double.triangles.push([2, 1, 0]);
    let found = find(&scene(vec![double.clone()], &[(0, turn)]));
    assert_eq!(marks(&found), [(0, &[Turned, None, Turned][..])]);
    let twice = scene(vec![quad(1.0, [0.0; 3])], &[(0, turn), (0, turn)]);
    assert_eq!(find(&twice).faces.len(), 2);
    let beside = DAffine3::from_translation(DVec3::Z * 0.1) * turn;
    let apart = scene(vec![quad(1.0, [0.0; 3])], &[(0, turn), (0, beside)]);
    assert!(find(&apart).is_empty());
    // Of other programs' files nobody has a picture by Cycles.
    let mut foreign = scene(vec![double], &[(0, turn)]);
    foreign.generator = Some("gltf-transform".into());
    assert!(find(&foreign).is_empty());
}

/// A lamp in the plane of a ceiling, over its hole, and below it.
/// What overlaps in a turned plane does so whatever its corners are; neighbours, and what lies a little above, do not.
#[test]
fn faces_that_overlap_in_a_turned_plane_are_found() {
    let slope = DAffine3::from_rotation_x(0.7) * DAffine3::from_rotation_z(0.3);
    let meshes = vec![
        quad(2.0, [0.0; 3]),
        quad(2.0, [1.0, 0.5, 0.0]),
        quad(2.0, [-2.0, 0.0, 0.0]),
        quad(1.0, [0.5, 0.5, 1e-4]),
    ];
    let places = [(0, slope), (1, slope), (2, slope), (3, slope)];
    let found = find(&scene(meshes, &places));
    let turned = [Overlap::Turned; 2];
    assert_eq!(marks(&found), [(0, &turned[..]), (1, &turned[..])]);
}

/// A plane across an axis stays one however it is turned about that.
#[test]
fn faces_that_are_turned_about_their_normal_are_flat() {
    let floor = || quad(4.0, [-2.0, -2.0, 0.0]);
    let turned =
        |angle: f64| DAffine3::from_translation(DVec3::Z * 0.7) * DAffine3::from_rotation_z(angle);
    for (a, b) in [(0.5, 0.5), (0.5, 0.9), (0.0, -0.998)] {
        let scene = scene(vec![floor(), floor()], &[(0, turned(a)), (1, turned(b))]);
        let flat = [Overlap::Flat; 2];
        assert_eq!(
            marks(&find(&scene)),
            [(0, &flat[..]), (1, &flat)],
            "{a} {b}"
        );
    }
    let leaning = DAffine3::from_rotation_x(0.3);
    let found = find(&scene(
        vec![floor(), floor()],
        &[(0, leaning), (1, leaning)],
    ));
    assert_eq!(marks(&found)[0].1, [Overlap::Turned; 2]);
}

/// What is 300 km long overlaps what is small by as little as that does others.
#[test]
fn long_faces_overlap_small_ones() {
    let mut spike = quad(1.0, [0.25, 0.25, 4.5]);
    spike.positions[2] = [3e5, 3e5, 4.5];
    spike.triangles = vec![[0, 1, 2]];
    let places = [(0, DAffine3::IDENTITY), (1, DAffine3::IDENTITY)];
    let found = find(&scene(vec![quad(1.0, [0.0, 0.0, 4.5]), spike], &places));
    assert_eq!(found.faces[&1], [Overlap::Flat]);
    assert!(found.faces[&0].contains(&Overlap::Flat));
}

/// Two walls of one mesh that leans by 6 µm in 13 m are 3 µm apart where they overlap: rounding across them is a tenth of that.
#[test]
fn wide_faces_are_not_thicker_than_small_ones() {
    let mut wall = quad(13.0, [0.0, 0.0, 1.25]);
    wall.positions[1][2] += 6e-6;
    wall.positions[2][2] += 6e-6;
    let along = DAffine3::from_translation(DVec3::X * 7.0);
    let places = [(0, DAffine3::IDENTITY), (0, along)];
    assert!(find(&scene(vec![wall], &places)).is_empty());
}

#[test]
fn lamps_in_the_plane_of_a_face_are_found() {
    let ceiling = quad(4.0, [-2.0, -2.0, 7.4205]);
    let lamp = |x: f64, z: f64| Light {
        name: "lamp".into(),
        color: [1.0; 3],
        kind: LightKind::Area {
            shape: AreaShape::Rectangle,
            size: [1.0, 1.0],
            power: 1.0,
            normalize: true,
            spread: std::f32::consts::PI,
        },
        world_from_light: DAffine3::from_translation(DVec3::new(x, 0.0, z)),
        visibility: Visibility::ALL,
        max_bounces: 1024,
        is_hit: true,
        links: Default::default(),
        graph: None,
    };
    let mut scene = scene(vec![ceiling], &[(0, DAffine3::IDENTITY)]);
    let z = f64::from(7.4205f32);
    scene.lights = vec![lamp(0.0, z), lamp(2.4, z), lamp(2.5, z), lamp(0.0, 7.42)];
    let found = find(&scene);
    for number in [0, 1] {
        let on = &found.lights[&number];
        assert_eq!((on.plane.axis, on.plane.coordinate()), (2, 7.4205));
        assert_eq!(on.faces.len(), 2, "{number}: {:?}", on.faces);
        for corner in on.faces.values().flatten() {
            assert_eq!(corner.abs(), Vec3::new(2.0, 2.0, 7.4205));
        }
    }
    assert_eq!(found.lights.len(), 2);
    assert!(found.faces.is_empty());
}

/// Where a mesh has several users Cycles does not apply its transform: rounding decides, but at 0 and at powers of two.
#[test]
fn of_shared_meshes_rounding_decides() {
    let mesh = || quad(1.0, [0.0; 3]);
    let at = |z: f64| DAffine3::from_translation(DVec3::new(0.3, 0.0, z));
    for (z, expected) in [
        (0.0, Overlap::Flat),
        (-0.5, Overlap::Flat),
        (2.0, Overlap::Flat),
        (-1.2, Overlap::Turned),
        (3.0, Overlap::Turned),
    ] {
        // Both are users of one mesh, or each of one of its own.
        let shared = find(&scene(vec![mesh()], &[(0, at(z)), (0, at(z))]));
        assert_eq!(
            marks(&shared),
            [(0, &[expected; 2][..]), (1, &[expected; 2])]
        );
        let alone = find(&scene(vec![mesh(), mesh()], &[(0, at(z)), (1, at(z))]));
        let flat = [Overlap::Flat; 2];
        assert_eq!(marks(&alone), [(0, &flat[..]), (1, &flat)]);
    }
}
