//! Lobes that have no directions of their own: where paths go on by them is not at the surface.

use super::{Bsdf, Entry};
use crate::math::average;
use crate::shading::closure::{Below, BsdfFeatures, Lobe, Portal};
use glam::Vec3;

/// How a path leaves a surface other than in a direction from it.
#[derive(Clone, Copy, Debug)]
pub enum Elsewhere {
    /// It goes on below.
    Below(Below),
    /// It goes through a portal.
    Portal(Portal),
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// The way elsewhere, its weight over the probability of the choice, if a number chooses one: then [`Self::sample`] has no
    /// direction for it. `uniform`: nor has [`Self::sample_uniform`].
    #[cold]
    #[inline(never)]
    pub fn elsewhere(&self, mut choice: f32, uniform: bool) -> Option<Elsewhere> {
        let last = self.others.len().wrapping_sub(1);
        if !uniform && choice >= self.p_others() {
            return None;
        }
        for (i, entry) in self.others().iter().enumerate() {
            let p = if uniform {
                Self::p_delta(entry)
            } else {
                entry.p
            };
            if choice < p || !uniform && i == last {
                return match entry.lobe {
                    Lobe::Below(below) => Some(Elsewhere::Below(Below {
                        weight: below.weight / p,
                        ..below
                    })),
                    Lobe::Portal(portal) => Some(Elsewhere::Portal(Portal {
                        weight: portal.weight / p,
                        ..portal
                    })),
                    _ => None,
                };
            }
            choice -= p;
        }
        None
    }

    /// The mean normal of what goes on below the surface; the surface's smooth one where nothing does.
    pub fn normal_below(&self) -> Vec3 {
        let below = |entry: &Entry| match entry.lobe {
            Lobe::Below(below) => below.normal * average(entry.albedo),
            _ => Vec3::ZERO,
        };
        let sum: Vec3 = self.others().iter().map(below).sum();
        sum.try_normalize().unwrap_or(self.smooth())
    }
}
