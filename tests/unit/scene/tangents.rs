use super::*;
use crate::scene::{Diagnostics, Scene};

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
fn flat_meshes_get_unit_tangents() {
    let mut mesh = quad();
    mesh.normals = None;
    compute(&mut mesh, 0);
    for t in mesh.tangents.as_ref().unwrap() {
        let length = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
        assert!((length - 1.0).abs() < 1e-6 && t[3].abs() == 1.0, "{t:?}");
    }
}

/// A point, and a line.
#[test]
fn coordinates_without_area_give_tangents_along_x() {
    for uv in [|_| [0.3, 1.0], |[u, _]: [f32; 2]| [u, 1.0]] {
        let mut mesh = quad();
        mesh.uvs[0] = mesh.uvs[0].iter().map(|&at| uv(at)).collect();
        compute(&mut mesh, 0);
        assert_eq!(mesh.tangents.unwrap(), [[1.0, 0.0, 0.0, -1.0]; 4]);
    }
}

/// As the sum of tangents of a group may be.
#[test]
fn tangents_of_coordinates_may_be_zero() {
    let mut mesh = quad();
    compute(&mut mesh, 0);
    mesh.tangents.as_mut().unwrap()[1] = [0.0, 0.0, 0.0, 1.0];
    let clean = |mesh: &Mesh| {
        let mut scene = Scene {
            meshes: vec![mesh.clone()],
            ..Scene::default()
        };
        let mut diagnostics = Diagnostics::default();
        crate::scene::validate::clean(&mut scene, &mut diagnostics);
        let tangents = scene.meshes.remove(0).tangents.unwrap();
        (tangents[1][..3] == [0.0; 3], diagnostics.is_empty())
    };
    assert_eq!(clean(&mesh), (true, true));
    // A file's own are replaced, which is told.
    mesh.tangent_set = None;
    assert_eq!(clean(&mesh), (false, false));
}
