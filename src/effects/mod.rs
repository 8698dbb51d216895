//! Which effects a scene and the settings of a render call for, by value.
//!
//! [`TABLE`] has them all. [`EffectReport::detect`] finds those that are called for, and why the others are not. Worlds and
//! kernels are made for a set of them ([`without_effects`] says what a material is without some). A finding may be wrong to
//! one side only: an effect that is found though it changes nothing costs time, one that is missed would be another picture.
//! docs/effects.md is about all of it.

mod census;
mod detect;
mod features;
pub mod lines;
mod requested;
mod sets;
mod table;
mod without;

pub use detect::{Cause, EffectReport, Finding, State, Thing, is_translucent, tells_rays_apart};
pub use features::{Box, Features, General, Matte, Opaque};
pub use requested::RequestedSettings;
pub use sets::{
    ALL, ALPHA, ENVIRONMENT, GROUPS, LAMPS, PATHS, STRUCTURE, TEXTURES, TRANSMISSION, names, parse,
};
pub use table::{COUNT, Decided, EffectRow, TABLE, markdown, row};
pub use without::{keeps, keeps_environment, without_effects};

pub use crate::scene::Effect;
