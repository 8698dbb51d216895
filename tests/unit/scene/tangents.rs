use super::*;

/// A quad in the xy plane whose u runs along +x and whose v (downwards) along −y.
fn quad() -> Mesh {
    Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
        uvs: vec![vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

#[test]
fn the_tangent_follows_u_and_the_bitangent_points_up_the_picture() {
    let mut mesh = quad();
    compute(&mut mesh, 0);
    assert_eq!(mesh.positions.len(), 4, "a smooth quad is welded again");
    for t in mesh.tangents.as_ref().unwrap() {
        assert_eq!(*t, [1.0, 0.0, 0.0, 1.0]);
    }
}

#[test]
fn mirrored_texture_coordinates_split_vertices_and_flip_the_sign() {
    let mut mesh = quad();
    // Second triangle mirrored in u: shared corners now have two tangent frames.
    mesh.uvs[0] = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0]];
    compute(&mut mesh, 0);
    let signs: Vec<f32> = mesh
        .tangents
        .as_ref()
        .unwrap()
        .iter()
        .map(|t| t[3])
        .collect();
    assert_eq!(mesh.positions.len(), 6);
    assert!(signs.contains(&1.0) && signs.contains(&-1.0));
    let by_triangle = |t: usize| mesh.triangles[t].map(|i| signs[i as usize]);
    assert_eq!(by_triangle(0), [1.0; 3]);
    assert_eq!(by_triangle(1), [-1.0; 3]);
}

#[test]
fn flat_meshes_and_degenerate_coordinates_get_unit_tangents() {
    let mut mesh = quad();
    mesh.normals = None;
    // One point for the corners of one triangle.
    let [a, b, c] = mesh.triangles[0].map(|corner| corner as usize);
    let uvs = &mut mesh.uvs[0];
    (uvs[b], uvs[c]) = (uvs[a], uvs[a]);
    compute(&mut mesh, 0);
    for t in mesh.tangents.as_ref().unwrap() {
        let length = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        assert!((length - 1.0).abs() < 1e-6 && t[3].abs() == 1.0, "{t:?}");
    }
}

/// As of a map that the mesh does not have: normals stay.
#[test]
fn one_point_for_all_corners_gives_no_tangents() {
    let mut mesh = quad();
    mesh.uvs[0] = vec![[0.0, 1.0]; 4];
    compute(&mut mesh, 0);
    assert!(mesh.tangents.is_none());
}
