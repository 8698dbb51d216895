//! The curve of sRGB (IEC 61966-2-1).

/// The code, 0..=1, of linear light; clipped.
pub fn encode(light: f32) -> f32 {
    let light = light.clamp(0.0, 1.0);
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear light of a code.
pub fn decode(code: f32) -> f32 {
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/math/srgb.rs"]
mod tests;
