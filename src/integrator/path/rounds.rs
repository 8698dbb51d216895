//! Notices a ray that goes straight on and yet meets the same surfaces over and over.
//!
//! A ray leaves a surface by the bound of its point's error in the world. Where an object is so flat and so long that its inverse
//! transform loses all digits of an f32, Embree may see that start before the surface again, and never come past it.

use crate::world::Hit;

/// A surface that is met more often than this on one straight way goes round: a sphere is met twice, and so is a strand.
const MOST_MET: u32 = 4;
/// Surfaces that are passed before another one is marked: doubled each time, so that circles of any length are noticed.
const LEAST_SPAN: u32 = 16;

/// What tells a surface from others: its primitive, its geometry and the instance.
type Surface = (u32, u32, Option<u32>);

/// Surfaces that a path passes, as far as they have to be known: one of them (Brent's way to find a circle).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounds {
    /// One that was passed, after which bounce, and how often it was met since.
    mark: Option<(u32, Surface)>,
    met: u32,
    /// So many are passed until another one is marked, of so many.
    left: u32,
    span: u32,
    /// The bounce after which the ray has gone round.
    round: Option<u32>,
}

impl Rounds {
    fn surface(hit: &Hit) -> Surface {
        (hit.primitive, hit.geometry, hit.instance)
    }

    /// Whether a ray that has met a surface since a bounce goes round. It is told so once.
    #[inline]
    pub fn comes_back(&mut self, hit: &Hit, bounce: u32) -> bool {
        if self.mark != Some((bounce, Self::surface(hit))) || self.goes_round(bounce) {
            return false;
        }
        self.met += 1;
        if self.met < MOST_MET {
            return false;
        }
        self.round = Some(bounce);
        true
    }

    /// A surface is passed. Whether the ray is to go on from where it began, since starts behind its surfaces are not to be trusted.
    #[inline]
    pub fn passes(&mut self, hit: &Hit, bounce: u32) -> bool {
        if self.left == 0 {
            self.mark = Some((bounce, Self::surface(hit)));
            self.met = 0;
            self.span = self.span.saturating_mul(2).max(LEAST_SPAN);
            self.left = self.span;
        }
        self.left -= 1;
        self.goes_round(bounce)
    }

    fn goes_round(&self, bounce: u32) -> bool {
        self.round == Some(bounce)
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/integrator/path/rounds.rs"]
mod tests;
