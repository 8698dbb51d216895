//! What is not finite: none of it reaches the film, each sample of it is counted with its cause, and numbers that
//! make no sense are mended before anything is rendered.

use super::{Case, Effort, Finding};
use glam::{DAffine3, DVec3};
use sundog::film::Picture;
use sundog::render::{RenderError, RenderSettings, Rendering, Silent, render, replay};
use sundog::scene::validate::clean;
use sundog::scene::{Diagnostics, Light, LightKind, MetallicRoughness, Scene};
use sundog::selftest::kit::{
    Bench, camera, colors, constant_environment, diffuse, light, place, quad, small, sphere,
};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "causes-are-named",
        about: "Lights of 3e38, whose products with anything leave f32: the picture stays finite, and each sample that is lost is counted under the name of the light.",
        run: causes_are_named,
    },
    Case {
        name: "edge-of-f32",
        about: "Radiance of 3.4e38 all around: the mean of such samples is itself.",
        run: edge_of_f32,
    },
    Case {
        name: "broken-numbers",
        about: "NaN, infinities, 1e38, 1e-45 and negative numbers in the place of any number of a scene: it is cleaned up and renders.",
        run: broken_numbers,
    },
];

/// The largest number of a light here.
const HUGE: f32 = 3e38;

/// A sphere above a floor, which nothing shines on.
fn dark() -> Scene {
    dark_with(diffuse([0.9; 3]))
}

fn dark_with(material: MetallicRoughness) -> Scene {
    let mut scene = Scene {
        cameras: vec![camera(DVec3::new(0.0, 0.5, 4.0), 0.7)],
        ..Scene::default()
    };
    let floor = quad([-4.0, -1.0, -4.0], [0.0, 0.0, 8.0], [8.0, 0.0, 0.0]);
    place(
        &mut scene,
        sphere(12, 0.0, true),
        material,
        &[DAffine3::IDENTITY],
    );
    place(
        &mut scene,
        floor,
        MetallicRoughness::default(),
        &[DAffine3::IDENTITY],
    );
    scene
}

fn beacon(kind: LightKind, at: DVec3) -> Light {
    light("beacon", kind, DAffine3::from_translation(at))
}

/// Scenes with something far too bright, and the words by which it is named.
fn too_bright() -> Vec<(&'static str, Scene)> {
    let with = |change: &dyn Fn(&mut Scene)| {
        let mut scene = dark();
        change(&mut scene);
        scene
    };
    let lamp =
        |kind: LightKind| with(&|scene| scene.lights.push(beacon(kind, DVec3::new(0.0, 1.5, 0.0))));
    let panel = MetallicRoughness {
        name: "panel".into(),
        emission: [HUGE; 3],
        ..diffuse([0.5; 3])
    };
    vec![
        (
            "the environment",
            with(&|scene| scene.environment = constant_environment(HUGE)),
        ),
        (
            "light \"beacon\"",
            lamp(LightKind::Point {
                intensity: HUGE,
                radius: 0.0,
                soft_falloff: false,
            }),
        ),
        (
            "light \"beacon\"",
            lamp(LightKind::Point {
                intensity: HUGE,
                radius: 0.1,
                soft_falloff: false,
            }),
        ),
        (
            "material \"panel\"",
            with(&|scene| {
                let mesh = quad([-3.0, 1.2, -3.0], [6.0, 0.0, 0.0], [0.0, 0.0, 6.0]);
                place(scene, mesh, panel.clone(), &[DAffine3::IDENTITY]);
            }),
        ),
    ]
}

fn not_finite(picture: &Picture) -> u64 {
    let all = picture.layers.iter().flat_map(|layer| &layer.data);
    all.filter(|value| !value.is_finite()).count() as u64
}

fn causes_are_named(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 16, 64), 3);
    let mut findings = Vec::new();
    for (name, scene) in too_bright() {
        let Rendering {
            picture,
            statistics,
            ..
        } = render(&scene, &settings, &Silent)?;
        let causes = &statistics.non_finite_causes;
        let sum = "sum of finite contributions";
        let named = causes
            .iter()
            .filter(|(cause, _)| cause.contains(name) || *cause == sum);
        let named: u64 = named.map(|(_, count)| count).sum();
        findings.push(Finding::none(
            format!("values of the picture that are not finite, {name}"),
            not_finite(&picture),
        ));
        // NaN, which never holds, if nothing was counted at all.
        findings.push(Finding::new(
            format!("share of lost samples that name {name} (or the sum)"),
            1.0,
            named as f64 / statistics.non_finite as f64,
            0.0,
        ));
        let mut others = 0;
        for &place in &statistics.non_finite_examples {
            let cause = replay(&scene, &settings, place)?.cause;
            others += u64::from(!cause.is_some_and(|cause| causes.contains_key(&cause)));
        }
        findings.push(Finding::none(
            format!("examples that tell another cause when replayed, {name}"),
            others,
        ));
    }
    Ok(findings)
}

