//! Who sees a light.

use crate::scene::{RayKind, Visibility};

/// Which rays see a light, and how many bounces they may have behind them.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Kinds of rays; without [`RayKind::Shadow`] it shines through everything.
    pub visibility: Visibility,
    /// Paths with more bounces do not see it.
    pub max_bounces: u32,
    /// Whether scattered rays find it.
    pub is_hit: bool,
    /// Whether they share its light with light samples though it shines through what stops them, as in Cycles: their part
    /// of it is lost where something is in the way.
    pub loses_rays: bool,
}

impl Rules {
    /// Seen by all.
    pub const NONE: Self = Self {
        visibility: Visibility::ALL,
        max_bounces: u32::MAX,
        is_hit: true,
        loses_rays: false,
    };

    /// `by_kind`: kinds of rays are told apart; otherwise only the camera's are.
    pub fn new(visibility: Visibility, (max_bounces, is_hit): (u32, bool), by_kind: bool) -> Self {
        if by_kind {
            Self {
                visibility,
                max_bounces,
                is_hit,
                loses_rays: false,
            }
        } else if visibility.sees(RayKind::Camera) {
            Self::NONE
        } else {
            Self {
                visibility: Visibility::ALL.without(RayKind::Camera),
                ..Self::NONE
            }
        }
    }

    /// Of a surface that shines: it cannot shine through others.
    pub fn of_surface(visibility: Visibility) -> Self {
        Self {
            visibility: visibility.with(RayKind::Shadow),
            ..Self::NONE
        }
    }

    /// Whether a ray that left after so many bounces sees it. `also`: what else it is for lights, as in
    /// [`super::LightSampleContext::also`].
    #[inline]
    pub fn allow(&self, kind: RayKind, also: u32, bounces: u32) -> bool {
        let is_found = self.is_hit || kind == RayKind::Camera;
        let is_diffuse = also & RayKind::Diffuse.bit() != 0;
        let is_seen =
            (!is_diffuse || self.visibility.sees(RayKind::Diffuse)) && self.visibility.sees(kind);
        is_found && is_seen && bounces <= self.max_bounces
    }

    /// Whether rays from all lobes see it.
    pub fn is_seen_by_all_that_scatters(&self) -> bool {
        [RayKind::Diffuse, RayKind::Glossy, RayKind::Transmission]
            .iter()
            .all(|kind| self.visibility.sees(*kind))
    }

    /// As in Cycles where scattered rays meet what it shines through.
    pub fn losing_rays(self, loses_rays: bool) -> Self {
        Self { loses_rays, ..self }
    }

    /// Whether light sampling is the only way to find it.
    #[inline]
    pub fn only_sampled(&self) -> bool {
        !self.is_hit || self.shines_through() && !self.loses_rays
    }

    /// Whether its light passes what stops a ray, so that light sampling is the only way to find it.
    #[inline]
    pub fn shines_through(&self) -> bool {
        !self.visibility.sees(RayKind::Shadow)
    }
}
