//! What is in a file but changes nothing is taken out before anything is made of it.
//!
//! By value, not by presence: an image that is the same everywhere is a factor, a normal map that is flat is none. The
//! result is a scene like any other, so that all kernels, and all of what looks at the scene, see the same. What is left
//! out is told with its reason. Nothing here depends on settings or on the camera; and nothing changes the picture but for
//! roundings, chance (other numbers are drawn where lights or objects are gone), and half a step of a flat normal map.

mod images;
mod materials;
mod unseen;
mod unused;

use super::{LeftOut, Scene};

/// Takes out what changes nothing; tells what, and why. The scene must be clean (see [`super::validate::clean`]).
pub fn simplify(scene: &mut Scene) -> Vec<LeftOut> {
    let mut left_out = Vec::new();
    unseen::objects(scene, &mut left_out);
    unseen::lights(scene, &mut left_out);
    unseen::environment(scene, &mut left_out);
    unseen::colors(scene, &mut left_out);
    images::join(scene, &mut left_out);
    images::fold_environment(scene, &mut left_out);
    materials::fold(scene, &mut left_out);
    materials::join(scene, &mut left_out);
    unused::meshes(scene, &mut left_out);
    unused::materials(scene, &mut left_out);
    unused::images(scene, &mut left_out);
    unused::attributes(scene, &mut left_out);
    left_out
}

#[cfg(test)]
#[path = "../../../tests/unit/scene/simplify/mod.rs"]
mod tests;
