use super::*;
use crate::scene::{MaterialId, MetallicRoughness, RayKind};
use glam::DAffine3;

/// A copy of an object in its place goes, one that only shares a triangle loses it, whichever way it is turned.
#[test]
fn twins_of_other_objects_go() {
    let shining = Material::from(MetallicRoughness {
        emission: [1.0; 3],
        ..MetallicRoughness::default()
    });
    let mesh = |triangles: &[[u32; 3]]| Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ],
        triangles: triangles.to_vec(),
        material: Some(MaterialId(0)),
        ..Mesh::default()
    };
    let placed = |mesh: u32, x: f64, visibility| Instance {
        motion: Vec::new(),
        name: format!("{mesh} at {x}"),
        mesh: MeshId(mesh),
        world_from_object: DAffine3::from_translation(DVec3::X * x),
        visibility,
        holdout: false,
        info: Default::default(),
    };
    let all = Visibility::ALL;
    let mut scene = Scene {
        materials: vec![shining],
        meshes: vec![
            mesh(&[[0, 1, 2], [0, 1, 3]]),
            mesh(&[[0, 2, 3], [1, 2, 0], [0, 3, 1]]),
        ],
        instances: vec![
            placed(0, 0.3, all),
            placed(0, 0.3, all),
            placed(1, 0.3, all),
            placed(0, 0.4, all),
        ],
        ..Scene::default()
    };
    let mut with_two_sides = scene.clone();
    with_two_sides.materials[0].double_sided = true;
    leave_out_across(&mut with_two_sides);
    assert_eq!(with_two_sides.instances.len(), 3);
    let rest = with_two_sides.instances[1].mesh.0 as usize;
    assert_eq!(with_two_sides.meshes[rest].triangles, [[0, 2, 3]]);

    scene.materials[0].double_sided = false;
    // What the camera does not see is seen by no ray that sees the others; what they do not see stays for the camera.
    let mut hidden = scene.clone();
    let behind = Visibility::ALL.without(RayKind::Camera);
    hidden.instances = vec![placed(0, 0.3, all), placed(0, 0.3, behind)];
    leave_out_across(&mut hidden);
    assert_eq!(hidden.instances.len(), 1);
    hidden.instances = vec![placed(0, 0.3, behind), placed(1, 0.3, all)];
    leave_out_across(&mut hidden);
    let [first, rest, shared] = &hidden.instances[..] else {
        panic!("{:?}", hidden.instances);
    };
    let triangles = |i: &Instance| hidden.meshes[i.mesh.0 as usize].triangles.len();
    assert_eq!([first, rest, shared].map(triangles), [2, 2, 1]);
    assert_eq!((first.visibility, rest.visibility), (behind, all));
    for (kind, _) in RayKind::ALL {
        let sees = matches!(kind, RayKind::Camera | RayKind::Shadow);
        assert_eq!(shared.visibility.sees(kind), sees, "{kind:?}");
    }

    leave_out_across(&mut scene);
    let left: Vec<_> = scene
        .instances
        .iter()
        .map(|i| scene.meshes[i.mesh.0 as usize].triangles.clone())
        .collect();
    let whole = scene.meshes[0].triangles.clone();
    assert_eq!(left, [whole.clone(), vec![[0, 2, 3], [0, 3, 1]], whole]);
    // The mesh itself stays what it was.
    assert_eq!(scene.meshes[1].triangles.len(), 3);
    scene.materials[0] = Material::default();
    scene.instances.push(placed(0, 0.3, all));
    leave_out_across(&mut scene);
    assert_eq!(scene.instances.len(), 4);
}

#[test]
fn twins_go_and_others_stay() {
    let (p, q, r, s) = (
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    );
    let mut mesh = Mesh {
        positions: vec![p, q, r, s, p, q, r],
        // The second is the first with other vertices, the third is turned over, the fourth begins elsewhere.
        triangles: vec![[0, 1, 2], [4, 5, 6], [0, 2, 1], [1, 2, 0], [0, 1, 3]],
        ..Mesh::default()
    };
    assert_eq!(leave_out(&mut mesh, false), 2);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 1], [0, 1, 3]]);
    assert_eq!(leave_out(&mut mesh, true), 1);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
}
