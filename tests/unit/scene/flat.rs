use super::*;

fn tent(rise: f32, normals: [[f32; 3]; 4]) -> Mesh {
    Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, rise, 1.0],
            [0.0, 0.0, 1.0],
        ],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        normals: Some(normals.to_vec()),
        ..Mesh::default()
    }
}

#[test]
fn only_normals_that_differ_from_those_of_the_triangles_count() {
    let up = [0.0, 1.0, 0.0];
    assert!(!tent(0.0, [up; 4]).is_smooth());
    assert!(
        !Mesh {
            normals: None,
            ..tent(0.5, [up; 4])
        }
        .is_smooth()
    );
    assert!(tent(0.5, [up; 4]).is_smooth());
    assert!(tent(0.0, [up, up, up, [0.0, -1.0, 0.0]]).is_smooth());
    let slightly = [1e-5, (1.0f32 - 1e-10).sqrt(), 0.0];
    assert!(tent(0.0, [up, slightly, up, up]).is_smooth());
    let rounded = [1e-8, 1.0 - f32::EPSILON, 0.0];
    assert!(!tent(0.0, [up, rounded, up, up]).is_smooth());
}
