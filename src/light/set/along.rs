//! Which light a ray through a medium looks for, and light of one that was chosen so.

use super::{Drawn, Group, InfiniteLight, LightSet};
use crate::light::estimate::MOST;
use crate::light::kinds::{LightSample, LightSampleContext};
use crate::light::pivot::Pivot;
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

/// Of up to so many lights each is looked at along a ray through a medium.
const MOST_ALONG: usize = 16;

/// More are drawn as they are seen from places on the ray: parts of what is seen of it, each with its share. A light that shines to one
/// side of a plane shines on one of two ends or on nothing between them. The last one lets all but e⁻⁴ of the light be before it.
const PLACES: [(f32, f32); 3] = [(0.0, 0.3), (0.5, 0.4), (4.0, 0.2)];

/// A light that was drawn for places along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Along {
    /// Which.
    pub drawn: Drawn,
    /// With which probability.
    pub probability: f32,
    /// Where it is; none at infinity.
    pub pivot: Option<Pivot>,
}

impl LightSet {
    /// Draws a light for places along a ray (direction of length 1) up to an end, of which so much is `seen`. Among few lights by the
    /// light that falls on all of them, without what is on the way; among many as they are seen from some places. None where none
    /// shines on any of them.
    pub fn along(
        &self,
        at: &mut LightSampleContext,
        u: f32,
        (ray, end, seen): ((Vec3, Vec3), f32, f32),
    ) -> Option<Along> {
        let pivot = |drawn: Drawn| match drawn {
            Drawn::Finite(number) => self.lights[number as usize].bounds()?.pivot(ray, end),
            Drawn::Infinite(_) => None,
        };
        let finite = self.lights.len();
        let count = finite + self.infinite.len();
        if count > MOST_ALONG || at.receiver != 0 {
            let (drawn, probability) = self.draw_from_places(at, u, (ray, end, seen))?;
            let pivot = pivot(drawn);
            let shines = pivot.is_some() || matches!(drawn, Drawn::Infinite(_));
            return shines.then_some(Along {
                drawn,
                probability,
                pivot,
            });
        }
        let looked_for = |other: &InfiniteLight| other.estimate > 0.0;
        // One alone needs no comparison.
        let alone = finite == 1 && !self.infinite.iter().any(looked_for);
        let mut found: ArrayVec<(Drawn, f32, Option<Pivot>), MOST_ALONG> = ArrayVec::new();
        for number in 0..finite as u32 {
            let drawn = Drawn::Finite(number);
            if let Some(pivot) = pivot(drawn) {
                if alone {
                    return Some(Along {
                        drawn,
                        probability: 1.0,
                        pivot: Some(pivot),
                    });
                }
                let bounds = self.lights[number as usize].bounds();
                let intensity = bounds.map_or(0.0, |bounds| bounds.intensity);
                found.push((drawn, intensity * pivot.falls_on(ray, seen), Some(pivot)));
            }
        }
        for (i, other) in self.infinite.iter().enumerate() {
            if looked_for(other) {
                let drawn = Drawn::Infinite(i as u32);
                found.push((drawn, other.estimate * seen.min(end), None));
            }
        }
        found.retain(|(_, weight, _)| *weight > 0.0);
        let sum: f32 = found.iter().map(|(_, weight, _)| weight.min(MOST)).sum();
        // A part of it evenly, so that no estimate can starve a light.
        let even = 0.2 / found.len() as f32;
        let mut u = u;
        let last = found.len().checked_sub(1)?;
        for (i, (drawn, weight, pivot)) in found.into_iter().enumerate() {
            let probability = 0.8 * weight.min(MOST) / sum + even;
            if u < probability || i == last {
                return probability.is_finite().then_some(Along {
                    drawn,
                    probability,
                    pivot,
                });
            }
            u -= probability;
        }
        None
    }

    /// Draws a light as it is seen from one of [`PLACES`], or any of them: what no place sees may shine on the ray elsewhere.
    fn draw_from_places(
        &self,
        at: &mut LightSampleContext,
        mut u: f32,
        ((origin, direction), end, seen): ((Vec3, Vec3), f32, f32),
    ) -> Option<(Drawn, f32)> {
        let seen = if seen.is_finite() { seen } else { 0.0 };
        let place = |part: f32| origin + direction * (part * seen).min(end);
        let mut drawn = None;
        for (part, share) in PLACES {
            if u < share {
                self.context_into(at, place(part), None);
                drawn = Some(self.draw(at, u / share)?.0);
                break;
            }
            u -= share;
        }
        let of_any = 1.0 - PLACES.iter().map(|(_, share)| share).sum::<f32>();
        let (finite, count) = (self.lights.len(), self.lights.len() + self.infinite.len());
        let drawn = drawn.unwrap_or_else(|| {
            let number = ((u / of_any * count as f32) as usize).min(count - 1);
            match number.checked_sub(finite) {
                Some(infinite) => Drawn::Infinite(infinite as u32),
                None => Drawn::Finite(number as u32),
            }
        });
        let mut probability = of_any / count as f32;
        for (part, share) in PLACES {
            self.context_into(at, place(part), None);
            probability += share * self.drawn_probability(at, drawn);
        }
        Some((drawn, probability))
    }

    /// The middle of a light, drawn by what lights give to a place. None of one at infinity.
    pub fn near(&self, at: &LightSampleContext, u: f32) -> Option<Vec3> {
        match self.draw(at, u)?.0 {
            Drawn::Finite(number) => Some(self.lights[number as usize].bounds()?.center()),
            Drawn::Infinite(_) => None,
        }
    }

    /// Probability with which a light is drawn from a place.
    #[inline]
    pub(super) fn drawn_probability(&self, at: &LightSampleContext, drawn: Drawn) -> f32 {
        match drawn {
            Drawn::Finite(number) => self.probability(at, number),
            Drawn::Infinite(i) => self.group_probability(Group::Infinite(i as usize), at),
        }
    }

    /// Draws a direction to a light that was drawn with a probability elsewhere. The density that is told is the one of
    /// [`Self::sample`] at the point, by which it counts beside what other techniques find.
    pub fn sample_drawn(
        &self,
        at: &LightSampleContext,
        (drawn, probability): (Drawn, f32),
        u: Vec2,
    ) -> Option<LightSample> {
        let here = self.told_probability(at, drawn);
        if at.receiver != 0 && !self.reaches(self.source(drawn), at.receiver) {
            return None;
        }
        self.light(drawn)
            .sample_li(at, u)?
            .chosen_elsewhere(probability, here)
    }
}
