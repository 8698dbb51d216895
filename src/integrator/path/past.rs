//! What is known of the way that a path has come.

use super::{Beside, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::Record;
use crate::world::{Past, RayKind};

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// What programs may ask about its past: only the general kernel has any.
    #[inline(always)]
    pub(super) fn past(&self) -> Past {
        if !E::EVERYTHING {
            return Past::UNKNOWN;
        }
        let least = |count: u32| count.min(255) as u8;
        let Beside {
            previous,
            scatterings: [diffuse, glossy, transmission],
            portals,
            ..
        } = &*self.beside;
        Past {
            depths: [*diffuse, *glossy, *transmission, self.counted(), *portals].map(least),
            singular: previous.delta,
            reflected: self.bounce > 0 && previous.kind != RayKind::Transmission,
            // As in Cycles.
            blurry: self.min_pdf < 8.0,
            way: self.beside.way,
            wide: self.beside.wide,
            wavelength: self.beside.wavelength,
            other_side: self.beside.other_side.index,
            also: previous.at.also,
            numbers: (self.world.traces()).then_some((*self.sampler, self.bounce)),
            left: self.beside.left,
        }
    }

    /// Transparent surfaces that it has passed. As in Cycles, those that only bound a medium do not count.
    #[inline(always)]
    pub(super) fn counted(&self) -> u32 {
        if E::EVERYTHING {
            self.passed - self.beside.bounds
        } else {
            self.passed
        }
    }

    /// Surfaces that a shadow ray from it may pass.
    #[inline(always)]
    pub(super) fn transparent_left(&self) -> u32 {
        self.settings.transparent_left(self.counted())
    }
}
