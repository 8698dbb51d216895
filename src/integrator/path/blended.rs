//! Light samples at surfaces that a path may pass by chance.
//!
//! A path that stops there brings the light of a light sample, and so does one that passes: by the share of the surface that scatters.
//! Cycles does the same. With those that stop alone a floor of which half is there has twice the noise of one that is whole.

use super::{Found, KernelBsdf, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::{Record, Step};
use crate::sampler::Sampler;
use crate::world::{Hit, Past, Scratch, Surface, Wanted};

/// Tells the numbers of light samples behind surfaces that a path has passed from those before them.
const LIT_BEHIND: u32 = 0x_3b1e_4ded;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Whether paths that pass a surface by chance take its light, too. Not where one light sample for each path that stops is asked for
    /// by what stands on it: catchers split what they bring, portals send it elsewhere, and on faces that lie in one place a number says
    /// which is met.
    fn lights_in_passing(&self, hit: &Hit) -> bool {
        let world = self.world;
        !self.last && !world.has_portals() && !world.has_lids() && !world.is_catcher(hit)
    }

    /// What of the light samples' light a path that has stopped here brings: the rest comes by those that pass.
    #[inline(always)]
    pub(super) fn lit(&self, hit: &Hit) -> f32 {
        if !E::EVERYTHING || self.beside.passing == 0.0 || !self.lights_in_passing(hit) {
            return 1.0;
        }
        1.0 / (1.0 + self.beside.passing)
    }

    /// The numbers of light samples here.
    #[inline(always)]
    pub(super) fn light_numbers(&self) -> Sampler {
        match self.tints() {
            0 => *self.sampler,
            tints => self.sampler.beside(LIT_BEHIND.wrapping_add(tints)),
        }
    }

    /// Adds the lobes of a surface, in place: a BSDF is too large to be handed over.
    #[inline(always)]
    pub(super) fn add_lobes(&mut self, bsdf: &mut KernelBsdf<E>, surface: &mut Surface) {
        match &mut surface.mixed {
            Some(mixed) if E::EVERYTHING => {
                mixed.add_to(bsdf, surface.normals.smooth);
                self.beside.lobes_left_out += bsdf.left_out();
            }
            _ => {
                let frame = (surface.normals.shading, None);
                bsdf.add_principled(1.0, surface.principled(), surface.dielectrics, frame);
            }
        }
        bsdf.finish();
    }

    /// Takes the light of a light sample at a surface that the path passes, of which the share `rest` scatters.
    #[cold]
    #[inline(never)]
    pub(super) fn add_light_in_passing(&mut self, found: &Found, rest: f32) {
        if rest <= 0.0 || !self.lights_in_passing(&found.hit) {
            return;
        }
        let world = self.world;
        let past = self.past();
        let asking = self.asking(&found.hit, &past);
        let mut scratch = Scratch::default();
        let at = (self.origin, asking);
        let mut surface = world.surface::<E>(&found.hit, at, Wanted::Lobes, &mut scratch);
        if surface.is_unlit() {
            return;
        }
        let mut bsdf = self.bare(&surface);
        self.add_lobes(&mut bsdf, &mut surface);
        let mut throughput = self.throughput * rest;
        if (surface.disperses || self.beside.other_side.disperses)
            && let Some(counts) = self.beside.counts
        {
            // Its light is of one wavelength, as that of paths that stop; what passes is not.
            throughput *= counts;
        }
        if self.bounce == 0 {
            self.light.sink.first_colors(throughput, || bsdf.colors());
        }
        if !bsdf.is_samplable() {
            return;
        }
        self.light.sink.step(|| Step::met(&found.hit, &surface));
        let past = Past {
            left: world.strand_of(&found.hit),
            ..past
        };
        // What its ray finds afterwards is weighted by where the path was scattered last.
        let before = self.beside.previous.at;
        self.receive(&found.hit, surface.point.point, bsdf.receiving());
        let numbers = self.light_numbers();
        let (scene, met) = ((world, self.settings), (&found.hit, &surface));
        let way = (throughput, self.bounce, self.passed);
        let vertex = self.beside.vertex::<E>(scene, met, (&bsdf, &past), way);
        self.rays += vertex.add_direct_light(&numbers, self.light);
        self.beside.previous.at = before;
    }
}
