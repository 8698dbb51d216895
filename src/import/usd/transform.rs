//! Where a prim is: its stack of transform operations.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use openusd::sdf::Value;

use super::source::View;
use super::value;
use crate::scene::{Diagnostics, Verdict};

/// The place of a prim in that of its parent, or in the world if it says so.
pub(super) struct Local {
    pub matrix: DAffine3,
    /// The parent's place does not count.
    pub resets: bool,
}

impl Local {
    /// The parent's place.
    pub(super) fn nowhere() -> Self {
        Self {
            matrix: DAffine3::IDENTITY,
            resets: false,
        }
    }
}

/// Reads the operations that a prim lists.
pub(super) fn local(prim: &View, diagnostics: &mut Diagnostics) -> Local {
    let mut local = Local::nowhere();
    let Some(order) = prim.value("xformOpOrder") else {
        return local;
    };
    for name in value::words(&order) {
        if name == "!resetXformStack!" {
            // What stands before it does not count either.
            local.matrix = DAffine3::IDENTITY;
            local.resets = true;
            continue;
        }
        let (inverted, name) = match name.strip_prefix("!invert!") {
            Some(rest) => (true, rest),
            None => (false, name.as_str()),
        };
        let Some(value) = prim.value(name) else {
            continue;
        };
        let operation = operation(name, &value);
        let operation = match (operation, inverted) {
            (Some(m), true) => Some(m.inverse()),
            (other, _) => other,
        };
        match operation.filter(DAffine3::is_finite) {
            Some(m) => local.matrix *= m,
            None => diagnostics.report(
                "usd-transform",
                Verdict::Lost,
                format!("transform operation \"{name}\" without a meaning"),
                prim.path().to_string(),
                "left out: the prim stands where the others put it",
            ),
        }
    }
    local
}

/// One operation: its kind is the second part of its name.
fn operation(name: &str, value: &Value) -> Option<DAffine3> {
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let number = || value::number(value);
    let vector = || value::vector::<3>(value).map(DVec3::from);
    let turned = |m: DMat3| DAffine3::from_mat3(m);
    let x = |degrees: f64| DMat3::from_rotation_x(degrees.to_radians());
    let y = |degrees: f64| DMat3::from_rotation_y(degrees.to_radians());
    let z = |degrees: f64| DMat3::from_rotation_z(degrees.to_radians());
    Some(match kind {
        "translate" => DAffine3::from_translation(vector()?),
        "translateX" => DAffine3::from_translation(DVec3::X * number()?),
        "translateY" => DAffine3::from_translation(DVec3::Y * number()?),
        "translateZ" => DAffine3::from_translation(DVec3::Z * number()?),
        "scale" => DAffine3::from_scale(vector()?),
        "scaleX" => DAffine3::from_scale(DVec3::new(number()?, 1.0, 1.0)),
        "scaleY" => DAffine3::from_scale(DVec3::new(1.0, number()?, 1.0)),
        "scaleZ" => DAffine3::from_scale(DVec3::new(1.0, 1.0, number()?)),
        "rotateX" => turned(x(number()?)),
        "rotateY" => turned(y(number()?)),
        "rotateZ" => turned(z(number()?)),
        "orient" => DAffine3::from_quat(value::rotation(value)?),
        "transform" => affine(value::matrix(value)?),
        _ => {
            // The axes stand in the order in which they turn.
            let axes = kind.strip_prefix("rotate").filter(|axes| axes.len() == 3)?;
            let angles = vector()?;
            let mut matrix = DMat3::IDENTITY;
            for axis in axes.chars() {
                let turn = match axis {
                    'X' => x(angles.x),
                    'Y' => y(angles.y),
                    'Z' => z(angles.z),
                    _ => return None,
                };
                matrix = turn * matrix;
            }
            turned(matrix)
        }
    })
}

/// A matrix without its last row.
pub(super) fn affine(m: DMat4) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_cols(
        m.x_axis.truncate().extend(0.0),
        m.y_axis.truncate().extend(0.0),
        m.z_axis.truncate().extend(0.0),
        m.w_axis.truncate().extend(1.0),
    ))
}

/// The place of an instance of a point instancer.
pub(super) fn of_instance(position: [f32; 3], turn: DQuat, scale: [f32; 3]) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::from(scale.map(f64::from)),
        turn,
        DVec3::from(position.map(f64::from)),
    )
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/transform.rs"]
mod tests;
