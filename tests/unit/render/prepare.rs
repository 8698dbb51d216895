use super::*;
use crate::scene::{Instance, MaterialId, Mesh, MeshId, MetallicRoughness, Visibility};

#[test]
fn many_triangles_that_shine_are_told_before_they_are_made_ready() {
    let instance = Instance {
        motion: Vec::new(),
        name: String::new(),
        mesh: MeshId(0),
        world_from_object: glam::DAffine3::IDENTITY,
        visibility: Visibility::ALL,
        holdout: false,
        info: Default::default(),
    };
    let mut scene = Scene {
        meshes: vec![Mesh {
            triangles: vec![[0, 1, 2]; 1 << 10],
            material: Some(MaterialId(0)),
            ..Mesh::default()
        }],
        materials: vec![
            MetallicRoughness {
                emission: [1.0, 0.0, 0.0],
                ..MetallicRoughness::default()
            }
            .into(),
        ],
        instances: vec![instance.clone(); 1 << 10],
        ..Scene::default()
    };
    let Some(Event::Preparing { shining, .. }) = long(&scene) else {
        panic!("not told");
    };
    assert_eq!(shining, 1 << 20);
    scene.instances.pop();
    assert!(long(&scene).is_none());
    scene.instances.push(instance);
    scene.materials[0] = Material::default();
    assert!(long(&scene).is_none());
}
