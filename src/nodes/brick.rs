//! Blender's Brick Texture.

use glam::Vec3;

use super::{CyclesVersion, fused, smoothstep, whole};

/// The node's properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickSettings {
    /// How far every so manieth row is moved, in bricks.
    pub offset: f32,
    /// Which rows are moved; 0: none are moved or squashed.
    pub offset_frequency: u8,
    /// The width of bricks in rows that are not among those of `squash_frequency`, beside the others'.
    pub squash: f32,
    /// Which rows are squashed; 0: none are moved or squashed.
    pub squash_frequency: u8,
    /// Bricks without width are counted to infinity, so that they have no sides: those of Cycles from 5.1 on.
    pub without_sides: bool,
}

impl BrickSettings {
    /// Whether bricks without width have no sides in a version.
    pub fn are_without_sides(version: CyclesVersion) -> bool {
        version >= CyclesVersion::new(5, 1)
    }
}

impl Default for BrickSettings {
    fn default() -> Self {
        Self {
            offset: 0.5,
            offset_frequency: 2,
            squash: 1.0,
            squash_frequency: 2,
            without_sides: true,
        }
    }
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickInputs {
    /// Vector.
    pub vector: Vec3,
    /// Color1 of bricks.
    pub color1: Vec3,
    /// Color2 of bricks.
    pub color2: Vec3,
    /// The mortar's colour.
    pub mortar: Vec3,
    /// Scale.
    pub scale: f32,
    /// Mortar Size, from the middle of the joint to the brick.
    pub mortar_size: f32,
    /// Mortar Smooth: how soft the brick's edge is.
    pub mortar_smooth: f32,
    /// Bias between the two colours, −1 to 1.
    pub bias: f32,
    /// Brick Width.
    pub brick_width: f32,
    /// Row Height.
    pub row_height: f32,
}

impl Default for BrickInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            color1: Vec3::splat(0.8),
            color2: Vec3::splat(0.2),
            mortar: Vec3::ZERO,
            scale: 5.0,
            mortar_size: 0.02,
            mortar_smooth: 0.1,
            bias: 0.0,
            brick_width: 0.5,
            row_height: 0.25,
        }
    }
}

/// The node's outputs: Fac, 1 in the mortar, and Color.
#[inline]
pub fn brick(settings: &BrickSettings, inputs: &BrickInputs) -> (f32, Vec3) {
    let p = inputs.vector * inputs.scale;
    let row = whole((p.y / inputs.row_height).floor());
    let mut width = inputs.brick_width;
    let mut offset = 0.0;
    if settings.offset_frequency != 0 && settings.squash_frequency != 0 {
        if row % i32::from(settings.squash_frequency) == 0 {
            width *= settings.squash;
        }
        if row % i32::from(settings.offset_frequency) == 0 {
            offset = width * settings.offset;
        }
    }
    let count = ((p.x + offset) / width).floor();
    let number = whole(count);
    // Fused as in Cycles, so that far from the origin both round alike.
    let count = if settings.without_sides {
        count
    } else {
        number as f32
    };
    let x = fused(-width, count, p.x + offset);
    let y = fused(-inputs.row_height, row as f32, p.y);

    let key = ((row as u32) << 16).wrapping_add(number as u32 & 0xffff);
    let tint = (random(key) + inputs.bias).clamp(0.0, 1.0);
    // The way to a side that is no number does not count.
    let from_edge = x.min(y).min((width - x).min(inputs.row_height - y));
    let mortar = if from_edge >= inputs.mortar_size {
        0.0
    } else if inputs.mortar_smooth == 0.0 {
        1.0
    } else {
        smoothstep((1.0 - from_edge / inputs.mortar_size) / inputs.mortar_smooth)
    };
    let bricks = if mortar == 1.0 {
        inputs.color1
    } else {
        inputs.color1 * (1.0 - tint) + inputs.color2 * tint
    };
    (mortar, bricks * (1.0 - mortar) + inputs.mortar * mortar)
}

/// A number from 0 to 1 for each brick, by the integer noise of libnoise (libnoise.sourceforge.net/noisegen).
fn random(key: u32) -> f32 {
    let n = key.wrapping_add(1013) & 0x7fff_ffff;
    let n = (n >> 13) ^ n;
    let mixed = n
        .wrapping_mul(
            n.wrapping_mul(n)
                .wrapping_mul(60493)
                .wrapping_add(19_990_303),
        )
        .wrapping_add(1_376_312_589)
        & 0x7fff_ffff;
    0.5 * (mixed as f32 / 1_073_741_824.0)
}
