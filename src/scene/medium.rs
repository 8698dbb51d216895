//! What fills a closed mesh or all space.

use super::graph::Graph;
use super::validate::clean_graph;
use super::{Diagnostics, Effect, Verdict};
use crate::math::single_scattering_albedo;
use glam::Vec3;

/// A medium: what it takes, scatters and emits over a metre.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Medium {
    /// Absorption coefficient, 1/m.
    pub absorption: [f32; 3],
    /// Emitted radiance over length, W·sr⁻¹·m⁻³.
    pub emission: [f32; 3],
    /// What scatters; the sum counts.
    pub scatterers: Vec<Scatterer>,
    /// What varies and is there as well: a node tree, by its volume.
    pub varying: Option<Box<Graph>>,
}

/// One kind of particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatterer {
    /// Scattering coefficient, 1/m.
    pub coefficient: [f32; 3],
    /// Where to.
    pub phase: Phase,
}

/// How light is spread by a scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Henyey and Greenstein's, of a mean cosine, below 1 in magnitude; 0 is even.
    HenyeyGreenstein(f32),
    /// Of particles smaller than the wavelength.
    Rayleigh,
    /// Draine's: of dust.
    Draine {
        /// Of the part by Henyey and Greenstein, below 1 in magnitude.
        anisotropy: f32,
        /// How much more goes straight on and back.
        alpha: f32,
    },
    /// Fournier and Forand's: of what floats in water.
    FournierForand {
        /// Its index of refraction.
        ior: f32,
        /// The share that goes back.
        backscatter: f32,
    },
    /// Mie's: of droplets, by their diameter in µm.
    Mie(f32),
}

impl Medium {
    /// That takes light and does nothing else: of white light so much of it is left after a distance.
    pub fn absorbing(color: [f32; 3], distance: f32) -> Self {
        // Black would take all of it at once, and white takes none, however short the distance.
        let coefficient = |c: f32| match -c.clamp(f32::MIN_POSITIVE, 1.0).ln() {
            depth if depth > 0.0 => depth / distance,
            _ => 0.0,
        };
        Self {
            absorption: color.map(coefficient),
            ..Self::default()
        }
    }

    /// The same, but that it scatters what it takes, with a mean cosine, so that a thick one gives back a colour.
    #[must_use]
    pub fn scattering_back(self, color: [f32; 3], g: f32) -> Self {
        let albedo = single_scattering_albedo(color.map(|c| c.clamp(0.0, 1.0)).into(), g);
        let albedo = albedo.clamp(Vec3::ZERO, Vec3::ONE);
        let extinction = Vec3::from(self.absorption);
        let scatterer = Scatterer {
            coefficient: (extinction * albedo).into(),
            phase: Phase::HenyeyGreenstein(g),
        };
        Self {
            absorption: (extinction * (Vec3::ONE - albedo)).into(),
            scatterers: vec![scatterer],
            ..self
        }
    }

    /// Which effect it is; none where light crosses it as if there were nothing.
    pub fn effect(&self) -> Option<Effect> {
        let takes = |medium: &Self| medium.absorption.iter().any(|&c| c != 0.0);
        let scatters = self.scatterers.iter().flat_map(|s| &s.coefficient);
        if self.varying.is_some() {
            return Some(Effect::Media);
        }
        if self.emission.iter().chain(scatters).any(|&c| c != 0.0) {
            Some(Effect::Media)
        } else {
            takes(self).then_some(Effect::Absorption)
        }
    }

    /// Makes all numbers finite and legal; whether some were not.
    pub fn clean(&mut self) -> bool {
        let mut bad = false;
        let mut clean = |c: &mut f32, least: f32| {
            // Times the greatest distance that is not infinite, 1e8 m, it is a number still.
            let legal = if c.is_nan() {
                0.0
            } else {
                c.clamp(least, 1e30)
            };
            bad |= legal != *c;
            *c = legal;
        };
        let scatters = self.scatterers.iter_mut().flat_map(|s| &mut s.coefficient);
        for c in self.absorption.iter_mut().chain(scatters) {
            clean(c, 0.0);
        }
        for c in &mut self.emission {
            clean(c, -1e30);
        }
        for scatterer in &mut self.scatterers {
            bad |= scatterer.phase.clean();
        }
        bad
    }
}

impl Phase {
    /// Makes its numbers legal, which Cycles' limits say; whether some were not finite or far off.
    fn clean(&mut self) -> bool {
        let mut bad = false;
        let mut legal = |value: &mut f32, (least, most, otherwise): (f32, f32, f32)| {
            bad |= !value.is_finite();
            *value = if value.is_finite() {
                value.clamp(least, most)
            } else {
                otherwise
            };
        };
        let g = (-MOST_G, MOST_G, 0.0);
        match self {
            Self::HenyeyGreenstein(value) => {
                let was_far = value.abs() > 1.0;
                legal(value, g);
                bad |= was_far;
            }
            Self::Rayleigh => {}
            Self::Draine { anisotropy, alpha } => {
                legal(anisotropy, g);
                legal(alpha, (0.0, 1e6, 0.0));
            }
            Self::FournierForand { ior, backscatter } => {
                legal(ior, (1.0 + 1e-3, 1e3, 1.33));
                legal(backscatter, (0.0, 0.5 - 1e-3, 0.1));
            }
            Self::Mie(diameter) => legal(diameter, (0.0, 1e3, 20.0)),
        }
        bad
    }
}

/// As in Cycles: beyond it the phase function is a needle that f32 cannot tell from the straight way.
const MOST_G: f32 = 1.0 - 1e-3;

/// Makes the numbers of a volume legal, and cleans its node tree; tells what was not.
pub(super) fn clean(
    mut medium: Option<&mut Medium>,
    images: usize,
    owner: &str,
    diagnostics: &mut Diagnostics,
) {
    if medium.as_deref_mut().is_some_and(Medium::clean) {
        diagnostics.report_effect(
            Effect::Media,
            "volume-range",
            Verdict::Approximated,
            "volume with numbers outside of their legal range",
            owner,
            "the nearest legal number is used",
        );
    }
    if let Some(graph) = medium.and_then(|medium| medium.varying.as_mut()) {
        clean_graph(graph, images, owner, diagnostics);
    }
}
