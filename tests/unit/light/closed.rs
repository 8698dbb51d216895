use super::*;

/// A tetrahedron at a place; wound outwards, or inwards.
fn tetrahedron(at: Vec3, outwards: bool) -> Vec<[Vec3; 3]> {
    let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p + at);
    let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]];
    faces
        .map(|[a, b, c]| if outwards { [a, b, c] } else { [a, c, b] })
        .to_vec()
}

#[test]
fn each_part_of_a_closed_surface_has_an_outside() {
    let far = Vec3::splat(1e4);
    let mut both = tetrahedron(far, true);
    both.extend(tetrahedron(Vec3::ZERO, false));
    let found = outside(&both).unwrap();
    assert_eq!(found[..4], [Outside::Front; 4]);
    assert_eq!(found[4..], [Outside::Back; 4]);
}

#[test]
fn what_is_open_or_flat_or_not_wound_alike_has_none() {
    let closed = tetrahedron(Vec3::ZERO, true);
    assert!(outside(&closed).is_some());
    assert_eq!(outside(&closed[1..]), None);
    let mut turned = closed.clone();
    turned[2].swap(0, 1);
    assert_eq!(outside(&turned), None);
    let mut twice = closed.clone();
    twice.extend(&closed);
    assert_eq!(outside(&twice), None);
    let [a, b, c] = closed[3];
    assert_eq!(outside(&[[a, b, c], [a, c, b]]), None);
    assert_eq!(outside(&[[a, a, b]]), None);
}
