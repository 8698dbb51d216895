//! Light samples at surfaces that a path may pass by chance.
//!
//! A path that stops there brings the light of a light sample, and so does one that passes: by the share of the surface that scatters.
//! Cycles does the same. With those that stop alone a floor of which half is there has twice the noise of one that is whole.

use super::{Found, KernelBsdf, Passing, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::film::objects::FirstObject;
use crate::integrator::PathSettings;
use crate::integrator::record::{Record, Step};
use crate::math::average;
use crate::sampler::Sampler;
use crate::world::{Hit, Past, Scratch, Surface, Wanted};
use glam::Vec3;

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
        match &self.beside.stopped {
            Some(stopped)
                if E::EVERYTHING && stopped.passing != 0.0 && self.lights_in_passing(hit) =>
            {
                1.0 / (1.0 + stopped.passing)
            }
            _ => 1.0,
        }
    }

    /// What the path has brought to the surface where it has stopped, and what passes that, as a colour.
    #[inline(always)]
    pub(super) fn brought(&self) -> (Vec3, Vec3) {
        match &self.beside.stopped {
            Some(stopped) if E::EVERYTHING => (stopped.brought, stopped.passes),
            _ => (self.throughput, Vec3::ZERO),
        }
    }

    /// What of that light comes from what is there of the surface. Paths that pass bring as much, so that it is no matter how likely
    /// it was to stop.
    #[inline(always)]
    pub(super) fn there(&self) -> Vec3 {
        let (brought, passes) = self.brought();
        brought * alpha(passes)
    }

    /// Notes for passes of data what the camera sees. As in Cycles (kernel/film/data_passes.h), each surface counts for mattes and
    /// mist by how much of it is there; normals and texture coordinates are those of the first of which enough is.
    #[inline(always)]
    pub(super) fn note(&mut self, hit: &Hit, surface: &Surface, brought: Vec3, passes: Vec3) {
        if !self.beside.is_noted && is_enough(self.settings, passes) {
            self.beside.is_noted = true;
            self.first.normal = surface.normals.shading;
            let world = self.world;
            self.light
                .sink
                .first_surface(|| world.texture_coordinates(hit));
        }
        self.note_object(hit, surface.point.point, (brought, passes));
    }

    #[inline(always)]
    fn note_object(&mut self, hit: &Hit, point: Vec3, (brought, passes): (Vec3, Vec3)) {
        let world = self.world;
        self.light.sink.first_object(|| FirstObject {
            number: hit.object(),
            weight: average(brought) * (1.0 - average(passes)),
            there: average(brought * alpha(passes)),
            distance: world.camera.distance(point),
            open: Vec3::ZERO,
        });
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

    /// What a surface that the path passes brings: the light of a light sample, by the share of it that scatters, and what passes of
    /// data are told.
    #[cold]
    #[inline(never)]
    pub(super) fn pass_by(&mut self, found: &Found, passing: &Passing) {
        let (brought, passes, rest) = (self.throughput, passing.passes, passing.rest);
        let is_lit = rest > 0.0 && self.lights_in_passing(&found.hit);
        let is_first = self.bounce == 0;
        let is_to_note = is_first && !self.beside.is_noted && is_enough(self.settings, passes);
        let opens = is_first && self.light.sink.asks_occlusion() && alpha(passes) != Vec3::ZERO;
        if !(is_lit || is_to_note || opens) {
            if is_first {
                let point = self.origin + self.direction * found.hit.distance;
                self.note_object(&found.hit, point, (brought, passes));
            }
            return;
        }
        let world = self.world;
        let past = self.past();
        let asking = self.asking(&found.hit, &past);
        let mut scratch = Scratch::default();
        let at = (self.origin, asking);
        let mut surface = world.surface::<E>(&found.hit, at, Wanted::Lobes, &mut scratch);
        if is_first {
            self.note(&found.hit, &surface, brought, passes);
        }
        let is_lit = is_lit && !surface.is_unlit();
        if !(is_lit || opens) {
            return;
        }
        let mut bsdf = self.bare(&found.hit, &surface);
        self.add_lobes(&mut bsdf, &mut surface);
        let mut throughput = brought * rest;
        if (surface.disperses || self.beside.other_side.disperses)
            && let Some(counts) = self.beside.counts
        {
            // Its light is of one wavelength, as that of paths that stop; what passes is not.
            throughput *= counts;
        }
        if is_first && is_lit {
            self.light.sink.first_colors(throughput, || bsdf.colors());
        }
        let is_lit = is_lit && bsdf.is_samplable();
        if !(is_lit || opens) {
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
        let way = (throughput, self.bounce, self.counted());
        let vertex = self.beside.vertex::<E>(scene, met, (&bsdf, &past), way);
        if is_lit {
            self.rays += vertex.add_direct_light(&numbers, self.light);
            if world.is_approximated() {
                self.rays += vertex.add_openness(&numbers, alpha(passes), self.light);
            }
        }
        if opens {
            let there = brought * alpha(passes);
            let sink = &mut *self.light.sink;
            self.rays += sink.occlusion(|distance| there * vertex.openness(&numbers, distance));
        }
        self.beside.previous.at = before;
    }
}

/// How much of a surface is there, by what passes it straight on.
#[inline(always)]
pub(in crate::integrator) fn alpha(passes: Vec3) -> Vec3 {
    (Vec3::ONE - passes).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Whether so much of it is there that passes of data have no look at what lies behind.
#[inline(always)]
pub(in crate::integrator) fn is_enough(settings: &PathSettings, passes: Vec3) -> bool {
    average(alpha(passes)) >= settings.alpha_threshold
}
