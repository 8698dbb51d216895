//! Mapping and Vector Rotate.

use super::vector_math::divided;
use glam::{EulerRot, Mat3, Quat, Vec3};

choice! {
    /// What the Mapping node maps.
    Mapping {
        /// Points: scaled, turned, moved.
        Point = "POINT",
        /// The texture instead: all of it backwards.
        Texture = "TEXTURE",
        /// Directions: scaled and turned.
        Vector = "VECTOR",
        /// Normals: scaled by the inverse, turned, of unit length.
        Normal = "NORMAL",
    }
}

/// Turns by angles about X, then Y, then Z.
fn euler(angles: Vec3) -> Mat3 {
    // Most mappings turn nothing, and sines take longer than all the rest.
    if angles == Vec3::ZERO {
        return Mat3::IDENTITY;
    }
    Mat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x)
}

impl Mapping {
    /// The mapped vector.
    pub fn of(self, v: Vec3, location: Vec3, rotation: Vec3, scale: Vec3) -> Vec3 {
        match self {
            Self::Point => euler(rotation) * (v * scale) + location,
            Self::Texture => divided(euler(rotation).transpose() * (v - location), scale),
            Self::Vector => euler(rotation) * (v * scale),
            Self::Normal => (euler(rotation) * divided(v, scale)).normalize_or_zero(),
        }
    }
}

choice! {
    /// About what Vector Rotate turns.
    #[allow(missing_docs, reason = "the names are Blender's")]
    RotationAxis {
        AxisAngle = "AXIS_ANGLE",
        X = "X_AXIS",
        Y = "Y_AXIS",
        Z = "Z_AXIS",
        EulerXyz = "EULER_XYZ",
    }
}

impl RotationAxis {
    /// The vector, turned about the centre.
    pub fn of(self, v: Vec3, center: Vec3, axis: Vec3, angle: Vec3, backwards: bool) -> Vec3 {
        let turn = if backwards { -angle.x } else { angle.x };
        let about = |axis: Vec3| Mat3::from_quat(Quat::from_axis_angle(axis, turn));
        let matrix = match self {
            Self::AxisAngle => match axis.try_normalize() {
                None => return v,
                Some(axis) => about(axis),
            },
            Self::X => about(Vec3::X),
            Self::Y => about(Vec3::Y),
            Self::Z => about(Vec3::Z),
            Self::EulerXyz if backwards => euler(angle).transpose(),
            Self::EulerXyz => euler(angle),
        };
        matrix * (v - center) + center
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn near(a: Vec3, b: Vec3) {
        assert!((a - b).abs().max_element() < 1e-6, "{a} {b}");
    }

    #[test]
    fn points_are_mapped_there_and_back() {
        let (location, scale) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 1.0, 0.5));
        let rotation = Vec3::new(0.3, -0.4, 1.1);
        let v = Vec3::new(0.2, -0.7, 0.9);
        let mapped = Mapping::Point.of(v, location, rotation, scale);
        near(Mapping::Texture.of(mapped, location, rotation, scale), v);
        // X first, then Z: y goes to z and stays there; x goes to y.
        let quarter = Vec3::new(FRAC_PI_2, 0.0, FRAC_PI_2);
        near(Mapping::Vector.of(Vec3::Y, v, quarter, Vec3::ONE), Vec3::Z);
        near(Mapping::Vector.of(Vec3::X, v, quarter, Vec3::ONE), Vec3::Y);
    }

    #[test]
    fn vectors_are_turned_about_a_centre() {
        let turned =
            RotationAxis::Z.of(Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::splat(FRAC_PI_2), false);
        near(turned, Vec3::new(1.0, 2.0, 0.0));
        let axis = Vec3::new(0.0, 0.0, 3.0);
        let back = RotationAxis::AxisAngle.of(turned, Vec3::Y, axis, Vec3::splat(FRAC_PI_2), true);
        near(back, Vec3::X);
    }
}
