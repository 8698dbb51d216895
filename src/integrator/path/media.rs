//! Media on the way of a path: what they take and add, and where they scatter it.

use super::{Beside, Walk};
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::{End, Lit, Record, Step};
use crate::light::{Along, Drawn, LightSample, LightSampleContext, Pivot};
use crate::math::average;
use crate::medium::tracking::Gathered;
use crate::medium::{Equiangular, Flight, Medium, transmittance};
use crate::sampler::{Dimension, hashed};
use crate::world::{
    Draws, Flown, Hit, Met, Passage, Past, RayKind, Sender, Source, Way, Within, World,
};
use glam::Vec3;

/// Tells the numbers of flights from those of opacity.
const FLIGHT: u32 = 0x_f119_47ed;
/// Tells the numbers of light that a ray meets from those of its flight.
const FOUND: u32 = 0x_0f0d_2b97;

/// What the last ray of a path is worth that a medium has scattered, where all lights are sampled: only what of their light the phase
/// function finds is left for it.
const LAST_WORTH: f32 = 0.25;
/// The same where some light is at infinity: of a world rays find a half of what they and light samples find together, of a sun nearly
/// nothing.
const LAST_WORTH_OF_FAR: f32 = 0.35;
/// The greatest share of the places at which light is looked for that lie by the angles about a light.
const MOST_BY_ANGLE: f32 = 0.75;

/// Where a medium scatters a path: how far from where its ray begins, and whether light that is scattered on the way there has been
/// looked for; what is there, where media vary.
#[derive(Clone, Debug)]
pub(super) struct Event {
    distance: f32,
    is_lit: bool,
    there: Option<Medium>,
}

