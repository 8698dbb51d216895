//! What stands for indirect light in a prepared scene.

use super::placed::by_entry;
use super::{Options, World};
use crate::effects::Effect;
use crate::scene::{FastGi, FastGiMethod, Scene};

/// What stands for it, and how far it sees.
#[derive(Debug)]
pub struct Approximation {
    gi: FastGi,
    /// By entry; empty where it is the same from everywhere.
    reaches: Vec<f32>,
}

impl Approximation {
    pub(super) fn new(scene: &Scene, options: &Options) -> Option<Self> {
        let gi = scene.fast_gi?;
        options.effects.contains(Effect::FastGi).then(|| Self {
            gi,
            reaches: by_entry(|i| i.info.reach, 0.0, Effect::FastGi, scene, options),
        })
    }

    /// Whether the last rays of paths see less than light samples.
    pub(super) fn replaces(&self) -> bool {
        self.gi.method != FastGiMethod::Add
    }
}

impl World {
    /// Whether anything stands for indirect light.
    #[inline(always)]
    pub fn is_approximated(&self) -> bool {
        self.geometry.approximation.is_some()
    }

    /// After how many bounces the world shines past what is not near, and how brightly; `None` if it does not.
    #[inline]
    pub fn replaced_after(&self) -> Option<(u32, f32)> {
        let gi = &self.geometry.approximation.as_ref()?.gi;
        match gi.method {
            FastGiMethod::Replace { bounces } => Some((bounces, gi.factor)),
            FastGiMethod::Add => None,
        }
    }

    /// What is added at each surface, for its colour, and how far what hides it is; `None` if nothing is.
    #[inline]
    pub fn added_openness(&self) -> Option<(f32, f32)> {
        let gi = &self.geometry.approximation.as_ref()?.gi;
        (gi.method == FastGiMethod::Add).then_some((gi.factor, gi.distance))
    }

    /// How far the last rays of paths see that leave an object, or none.
    pub fn reach(&self, object: Option<u32>) -> f32 {
        let Some(Approximation { gi, reaches }) = &self.geometry.approximation else {
            return f32::INFINITY;
        };
        let own = object.and_then(|object| reaches.get(object as usize));
        own.copied()
            .filter(|reach| *reach != 0.0)
            .unwrap_or(gi.distance)
    }
}
