//! The light from all around, by SUNDOG_scene.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::container::Document;
use super::extensions::report_property;
use super::medium;
use super::schema::{TextureLimitJson, WorldJson, WorldSunJson};
use crate::import::{ImportError, Taking, environment_image, left_for_images};
use crate::scene::graph::Graph;
use crate::scene::{
    Diagnostics, Effect, Environment, ImageId, Light, LightKind, Links, Scene, Verdict, Visibility,
    WorldGraph,
};

/// How far a rotation's columns may be from orthonormal: f32 writers are within 1e-6.
const ORTHONORMAL: f64 = 1e-4;

/// Gives the scene the world of the file.
pub(super) fn load(
    document: &Document,
    (world, graph): (&WorldJson, Option<Graph>),
    (most_bytes, limit): (Option<u64>, Option<&TextureLimitJson>),
    scene: &mut Scene,
    diagnostics: &mut Diagnostics,
) -> Result<(), ImportError> {
    for property in world.unknown.keys() {
        report_property(diagnostics, "SUNDOG_scene", property, "world");
    }
    let visibility = world.visibility.visibility(|kind| {
        report_property(
            diagnostics,
            "SUNDOG_scene",
            &format!("visibility.{kind}"),
            "world",
        );
    });
    let medium = |volume| medium::read(volume, "world", diagnostics);
    scene.medium = world.volume.as_ref().map(medium);
    let mut image = None;
    if let Some(uri) = &world.image {
        let bytes = document.resolve(uri, "world")?;
        let name = if uri.starts_with("data:") {
            "the world's image"
        } else {
            uri
        };
        let decoded = environment_image(
            &bytes,
            &document.file,
            name,
            &Taking {
                space: scene.color_management.working_space,
                floats_are_in_it: true,
                most_bytes: left_for_images(&scene.images, most_bytes),
            },
            diagnostics,
        )?;
        image = Some(ImageId(
            u32::try_from(scene.images.len()).unwrap_or(u32::MAX),
        ));
        scene.images.push(match limit {
            Some(limit) => limit.of(decoded, false),
            None => decoded,
        });
    }
    // An image is multiplied with nothing, and without one the world is black.
    let default = if image.is_some() { 1.0 } else { 0.0 };
    let sampling = world.sampling.as_ref();
    for property in sampling.iter().flat_map(|sampling| sampling.unknown.keys()) {
        let name = format!("sampling.{property}");
        report_property(diagnostics, "SUNDOG_scene", &name, "world");
    }
    let graph = graph.map(|graph| {
        let resolution = sampling.map_or(0, |sampling| sampling.resolution);
        Box::new(WorldGraph { graph, resolution })
    });
    let links = Links {
        group: world.light_group.as_deref().map(Into::into),
        ..Links::default()
    };
    scene.environment = Some(Environment {
        image: image.filter(|_| graph.is_none()),
        // The colour is for those that do not evaluate the graph.
        radiance: if graph.is_some() {
            [1.0; 3]
        } else {
            world.color.unwrap_or([default; 3])
        },
        rotation: rotation(world, diagnostics),
        visibility,
        links: links.clone(),
        graph,
    });
    if let Some(sun) = &world.sun {
        for property in sun.unknown.keys() {
            report_property(
                diagnostics,
                "SUNDOG_scene",
                &format!("sun.{property}"),
                "world",
            );
        }
        scene
            .lights
            .push(self::sun(sun, (visibility, links), document)?);
    }
    Ok(())
}

/// The disc of the sun, as a light that the rays see which see the world.
fn sun(
    sun: &WorldSunJson,
    (visibility, links): (Visibility, Links),
    document: &Document,
) -> Result<Light, ImportError> {
    // Blender's (x, y, z) is (x, z, -y) of glTF.
    let [x, y, z] = sun.direction;
    let toward = DVec3::new(x, z, -y).try_normalize();
    let legal = |v: f32| v.is_finite() && v >= 0.0;
    let (Some(toward), true) = (
        toward,
        sun.strength.iter().all(|&v| legal(v)) && legal(sun.angle),
    ) else {
        return Err(ImportError::malformed(
            &document.file,
            "world",
            "its sun needs a direction, and an angle and a strength of at least 0",
        ));
    };
    // A light looks down its -Z axis.
    let turn = DQuat::from_rotation_arc(DVec3::Z, toward);
    Ok(Light {
        name: "the world's sun".into(),
        color: sun.strength,
        kind: LightKind::Sun {
            irradiance: 1.0,
            angle: sun.angle,
        },
        world_from_light: DAffine3::from_quat(turn),
        visibility,
        max_bounces: Light::MAX_BOUNCES,
        is_hit: true,
        links,
        graph: None,
    })
}

/// The rotation, made exactly orthonormal; the identity (with a diagnostic) for what is none.
fn rotation(world: &WorldJson, diagnostics: &mut Diagnostics) -> DMat3 {
    let Some(rows) = &world.rotation else {
        return DMat3::IDENTITY;
    };
    let m = DMat3::from_cols_array(rows).transpose();
    let error = (m.transpose() * m - DMat3::IDENTITY)
        .to_cols_array()
        .iter()
        .fold(0.0f64, |worst, e| {
            if e.is_nan() {
                f64::INFINITY
            } else {
                worst.max(e.abs())
            }
        });
    if error > ORTHONORMAL {
        diagnostics.report_effect(
            Effect::ImageEnvironment,
            "world-rotation",
            Verdict::Lost,
            "rotation of the world that is none",
            "world",
            "the image is not turned",
        );
        return DMat3::IDENTITY;
    }
    let x = m.x_axis.normalize();
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize();
    let z = x.cross(y);
    // A mirror stays one.
    DMat3::from_cols(x, y, if z.dot(m.z_axis) < 0.0 { -z } else { z })
}
