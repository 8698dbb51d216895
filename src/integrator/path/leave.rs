//! How a path leaves a vertex. From the first one several may go on: where light that comes by many scatterings makes most of the
//! noise, they share the ray of the camera and the light that falls on what it meets (splitting: Arvo and Kirk, *Particle Transport
//! and Image Synthesis*, 1990). The best number follows from what both parts cost and how much they vary.

use super::{KernelBsdf, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::accumulator::Accumulator;
use crate::integrator::record::Record;
use crate::sampler::Sampler;
use crate::world::{Hit, Surface};

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Goes on from a surface; whether the path has not ended.
    #[inline(always)]
    pub(super) fn leave(&mut self, hit: &Hit, surface: &Surface, bsdf: &KernelBsdf<E>) -> bool {
        match self.below(bsdf) {
            Some(below) => self.go_below(hit, surface, &below),
            None => self.leave_by((hit, surface), bsdf, self.sampler),
        }
    }

    /// The same above it, by the numbers of a sampler.
    #[inline(always)]
    pub(super) fn leave_by(
        &mut self,
        (hit, surface): (&Hit, &Surface),
        bsdf: &KernelBsdf<E>,
        sampler: &Sampler,
    ) -> bool {
        let Some(sample) = self.sample(bsdf, sampler) else {
            return false;
        };
        self.widen(hit.distance, bsdf, &sample);
        if !self.follow(hit, surface, &sample) {
            return false;
        }
        if E::EVERYTHING && self.world.lights.is_shadow_linked() {
            self.add_shadow_linked();
        }
        true
    }

    /// Whether several paths go on from here.
    #[inline(always)]
    pub(super) fn is_to_branch(&self) -> bool {
        self.bounce == 0 && self.settings.branches > 1 && self.light.branches == 1
    }

    /// Goes on several times by numbers of their own, and to their ends: what each finds counts by its share.
    #[cold]
    #[inline(never)]
    pub(super) fn branch(&mut self, mut leave: impl FnMut(&mut Walk<'_, '_, E, A>) -> bool) {
        let branches = self.settings.branches;
        for number in 0..branches {
            let sampler = self.sampler.part(number, branches);
            let mut beside = self.beside.clone();
            self.light.sink.branch(number);
            let mut light = Accumulator {
                radiance: self.light.radiance,
                clamped: self.light.clamped,
                counts: self.light.counts,
                branches,
                sink: &mut *self.light.sink,
            };
            let mut path = Walk {
                sampler: &sampler,
                light: &mut light,
                beside: &mut beside,
                rays: 0,
                ..*self
            };
            if leave(&mut path) {
                path.go_apart();
            }
            self.rays += path.rays;
            self.beside.lobes_left_out = beside.lobes_left_out;
            (self.light.radiance, self.light.clamped) = (light.radiance, light.clamped);
        }
    }

    /// The loop again, which does not branch.
    #[inline(never)]
    fn go_apart(&mut self) {
        self.go();
    }
}
