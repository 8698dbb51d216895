//! Surfaces that send a path elsewhere. As in Cycles that is no scattering: it is counted as a surface that the path has passed,
//! and rays stay of the kind that they are.

use super::{KernelBsdf, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::film::pixel::FirstHit;
use crate::integrator::record::{End, Record, Step};
use crate::math::float::RAY_START;
use crate::shading::bsdf::Elsewhere;
use crate::shading::closure::Portal;
use crate::world::{Hit, Passage, RayKind, Surface};

/// Tells the numbers behind portals from those of the vertices before them.
const PORTAL: u32 = 0x_9047_a1b3;
/// Portals that a path without a limit goes through: the most that Blender lets one ask for. They may send it round for ever.
const MOST_PORTALS: u32 = 1024;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// The way elsewhere, if the path is to go on by it.
    #[inline(always)]
    pub(super) fn elsewhere(&self, bsdf: &KernelBsdf<E>) -> Option<Elsewhere> {
        if !E::EVERYTHING || !(self.world.goes_below() || self.world.has_portals()) {
            return None;
        }
        bsdf.elsewhere(self.numbers(self.sampler).z, self.settings.uniform)
    }

    /// Goes through a portal: then [`Self::follow_portals`] has the rest of the path, which ends here. `receiver`: that of the vertex
    /// from which the ray has come.
    #[cold]
    #[inline(never)]
    pub(super) fn go_through(
        &mut self,
        (hit, surface): (&Hit, &Surface),
        portal: &Portal,
        receiver: u8,
    ) {
        let point = surface.point.point;
        let left = self.transparent_left();
        if left == 0 || self.beside.portals >= MOST_PORTALS {
            return self.end(End::Transparent);
        }
        let beyond = self.world.beyond_portal(portal, (point, self.direction));
        let Some((place, onward)) = beyond else {
            return self.end(End::Absorbed);
        };
        self.throughput *= portal.weight;
        // NaN goes on, to be counted at the film.
        if self.throughput.max_element() <= 0.0 {
            return self.end(End::Black);
        }
        if let Some(pixel) = self.world.widened() {
            self.widen_by((hit.distance, pixel), 0.0);
        }
        self.beside.way += self.beside.walked + hit.distance;
        (self.beside.walked, self.beside.near) = (0.0, 0.0);
        let (kind, depth) = (self.beside.previous.kind, self.bounce);
        if let Some(place) = place {
            self.cross(hit, self.direction);
            (self.origin, self.direction) = (place, onward);
            self.span = (RAY_START, f32::INFINITY);
            self.beside.passage = Passage::default();
            self.beside.skipped = 0.0;
            self.leave_object(None);
        } else {
            let beyond = onward.dot(surface.normals.geometric) < 0.0;
            let crosses = (beyond, true);
            if !self.depart((hit, surface), onward, crosses, (kind, depth)) {
                return self.end(End::Own);
            }
        }
        self.passed += 1;
        self.beside.portals += 1;
        // No light sample has come this way.
        self.beside.previous.only_bsdf = true;
        self.beside.previous.at.receiver = receiver;
        if self.bounce == 0 {
            self.first = FirstHit {
                transparent: self.first.transparent,
                ..FirstHit::default()
            };
            self.light.sink.leave_first();
            self.beside.is_noted = false;
        }
        let (to, throughput) = (self.origin, self.throughput);
        self.light.sink.step(|| Step::Portal {
            from: point,
            to,
            direction: onward,
            throughput,
        });
        if self.world.lights.is_shadow_linked() && kind != RayKind::Camera {
            self.add_shadow_linked();
        }
        self.beside.is_through = true;
    }

    /// The rest of a path that has gone through a portal.
    #[inline(always)]
    pub(super) fn follow_portals(&mut self) {
        if E::EVERYTHING && self.beside.is_through {
            self.go_on_behind();
        }
    }

    /// Behind each portal it has numbers of its own: it has come to no next bounce.
    #[cold]
    #[inline(never)]
    fn go_on_behind(&mut self) {
        while std::mem::take(&mut self.beside.is_through) {
            let sampler = self
                .sampler
                .beside(PORTAL.wrapping_add(self.beside.portals));
            let mut path = Walk {
                sampler: &sampler,
                light: &mut *self.light,
                beside: &mut *self.beside,
                ..*self
            };
            path.go_apart();
            let Walk {
                throughput,
                bounce,
                rays,
                origin,
                direction,
                span,
                first,
                last,
                passed,
                min_pdf,
                own,
                ..
            } = path;
            (self.throughput, self.bounce, self.rays) = (throughput, bounce, rays);
            (self.origin, self.direction, self.span) = (origin, direction, span);
            (self.first, self.last, self.passed) = (first, last, passed);
            (self.min_pdf, self.own) = (min_pdf, own);
        }
    }
}
