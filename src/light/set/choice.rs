//! How often each light is drawn, where that is not by what it gives to a place.

use super::{InfiniteLight, LightSet, is_even};
use crate::light::estimate::{Angle, LightBounds};
use crate::light::kinds::{Light, LightSampleContext};
use crate::light::set::Drawn;
use crate::light::two_bounds::{Emitter, Receiver, TwoBounds};
use glam::Vec3;

/// How finite lights are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightChoice {
    /// By what they give to the point at most.
    Place,
    /// By their power alone.
    Power,
    /// By place, but each sample counts as if surfaces were drawn by their areas and all others evenly.
    Even,
    /// By place, but each sample counts as if it were drawn as by Cycles' Light Tree.
    Tree,
}

/// How often Cycles draws each light, where samples are to count as if they were drawn so.
pub(super) enum AsCycles {
    /// With its Light Tree.
    Tree(TwoBounds),
    /// Without: the same everywhere.
    Even {
        /// Of finite lights …
        finite: Vec<f32>,
        /// … and of those at infinity.
        infinite: Vec<f32>,
    },
}

impl AsCycles {
    /// The probability of a light at a place.
    #[inline]
    pub(super) fn probability(&self, at: impl FnOnce() -> Receiver, light: Drawn) -> f32 {
        match (self, light) {
            (Self::Tree(tree), light) => tree.probability(&at(), light),
            (Self::Even { finite, .. }, Drawn::Finite(number)) => finite[number as usize],
            (Self::Even { infinite, .. }, Drawn::Infinite(number)) => infinite[number as usize],
        }
    }
}

/// Makes all lights of a tree look as if they stood in the same place and shone everywhere, so that they are drawn by their
/// power alone. One is left as it is: the estimate for all of them is weighed against the sky's.
pub(super) fn by_power(bounds: &mut [LightBounds]) {
    let [first, rest @ ..] = &*bounds else {
        return;
    };
    if rest.is_empty() {
        return;
    }
    let (min, max) = rest.iter().fold((first.min, first.max), |(min, max), b| {
        (min.min(b.min), max.max(b.max))
    });
    for b in bounds {
        *b = LightBounds {
            min,
            max,
            intensity: b.intensity,
            axis: Vec3::Z,
            normals: Angle::ALL,
            cos_emission: 0.0,
            two_sided: true,
            front: None,
        };
    }
}

impl LightSet {
    /// Half of the light samples go to surfaces that emit, by their areas, and the other half evenly to all others: Cycles without
    /// its Light Tree. `None` where there is no choice.
    pub(super) fn evenly(&self) -> Option<AsCycles> {
        let area: f64 = (self.lights.iter().filter_map(Light::surface_area))
            .map(f64::from)
            .sum();
        let is_looked_for = |other: &InfiniteLight| other.estimate > 0.0;
        let distant = self.infinite.iter().filter(|o| is_looked_for(o)).count();
        let others = self.rules.len() + distant;
        let of_surfaces = match others {
            0 => 1.0,
            _ if area > 0.0 => 0.5,
            _ => 0.0,
        };
        let each = ((1.0 - of_surfaces) / others.max(1) as f64) as f32;
        let of_finite = |light: &Light| match light.surface_area() {
            Some(part) => (of_surfaces * f64::from(part) / area) as f32,
            None => each,
        };
        let of_infinite = |other| if is_looked_for(other) { each } else { 0.0 };
        (self.lights.len() + distant > 1).then(|| AsCycles::Even {
            finite: self.lights.iter().map(of_finite).collect(),
            infinite: self.infinite.iter().map(of_infinite).collect(),
        })
    }

    /// Of the density of a sample, the one that it has in Cycles, where that is known.
    #[cold]
    pub fn density_in_cycles(&self, at: &LightSampleContext, light: Drawn, density: f32) -> f32 {
        match self.as_cycles.as_deref() {
            Some(cycles) if self.as_cycles_at(at).is_none() => {
                let drawn = self.drawn_probability(at, light);
                if drawn <= 0.0 {
                    return density;
                }
                density / drawn * cycles.probability(|| at.receiver_in_tree(), light)
            }
            _ => density,
        }
    }

    /// Whether all of a light is behind the surface's normal. Cycles' Light Tree does not draw it, so that rays alone count: they may find
    /// it where a lobe has a normal of its own beside a displacement that is a bump.
    pub(super) fn is_behind(&self, at: &LightSampleContext, light: Drawn) -> bool {
        let (Some((normal, false)), Some(balls)) = (at.facing, &self.balls) else {
            return false;
        };
        let ball = match light {
            Drawn::Finite(number) => balls.get(number as usize),
            Drawn::Infinite(_) => None,
        };
        self.light(light).is_behind(ball, (at.point, normal))
    }

    /// None of the light samples goes to a sky of one colour, as in Cycles. BSDF sampling finds it as well or better: half of the sphere is
    /// below the surface, and in a room such samples end at the walls.
    pub(super) fn leave_even_sky_to_bsdf(&mut self) {
        for sky in &mut self.infinite {
            if is_even(&sky.light) && !sky.rules.only_sampled() {
                sky.estimate = 0.0;
            }
        }
    }

    /// How often Cycles' Light Tree draws each light; `None` where there is no choice.
    pub(super) fn by_tree(&self) -> Option<AsCycles> {
        let (mut lamps, mut meshes) = (Vec::new(), Vec::<Vec<Emitter>>::new());
        let mut last = None;
        for (number, light) in (0..).zip(&self.lights) {
            let emitter = light.in_tree(Drawn::Finite(number));
            match light.object() {
                None => lamps.extend(emitter),
                object => {
                    if object != last {
                        meshes.push(Vec::new());
                        last = object;
                    }
                    if let Some(mesh) = meshes.last_mut() {
                        mesh.extend(emitter);
                    }
                }
            }
        }
        let looked_for = (0..)
            .zip(&self.infinite)
            .filter(|(_, other)| other.estimate > 0.0);
        let distant = looked_for.filter_map(|(i, other)| other.light.in_tree(Drawn::Infinite(i)));
        let distant: Vec<_> = distant.collect();
        let counts = (self.lights.len(), self.infinite.len());
        (counts.0 + distant.len() > 1)
            .then(|| AsCycles::Tree(TwoBounds::new(&lamps, &meshes, &distant, counts)))
    }
}