/// Says who receives light in a medium on the way, after so many bounces. Of what fills all space no object says which lights it receives.
#[inline]
fn receive((world, within): (&World, &Within), bounces: u32, at: &mut LightSampleContext) {
    if world.lights.is_linked() {
        let object = within.last_entered();
        at.receiver = object.map_or(0, |object| world.lights.receiver(object));
    }
    at.bounces = bounces;
}

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Share of light that comes from a distance along the ray through what is around.
    #[inline(always)]
    pub(super) fn share(
        (world, within): (&World, &Within),
        (way, sender): (Way, &Sender),
        key: impl FnOnce() -> u32,
    ) -> Vec3 {
        if !E::EVERYTHING || !world.has_media() {
            return Vec3::ONE;
        }
        if within.varies {
            let way_number = FOUND ^ way.span.1.to_bits();
            return world.share(within, (&way, sender), &mut Draws::new(key(), way_number));
        }
        transmittance(within.medium.extinction, way.span.1 - way.span.0)
    }

    /// How much of the light of lamps and of the world that rays within media find is left in Cycles: roulette that is played before a
    /// medium is looked at ends paths without it (`integrator_intersect_terminate`), and nothing makes up for it.
    #[inline(always)]
    pub(super) fn left_by_roulette(&self) -> f32 {
        if E::EVERYTHING && self.world.has_media() {
            self.left_in_media()
        } else {
            1.0
        }
    }

    #[cold]
    #[inline(never)]
    fn left_in_media(&self) -> f32 {
        let within = &self.beside.within;
        let is_within = within.varies || !within.medium.is_clear();
        if is_within && self.world.is_as_in_cycles() {
            self.survival_in_cycles()
        } else {
            1.0
        }
    }

    /// A ray that meets nothing was in no object: one that it never leaves is open, or ends beyond what the camera sees. So it is in Cycles
    /// (`volume_stack_clean`).
    #[inline(always)]
    pub(super) fn leave_objects(&mut self) {
        if E::EVERYTHING && self.world.has_media() && self.beside.within.is_in_objects() {
            self.beside.within = self.world.media_without_objects();
        }
    }

    /// The medium that paths pass by chance before they find light that is clamped: Cycles', where ours has their mean.
    #[inline(always)]
    pub(super) fn passed_by_chance(&self) -> Option<Medium> {
        if !E::EVERYTHING || !self.world.has_media() || self.bounce == 0 || !self.clamps() {
            return None;
        }
        let Within { medium, varies, .. } = &self.beside.within;
        (!varies && medium.scattering != Vec3::ZERO).then(|| medium.clone())
    }

    /// What media may ask about the path's past.
    #[inline(always)]
    pub(super) fn past_in_media(&self) -> Past {
        if E::EVERYTHING && self.beside.within.varies {
            return self.past();
        }
        Past::UNKNOWN
    }

    /// Goes through what is around to the end of the ray, where light has been looked for already; says how far it came if it is
    /// scattered before. `is_end`: nothing else is there.
    #[cold]
    #[inline(never)]
    pub(super) fn fly(&mut self, far: f32, is_end: bool) -> Option<Event> {
        if self.beside.within.varies {
            return self.fly_through_what_varies(far, is_end);
        }
        if self.beside.within.medium.is_clear() {
            return None;
        }
        let length = self.length(far);
        let emitted = self.beside.within.medium.emitted(length);
        // What it takes and scatters nowhere needs no number.
        let scatters = !self.last && self.beside.within.medium.scattering != Vec3::ZERO;
        let u = if scatters { self.flight_number() } else { 0.0 };
        self.add_glow(emitted);
        let (flight, by_light) = if scatters {
            self.add_light_on_the_way(length);
            let worth = if is_end {
                f32::INFINITY
            } else {
                self.worth_of_scattering()
            };
            let medium = &self.beside.within.medium;
            medium.fly(self.throughput, length, worth, u)
        } else {
            let medium = &self.beside.within.medium;
            (
                Flight::Through(transmittance(medium.extinction, length)),
                1.0,
            )
        };
        self.clamp_as_if(by_light);
        match flight {
            Flight::Scattered(t, weight) => {
                self.throughput *= weight;
                Some(Event {
                    distance: t + self.span.0 - self.beside.skipped,
                    is_lit: true,
                    there: None,
                })
            }
            Flight::Through(weight) => {
                self.throughput *= weight;
                None
            }
        }
    }

    /// Adds light that media emit on the way. As in Cycles all of it is in the light group of the object that was entered last.
    fn add_glow(&mut self, emitted: Vec3) {
        // What all space emits has no end.
        if emitted == Vec3::ZERO || !emitted.is_finite() {
            return;
        }
        let found = self.throughput * emitted;
        let kept = self.light.add_found(self.settings, found, self.bounce);
        let (within, lights) = (&self.beside.within, &self.world.lights);
        let group = || lights.group(Source::Surface(within.last_entered()?));
        self.light.sink.grouped(kept, group);
    }

    /// What comes to the path if it is scattered, for what comes to it otherwise: a guess that only changes the noise. Light of lamps
    /// is looked for on the way.
    fn worth_of_scattering(&self) -> f32 {
        let light = self.throughput.max(Vec3::ZERO);
        let scattered = light * self.beside.within.medium.albedo();
        let albedo = scattered.element_sum() / light.element_sum();
        let share = self.worth_by_bounces();
        // Free of rounding where all is scattered.
        if albedo > 1.0 - 1e-6 || !albedo.is_finite() {
            share
        } else {
            (albedo * share).max(1e-3)
        }
    }

    /// The same, of light that is all scattered.
    fn worth_by_bounces(&self) -> f32 {
        let is_last = self.bounce + 1 > self.settings.bounces
            || self.beside.scattered_in_media + 1 > self.settings.volume_limit;
        if !is_last {
            1.0
        } else if self.world.lights.are_all_near() {
            LAST_WORTH
        } else {
            LAST_WORTH_OF_FAR
        }
    }

    /// How far it is to where the ray ends: in f64, where faces are nearer to each other than f32 tells.
    fn length(&mut self, far: f32) -> f32 {
        let exact = self.beside.passage.way.take();
        exact.unwrap_or(far - self.span.0 + self.beside.skipped)
    }

    /// A number for where a medium scatters the path: on the first such way after a scattering one that is spread evenly over the
    /// samples of the pixel, while roulette has no use for it.
    fn flight_number(&mut self) -> f32 {
        if self.bounce < self.settings.roulette && self.beside.flown <= self.bounce {
            self.beside.flown = self.bounce + 1;
            return self.sampler.single(Dimension::Roulette, self.bounce);
        }
        let key = self.sampler.key(Dimension::Opacity, self.bounce);
        hashed(key, FLIGHT, self.passed)
    }

    /// The same where the media vary.
    fn fly_through_what_varies(&mut self, far: f32, is_end: bool) -> Option<Event> {
        let start = self.span.0 - self.beside.skipped;
        let way = Way {
            origin: self.origin,
            direction: self.direction,
            span: (start, start + self.length(far)),
        };
        let key = self.sampler.key(Dimension::Opacity, self.bounce);
        let first = if self.last {
            None
        } else {
            Some(self.flight_number())
        };
        if let Some(u) = first
            && self.bounce == 0
        {
            return self.gather_on_the_way(&way, (key, u), is_end);
        }
        let draws = Draws::beginning(key, FLIGHT ^ self.passed, first);
        let light = (self.throughput, !self.last);
        let past = self.past();
        let sender = self.sender(&past);
        let Flown {
            flight,
            emitted,
            there,
        } = self
            .world
            .fly(&self.beside.within, (&way, &sender), light, draws);
        self.add_glow(emitted);
        match flight {
            Flight::Scattered(t, weight) => {
                self.throughput *= weight;
                Some(Event {
                    distance: t,
                    is_lit: false,
                    there: Some(there),
                })
            }
            Flight::Through(weight) => {
                self.throughput *= weight;
                None
            }
        }
    }

    /// The same where the camera looks through them: light is looked for on the whole way, wherever the path itself goes on.
    fn gather_on_the_way(
        &mut self,
        way: &Way,
        (key, u): (u32, f32),
        is_end: bool,
    ) -> Option<Event> {
        let numbers = self.sampler.quadruple(Dimension::Light, self.bounce);
        let draws = Draws::beginning(key, FLIGHT ^ self.passed, Some(numbers.w));
        let past = self.past();
        let sender = self.sender(&past);
        let Met { gathered, there } =
            self.world
                .gather(&self.beside.within, (way, &sender), self.throughput, draws);
        let Gathered {
            scattered,
            through,
            emitted,
        } = gathered;
        self.add_glow(emitted);
        let Some((t, weight)) = scattered else {
            self.throughput *= through;
            return None;
        };
        let point = way.origin + way.direction * t;
        self.add_light_at(point, &there, weight, numbers.truncate());
        let of = |share: Vec3| average((self.throughput * share).abs());
        let (scatters, passes) = (of(weight), of(through));
        let worth = if is_end {
            f32::INFINITY
        } else {
            self.worth_by_bounces()
        };
        // How often light comes so, and how often it is drawn.
        let by_light = scatters / (scatters + passes);
        let often = if passes == 0.0 || worth == f32::INFINITY {
            1.0
        } else {
            scatters * worth / (scatters * worth + passes)
        };
        if u < often {
            self.clamp_as_if(by_light / often);
            self.throughput *= weight / often;
            Some(Event {
                distance: t,
                is_lit: true,
                there: Some(there),
            })
        } else {
            self.clamp_as_if((1.0 - by_light) / (1.0 - often));
            self.throughput *= through / (1.0 - often);
            None
        }
    }

    /// Adds light of a sampled light at a point of a medium, with a weight.
    fn add_light_at(&mut self, point: Vec3, there: &Medium, weight: Vec3, numbers: Vec3) {
        let world = self.world;
        if world.lights.is_empty() {
            return;
        }
        let mut at = self.beside.previous.at;
        receive((world, &self.beside.within), self.bounce, &mut at);
        world.lights.context_into(&mut at, point, None);
        let drawn = world.lights.sample(&at, numbers.z, numbers.truncate());
        if let Some(drawn) = drawn {
            self.add_light_in_medium(point, Some(there), weight, drawn, numbers);
        }
    }

    /// Adds light of a sampled light that a medium scatters somewhere on a way of a length, wherever the path itself goes on. Where is
    /// drawn by the angles at which a light sees the way, or by what scatters there; a place counts by the density of both together.
    fn add_light_on_the_way(&mut self, length: f32) {
        let (world, bounce) = (self.world, self.bounce);
        let medium = &self.beside.within.medium;
        if world.lights.is_empty() {
            return;
        }
        // Of one sequence: the places of the samples that look for one light are spread evenly, and so are the points on it.
        let numbers = self.sampler.quadruple(Dimension::Light, bounce);
        let (numbers, u) = (numbers.truncate(), numbers.w);
        let start = self.span.0 - self.beside.skipped;
        // What the path sees of the way.
        let seen = length.min(medium.extinction.max_element().recip());
        let ray = (self.origin + self.direction * start, self.direction);
        let mut at = self.beside.previous.at;
        receive((world, &self.beside.within), bounce, &mut at);
        let along = world.lights.along(&mut at, numbers.z, (ray, length, seen));
        if let Some(along) = along
            && let Some((t, weight)) = self.place_on_the_way(&along, (ray, length, seen), u)
            && t.is_finite()
            && weight.is_finite()
            && weight != Vec3::ZERO
        {
            let point = ray.0 + self.direction * t;
            world.lights.context_into(&mut at, point, None);
            let drawn = (along.drawn, along.probability);
            let light = world.lights.sample_drawn(&at, drawn, numbers.truncate());
            if let Some(light) = light {
                self.add_light_in_medium(point, None, weight, (light, along.drawn), numbers);
            }
        }
    }

    /// A place at which light of a light is looked for on a way of a length, with what is scattered there over its density.
    fn place_on_the_way(
        &self,
        Along { pivot, .. }: &Along,
        ((origin, direction), length, seen): ((Vec3, Vec3), f32, f32),
        u: f32,
    ) -> Option<(f32, Vec3)> {
        let medium = &self.beside.within.medium;
        let (from, to) = pivot.map_or((0.0, length), |pivot| pivot.lit);
        let (before, way) = (transmittance(medium.extinction, from), to - from);
        let angle = pivot.and_then(|pivot: Pivot| {
            let ray = (origin + direction * from, direction);
            Equiangular::new(ray, way, (pivot.center, pivot.ball()))
        });
        // By angle where the light is near for what is seen, by what scatters where it is far.
        let by_angle = angle.map_or(0.0, |angle| {
            (seen / (seen + angle.height())).min(MOST_BY_ANGLE)
        });
        let distances = medium.distances(self.throughput * before, way);
        let t = match angle {
            Some(angle) if u < by_angle => angle.sample(u / by_angle),
            _ => distances?.sample((u - by_angle) / (1.0 - by_angle))?,
        };
        let left = transmittance(medium.extinction, t);
        let density = by_angle * angle.map_or(0.0, |angle| angle.density(t))
            + (1.0 - by_angle) * distances.map_or(0.0, |distances| distances.density(left));
        Some((from + t, medium.scattering * before * left / density))
    }

    /// The path goes to the other side of a surface.
    #[inline(always)]
    pub(super) fn cross(&mut self, hit: &Hit, direction: Vec3) {
        if E::EVERYTHING && self.world.has_media() {
            self.world.cross(&mut self.beside.within, hit, direction);
            if self.world.has_close_interfaces() {
                let Beside {
                    within, passage, ..
                } = &mut *self.beside;
                self.world
                    .cross_in_its_place(within, passage, (hit, direction));
            }
        }
    }

    /// Light that falls on a point of a medium and is scattered there, and the way on; whether the path goes on.
    #[cold]
    #[inline(never)]
    pub(super) fn scatter(&mut self, event: Event) -> bool {
        let Event {
            distance,
            is_lit,
            there,
        } = event;
        if !self.survives(self.roulette()) {
            self.end(End::Roulette);
            return false;
        }
        let point = self.origin + self.direction * distance;
        let Beside {
            within, previous, ..
        } = &mut *self.beside;
        receive((self.world, within), self.bounce, &mut previous.at);
        self.world
            .lights
            .context_into(&mut previous.at, point, None);
        if !is_lit && !self.world.lights.is_empty() {
            let numbers = self.sampler.triple(Dimension::Light, self.bounce);
            let at = &self.beside.previous.at;
            let drawn = self.world.lights.sample(at, numbers.z, numbers.truncate());
            if let Some(drawn) = drawn {
                self.add_light_in_medium(point, there.as_ref(), Vec3::ONE, drawn, numbers);
            }
        }
        let leave =
            |path: &mut Walk<'_, '_, E, A>| path.leave_in_medium((point, distance), there.as_ref());
        if self.is_to_branch() {
            self.branch(self.settings.branches.in_medium, leave);
            return false;
        }
        leave(self)
    }

    /// Goes on from a point of a medium, so far from where the ray began; whether the path has not ended.
    fn leave_in_medium(&mut self, (point, distance): (Vec3, f32), there: Option<&Medium>) -> bool {
        let u = self.numbers(self.sampler);
        let (onward, value, pdf) = self.scattered_by(point, there, u);
        let medium = there.unwrap_or(&self.beside.within.medium);
        if pdf <= 0.0 {
            self.end(End::Absorbed);
            return false;
        }
        if self.bounce == 0 {
            self.light.sink.first_in_medium();
        }
        let camera = &self.world.camera;
        self.light
            .sink
            .scatter(|| medium.albedo(), || camera.backward());
        self.throughput *= value / pdf;
        (self.origin, self.direction, self.span) = (point, onward, (0.0, f32::INFINITY));
        if let Some(pixel) = self.world.widened() {
            let width = medium.phase_width();
            self.widen_by((distance, pixel), width);
        }
        let beside = &mut *self.beside;
        beside.way += beside.walked + distance;
        (beside.walked, beside.near, beside.skipped) = (0.0, 0.0, 0.0);
        // It begins at no surface.
        beside.passage = Passage::default();
        let previous = &mut beside.previous;
        (previous.pdf, previous.only_bsdf, previous.delta) = (pdf, false, false);
        previous.kind = RayKind::Volume;
        beside.is_clear = false;
        previous.at.also = 0;
        self.min_pdf = self.min_pdf.min(pdf);
        beside.scattered_in_media += 1;
        let scattered = beside.scattered_in_media;
        self.bounce += 1;
        self.clamp_as_deferred();
        self.last = self.bounce > self.settings.bounces || scattered > self.settings.volume_limit;
        self.leave_object(self.beside.within.last_entered());
        if self.world.lights.is_shadow_linked() {
            self.add_shadow_linked();
        }
        true
    }

    /// Adds the light of a sampled light at a point of a medium, with a weight: of this one, where it varies.
    fn add_light_in_medium(
        &mut self,
        point: Vec3,
        there: Option<&Medium>,
        weight: Vec3,
        (light, drawn): (LightSample, Drawn),
        numbers: Vec3,
    ) {
        let (world, settings, bounce) = (self.world, self.settings, self.bounce);
        let rules = world.lights.rules(drawn);
        if bounce > rules.max_bounces || !rules.visibility.sees(RayKind::Volume) {
            return;
        }
        let within = &self.beside.within;
        let medium = there.unwrap_or(&within.medium);
        let (value, pdf) = medium.phase(self.direction.dot(light.wi));
        let delta = light.delta || rules.only_sampled();
        let weighted = value * settings.weight_of_sampled(light.pdf, delta, pdf);
        let arriving = light.contribution();
        let past = self.past();
        let mut sender = Sender {
            depth: bounce + 1,
            time: self.beside.time,
            past: &past,
            ..RayKind::Shadow.into()
        };
        if world.lights.is_linked() {
            let blockers = world.lights.blockers(world.lights.source(drawn));
            sender.blockers = blockers.unwrap_or(0);
        }
        let left = (self.transparent_left(), &sender);
        let ray = (point, light.wi);
        let key = self.sampler.key(Dimension::Opacity, bounce);
        let share = if rules.shines_through() || world.has_priorities() {
            let share = if rules.shines_through() {
                Vec3::ONE
            } else {
                world.transmittance_nested(within, ray, light.target, left)
            };
            share * world.media_before(within, ray, light.target, (&sender, key))
        } else {
            world.light_through(within, ray, light.target, left, key)
        };
        self.rays += 1;
        self.light.sink.step(|| Step::Light {
            light: Some(Lit {
                source: Some(world.lights.source(drawn)),
                direction: light.wi,
                pdf: light.pdf,
                contribution: arriving,
                bsdf: value,
                bsdf_pdf: pdf,
                weighted,
                share: Some(average(share)),
            }),
            numbers,
        });
        if bounce == 0 {
            self.light.sink.first_in_medium();
        }
        let found = self.throughput * weight * weighted * arriving * share;
        let kept = self
            .light
            .add_sampled(settings, found, (bounce, light.counts));
        let group = || world.lights.group(world.lights.source(drawn));
        self.light.sink.grouped(kept, group);
    }

    /// Whether the ray is scattered before its end; `is_end`: nothing is there.
    #[inline(always)]
    pub(super) fn scattered(&mut self, far: f32, is_end: bool) -> bool {
        if !E::EVERYTHING || !self.world.has_media() {
            return false;
        }
        self.beside.scattered = self.fly(far, is_end);
        self.beside.scattered.is_some()
    }
}
