//! Which effects a scene and the settings of a render call for, by value.
//!
//! [`TABLE`] has them all. [`EffectSet::detect`] finds those that are called for, and why the others are not; a set of those
//! that can be left out is a [`Mask`], for which kernels are compiled and worlds prepared ([`kept`] says what a material is
//! without some). A finding may be wrong to one side only: an effect that is found though it changes nothing costs time, one
//! that is missed would be another picture. docs/effects.md is about all of it.

mod census;
mod detect;
mod features;
mod kept;
mod mask;
mod requested;
mod table;

pub use detect::{Cause, EffectSet, Finding, State, Thing, is_translucent, tells_rays_apart};
pub use features::{Box, Features, General, Matte, Opaque};
pub use kept::{keeps, keeps_environment, kept};
pub use mask::{
    ALL, ALPHA, ALPHA_BLEND, ALPHA_CLIP, AREA_LIGHTS, BASE_COLOR_TEXTURE, CLEAR_GLASS, COMPILED,
    CONSTANT_ENVIRONMENT, DEPTH_OF_FIELD, EMISSION_TEXTURE, ENVIRONMENT, FACETS, GLOSS, GROUPS,
    HOLDOUTS, IMAGE_ENVIRONMENT, INSTANCES, LAMPS, LIGHT_TREE, MESH_LIGHTS, METAL,
    METALLIC_ROUGHNESS_TEXTURE, Mask, NORMAL_MAPS, PATHS, POINT_LIGHTS, ROUGH_GLASS,
    SMOOTH_NORMALS, SPECULAR_COLOR_TEXTURE, SPECULAR_TEXTURE, SPOT_LIGHTS, STRUCTURE, SUNS,
    TEXTURES, THIN_GLASS, TRANSMISSION, TRANSMISSION_TEXTURE, VERTEX_COLORS, VISIBILITY, has,
    names, parse,
};
pub use requested::RequestedSettings;
pub use table::{COUNT, Decided, Row, TABLE, markdown};

pub use crate::scene::Effect;
