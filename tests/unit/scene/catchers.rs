use super::*;
use crate::scene::{Environment, LightKind, Links, MaterialId, MeshId, ObjectInfo, Visibility};
use glam::DAffine3;

fn scene() -> Scene {
    let mesh = |material| Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        material: Some(MaterialId(material)),
        ..Mesh::default()
    };
    let instance = |mesh, shadow_catcher| Instance {
        name: format!("{mesh}"),
        mesh: MeshId(mesh),
        world_from_object: DAffine3::IDENTITY,
        motion: Vec::new(),
        visibility: Visibility::ALL,
        holdout: false,
        info: ObjectInfo {
            links: Links {
                shadow_catcher,
                ..Links::default()
            },
            ..ObjectInfo::default()
        },
    };
    let light = |name: &str, shadow_catcher| Light {
        name: name.into(),
        color: [1.0; 3],
        kind: LightKind::Sun {
            irradiance: 1.0,
            angle: 0.0,
        },
        world_from_light: DAffine3::IDENTITY,
        visibility: Visibility::ALL,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links: Links {
            shadow_catcher,
            ..Links::default()
        },
        graph: None,
    };
    Scene {
        meshes: vec![mesh(0), mesh(1)],
        instances: vec![
            instance(0, None),
            instance(1, Some(true)),
            instance(0, Some(false)),
        ],
        materials: vec![Material::default(); 2],
        lights: vec![light("sun", None), light("of the scene", Some(false))],
        environment: Some(Environment::constant([1.0; 3])),
        ..Scene::default()
    }
}

#[test]
fn the_photograph_has_catchers_and_their_lights() {
    let scene = scene();
    assert!(scene.has_catchers());
    let alone = scene.of_catchers();
    let names: Vec<_> = alone.instances.iter().map(|i| &i.name[..]).collect();
    assert_eq!(names, ["1"]);
    assert!(alone.meshes[0].triangles.is_empty());
    assert_eq!(alone.meshes[1].triangles, scene.meshes[1].triangles);
    let lights: Vec<_> = alone.lights.iter().map(|l| &l.name[..]).collect();
    assert_eq!(lights, ["sun"]);
    assert!(alone.environment.is_some());
    assert_eq!(alone.materials.len(), scene.materials.len());
}

#[test]
fn an_object_without_triangles_is_no_catcher() {
    let mut scene = scene();
    scene.meshes[1].triangles.clear();
    assert!(!scene.has_catchers());
}
