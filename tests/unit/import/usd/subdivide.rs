use super::*;
use crate::math::BOX_SIDES;

fn cube() -> Polygons {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 });
    let mut cube = Polygons::new((0..8).map(corner).collect());
    for face in BOX_SIDES {
        cube.face(&face);
    }
    cube
}

/// A corner of a cube: n = 3, its own place 1, ends 1 + 1 − 1 … : the limit is (9·1 + 4·1 + (−1)) / 24 = 1/2.
#[test]
fn a_cubes_corners_come_to_half_their_place() {
    let mut limit = cube();
    to_limit(&mut limit, &Wishes::default());
    for point in &limit.points {
        for v in point {
            assert!((v.abs() - 0.5).abs() < 1e-6, "{point:?}");
        }
    }
    // Divided first, they come to the same.
    let mut parts = vec![0; 6];
    let mut divided = cube();
    apply(&mut divided, &mut parts, &Wishes::default());
    assert!((divided.points[7][0] - 0.5).abs() < 1e-6);
    assert_eq!(parts.len(), 6 * 4usize.pow(4));
}

#[test]
fn sharp_edges_keep_a_cube() {
    let mut wishes = Wishes::default();
    let shape = cube();
    for start in shape.starts() {
        let ring = &shape.corners[start..start + 4];
        for i in 0..4 {
            wishes.edges.insert(key(ring[i], ring[(i + 1) % 4]), 10.0);
        }
    }
    let mut parts = vec![0; 6];
    let mut divided = shape;
    apply(&mut divided, &mut parts, &wishes);
    for point in &divided.points {
        let most = point.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        assert!((most - 1.0).abs() < 1e-6, "{point:?}");
    }
}

#[test]
fn a_flat_sheet_with_corners_stays_the_same_size() {
    let mut sheet = Polygons::new(vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ]);
    sheet.face(&[0, 1, 2, 3]);
    let uv = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    sheet.primvars.insert(
        "st".into(),
        Layer {
            components: 2,
            values: uv.to_vec(),
            interpolation: Interpolation::FaceVarying,
            indices: None,
        },
    );
    let wishes = Wishes {
        corners_stay: true,
        ..Wishes::default()
    };
    apply(&mut sheet, &mut vec![0], &wishes);
    assert_eq!(
        &sheet.points[..4],
        &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    );
    // Coordinates follow, as they lie in a line.
    let layer = &sheet.primvars["st"];
    assert_eq!(layer.values.len(), 2 * sheet.corners.len());
    for (number, point) in sheet.corners.iter().enumerate() {
        let [x, y, _] = sheet.points[*point as usize];
        let [u, v] = layer.at(number, [0.0; 2]);
        assert!((u - x).abs() < 1e-6 && (v - y).abs() < 1e-6);
    }
}

#[test]
fn borders_and_loose_points_do_no_harm() {
    let mut odd = Polygons::new(vec![[0.0; 3]; 5]);
    odd.face(&[0, 0, 0]);
    odd.face(&[1, 2]);
    odd.face(&[]);
    let mut parts = vec![0; 3];
    apply(&mut odd, &mut parts, &Wishes::default());
    assert!(odd.points.iter().flatten().all(|v| v.is_finite()));
}

fn octahedron() -> Polygons {
    let mut polygons = Polygons::new(
        [
            [1, 0, 0],
            [-1, 0, 0],
            [0, 1, 0],
            [0, -1, 0],
            [0, 0, 1],
            [0, 0, -1],
        ]
        .map(|p: [i32; 3]| p.map(|v| v as f32))
        .to_vec(),
    );
    for face in [
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ] {
        polygons.face(&face);
    }
    polygons
}

/// The limit of a point is the same whatever steps led there: by the mask on the cage, n = 4, β = 31/256 and a weight of
/// 1 / (4 + 3/(8β)), with neighbours whose sum is 0.
#[test]
fn triangles_come_to_the_limit_of_loops_scheme() {
    let mut polygons = octahedron();
    let mut parts = vec![0; 8];
    let wishes = Wishes {
        triangles: true,
        ..Wishes::default()
    };
    let levels = apply(&mut polygons, &mut parts, &wishes);
    assert_eq!(levels, MOST_LEVELS);
    assert_eq!(polygons.counts.len(), 8 * 4usize.pow(levels));
    assert_eq!(parts.len(), polygons.counts.len());
    let beta = 31.0 / 256.0;
    let expected = 1.0 - 4.0 / (4.0 + 0.375 / beta);
    let corner = polygons.points[0];
    assert!((f64::from(corner[0]) - expected).abs() < 1e-6, "{corner:?}");
    assert!(corner[1].abs() < 1e-6 && corner[2].abs() < 1e-6);
}

/// A flat border is a cubic spline; with corners that stay, a triangle keeps its own.
#[test]
fn borders_of_triangles_are_those_of_catmull_and_clark() {
    let mut polygons = Polygons::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    polygons.face(&[0, 1, 2]);
    let wishes = Wishes {
        triangles: true,
        corners_stay: true,
        ..Wishes::default()
    };
    apply(&mut polygons, &mut vec![0], &wishes);
    assert_eq!(polygons.points[1], [1.0, 0.0, 0.0]);
    assert!(polygons.points.iter().all(|p| p[2] == 0.0));
}
