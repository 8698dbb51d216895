//! The light from all around, by SUNDOG_scene.

use glam::DMat3;

use super::container::{Document, Resolved};
use super::extensions::report_property;
use super::schema::WorldJson;
use crate::import::{ImportError, environment_image};
use crate::scene::{Diagnostics, Environment, ImageId, Scene, Verdict};

/// How far a rotation's columns may be from orthonormal: f32 writers are within 1e-6.
const ORTHONORMAL: f64 = 1e-4;

/// Gives the scene the world of the file.
pub(super) fn load(
    document: &Document,
    world: &WorldJson,
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
    let mut image = None;
    if let Some(uri) = &world.image {
        let Resolved::Data(bytes) = document.resolve(uri, "world")?;
        let name = if uri.starts_with("data:") {
            "the world's image"
        } else {
            uri
        };
        let decoded = environment_image(&bytes, &document.file, name, diagnostics)?;
        image = Some(ImageId(
            u32::try_from(scene.images.len()).unwrap_or(u32::MAX),
        ));
        scene.images.push(decoded);
    }
    // An image is multiplied with nothing, and without one the world is black.
    let default = if image.is_some() { 1.0 } else { 0.0 };
    scene.environment = Some(Environment {
        image,
        radiance: world.color.unwrap_or([default; 3]),
        rotation: rotation(world, diagnostics),
        visibility,
    });
    Ok(())
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
        diagnostics.report(
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
