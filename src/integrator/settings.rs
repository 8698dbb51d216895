//! What a path takes from the settings, and the weights that follow from them.

use super::path::Previous;
use crate::effects::Features;
use crate::light::power_heuristic;
use crate::shading::Changes;
use crate::world::RayKind;

/// What a path takes from the settings.
#[derive(Clone, Copy, Debug)]
pub struct PathSettings {
    /// Indirect bounces: 0 is direct light only, as Cycles counts "Max Bounces".
    pub bounces: u32,
    /// The same for the scatterings of one kind, in the order of [`crate::shading::Scattering`]; `u32::MAX` for no limit.
    pub limits: [u32; 3],
    /// Surfaces that a path may pass by their opacity, as Cycles counts its transparent "Max Bounces";
    /// `u32::MAX` for no limit.
    pub transparent: u32,
    /// How much of a surface has to be there for passes of data to stop at it: Cycles' "Alpha Threshold" of passes.
    pub alpha_threshold: f32,
    /// Greatest mean of the channels that one contribution may have: direct light, indirect light.
    /// Infinite for no limit.
    pub clamp: [f32; 2],
    /// Cycles' "Filter Glossy"; 0 for none.
    pub filter_glossy: f32,
    /// The world is no part of the picture where the camera looks straight at it.
    pub transparent_film: bool,
    /// What lets light through with an α up to this is as nothing to that: Cycles' "Transparent Glass". Below 0 none.
    pub clear_alpha: f32,
    /// What reflects, and what lets through, still does so behind a diffuse reflection.
    pub caustics: [bool; 2],
    /// Light is found by sampling lights.
    pub sample_lights: bool,
    /// Light is found by sampling BSDFs.
    pub sample_bsdf: bool,
    /// Directions are drawn without a look at the BSDF, wherever that can work. For studies; the general
    /// kernel alone can do it.
    pub uniform: bool,
    /// Rays start at a fixed distance off surfaces. For studies; the general kernel alone can do it.
    pub naive_offsets: bool,
    /// Light samples at the surface that the camera sees; their mean counts. At all others it is one.
    pub light_samples: u32,
    /// Paths that go on from the first vertex, for one ray of the camera.
    pub branches: Branches,
    /// Most scatterings by media.
    pub volume_limit: u32,
    /// The first bounce that Russian roulette may be played at; `u32::MAX` for none.
    pub roulette: u32,
}

/// So many paths go on from the first vertex and share what came before it. Several: in the general kernel alone.
#[derive(Clone, Copy, Debug)]
pub struct Branches {
    /// From a surface.
    pub at_surface: u32,
    /// From where a medium scatters.
    pub in_medium: u32,
}

impl Branches {
    /// The same everywhere.
    pub const fn all(count: u32) -> Self {
        Self {
            at_surface: count,
            in_medium: count,
        }
    }

    /// Whether it is more than one anywhere.
    #[inline(always)]
    pub fn are_several(&self) -> bool {
        self.at_surface.max(self.in_medium) > 1
    }
}

impl PathSettings {
    /// Weight of light that a BSDF sample found with density `previous.pdf`, and that light
    /// sampling finds with `light_pdf`.
    #[inline]
    pub(super) fn weight_of_found(&self, previous: &Previous, light_pdf: f32) -> f32 {
        if previous.only_bsdf || light_pdf <= 0.0 {
            1.0
        } else if light_pdf.is_infinite() {
            0.0 // Lights without shadows: sampled lights reach farther than rays.
        } else if !self.sample_lights {
            1.0
        } else if self.sample_bsdf {
            power_heuristic(previous.pdf, light_pdf)
        } else {
            0.0
        }
    }

    /// Surfaces that a shadow ray may pass from a path that has passed some.
    #[inline]
    pub(super) fn transparent_left(&self, passed: u32) -> u32 {
        if self.transparent == u32::MAX {
            u32::MAX
        } else {
            self.transparent.saturating_sub(passed)
        }
    }

    /// The least α that a surface is given after a path whose least density is `min_pdf`: a ray that
    /// came by a blurring bounce cannot tell a sharp highlight from a soft one, and the soft one is far
    /// less noisy. It changes the picture. Cycles' curve: ½ √(1 − p/x), nothing once p reaches x.
    #[inline]
    fn least_alpha(&self, min_pdf: f32) -> f32 {
        0.5 * (1.0 - min_pdf / self.filter_glossy).max(0.0).sqrt()
    }

    /// What the path changes about the next surface. As Cycles leaves caustics out, the kind of the ray decides, so that a
    /// reflection seen in a mirror stays.
    #[inline]
    pub(super) fn changes<E: Features>(
        &self,
        min_pdf: f32,
        previous: RayKind,
        diffused: bool,
    ) -> Changes {
        let mut changes = Changes::NONE;
        if E::EVERYTHING {
            changes.diffused = diffused;
        }
        if E::FACETS && self.filter_glossy > 0.0 {
            changes.least_alpha = self.least_alpha(min_pdf);
        }
        if E::FACETS && previous == RayKind::Diffuse {
            changes.caustics = self.caustics;
        }
        changes
    }

    /// Whether a surface takes one light sample.
    #[inline]
    pub(super) fn takes_one(&self, bounce: u32) -> bool {
        bounce > 0 || self.light_samples == 1
    }

    /// Weight of light that light sampling found.
    #[inline]
    pub(super) fn weight_of_sampled(&self, light_pdf: f32, delta: bool, bsdf_pdf: f32) -> f32 {
        if delta || !self.sample_bsdf {
            1.0 // Points and parallel light: nothing else finds them, whatever was asked for.
        } else if self.sample_lights {
            power_heuristic(light_pdf, bsdf_pdf)
        } else {
            0.0
        }
    }
}
