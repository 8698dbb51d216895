//! Blender's White Noise Texture: a hash of the coordinates' bits.

use glam::Vec3;

use super::{Dimensions, hash};

/// The value alone.
pub fn white_noise_value(dimensions: Dimensions, vector: Vec3, w: f32) -> f32 {
    match dimensions {
        Dimensions::One => hash::unit_1(w),
        Dimensions::Two => hash::unit_2(vector.x, vector.y),
        Dimensions::Three => hash::unit_3(vector.x, vector.y, vector.z),
        Dimensions::Four => hash::unit_4(vector.x, vector.y, vector.z, w),
    }
}

/// The node's outputs: Value and Color. The colour's red is the value.
pub fn white_noise(dimensions: Dimensions, vector: Vec3, w: f32) -> (f32, Vec3) {
    let color = match dimensions {
        Dimensions::One => hash::color_1(w),
        Dimensions::Two => hash::color_2(vector.truncate()),
        Dimensions::Three => hash::color_3(vector),
        Dimensions::Four => hash::color_4(vector.extend(w)),
    };
    (color.x, color)
}
