use super::super::material::{Preparer, Vertices};
use crate::light::emissive::{Eye, outside};
use crate::scene::{AlphaMode, MetallicRoughness, RayKind, Scene, Visibility};
use crate::selftest::kit::{camera, diffuse, glass};
use crate::shading::tables::Estimate;
use glam::{DVec3, Vec3};

/// A tetrahedron of size 1 at the origin, wound outwards.
fn triangles() -> Vec<[Vec3; 3]> {
    let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
}

fn found(
    visibility: Visibility,
    material: &MetallicRoughness,
    triangles: &[[Vec3; 3]],
    eye: DVec3,
) -> bool {
    let material = Preparer::new(false, Estimate::Exact).material(
        &Scene::default(),
        &material.clone().into(),
        Vertices::default(),
    );
    let eye = Eye::new(&camera(eye, 0.8), DVec3::ZERO);
    outside(visibility, material.is_opaque(), triangles, &eye).is_some()
}

#[test]
fn opaque_closed_surfaces_that_the_camera_is_not_in_shine_outwards() {
    let (opaque, away) = (diffuse([0.5; 3]), DVec3::splat(3.0));
    assert!(found(Visibility::ALL, &opaque, &triangles(), away));
    assert!(!found(Visibility::ALL, &opaque, &triangles()[..3], away));
    assert!(!found(
        Visibility::ALL,
        &glass(0.0, 1.5),
        &triangles(),
        away
    ));
    assert!(!found(
        Visibility::ALL,
        &opaque,
        &triangles(),
        DVec3::splat(0.2)
    ));
    let hidden = Visibility::ALL.without(RayKind::Camera);
    assert!(!found(hidden, &opaque, &triangles(), away));
    // There is no glass below metal, in whichever kernel.
    let metal = MetallicRoughness {
        metallic: 1.0,
        ..glass(0.0, 1.5)
    };
    assert!(found(Visibility::ALL, &metal, &triangles(), away));
    let half_there = MetallicRoughness {
        alpha: 0.5,
        alpha_mode: AlphaMode::Blend,
        ..opaque
    };
    assert!(!found(Visibility::ALL, &half_there, &triangles(), away));
}

#[test]
fn many_triangles_are_asked_at_fewer_places_each() {
    assert_eq!([1, 12, 50_000].map(super::divisions), [8; 3]);
    let asked = |triangles: usize| {
        let n = super::divisions(triangles) as usize;
        triangles * n * (n + 1) / 2
    };
    for triangles in [60_000, 200_000, 300_000, 1_000_000, 2_000_000] {
        assert!(asked(triangles) <= super::ASKED_AT, "{triangles}");
    }
    assert_eq!(super::divisions(usize::MAX), 1);
}
