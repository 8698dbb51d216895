use super::*;

#[test]
fn a_tube_has_the_area_of_its_side() {
    let (points, normals, triangles) = tube(0.5, 3.0);
    assert_eq!(points.len(), normals.len());
    let mut area = 0.0;
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| glam::Vec3::from(points[i as usize]));
        let side = (b - a).cross(c - a);
        // It is seen from outside.
        let outwards = glam::Vec3::from(normals[triangle[0] as usize]);
        assert!(side.dot(outwards) > 0.0);
        assert!(outwards.x == 0.0);
        area += 0.5 * side.length();
    }
    // 128 sides.
    let side = 2.0 * 0.5 * (PI as f32 / 128.0).sin() * 128.0;
    assert!((area - side * 3.0).abs() < 1e-3, "{area}");
}
