//! How wide a path has become by what has scattered it.
//!
//! Cycles filters bumps so from 5.2 on: a ray that a rough surface scatters stands for all directions around it. Roughness is
//! the mean of the lobes' at that direction, weighted by their densities; Filter Glossy below 1 takes less of it.

use super::{KernelBsdf, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::Record;
use crate::math::average;
use crate::shading::BsdfSample;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// The path is scattered by a surface at a distance.
    #[inline(always)]
    pub(super) fn widen(&mut self, distance: f32, bsdf: &KernelBsdf<E>, sample: &BsdfSample) {
        if E::FACETS && !sample.delta {
            let filters = self.settings.filter_glossy > 0.0;
            let pdf = if filters {
                bsdf.pdf_of_all_facets(sample)
            } else {
                sample.pdf
            };
            self.min_pdf = self.min_pdf.min(pdf * self.share_of_scattering(bsdf));
        }
        if E::EVERYTHING
            && let Some(pixel) = self.world.widened()
        {
            let roughness = if sample.delta {
                0.0
            } else {
                bsdf.roughness_towards(sample.wi)
            };
            self.widen_by((distance, pixel), roughness);
        }
    }

    /// How often Cycles draws a direction at all where some of what arrives passes straight on: that is a lobe among others there.
    #[inline(always)]
    fn share_of_scattering(&self, bsdf: &KernelBsdf<E>) -> f32 {
        match &self.beside.stopped {
            Some(stopped) if E::EVERYTHING && stopped.passing != 0.0 => {
                let scattered = average(bsdf.albedo());
                scattered / (scattered + stopped.passing)
            }
            _ => 1.0,
        }
    }

    /// The path is scattered at a distance, with a roughness; `pixel`: the angle of one.
    pub(super) fn widen_by(&mut self, (distance, pixel): (f32, f32), roughness: f32) {
        let share = self.settings.filter_glossy.min(1.0);
        let beside = &mut *self.beside;
        let distance = beside.walked + distance;
        beside.wide = beside.wide.scattered(distance, share * roughness - pixel);
    }
}
