//! How a path leaves a vertex. From the first one several may go on: where light that comes by many scatterings makes most of the
//! noise, they share the ray of the camera and the light that falls on what it meets (splitting: Arvo and Kirk, *Particle Transport
//! and Image Synthesis*, 1990). The best number follows from what both parts cost and how much they vary.

use super::{KernelBsdf, Walk, spawn_ray};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::accumulator::Accumulator;
use crate::integrator::record::Record;
use crate::math::float::RAY_START;
use crate::sampler::Sampler;
use crate::shading::bsdf::Elsewhere;
use crate::world::{Hit, RayKind, Sender, Surface};
use glam::Vec3;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Goes on from a surface; whether the path has not ended.
    #[inline(always)]
    pub(super) fn leave(
        &mut self,
        (hit, surface): (&Hit, &Surface),
        bsdf: &KernelBsdf<E>,
        receiver: u8,
    ) -> bool {
        match self.elsewhere(bsdf) {
            Some(Elsewhere::Below(below)) => self.go_below(hit, surface, &below),
            Some(Elsewhere::Portal(portal)) => {
                self.go_through((hit, surface), &portal, receiver);
                false
            }
            None => self.leave_by((hit, surface), bsdf, self.sampler),
        }
    }

    /// Sends a ray from a surface in a direction, `beyond` it or not, which `crosses` it or not; `next`: its kind and how many
    /// surfaces have scattered it. Whether there is any.
    #[inline(always)]
    pub(super) fn depart(
        &mut self,
        (hit, surface): (&Hit, &Surface),
        direction: Vec3,
        (beyond, crosses): (bool, bool),
        (kind, depth): (RayKind, u32),
    ) -> bool {
        let start = spawn_ray::<E>(self.world, self.settings, (hit, surface), direction, beyond);
        if crosses {
            self.cross(hit, self.direction);
        }
        if E::EVERYTHING {
            self.beside.skipped = start.map_or(0.0, |start| start.distance(surface.point.point));
            self.beside.left = self.world.strand_of(hit);
        }
        self.leave_object(Some(hit.object()));
        (self.origin, self.direction, self.span) = if let Some(start) = start {
            (start, direction, (RAY_START, f32::INFINITY))
        } else {
            let met = self
                .world
                .self_intersection::<E>(hit, surface, direction, kind);
            let Some(back) = met else {
                return false;
            };
            let distance = 0.0;
            self.own = Some((Hit { distance, ..*hit }, surface.point));
            (surface.point.point, back, (0.0, 0.0))
        };
        if E::EVERYTHING && self.world.has_lids() && self.own.is_none() {
            let past = self.past();
            let sender = Sender {
                kind,
                depth,
                ..self.sender(&past)
            };
            let side = self.beside.side;
            self.beside.lid = self.world.lid((hit, surface), direction, side, &sender);
        }
        true
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
        if !self.follow((hit, surface), bsdf, &sample) {
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
        // Behind a portal is the first surface of a path.
        self.bounce == 0
            && self.settings.branches.are_several()
            && self.light.branches == 1
            // What is seen through glass is one sample's affair.
            && self.settings.clear_alpha < 0.0
            && !self.world.has_portals()
    }

    /// Goes on several times by numbers of their own, and to their ends: what each finds counts by its share.
    #[cold]
    #[inline(never)]
    pub(super) fn branch(
        &mut self,
        branches: u32,
        mut leave: impl FnMut(&mut Walk<'_, '_, E, A>) -> bool,
    ) {
        for number in 0..branches {
            let sampler = self.sampler.part(number, branches);
            let mut beside = self.beside.clone();
            // Each has a choice of its own.
            beside.stopped = None;
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
    pub(super) fn go_apart(&mut self) {
        self.go();
    }
}
