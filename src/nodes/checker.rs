//! Blender's Checker Texture.

use glam::Vec3;

use super::{off_edges, whole};

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckerInputs {
    /// Vector.
    pub vector: Vec3,
    /// Color1.
    pub color1: Vec3,
    /// Color2.
    pub color2: Vec3,
    /// Scale.
    pub scale: f32,
}

impl Default for CheckerInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            color1: Vec3::splat(0.8),
            color2: Vec3::splat(0.2),
            scale: 5.0,
        }
    }
}

/// The node's outputs: Fac, 1 where Color1 is, and Color.
pub fn checker(inputs: &CheckerInputs) -> (f32, Vec3) {
    let p = off_edges(inputs.vector * inputs.scale);
    let [x, y, z] = p.to_array().map(|x| whole(x.floor()) & 1 == 1);
    if (x == y) == z {
        (1.0, inputs.color1)
    } else {
        (0.0, inputs.color2)
    }
}
