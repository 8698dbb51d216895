//! Transforms: turned, mirrored, made of ten or carried into the vertices, a scene looks the same.

use super::{Case, Effort, Finding};
use crate::fuzz::fuzzer::document;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};
use sundog::import::{ImportOptions, load};
use sundog::render::RenderError;
use sundog::scene::{MeshId, Scene};
use sundog::selftest::place::{same, settings, without_diffuse_bounces};
use sundog::selftest::still_life::{Lit, Similarity, still_life};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "turned-and-mirrored",
        about: "A scene with a normal map, instances and glass, turned and mirrored together with its camera: the same picture.",
        run: turned_and_mirrored,
    },
    Case {
        name: "ten-transforms",
        about: "Each transform is the product of ten: the same picture.",
        run: ten_transforms,
    },
    Case {
        name: "ten-nodes-in-a-file",
        about: "A glTF file with a mesh, instances, lamps and a camera, each node as the last of a chain of ten: the same picture.",
        run: ten_nodes_in_a_file,
    },
    Case {
        name: "flattened",
        about: "Instances become meshes of their own: the same picture.",
        run: flattened_instances,
    },
];

fn turned_and_mirrored(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::Sharply);
    let turn = DMat3::from_quat(DQuat::from_axis_angle(
        DVec3::new(2.0, -3.0, 6.0) / 7.0,
        1.0,
    ));
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let quarter = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let others = [
        ("turned by 1 radian", turn),
        ("turned by a quarter", quarter),
        ("mirrored", mirror),
        ("mirrored and turned", turn * mirror),
    ]
    .map(|(name, turn)| {
        (
            name.to_owned(),
            Similarity {
                turn,
                ..Similarity::NONE
            }
            .of(&scene),
        )
    });
    same(&scene, others, &without_diffuse_bounces(effort))
}

/// A transform as the product of ten: nine of all kinds, and what is left.
pub fn ten(whole: &DAffine3) -> [DAffine3; 10] {
    let mut parts = [DAffine3::IDENTITY; 10];
    let mut so_far = DAffine3::IDENTITY;
    for (i, part) in parts.iter_mut().take(9).enumerate() {
        let i = i as f64;
        *part = DAffine3::from_scale_rotation_translation(
            DVec3::splat(if i % 2.0 == 0.0 { 3.0 + i } else { 0.2 }),
            DQuat::from_euler(glam::EulerRot::XYZ, 0.3 + i, -0.7 * i, 1.1),
            DVec3::new(10.0 - i, 0.1 * i, -3.0),
        );
        so_far *= *part;
    }
    parts[9] = so_far.inverse() * *whole;
    parts
}

fn ten_transforms(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let mut split = scene.clone();
    let again = |whole: &mut DAffine3| {
        *whole = ten(whole)
            .into_iter()
            .fold(DAffine3::IDENTITY, |a, b| a * b)
    };
    split
        .instances
        .iter_mut()
        .for_each(|i| again(&mut i.world_from_object));
    split
        .lights
        .iter_mut()
        .for_each(|l| again(&mut l.world_from_light));
    split
        .cameras
        .iter_mut()
        .for_each(|c| again(&mut c.world_from_camera));
    same(
        &scene,
        [("of products of ten transforms".into(), split)],
        &settings(effort),
    )
}

/// The transform of a node.
fn of_node(node: &Value) -> DAffine3 {
    let numbers = |name: &str| -> Vec<f64> {
        let list = node[name].as_array().into_iter().flatten();
        list.filter_map(Value::as_f64).collect()
    };
    if let Ok(matrix) = <[f64; 16]>::try_from(numbers("matrix")) {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix));
    }
    let three = |name: &str, default: f64| match numbers(name)[..] {
        [x, y, z] => DVec3::new(x, y, z),
        _ => DVec3::splat(default),
    };
    let turn = match numbers("rotation")[..] {
        [x, y, z, w] => DQuat::from_xyzw(x, y, z, w),
        _ => DQuat::IDENTITY,
    };
    DAffine3::from_scale_rotation_translation(three("scale", 1.0), turn, three("translation", 0.0))
}

/// Each node becomes the last of a chain of ten whose product is its transform. The heads of the chains come first, in
/// the order of the nodes, so that references to nodes stay right.
fn in_chains(mut document: Value) -> Value {
    let nodes = document["nodes"].as_array().cloned().unwrap_or_default();
    let (mut heads, mut links) = (Vec::new(), Vec::new());
    for node in &nodes {
        let parts = ten(&of_node(node)).map(|part| DMat4::from(part).to_cols_array());
        let first = nodes.len() + links.len();
        heads.push(json!({ "matrix": parts[0], "children": [first] }));
        for (k, part) in parts[1..9].iter().enumerate() {
            links.push(json!({ "matrix": part, "children": [first + k + 1] }));
        }
        let mut last = node.clone();
        if let Some(members) = last.as_object_mut() {
            for name in ["translation", "rotation", "scale"] {
                members.remove(name);
            }
            members.insert("matrix".into(), json!(parts[9]));
        }
        links.push(last);
    }
    heads.extend(links);
    document["nodes"] = json!(heads);
    document
}

fn ten_nodes_in_a_file(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (whole, buffer) = document::document(true);
    let read = |content: Value| {
        let file = || -> std::io::Result<_> {
            let folder = tempfile::tempdir()?;
            let path = folder.path().join("scene.glb");
            std::fs::write(&path, document::written(content, &buffer, true))?;
            Ok(load(&path, &ImportOptions::default()).map(|imported| imported.scene))
        };
        match file() {
            Ok(Ok(scene)) => Ok(scene),
            Ok(Err(refused)) => Err(RenderError::Setting(refused.to_string())),
            Err(error) => Err(RenderError::Setting(error.to_string())),
        }
    };
    let scene = read(whole.clone())?;
    let chains = read(in_chains(whole))?;
    same(
        &scene,
        [("of chains of ten nodes".into(), chains)],
        &settings(effort),
    )
}

fn flattened_instances(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let flat = flattened(&scene);
    same(
        &scene,
        [("without instances".into(), flat)],
        &settings(effort),
    )
}

/// All instances become meshes of their own, their vertices still in object space.
pub fn flattened(scene: &Scene) -> Scene {
    let mut flat = scene.clone();
    flat.meshes.clear();
    for instance in &mut flat.instances {
        flat.meshes
            .push(scene.meshes[instance.mesh.0 as usize].clone());
        instance.mesh = MeshId(flat.meshes.len() as u32 - 1);
    }
    flat
}
