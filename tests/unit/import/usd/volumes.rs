use super::*;
use glam::IVec3;

fn grid(object_from_index: DAffine3) -> Arc<Grid> {
    let mut grid = Grid::new("density", 1, glam::Vec4::ZERO, object_from_index, false);
    grid.active = Some((IVec3::new(0, 1, 2), IVec3::new(3, 5, 7)));
    Arc::new(grid)
}

/// Six times its volume by the divergence theorem: positive where all sides look outwards.
fn six_volumes(mesh: &Mesh) -> f64 {
    let at = |i: u32| glam::Vec3::from(mesh.positions[i as usize]).as_dvec3();
    let parts = mesh.triangles.iter();
    parts
        .map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c))))
        .sum()
}

#[test]
fn boxes_hold_all_points_and_look_outwards() {
    let scale = DVec3::new(0.5, 2.0, 1.0);
    for mirror in [1.0, -1.0] {
        let place = DAffine3::from_scale(scale * DVec3::new(mirror, 1.0, 1.0));
        let mesh = boxed(&grid(place), "cloud").unwrap();
        // Points 0 to 3, 1 to 5 and 2 to 7, and one more on each side.
        let expected = 5.0 * 6.0 * 7.0;
        assert!((six_volumes(&mesh) / 6.0 - expected).abs() < 1e-3);
        let low = mesh.positions.iter().fold([f32::MAX; 3], |low, p| {
            [0, 1, 2].map(|axis: usize| low[axis].min(p[axis]))
        });
        assert_eq!(low, [if mirror > 0.0 { -0.5 } else { -2.0 }, 0.0, 1.0]);
    }
    let mut empty = Grid::clone(&grid(DAffine3::IDENTITY));
    empty.active = None;
    assert!(boxed(&Arc::new(empty), "nothing").is_none());
}
