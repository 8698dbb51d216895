use super::*;

#[test]
fn strips_and_fans_keep_their_winding() {
    assert_eq!(
        assemble(Mode::TriangleStrip, &[0, 1, 2, 3, 4]),
        [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    );
    assert_eq!(
        assemble(Mode::TriangleFan, &[0, 1, 2, 3]),
        [[1, 2, 0], [2, 3, 0]]
    );
    assert_eq!(assemble(Mode::Triangles, &[0, 1, 2, 3, 4]), [[0, 1, 2]]);
    for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
        for length in 0..3 {
            assert!(assemble(mode, &[0, 1][..length.min(2)]).is_empty());
        }
    }
}

#[test]
fn only_used_vertices_stay() {
    let mut mesh = Mesh {
        positions: (0..5).map(|i| [i as f32, 0.0, 0.0]).collect(),
        uvs: vec![(0..5).map(|i| [i as f32, 0.0]).collect()],
        triangles: vec![[1, 3, 4]],
        ..Mesh::default()
    };
    drop_unused_vertices(&mut mesh);
    assert_eq!(
        mesh.positions,
        [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]]
    );
    assert_eq!(mesh.uvs[0], [[1.0, 0.0], [3.0, 0.0], [4.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}
