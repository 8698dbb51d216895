//! The Cornell box of scenes/gallery.py without Blender: the figures of reference need no file.

use glam::{DAffine3, DVec3};
use sundog::scene::{
    Camera, Instance, MaterialId, Mesh, MeshId, MetallicRoughness, Projection, Scene, Visibility,
};

const WHITE: u32 = 0;
const RED: u32 = 1;
const GREEN: u32 = 2;
const LIGHT: u32 = 3;

fn matte(name: &str, base_color: [f32; 3]) -> MetallicRoughness {
    MetallicRoughness {
        name: name.into(),
        base_color,
        metallic: 0.0,
        roughness: 1.0,
        specular: 0.0,
        ..MetallicRoughness::default()
    }
}

/// Adds a mesh of quads with normals of their own.
fn add(scene: &mut Scene, name: &str, material: u32, place: DAffine3, quads: &[[[f32; 3]; 4]]) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for quad in quads {
        let first = positions.len() as u32;
        positions.extend(quad);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    scene.meshes.push(Mesh {
        name: name.into(),
        positions,
        triangles,
        material: Some(MaterialId(material)),
        ..Mesh::default()
    });
    scene.instances.push(Instance {
        motion: Vec::new(),
        name: name.into(),
        mesh: MeshId(scene.meshes.len() as u32 - 1),
        world_from_object: place,
        visibility: Visibility::ALL,
        holdout: false,
        info: Default::default(),
    });
}

/// A box by its size, middle and turn about the up axis in degrees.
fn add_box(
    scene: &mut Scene,
    name: &str,
    material: u32,
    size: [f32; 3],
    middle: [f64; 3],
    turn: f64,
) {
    let [x, y, z] = size.map(|s| 0.5 * s);
    let quads = [
        [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]],
        [[x, -y, -z], [-x, -y, -z], [-x, y, -z], [x, y, -z]],
        [[x, -y, z], [x, -y, -z], [x, y, -z], [x, y, z]],
        [[-x, -y, -z], [-x, -y, z], [-x, y, z], [-x, y, -z]],
        [[-x, y, z], [x, y, z], [x, y, -z], [-x, y, -z]],
        [[-x, -y, -z], [x, -y, -z], [x, -y, z], [-x, -y, z]],
    ];
    let place = DAffine3::from_translation(DVec3::from(middle))
        * DAffine3::from_rotation_y(turn.to_radians());
    add(scene, name, material, place, &quads);
}

/// The scene.
pub fn cornell() -> Scene {
    let mut scene = Scene {
        materials: [
            matte("White", [0.73, 0.73, 0.73]),
            matte("Red", [0.63, 0.06, 0.05]),
            matte("Green", [0.14, 0.45, 0.09]),
            MetallicRoughness {
                emission: [18.0, 14.04, 8.64],
                ..matte("Light", [0.0; 3])
            },
        ]
        .into_iter()
        .map(Into::into)
        .collect(),
        ..Scene::default()
    };
    let still = DAffine3::IDENTITY;
    let s = &mut scene;
    add(
        s,
        "Floor",
        WHITE,
        still,
        &[[
            [-1.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, -1.0],
            [-1.0, 0.0, -1.0],
        ]],
    );
    add(
        s,
        "Ceiling",
        WHITE,
        still,
        &[[
            [-1.0, 2.0, -1.0],
            [1.0, 2.0, -1.0],
            [1.0, 2.0, 1.0],
            [-1.0, 2.0, 1.0],
        ]],
    );
    add(
        s,
        "Back",
        WHITE,
        still,
        &[[
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
            [1.0, 2.0, -1.0],
            [-1.0, 2.0, -1.0],
        ]],
    );
    add(
        s,
        "Left",
        RED,
        still,
        &[[
            [-1.0, 0.0, 1.0],
            [-1.0, 0.0, -1.0],
            [-1.0, 2.0, -1.0],
            [-1.0, 2.0, 1.0],
        ]],
    );
    add(
        s,
        "Right",
        GREEN,
        still,
        &[[
            [1.0, 0.0, -1.0],
            [1.0, 0.0, 1.0],
            [1.0, 2.0, 1.0],
            [1.0, 2.0, -1.0],
        ]],
    );
    add_box(s, "Lamp", LIGHT, [0.5, 0.02, 0.4], [0.0, 1.985, 0.0], 0.0);
    add_box(
        s,
        "Tall box",
        WHITE,
        [0.58, 1.2, 0.58],
        [-0.34, 0.6, -0.3],
        -17.0,
    );
    add_box(
        s,
        "Short box",
        WHITE,
        [0.58, 0.58, 0.58],
        [0.36, 0.29, 0.3],
        17.0,
    );
    scene.cameras.push(Camera {
        motion: None,
        stereo: None,
        name: "Camera".into(),
        projection: Projection::Perspective {
            vertical_fov: 39.3f64.to_radians(),
            aspect: None,
        },
        world_from_camera: DAffine3::from_translation(DVec3::new(0.0, 1.0, 3.9)),
        window: None,
        clip_near: 0.01,
        clip_far: 1000.0,
        aperture: None,
    });
    scene
}
