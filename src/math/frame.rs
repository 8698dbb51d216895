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
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_in_all_directions_and_near_the_poles() {
        let mut worst = 0f32;
        for i in 0..200 {
            for j in 0..100 {
                let phi = i as f32 * 0.031_415_9;
                let cos = 1.0 - j as f32 * 0.020_202;
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                for z in [
                    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos).normalize(),
                    Vec3::new(1e-7 * phi.cos(), 1e-4 * phi.sin(), -1.0).normalize(),
                ] {
                    let f = Frame::from_normal(z);
                    for error in [
                        f.x.dot(f.y),
                        f.x.dot(f.z),
                        f.y.dot(f.z),
                        f.x.length() - 1.0,
                        f.y.length() - 1.0,
                        (f.x.cross(f.y) - f.z).length(),
                    ] {
                        worst = worst.max(error.abs());
                    }
                }
            }
        }
        // The paper finds errors below 1e-6 in f32 over all directions (its table 1).
        assert!(worst < 2e-6, "{worst}");
    }
}
