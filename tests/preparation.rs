//! What is prepared of a scene, and what is not as nothing reads it.

use glam::{DAffine3, DVec3};
use std::sync::Arc;
use sundog::effects::{ALL, Effect, EffectReport, STRUCTURE};
use sundog::scene::{
    Camera, Image, ImageId, Instance, Material, MaterialId, Mesh, MeshId, MetallicRoughness,
    Pixels, Projection, Scene, Texture, Visibility,
};
use sundog::world::{Options, World};

/// A square with all attributes that a file may have, flat and white.
fn square() -> Scene {
    let up = [0.0, 1.0, 0.0];
    let mesh = Mesh {
        name: "square".into(),
        positions: vec![
            [-1.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, -1.0],
            [-1.0, 0.0, -1.0],
        ],
        normals: Some(vec![up; 4]),
        tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; 4]),
        radial: None,
        uvs: vec![vec![[0.5, 0.5]; 4]; 2],
        colors: Some(vec![[1.0; 4]; 4]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(MaterialId(0)),
        ..Mesh::default()
    };
    let camera = Camera {
        motion: None,
        stereo: None,
        name: "camera".into(),
        world_from_camera: DAffine3::from_translation(DVec3::new(0.0, 1.0, 5.0)),
        projection: Projection::Perspective {
            vertical_fov: 0.7,
            aspect: None,
        },
        window: None,
        clip_near: 0.01,
        clip_far: 100.0,
        aperture: None,
    };
    Scene {
        meshes: vec![mesh],
        instances: vec![placed(DVec3::ZERO)],
        materials: vec![Material::default()],
        cameras: vec![camera],
        ..Scene::default()
    }
}

fn placed(at: DVec3) -> Instance {
    Instance {
        motion: Vec::new(),
        name: "square".into(),
        mesh: MeshId(0),
        world_from_object: DAffine3::from_translation(at),
        visibility: Visibility::ALL,
        holdout: false,
        info: Default::default(),
    }
}

fn prepared(scene: &Scene, uv_pass: bool) -> World {
    let options = Options {
        camera: &scene.cameras[0],
        rows: 4,
        aspect: 1.0,
        effects: ALL,
        threads: Some(1),
        instructions: None,
        cull_backfaces: false,
        light_shares: Default::default(),
        clamps_direct: false,
        uv_pass,
        aovs: false,
        vectors: false,
        roughens: false,
        coincident: None,
        ablation: Default::default(),
    };
    World::new(scene, &options).unwrap()
}

/// Four corners and two triangles, each of 12 bytes.
const CORNERS: u64 = 4 * 12 + 2 * 12;

#[test]
fn attributes_that_nothing_reads_are_dropped() {
    let scene = square();
    assert_eq!(prepared(&scene, false).mesh_bytes(), (CORNERS, 0));
    assert_eq!(prepared(&scene, true).mesh_bytes(), (CORNERS, 4 * 8));

    let mut smooth = square();
    smooth.meshes[0].normals.as_mut().unwrap()[2] = [0.6, 0.8, 0.0];
    assert_eq!(prepared(&smooth, false).mesh_bytes(), (CORNERS, 4 * 12));

    let mut colored = square();
    colored.meshes[0].colors.as_mut().unwrap()[1] = [0.5, 1.0, 1.0, 1.0];
    assert_eq!(prepared(&colored, false).mesh_bytes(), (CORNERS, 4 * 16));
}

#[test]
fn images_are_kept_once_in_their_own_precision() {
    let mut scene = square();
    let values: Arc<sundog::ffi::values::Values<u8>> =
        Arc::new(vec![10u8, 20, 30, 200, 100, 0].into());
    scene.images.push(Image {
        name: "image".into(),
        width: 2,
        height: 1,
        channels: 3,
        pixels: Pixels::U8(values.clone()),
    });
    let texture = Texture {
        uv_set: 1,
        ..ImageId(0).into()
    };
    scene.materials[0] = MetallicRoughness {
        base_color_texture: Some(texture),
        ..MetallicRoughness::default()
    }
    .into();
    let world = prepared(&scene, false);
    // This test, the scene, the world: nobody has a copy.
    assert_eq!(Arc::strong_count(&values), 3);
    // The second set is read, and keeps its number.
    assert_eq!(world.mesh_bytes(), (CORNERS, 2 * 4 * 8));
}

#[test]
fn kernels_are_told_how_the_world_is_built() {
    let mut scene = square();
    assert_eq!(
        prepared(&scene, false).structure(),
        enumset::EnumSet::empty()
    );
    assert!(
        EffectReport::detect(&scene)
            .called_for
            .is_disjoint(STRUCTURE)
    );
    scene.instances.push(placed(DVec3::Y));
    assert_eq!(prepared(&scene, false).structure(), Effect::Instances);
    scene.meshes[0].normals.as_mut().unwrap()[2] = [0.6, 0.8, 0.0];
    assert_eq!(
        prepared(&scene, false).structure(),
        STRUCTURE - Effect::Strands
    );
    assert_eq!(
        EffectReport::detect(&scene).called_for & STRUCTURE,
        STRUCTURE - Effect::Strands
    );
}
