//! Names of the effects that things which are left out belong to, as in `effects::TABLE`, which this room can't see.

pub const BASE_COLOR_TEXTURE: &str = "base-color-texture";
pub const METALLIC_ROUGHNESS_TEXTURE: &str = "metallic-roughness-texture";
pub const EMISSION_TEXTURE: &str = "emission-texture";
pub const SPECULAR_TEXTURE: &str = "specular-texture";
pub const SPECULAR_COLOR_TEXTURE: &str = "specular-color-texture";
pub const TRANSMISSION_TEXTURE: &str = "transmission-texture";
pub const VERTEX_COLORS: &str = "vertex-colors";
pub const NORMAL_MAPS: &str = "normal-maps";
pub const ALPHA_BLEND: &str = "alpha-blend";
pub const ALPHA_CLIP: &str = "alpha-clip";
pub const POINT_LIGHTS: &str = "point-lights";
pub const SPOT_LIGHTS: &str = "spot-lights";
pub const AREA_LIGHTS: &str = "area-lights";
pub const SUNS: &str = "suns";
pub const CONSTANT_ENVIRONMENT: &str = "constant-environment";
pub const IMAGE_ENVIRONMENT: &str = "image-environment";
pub const RAY_VISIBILITY: &str = "ray-visibility";
/// Of no effect in particular.
pub const NONE: &str = "";

/// All of them, for a test that the table has them.
pub const PARTS: [&str; 17] = [
    BASE_COLOR_TEXTURE,
    METALLIC_ROUGHNESS_TEXTURE,
    EMISSION_TEXTURE,
    SPECULAR_TEXTURE,
    SPECULAR_COLOR_TEXTURE,
    TRANSMISSION_TEXTURE,
    VERTEX_COLORS,
    NORMAL_MAPS,
    ALPHA_BLEND,
    ALPHA_CLIP,
    POINT_LIGHTS,
    SPOT_LIGHTS,
    AREA_LIGHTS,
    SUNS,
    CONSTANT_ENVIRONMENT,
    IMAGE_ENVIRONMENT,
    RAY_VISIBILITY,
];
