//! Blender's Magic Texture.

use std::f32::consts::TAU;

use glam::Vec3;

use super::CyclesVersion;

/// The node's menus and boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MagicSettings {
    /// Depth: the number of turns, 0 to 10.
    pub turbulence_depth: u8,
    /// Whether coordinates are scaled before they are wrapped, as from 5.2 on, or after.
    pub scaled_first: bool,
}

impl MagicSettings {
    /// The node of a version.
    pub fn of(version: CyclesVersion, turbulence_depth: u8) -> Self {
        Self {
            turbulence_depth,
            scaled_first: version >= CyclesVersion::new(5, 2),
        }
    }
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagicInputs {
    /// Vector.
    pub vector: Vec3,
    /// Scale.
    pub scale: f32,
    /// Distortion.
    pub distortion: f32,
}

impl Default for MagicInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            scale: 5.0,
            distortion: 1.0,
        }
    }
}

/// The node's outputs: Fac, the mean of the colour's channels, and Color.
pub fn magic(settings: MagicSettings, inputs: &MagicInputs) -> (f32, Vec3) {
    let depth = settings.turbulence_depth;
    // A period of 2π on each axis keeps the sum of large coordinates exact enough.
    let (before, after) = if settings.scaled_first {
        (inputs.scale, 1.0)
    } else {
        (1.0, inputs.scale)
    };
    let [px, py, pz] = (inputs.vector * before).to_array().map(|x| x % TAU);
    let mut x = ((px + py + pz) * 5.0 * after).sin();
    let mut y = ((-px + py - pz) * 5.0 * after).cos();
    let mut z = -((-px - py + pz) * 5.0 * after).cos();
    let distortion = inputs.distortion;
    for turn in 1..=depth.min(10) {
        if turn == 1 {
            x *= distortion;
            y *= distortion;
            z *= distortion;
        }
        match turn {
            1 => y = -(x - y + z).cos() * distortion,
            2 => x = (x - y - z).cos() * distortion,
            3 => z = (-x - y - z).sin() * distortion,
            4 => x = -(-x + y - z).cos() * distortion,
            5 => y = -(-x + y + z).sin() * distortion,
            6 => y = -(-x + y + z).cos() * distortion,
            7 => x = (x + y + z).cos() * distortion,
            8 => z = (x + y - z).sin() * distortion,
            9 => x = -(-x - y + z).cos() * distortion,
            _ => y = -(x - y + z).sin() * distortion,
        }
    }
    let mut color = Vec3::new(x, y, z);
    if distortion != 0.0 {
        color /= distortion * 2.0;
    }
    color = 0.5 - color;
    ((color.x + color.y + color.z) * (1.0 / 3.0), color)
}
