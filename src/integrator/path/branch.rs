//! Several ways on from the first vertex of a path: where light that comes by many scatterings makes most of the noise, they share
//! the ray of the camera and the light that falls on what it meets (splitting: Arvo and Kirk, *Particle Transport and Image
//! Synthesis*, 1990, section 4; the best number follows from what both parts cost and how much they vary).

use super::Walk;
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::accumulator::Accumulator;
use crate::integrator::record::Record;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
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
