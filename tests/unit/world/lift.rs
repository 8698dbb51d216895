use super::*;

/// A triangle on the unit sphere, a part of a right angle wide.
fn facet(width: f32) -> [Vec3; 3] {
    let side = width.tan();
    [
        Vec3::new(-side, -side, 1.0),
        Vec3::new(side, -side, 1.0),
        Vec3::new(0.0, side, 1.0),
    ]
    .map(Vec3::normalize)
}

#[test]
fn points_of_a_ball_are_lifted_to_it() {
    for width in [0.05, 0.2, 0.4] {
        let corners = facet(width);
        let deepest = 1.0 - between(corners, Vec3::splat(1.0 / 3.0)).length();
        for step in 0..=20u8 {
            for other in 0..=20 - step {
                let (u, v) = (f32::from(step) / 20.0, f32::from(other) / 20.0);
                let weights = Vec3::new(1.0 - u - v, u, v);
                let point = between(corners, weights);
                let h = height(corners, corners, weights, true);
                // Above the sphere by its roundings, and no further than the tangent planes.
                let lifted = (point + between(corners, weights) * h).length();
                assert!(
                    h >= -1e-6 && lifted > 1.0 - 0.1 * deepest - 1e-6,
                    "{width} {weights}: {lifted}"
                );
                assert!(
                    lifted < 1.0 + 3.0 * deepest + 1e-6,
                    "{width} {weights}: {lifted}"
                );
            }
        }
        for corner in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert!(height(corners, corners, corner, true).abs() < 1e-6);
        }
    }
}

#[test]
fn flat_triangles_are_flat_and_hollow_ones_are_lifted_to_their_corners() {
    let corners = facet(0.2);
    let middle = Vec3::splat(1.0 / 3.0);
    let flat = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    for outward in [false, true] {
        assert!(height(corners, [flat; 3], middle, outward).abs() < 1e-6);
    }
    // From within the corners lie higher than what is between them: no higher than those is it lifted.
    let inward = corners.map(|n| -n);
    let hollow = height(corners, inward, middle, true);
    let highest = (corners[0] - corners[2]).dot(corners[0]).abs();
    assert!(hollow > 0.0 && hollow < highest, "{hollow} {highest}");
    for corner in [Vec3::X, Vec3::Y, Vec3::Z] {
        assert!(height(corners, inward, corner, true).abs() < 1e-6);
    }
    // The other side of a surface is as that of the same with its normals turned.
    assert_eq!(height(corners, corners, middle, false), -hollow);
    assert_eq!(
        height(corners, inward, middle, false),
        -height(corners, corners, middle, true)
    );
}
