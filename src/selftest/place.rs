//! Place and scale: wherever a scene stands, however large it is, it looks the same.

use super::kit::{Bench, camera, differing, diffuse, place, quad, rel_mse, small, sphere};
use super::still_life::{Lit, Similarity, flattened, light, looking, still_life};
use super::{Case, Effort, Finding, document};
use crate::import::{ImportOptions, load};
use crate::render::{BounceLimits, RenderError, RenderSettings};
use crate::scene::{LightKind, Scene};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "moved",
        about: "A scene with lamps of all kinds, a lens, glass and instances, moved by 1e3, 1e5 and 1e7 metres: the same picture.",
        run: moved,
    },
    Case {
        name: "scaled",
        about: "The same scene from a millionth to a million times its size: the same picture.",
        run: scaled,
    },
    Case {
        name: "scaled-by-powers-of-two",
        about: "The same scene scaled by 2^-20, 2^-10, 2^10 and 2^20: the same bits, as nothing rounds differently.",
        run: scaled_by_powers_of_two,
    },
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
    Case {
        name: "small-on-a-huge-ground",
        about: "A ball of a millimetre on a ground of 20 000 km: the ground and the shadow look as on a ground of 2 cm.",
        run: small_on_a_huge_ground,
    },
];

/// What the issue allows: the pictures have the same samples, so that they differ by the few paths alone that a
/// rounding sends another way.
const LARGEST_REL_MSE: f64 = 1e-4;

fn settings(effort: Effort) -> RenderSettings {
    small(effort.of(4, 64, 256), 6)
}

/// Compares pictures of scenes with that of the first.
fn same(
    original: &Scene,
    others: impl IntoIterator<Item = (String, Scene)>,
    settings: &RenderSettings,
) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let reference = bench.render(original, settings)?.picture;
    let mut findings = Vec::new();
    for (name, scene) in others {
        let picture = bench.render(&scene, settings)?.picture;
        let found = rel_mse(&picture, &reference);
        findings.push(Finding::at_most(
            format!("relMSE {name}"),
            LARGEST_REL_MSE,
            found,
        ));
    }
    Ok(bench.with(findings))
}

fn moved(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let others = [1e3, 1e5, 1e7].map(|distance| {
        let shift = DVec3::new(0.8, -0.36, 0.48) * distance;
        let by = Similarity {
            shift,
            ..Similarity::NONE
        };
        (format!("moved by {distance:.0e} m"), by.of(&scene))
    });
    same(&scene, others, &settings(effort))
}

fn scaled(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let scene = still_life(Lit::ByAll);
    let scales: &[f64] = effort.of(
        &[1e-6, 1e6],
        &[1e-6, 1e-3, 1e3, 1e6],
        &[
            1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6,
        ],
    );
    let others = scales.iter().map(|&scale| {
        let by = Similarity {
            scale,
            ..Similarity::NONE
        };
        (format!("scaled by {scale:.0e}"), by.of(&scene))
    });
    same(&scene, others, &settings(effort))
}

fn scaled_by_powers_of_two(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (scene, settings, mut bench) = (still_life(Lit::ByAll), settings(effort), Bench::default());
    let reference = bench.render(&scene, &settings)?.picture;
    let mut findings = Vec::new();
    for power in [-20, -10, 10, 20] {
        let by = Similarity {
            scale: 2f64.powi(power),
            ..Similarity::NONE
        };
        let picture = bench.render(&by.of(&scene), &settings)?.picture;
        let name = format!("pixels that differ, scaled by 2^{power}");
        findings.push(Finding::none(name, differing(&picture, &reference)));
    }
    Ok(bench.with(findings))
}

/// Nothing that is drawn about a normal is in the picture.
fn without_diffuse_bounces(effort: Effort) -> RenderSettings {
    RenderSettings {
        bounce_limits: BounceLimits {
            diffuse: Some(0),
            ..BounceLimits::default()
        },
        ..settings(effort)
    }
}

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

/// A ball of a millimetre lit by a point and by the sun, on a square ground; the camera is at its own height.
fn ball_on_a_ground(half: f32) -> Scene {
    let mut scene = Scene::default();
    let ground = quad(
        [-half, 0.0, half],
        [2.0 * half, 0.0, 0.0],
        [0.0, 0.0, -2.0 * half],
    );
    place(&mut scene, ground, diffuse([0.6; 3]), &[DAffine3::IDENTITY]);
    let ball = DAffine3::from_scale_rotation_translation(
        DVec3::splat(1e-3),
        DQuat::IDENTITY,
        DVec3::new(0.2e-3, 0.9e-3, -0.1e-3),
    );
    place(
        &mut scene,
        sphere(16, 0.0, true),
        diffuse([0.5, 0.3, 0.2]),
        &[ball],
    );
    let point = LightKind::Point {
        intensity: 1e-4,
        radius: 0.0,
        soft_falloff: false,
    };
    let sun = LightKind::Sun {
        irradiance: 2.0,
        angle: 0.0,
    };
    scene.lights = vec![
        light(point, DVec3::new(-4e-3, 5e-3, 3e-3), DVec3::ZERO),
        light(sun, DVec3::new(2.0, 4.0, 1.0), DVec3::ZERO),
    ];
    let eye = DVec3::new(0.7e-3, 3.1e-3, 5.3e-3);
    let mut view = camera(eye, 0.6);
    view.world_from_camera = looking(eye, DVec3::ZERO);
    scene.cameras.push(view);
    scene
}

fn small_on_a_huge_ground(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let others = [1e3f32, 1e7].map(|half| {
        (
            format!("on a ground of ±{half:.0e} m"),
            ball_on_a_ground(half),
        )
    });
    same(
        &ball_on_a_ground(1e-2),
        others,
        &without_diffuse_bounces(effort),
    )
}
