use super::*;

fn area(points: &[[f32; 3]], triangles: &[[usize; 3]]) -> f32 {
    let of = |[a, b, c]: &[usize; 3]| {
        let [a, b, c] = [*a, *b, *c].map(|i| Vec3::from(points[i]));
        // With the sign by which it is seen.
        0.5 * (b - a).cross(c - a).z
    };
    triangles.iter().map(of).sum()
}

fn cut(points: &[[f32; 3]]) -> Vec<[usize; 3]> {
    let ring: Vec<u32> = (0..points.len() as u32).collect();
    Cutter::default().cut(points, &ring)
}

#[test]
fn concave_polygons_are_cut_without_overlap() {
    // An L, counter-clockwise: area 3.
    let points = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
    ];
    let triangles = cut(&points);
    assert_eq!(triangles.len(), 4);
    assert!((area(&points, &triangles) - 3.0).abs() < 1e-6);
    assert!(triangles.iter().all(|t| area(&points, &[*t]) >= 0.0));
}

#[test]
fn an_arrow_of_four_corners_is_cut_at_its_inner_corner() {
    for turn in 0..4 {
        let mut points = vec![
            [0.0, 0.0, 0.0],
            [2.0, -1.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
        ];
        points.rotate_left(turn);
        let triangles = cut(&points);
        assert!(
            triangles.iter().all(|t| area(&points, &[*t]) > 0.0),
            "{turn}"
        );
        assert!((area(&points, &triangles) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn polygons_without_an_area_do_no_harm() {
    assert!(cut(&[[0.0; 3]; 2]).is_empty());
    assert_eq!(cut(&[[1.0; 3]; 6]).len(), 4);
    assert_eq!(cut(&[[f32::NAN; 3]; 6]).len(), 4);
}
