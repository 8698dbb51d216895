//! Transforms of nodes.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::schema::NodeJson;
use crate::scene::{Diagnostics, Verdict};

/// A unit quaternion from glTF's (x, y, z, w); the identity if it has no direction. Says whether it had the length 1.
pub(super) fn rotation(xyzw: [f64; 4]) -> (DQuat, bool) {
    let length = DQuat::from_array(xyzw).length();
    // Stored in 8 bits each of the four is off by up to half of 1/127, and the length by √4 of that.
    let unit = (length - 1.0).abs() <= 1.0 / 127.0;
    // Not-a-numbers pass, so that `scene::validate` finds them.
    if length == 0.0 {
        (DQuat::IDENTITY, unit)
    } else {
        (DQuat::from_array(xyzw.map(|c| c / length)), unit)
    }
}

pub(super) fn report_rotation(name: &str, diagnostics: &mut Diagnostics) {
    diagnostics.report(
        "rotation-length",
        Verdict::Approximated,
        "rotation by a quaternion that is not of length 1",
        name,
        "made that long; one of length 0 does not turn",
    );
}

pub(super) fn local_transform(
    node: &NodeJson,
    name: &str,
    diagnostics: &mut Diagnostics,
) -> DAffine3 {
    match &node.matrix {
        Some(columns) => matrix(columns, name, diagnostics),
        None => DAffine3::from_scale_rotation_translation(
            node.scale.map_or(DVec3::ONE, DVec3::from),
            node.rotation.map_or(DQuat::IDENTITY, |xyzw| {
                let (rotation, unit) = rotation(xyzw);
                if !unit {
                    report_rotation(name, diagnostics);
                }
                rotation
            }),
            node.translation.map_or(DVec3::ZERO, DVec3::from),
        ),
    }
}

/// The affine part of a matrix by columns.
pub(super) fn matrix(columns: &[f64; 16], name: &str, diagnostics: &mut Diagnostics) -> DAffine3 {
    let last = [columns[3], columns[7], columns[11], columns[15] - 1.0];
    // What products in f32 leave of zeros and a one.
    if last
        .iter()
        .any(|c| c.abs() > 16.0 * f64::from(f32::EPSILON))
    {
        diagnostics.report(
            "matrix-row",
            Verdict::Approximated,
            "matrix whose last row is not 0, 0, 0, 1",
            name,
            "the row is taken as that: glTF places objects without perspective",
        );
    }
    DAffine3::from_mat4(DMat4::from_cols_array(columns))
}
