//! Orthonormal frames.

use glam::Vec3;

/// A right-handed orthonormal frame with `z` as its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl Frame {
    /// A frame about a unit vector, without a branch and without a singular direction
    /// (Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017).
    pub fn from_normal(z: Vec3) -> Self {
        let sign = 1f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// A frame about a unit vector with x along a tangent, or any if the tangent has no part across the vector.
    pub fn from_normal_and_tangent(z: Vec3, tangent: Vec3) -> Self {
        match (tangent - z * z.dot(tangent)).try_normalize() {
            Some(x) => Self {
                x,
                y: z.cross(x),
                z,
            },
            None => Self::from_normal(z),
        }
    }

    /// World to local.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// Local to world.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
#[path = "../../tests/unit/math/frame.rs"]
mod tests;
