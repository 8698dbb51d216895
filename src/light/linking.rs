//! Light linking and shadow linking, as Cycles has them: which objects a light reaches, and which of them cast its shadows.
//!
//! Each set of receivers has a choice between lights of its own, in which those that do not reach it are black. Blockers are
//! told apart by Embree's masks of rays.

use super::Source;
use super::estimate::LightBounds;
use super::light_sampler::LightSampler;
use crate::scene::{Links, Scene};
use std::collections::BTreeSet;

/// What a light is linked to.
#[derive(Clone, Copy, Debug)]
struct LinkedTo {
    /// Sets of receivers, by their bits.
    receivers: u64,
    /// Mask of the rays that look for its blockers, if those are not all objects.
    blockers: Option<u32>,
}

impl LinkedTo {
    fn of(links: &Links) -> Self {
        Self {
            receivers: links.lit_sets,
            blockers: links.mask_of_blockers(),
        }
    }
}

/// The lights as a set of receivers has them.
#[derive(Debug)]
pub(super) struct Receivers {
    /// Its bit.
    bit: u64,
    pub sampler: LightSampler,
    /// Estimates of the lights at infinity.
    pub infinite: Vec<f32>,
}

/// All links of a scene, by the numbers of what shines and of objects.
#[derive(Debug)]
pub struct Linking {
    /// Of the scene's lights.
    lights: Vec<LinkedTo>,
    /// Of the instances with triangles, as the world counts objects.
    surfaces: Vec<LinkedTo>,
    /// By object, which of `receivers` it is in, from 1 on.
    receiver_of: Vec<u8>,
    receivers: Vec<Receivers>,
    /// Some light has blockers of its own.
    pub(super) has_blockers: bool,
}

impl Linking {
    /// Of a scene; `None` where all lights light all, and all objects cast shadows.
    pub fn of(scene: &Scene) -> Option<Self> {
        let lamps = || scene.lights.iter().map(|light| &light.links);
        let objects = || {
            let placed = scene.instances.iter();
            let placed = placed.filter(|instance| scene.has_triangles(instance));
            placed.map(|instance| &instance.info.links)
        };
        if !lamps().chain(objects()).any(Links::is_linked) {
            return None;
        }
        let lights: Vec<_> = lamps().map(LinkedTo::of).collect();
        let surfaces: Vec<_> = objects().map(LinkedTo::of).collect();
        let sets: BTreeSet<u8> = objects().map(|links| links.receiver_set).collect();
        // At most 64 of them.
        let place = |links: &Links| sets.range(..=links.receiver_set).count() as u8;
        let receivers = sets.iter().map(|set| Receivers {
            bit: 1 << set,
            sampler: LightSampler::default(),
            infinite: Vec::new(),
        });
        let mut all = lights.iter().chain(&surfaces);
        Some(Self {
            has_blockers: all.any(|linked| linked.blockers.is_some()),
            receiver_of: objects().map(place).collect(),
            receivers: receivers.collect(),
            lights,
            surfaces,
        })
    }

    /// Makes the choices of all receivers, from finite lights and those at infinity with their numbers among the scene's lights.
    pub(super) fn prepare(
        &mut self,
        finite: &[(Source, Option<u32>, LightBounds)],
        infinite: &[(Source, Option<u32>, f32)],
    ) {
        let mut receivers = std::mem::take(&mut self.receivers);
        for set in &mut receivers {
            let reaches = |source, in_scene| {
                self.linked(source, in_scene)
                    .is_none_or(|l| l.receivers & set.bit != 0)
            };
            let bounds = finite
                .iter()
                .map(|&(source, in_scene, bounds)| LightBounds {
                    intensity: if reaches(source, in_scene) {
                        bounds.intensity
                    } else {
                        0.0
                    },
                    ..bounds
                });
            set.sampler = LightSampler::new(bounds.collect());
            let estimates = infinite.iter().map(|&(source, in_scene, estimate)| {
                if reaches(source, in_scene) {
                    estimate
                } else {
                    0.0
                }
            });
            set.infinite = estimates.collect();
        }
        self.receivers = receivers;
    }

    fn linked(&self, source: Source, in_scene: Option<u32>) -> Option<&LinkedTo> {
        match source {
            Source::Surface(number) => self.surfaces.get(number as usize),
            Source::Lamp(_) | Source::Sun(_) => self.lights.get(in_scene? as usize),
            Source::Environment => None,
        }
    }

    /// The receivers that an object is one of, from 1 on.
    pub(super) fn receiver(&self, object: u32) -> u8 {
        self.receiver_of.get(object as usize).copied().unwrap_or(0)
    }

    /// A set of receivers.
    pub(super) fn receivers(&self, number: u8) -> Option<&Receivers> {
        self.receivers.get(usize::from(number).checked_sub(1)?)
    }

    /// Whether a light reaches a set of receivers; the camera sees all.
    pub(super) fn reaches(&self, source: Source, in_scene: Option<u32>, receiver: u8) -> bool {
        let (set, linked) = (self.receivers(receiver), self.linked(source, in_scene));
        match (set, linked) {
            (Some(set), Some(linked)) => linked.receivers & set.bit != 0,
            _ => true,
        }
    }

    /// Mask of the rays that look for a light's blockers, if it has some of its own.
    pub(super) fn blockers(&self, source: Source, in_scene: Option<u32>) -> Option<u32> {
        self.linked(source, in_scene)?.blockers
    }
}