fn edge_of_f32(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let radiance = 3.4e38f32;
    let scene = Scene {
        cameras: vec![camera(DVec3::ZERO, 0.7)],
        environment: constant_environment(radiance),
        ..Scene::default()
    };
    let rendering = bench.render(&scene, &small(effort.of(16, 256, 4096), 0))?;
    let other = colors(&rendering.picture)
        .flatten()
        .filter(|&value| value != f64::from(radiance));
    let findings = vec![
        Finding::none("values other than the radiance", other.count() as u64),
        Finding::none(
            "values of other layers that are not finite",
            not_finite(&rendering.picture),
        ),
    ];
    Ok(bench.with(findings))
}

/// What is put in the place of numbers.
const BROKEN: [f32; 8] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    -1.0,
    0.0,
    1e-45,
    1e38,
    f32::MAX,
];

/// Puts a number into one place of a material, if that is one of the first eight of [`PLACES`].
fn break_material(material: &mut MetallicRoughness, number: usize, value: f32) {
    match number {
        0 => material.base_color[1] = value,
        1 => material.metallic = value,
        2 => material.roughness = value,
        3 => material.ior = value,
        4 => material.specular = value,
        5 => material.specular_color[0] = value,
        6 => material.transmission = value,
        7 => material.alpha = value,
        _ => {}
    }
}

/// Puts a number into one of the other places of a scene.
fn break_number(scene: &mut Scene, number: usize, value: f32) {
    let wide = f64::from(value);
    match number {
        0..8 => {}
        8 => scene.meshes[0].positions[40][1] = value,
        9 => scene.meshes[0]
            .positions
            .iter_mut()
            .for_each(|p| p[2] = value),
        10 => scene.meshes[0].uvs[0][17][0] = value,
        11 => {
            if let Some(normals) = &mut scene.meshes[0].normals {
                normals.iter_mut().for_each(|n| n[0] = value);
            }
        }
        12 => scene.instances[0].world_from_object.translation.x = wide,
        13 => scene.instances[0].world_from_object.matrix3.x_axis.x = wide,
        14 => scene.lights[0].world_from_light.translation.x = wide,
        15 => scene.lights[0].world_from_light.translation.y = wide,
        16 => scene.lights[0].world_from_light.matrix3.z_axis.z = wide,
        17 => scene.lights[0].kind = sized(3.0, value),
        18 => scene.cameras[0].world_from_camera.translation.z = wide,
        19 => scene.cameras[0].world_from_camera.matrix3.y_axis.y = wide,
        20 => scene.cameras[0].clip_near = wide,
        21 => scene.cameras[0].clip_far = wide,
        22 => {
            scene.cameras[0].projection = sundog::scene::Projection::Perspective {
                vertical_fov: wide,
                aspect: None,
            };
        }
        _ => {
            if let Some(environment) = &mut scene.environment {
                environment.rotation.x_axis.x = wide;
            }
        }
    }
}

/// Places that [`break_material`] and [`break_number`] know. The strengths of lights are not among them: those of 1e38 overflow, which
/// another case is about.
const PLACES: usize = 24;

fn sized(intensity: f32, radius: f32) -> LightKind {
    LightKind::Point {
        intensity,
        radius,
        soft_falloff: false,
    }
}

fn broken_numbers(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let settings = RenderSettings {
        width: 12,
        height: 9,
        ..small(effort.of(2, 8, 64), 4)
    };
    let (mut bad_values, mut without_camera, mut rendered) = (0, 0, 0u64);
    for number in 0..PLACES {
        for value in BROKEN {
            let mut material = diffuse([0.9; 3]);
            break_material(&mut material, number, value);
            let mut scene = dark_with(material);
            scene.environment = constant_environment(0.5);
            let lamp = beacon(sized(3.0, 0.1), DVec3::new(0.0, 2.5, 1.0));
            scene.lights.push(lamp);
            break_number(&mut scene, number, value);
            clean(&mut scene, &mut Diagnostics::default());
            if scene.cameras.is_empty() {
                without_camera += 1;
                continue;
            }
            rendered += 1;
            let rendering = bench.render(&scene, &settings)?;
            bad_values += not_finite(&rendering.picture);
        }
    }
    let all = (PLACES * BROKEN.len()) as f64;
    Ok(bench.with(vec![
        Finding::none("values that are not finite", bad_values),
        Finding::new(
            "scenes rendered, or whose camera makes no picture",
            all,
            (rendered + without_camera) as f64,
            0.0,
        ),
        // Only the camera's own five numbers can take the camera away.
        Finding::at_most(
            "scenes whose camera makes no picture",
            (5 * BROKEN.len()) as f64,
            without_camera as f64,
        ),
    ]))
}
