use super::*;
use crate::scene::{Instance, Mesh, MeshId};
use glam::DAffine3;

fn scene() -> Scene {
    Scene {
        meshes: vec![Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        }],
        instances: vec![Instance {
            motion: Vec::new(),
            name: "a".into(),
            mesh: MeshId(0),
            world_from_object: DAffine3::IDENTITY,
            visibility: Visibility::ALL,
            holdout: false,
            info: Default::default(),
        }],
        ..Scene::default()
    }
}

#[test]
fn content_counts_and_names_do_not() {
    let reference = fingerprint(&scene());
    assert_eq!(reference.len(), 64);
    let mut renamed = scene();
    renamed.instances[0].name = "b".into();
    renamed.generator = Some("x".into());
    assert_eq!(fingerprint(&renamed), reference);
    let mut moved = scene();
    moved.instances[0].world_from_object.translation.x = 1e-12;
    assert_ne!(fingerprint(&moved), reference);
    let mut bent = scene();
    bent.meshes[0].positions[2][1] = 1.000_000_1;
    assert_ne!(fingerprint(&bent), reference);
    let mut flipped = scene();
    flipped.meshes[0].triangles[0] = [0, 2, 1];
    assert_ne!(fingerprint(&flipped), reference);
}
