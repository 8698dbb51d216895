use super::*;
use crate::scene::{Diagnostics, Instance, Visibility, validate};
use glam::DAffine3;

#[test]
fn directions_do_not_depend_on_the_scale() {
    for scale in [1e-30, 1.0, 1e30] {
        let of = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| {
            directions(&(DMat3::from_cols(x.into(), y.into(), z.into()) * scale))
        };
        assert_eq!(of([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), 3);
        assert_eq!(of([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]), 2);
        assert_eq!(of([1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 1.0]), 2);
        assert_eq!(of([1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [0.0, 0.0, 0.0]), 1);
        assert_eq!(of([0.0; 3], [0.0; 3], [0.0; 3]), 1);
    }
}

/// A scene that places a triangle by transforms.
fn scene(generator: &str, places: &[DMat3]) -> Scene {
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let instance = |m: &DMat3| Instance {
        name: String::new(),
        mesh: MeshId(0),
        world_from_object: DAffine3::from_mat3(*m),
        visibility: Visibility::ALL,
        holdout: false,
        info: Default::default(),
        motion: Vec::new(),
    };
    Scene {
        generator: Some(generator.into()),
        instances: places.iter().map(instance).collect(),
        meshes: vec![mesh],
        ..Scene::default()
    }
}

/// Cycles shows a flat object where it applies the transform to the mesh, and turns rays by one that does not exist elsewhere.
#[test]
fn flat_objects_of_shared_meshes_stay_out_as_in_cycles() {
    let pressed = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0));
    let left = |generator: &str, places: &[DMat3], moves: bool| {
        let mut scene = scene(generator, places);
        if moves {
            let place = scene.instances[0].world_from_object;
            scene.instances[0].motion = vec![place, place];
        }
        let mut diagnostics = Diagnostics::default();
        validate::clean(&mut scene, &mut diagnostics);
        let told = diagnostics.iter().any(|d| d.code == "singular-transform");
        (scene.instances.len(), told)
    };
    let blender = "Sundog add-on for Blender";
    assert_eq!(left(blender, &[pressed], false), (1, false));
    assert_eq!(left(blender, &[pressed], true), (0, true));
    assert_eq!(left(blender, &[pressed, DMat3::IDENTITY], false), (1, true));
    assert_eq!(
        left("another", &[pressed, DMat3::IDENTITY], false),
        (2, false)
    );
}
