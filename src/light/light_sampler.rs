//! The choice of a finite light: among few by an estimate for each of them, among many by the tree.

use super::estimate::{Candidates, Choice, LightBounds, draw, weigh};
use super::lanes::LANES;
use super::tree::{self, GROUPS, Tree, WIDTH};
use glam::Vec3;

/// So many emitters are few: as many as a turn of the tree has.
pub const FEW: usize = WIDTH;

/// Draws one of the finite lights.
#[derive(Debug)]
pub enum LightSampler {
    /// Up to [`FEW`], by their numbers; and how many they are.
    Few(Vec<Candidates>, usize),
    /// More.
    Many(Tree),
}

impl Default for LightSampler {
    fn default() -> Self {
        Self::Few(Vec::new(), 0)
    }
}

/// Probabilities of lights, or of the largest clusters of them, at a point. They are made once for it: its light sample and the
/// densities of what its ray finds need the same ones.
#[derive(Clone, Copy, Debug)]
pub struct Pmf {
    /// Estimate of the irradiance by all of them.
    pub sum: f32,
    /// Probability of each.
    of: tree::TurnPmf,
}

impl Pmf {
    /// Where nothing is chosen.
    pub const NONE: Self = Self {
        sum: 0.0,
        of: [[0.0; LANES]; GROUPS],
    };
}

impl LightSampler {
    /// For emitters 0, 1, 2, …
    pub fn new(bounds: Vec<LightBounds>) -> Self {
        if bounds.len() <= FEW {
            let groups = bounds.chunks(LANES).map(Candidates::new).collect();
            Self::Few(groups, bounds.len())
        } else {
            Self::Many(Tree::new(&bounds))
        }
    }

    /// Whether there are no emitters.
    pub fn is_empty(&self) -> bool {
        match self {
            Self::Few(_, count) => *count == 0,
            Self::Many(tree) => tree.is_empty(),
        }
    }

    /// Looks at the emitters from a point. `compared`: their sum is asked for.
    #[inline]
    pub fn pmf(&self, point: Vec3, normal: Option<Vec3>, compared: bool) -> Pmf {
        let mut pmf = Pmf::NONE;
        self.pmf_into(&mut pmf, point, normal, compared);
        pmf
    }

    /// The same in place. What no emitter reads stays as it is.
    #[inline]
    pub fn pmf_into(&self, pmf: &mut Pmf, point: Vec3, normal: Option<Vec3>, compared: bool) {
        match self {
            Self::Few(_, 1) if !compared => pmf.of[0][0] = 1.0,
            Self::Few(groups, _) => pmf.sum = weigh(groups, (point, normal), &mut pmf.of),
            Self::Many(tree) => {
                (pmf.of, pmf.sum) = tree.look((point, normal));
            }
        }
    }

    /// Draws an emitter.
    #[inline]
    pub fn sample(&self, pmf: &Pmf, place: (Vec3, Option<Vec3>), u: f32) -> Option<Choice> {
        match self {
            Self::Few(groups, _) => {
                let probabilities = &pmf.of[..groups.len().min(GROUPS)];
                let (emitter, _) = draw(probabilities, f64::from(u))?;
                Some(Choice {
                    emitter: emitter as u32,
                    probability: probabilities.as_flattened()[emitter],
                })
            }
            Self::Many(tree) => tree.sample(&pmf.of, place, u),
        }
    }

    /// Probability with which [`Self::sample`] draws an emitter.
    #[inline]
    pub fn probability(&self, pmf: &Pmf, place: (Vec3, Option<Vec3>), emitter: u32) -> f32 {
        match self {
            Self::Few(..) => pmf.of.as_flattened()[emitter as usize % FEW],
            Self::Many(tree) => tree.probability(&pmf.of, place, emitter),
        }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/light_sampler.rs"]
mod tests;
