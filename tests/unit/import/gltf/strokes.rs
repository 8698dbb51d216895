use super::*;

/// Six times the volume that closed triangles hold, which is positive if they face outward.
fn sixfold_volume(mesh: &Mesh) -> f32 {
    let at = |corner: u32| Vec3::from(mesh.positions[corner as usize]);
    let mut volume = 0.0;
    for &[a, b, c] in &mesh.triangles {
        volume += at(a).dot(at(b).cross(at(c)));
    }
    volume
}

fn plain(positions: Vec<[f32; 3]>) -> Mesh {
    Mesh {
        colors: Some(vec![[0.5; 4]; positions.len()]),
        positions,
        ..Mesh::default()
    }
}

/// More than any test takes.
fn budget() -> Budget {
    Budget::for_geometry(1 << 20, 0)
}

#[test]
fn all_spheres_are_closed_and_face_outward() {
    let full = 6.0 * 4.0 / 3.0 * std::f32::consts::PI;
    // The volume of an octahedron, an icosahedron, and that with each side in four, of a sphere's.
    for (points, share) in [
        (30_000, std::f32::consts::FRAC_1_PI),
        (3_000, 0.605),
        (1, 0.873),
    ] {
        let (directions, triangles) = ball(points);
        let mesh = Mesh {
            positions: directions.iter().map(|d| d.to_array()).collect(),
            triangles,
            ..Mesh::default()
        };
        let found = sixfold_volume(&mesh) / full;
        assert!((found - share).abs() < 1e-3, "{points}: {found}");
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for [a, b, c] in &mesh.triangles {
            edges.extend([[*a, *b], [*b, *c], [*c, *a]]);
        }
        // Each edge once each way.
        for [a, b] in &edges {
            assert_eq!(edges.iter().filter(|e| **e == [*a, *b]).count(), 1);
            assert_eq!(edges.iter().filter(|e| **e == [*b, *a]).count(), 1);
        }
    }
}

#[test]
fn spheres_stand_at_their_points() {
    let mut mesh = plain(vec![[1.0, 2.0, 3.0], [9.0; 3], [4.0, 5.0, 6.0]]);
    spheres(&mut mesh, &[[0, 0], [2, 2]], 0.5, &budget(), false).unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (84, 160));
    assert_eq!(mesh.colors.as_ref().map(Vec::len), Some(84));
    for (number, p) in mesh.positions.iter().enumerate() {
        let middle = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]][number / 42];
        let off = Vec3::from(*p).distance(Vec3::from(middle));
        assert!((off - 0.5).abs() < 1e-5);
    }
}

#[test]
fn tubes_are_closed_and_face_outward() {
    let mut mesh = plain(vec![[0.0; 3], [0.0, 0.0, 2.0], [0.0; 3]]);
    // One of no length has no surface.
    tubes(&mut mesh, &[[0, 1], [0, 2]], 1.0, &budget(), false).unwrap();
    assert_eq!(mesh.triangles.len(), 28);
    // A prism over a regular octagon, whose area is 2√2.
    let volume = sixfold_volume(&mesh) / 6.0;
    assert!((volume - 4.0 * 2f32.sqrt()).abs() < 1e-4, "{volume}");
}

#[test]
fn corners_become_ends() {
    let ends = |mode, corners: &[u32]| Stroke::new(mode, corners, 4).map(|s| s.ends);
    assert_eq!(ends(Mode::Points, &[0, 3, 4]), Some(vec![[0, 0], [3, 3]]));
    assert_eq!(
        ends(Mode::Lines, &[0, 1, 2, 3, 1]),
        Some(vec![[0, 1], [2, 3]])
    );
    assert_eq!(
        ends(Mode::LineStrip, &[0, 1, 2, 9]),
        Some(vec![[0, 1], [1, 2]])
    );
    assert_eq!(
        ends(Mode::LineLoop, &[0, 1, 2]),
        Some(vec![[0, 1], [1, 2], [2, 0]])
    );
    assert_eq!(ends(Mode::LineLoop, &[]), Some(vec![]));
    assert_eq!(ends(Mode::Triangles, &[0, 1, 2]), None);
}

#[test]
fn where_there_are_too_many_points_and_lines_have_fewer_sides() {
    let mut scene = Scene::default();
    let mut strokes = Vec::new();
    for mode in [Mode::Points, Mode::Lines] {
        scene.meshes.push(plain(vec![[0.0; 3], [0.0, 0.0, 2.0]]));
        let stroke = Stroke::new(mode, &[[0, 1]; 500].concat(), 2).unwrap();
        strokes.push((MeshId(scene.meshes.len() as u32 - 1), stroke));
    }
    let short = budget();
    short.take(short.left() - (1 << 20), 1).unwrap();
    draw(&mut scene, strokes, &short, &mut Diagnostics::default()).unwrap();
    let triangles = scene.meshes.iter().map(|mesh| mesh.triangles.len());
    assert_eq!(triangles.collect::<Vec<_>>(), [8000, 4000]);
    // A triangle's prism is closed, and faces outward.
    let mut mesh = plain(vec![[0.0; 3], [0.0, 0.0, 2.0]]);
    tubes(&mut mesh, &[[0, 1]], 1.0, &budget(), true).unwrap();
    let volume = sixfold_volume(&mesh) / 6.0;
    assert!((volume - 1.5 * 3f32.sqrt()).abs() < 1e-4, "{volume}");
}
