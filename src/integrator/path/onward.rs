//! The way of a ray to the next surface that the path does not pass, and the light on it.

use super::{Beside, Found, Walk};
use crate::camera::CameraRay;
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::{End, Record, Step};
use crate::integrator::settings::PathSettings;
use crate::light::{LightSampleContext, Shadows};
use crate::math::average;
use crate::math::float::{ONE_MINUS_EPSILON, RAY_START, ray_origin};
use crate::sampler::{Dimension, Sampler, hashed};
use crate::world::{
    Asking, Hit, Intersection, RayKind, Scratch, Sender, Source, Wanted, Way, World,
};
use glam::Vec3;

/// Tells the numbers of a transparent film from those of opacity.
const FILM: u32 = 0x_0f11_a1fa;

/// What becomes of a path at a surface that tints what passes straight on.
pub(in crate::integrator) enum Tinted {
    /// It stops there, with a weight.
    Stops(Vec3, Stopped),
    /// It goes on.
    Passes(Passing),
}

/// How much of a surface the camera does not see, since the picture is empty there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::integrator) enum HeldOut {
    /// A share by shaders, or nothing.
    Share,
    /// All but what passes straight on.
    Object,
    /// All.
    Whole,
}

/// A stop at a surface that a path might have passed.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Stopped {
    /// Of the numbers that have stopped it: for what it does there.
    pub left_over: Vec3,
    /// What passes straight on there, as a colour …
    pub passes: Vec3,
    /// … and for each part that does not, by mean.
    pub passing: f32,
    /// What the path brings there, before it has chosen.
    pub brought: Vec3,
}

/// A way past a surface.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrator) struct Passing {
    /// Of the path from there on.
    pub weight: Vec3,
    /// Where it goes on …
    pub onward: Vec3,
    /// … so far from the surface.
    pub skipped: f32,
    /// The share of the surface that scatters.
    pub rest: f32,
    /// What passes straight on, as a colour.
    pub passes: Vec3,
}

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Surfaces at which paths stop to choose that this one has passed since its last bounce.
    #[inline(always)]
    pub(super) fn tints(&self) -> u32 {
        match self.beside.tints {
            (bounce, tints) if E::EVERYTHING && bounce == self.bounce => tints,
            _ => 0,
        }
    }

    /// The numbers of the next choice: what is left over of those that have stopped the path here, or new ones of a sampler.
    #[inline(always)]
    pub(super) fn numbers(&self, sampler: &Sampler) -> Vec3 {
        match &self.beside.stopped {
            Some(stopped) if E::EVERYTHING => stopped.left_over,
            _ => sampler.triple_behind(Dimension::Bsdf, self.bounce, self.tints()),
        }
    }

    /// The next surface that the path does not pass, with the light of the lamps on the way to it, or of what lies behind all
    /// surfaces. Whether there is one.
    #[inline(always)]
    pub(super) fn next_surface(&mut self, found: &mut Found) -> bool {
        loop {
            if E::EVERYTHING {
                self.beside.stopped = None;
            }
            if !self.next_interface(found) {
                return false;
            }
            let is_met = !found.again && self.beside.scattered.is_none();
            if E::EVERYTHING && is_met && self.beside.rounds.comes_back(&found.hit, self.bounce) {
                self.span.0 = found.hit.distance.next_up();
                continue;
            }
            if E::EVERYTHING && self.world.has_priorities() && !self.is_there(found) {
                continue;
            }
            if !(E::EVERYTHING && self.world.is_tinted())
                || found.again
                || self.beside.scattered.is_some()
            {
                return true;
            }
            let held = if self.is_seen() && self.world.may_be_held_out(&found.hit) {
                self.hold_out(&found.hit)
            } else {
                HeldOut::Share
            };
            match held {
                HeldOut::Whole => {
                    self.end(End::Holdout);
                    return false;
                }
                HeldOut::Object => {}
                HeldOut::Share => self.add_passing_emission(found),
            }
            let left = self.transparent_left();
            let past = self.past();
            let ray = (self.origin, self.asking(&found.hit, &past));
            let numbers = self.numbers(self.sampler);
            match tinted::<E>(self.world, &found.hit, ray, (numbers, held)) {
                Tinted::Stops(weight, stopped) => {
                    let brought = self.throughput;
                    self.beside.stopped = Some(Stopped { brought, ..stopped });
                    self.throughput *= weight;
                    return true;
                }
                Tinted::Passes(passing) => {
                    self.pass_by(found, &passing);
                    let only_bounds = self.world.only_bounds(&found.hit);
                    if left == 0 && !only_bounds {
                        self.end(End::Transparent);
                        return false;
                    }
                    if self.world.has_portals() && self.world.is_portal(&found.hit, ray.1) {
                        // Shadow rays do not pass beside it (in Cycles this light counts twice), and depths count it.
                        self.beside.previous.only_bsdf = true;
                        self.beside.portals += 1;
                    }
                    self.throughput *= passing.weight;
                    // Nothing passes a surface that is neither clear nor scatters. NaN goes on, to be counted at the film.
                    if self.throughput.max_element() <= 0.0 {
                        self.end(End::Black);
                        return false;
                    }
                    if only_bounds {
                        self.carry_as_played(None);
                    }
                    self.cross(&found.hit, self.direction);
                    self.light.sink.go_by(found.hit.distance - self.span.0);
                    self.light.sink.pass(passing.weight);
                    self.passed += 1;
                    self.beside.bounds += u32::from(only_bounds);
                    self.beside.tints = (self.bounce, self.tints() + 1);
                    self.beside.left = self.world.strand_of(&found.hit);
                    self.leave_object(Some(found.hit.object()));
                    self.go_behind(&found.hit, (passing.onward, passing.skipped));
                }
            }
        }
    }

    /// Goes straight on behind a surface: from there, so far from it.
    #[inline(always)]
    fn go_behind(&mut self, hit: &Hit, (onward, skipped): (Vec3, f32)) {
        if self.beside.rounds.passes(hit, self.bounce) {
            self.span.0 = hit.distance.next_up();
            return;
        }
        self.beside.skipped = skipped;
        self.beside.walked += hit.distance;
        self.origin = onward;
        self.span = (RAY_START, f32::INFINITY);
    }

    /// Light of what shines and may be passed: by its share, whether the path passes it or not. A faint sign that shines brightly
    /// would be met by few paths, and be bright in those.
    #[inline(always)]
    fn add_passing_emission(&mut self, found: &mut Found) {
        if !self.world.glows_in_passing(&found.hit) {
            return;
        }
        let past = self.past();
        let asking = self.asking(&found.hit, &past);
        let Some((_, share)) = self.world.tint(&found.hit, asking) else {
            return;
        };
        let mut scratch = Scratch::default();
        let surface = self.world.surface::<E>(
            &found.hit,
            (self.origin, asking),
            Wanted::Light,
            &mut scratch,
        );
        self.add_emission(found, &surface, share);
        found.has_shone = true;
    }

    /// Whether what was found is there, by the priorities of solids; the path passes it where it is not.
    #[cold]
    #[inline(never)]
    fn is_there(&mut self, found: &mut Found) -> bool {
        if found.again || self.beside.scattered.is_some() {
            return true;
        }
        let (world, wavelength) = (self.world, self.beside.wavelength);
        let Beside {
            within, passage, ..
        } = &mut *self.beside;
        let met = (&found.hit, self.direction);
        if let Some((hit, other_side)) = world.interface((within, passage), met, wavelength) {
            (found.hit, self.beside.other_side) = (hit, other_side);
            return true;
        }
        self.cross(&found.hit, self.direction);
        self.light.sink.go_by(found.hit.distance - self.span.0);
        let behind = world.straight_on(&found.hit, self.direction);
        self.go_behind(&found.hit, behind);
        false
    }

    /// The next surface, as far as that lets no light pass without a colour.
    #[inline(always)]
    fn next_interface(&mut self, found: &mut Found) -> bool {
        let again = E::CURVED && self.own.is_some();
        self.rays += u32::from(!again);
        self.light.sink.step(|| Step::Ray {
            bounce: self.bounce,
            kind: self.beside.previous.kind,
            origin: self.origin,
            direction: self.direction,
            span: self.span,
            throughput: self.throughput,
        });
        let lid = if E::EVERYTHING {
            self.beside.lid.take()
        } else {
            None
        };
        let stands = E::EVERYTHING && self.world.is_approximated() && self.shorten();
        let (hit, limit) = match self.own {
            _ if E::EVERYTHING && lid.is_some() => (lid, None),
            Some((hit, _)) if E::CURVED => (Some(hit), None),
            _ => self.intersect(),
        };
        let lid_free = lid.is_none();
        let far = hit.map_or(limit.unwrap_or(self.span.1), |hit| hit.distance);
        if E::LIGHTS && self.world.lights.has_lamps_for(self.bounce) {
            self.add_lamps_on_the_way(far);
        }
        if limit.is_some() {
            self.end(End::Transparent);
            return false;
        }
        if hit.is_none() {
            self.leave_objects();
            self.add_environment();
        }
        let far = if hit.is_none() { f32::INFINITY } else { far };
        self.last |= stands && hit.is_some();
        if !again && lid_free && self.scattered(far, hit.is_none()) {
            return true;
        }
        let Some(hit) = hit else {
            self.end(End::Nothing);
            return false;
        };
        if self.is_seen()
            && self.world.is_holdout(&hit)
            && !(E::EVERYTHING && self.world.is_tinted() && self.world.decides(&hit))
        {
            self.see_through(self.throughput);
            self.end(End::Holdout);
            return false;
        }
        if E::EVERYTHING && self.world.has_lids() && !again {
            let met = self.sampler.key(Dimension::Opacity, self.bounce);
            if lid_free || !World::stays_on_side(met) {
                self.beside.side = met;
            }
        }
        *found = Found {
            hit,
            again,
            has_shone: false,
        };
        true
    }

    /// What the ray meets, or where it would pass one transparent surface too many.
    #[inline(always)]
    fn intersect(&mut self) -> (Option<Hit>, Option<f32>) {
        let (ray, kind) = ((self.origin, self.direction), self.beside.previous.kind);
        let past = self.past();
        let sender = self.sender(&past);
        let numbers = (self.sampler, self.bounce);
        let mut hit = if E::EVERYTHING && self.settings.transparent != u32::MAX {
            // Cycles notices the limit when it has passed a surface: one always is.
            let left = self.settings.transparent.max(1) - self.counted();
            let met = self
                .world
                .intersect_limited::<E>(ray.0, ray.1, self.span, sender, numbers, left);
            match met {
                Intersection::Surface(hit, more) => {
                    self.passed += more;
                    self.last |= self.counted() > 0 && self.counted() >= self.settings.transparent;
                    Some(hit)
                }
                Intersection::Nothing => None,
                Intersection::Limit(distance) => return (None, Some(distance)),
            }
        } else {
            self.world
                .intersect::<E>(ray.0, ray.1, self.span, sender, numbers)
        };
        if E::EVERYTHING && self.world.has_close_interfaces() {
            hit = self
                .world
                .first_in_order(hit, &mut self.beside.passage, ray, kind);
        }
        (hit, None)
    }

    /// Kind of the ray and number of the surface that it comes from, for what sees some rays alone.
    #[inline(always)]
    fn seen_by(&self) -> (RayKind, u32, Shadows) {
        let kind = self.beside.previous.kind;
        (kind, self.bounce.saturating_sub(1), Shadows::Plain)
    }

    #[inline(always)]
    fn add_lamps_on_the_way(&mut self, far: f32) {
        let ray = self.seen_by();
        let (settings, bounce) = (self.settings, self.bounce);
        let throughput = self.throughput * self.left_by_roulette();
        let past = self.past_in_media();
        let sender = self.sender(&past);
        let (previous, within, near) = (&self.beside.previous, &self.beside.within, self.span.0);
        let (origin, direction) = (self.origin, self.direction);
        let passed = self.passed_by_chance();
        let light = &mut *self.light;
        let through = |distance: f32| {
            let way = Way {
                origin,
                direction,
                span: (near, distance),
            };
            let key = || self.sampler.key(Dimension::Opacity, bounce);
            Self::share((self.world, within), (way, &sender), key)
        };
        let lights = &self.world.lights;
        lights.le_along_ray(
            &previous.at,
            (self.origin, self.direction, far),
            ray,
            |emitted, light_pdf, source, distance| {
                let weight = light.weigh(settings, previous, source, emitted, light_pdf);
                let found = throughput * emitted * weight * through(distance);
                let chance = passed.as_ref().map_or(1.0, |medium| {
                    medium.coming_through(throughput, distance - near)
                });
                let kept = light.add_found_by_chance(settings, found, (bounce, chance));
                light.sink.grouped(kept, || lights.group(source));
            },
        );
    }

    /// Light along the ray of what has blockers of its own: past other surfaces, with a shadow ray for each of them. (Cycles takes
    /// one of them by chance.)
    #[cold]
    #[inline(never)]
    pub(super) fn add_shadow_linked(&mut self) {
        // No light sample passes what is in its way there, and neither does this.
        if self.own.is_some() || self.beside.lid.is_some() {
            return;
        }
        let (kind, bounces, _) = self.seen_by();
        let ray = (kind, bounces, Shadows::Linked);
        let (world, settings, bounce) = (self.world, self.settings, self.bounce);
        let (origin, direction) = (self.origin, self.direction);
        let lights = &world.lights;
        let at = self.beside.previous.at;
        let mut found: Vec<(Vec3, f32, Source, Option<Vec3>)> = Vec::new();
        let whole = (origin, direction, f32::INFINITY);
        lights.le_along_ray(&at, whole, ray, |emitted, pdf, source, distance| {
            found.push((emitted, pdf, source, Some(origin + direction * distance)));
        });
        lights.environment_le(&at, direction, ray, |emitted, pdf, source| {
            found.push((emitted, pdf, source, None));
        });
        let past = self.past();
        let sender = self.sender(&past);
        world.shadow_linked_along((origin, direction), &sender, |hit, opacity| {
            let source = Source::Surface(hit.object());
            if !lights.is_found(source, at.receiver, (kind, Shadows::Linked)) {
                return;
            }
            let mut scratch = Scratch::default();
            let asking = Asking::of(&sender, direction, hit);
            let surface = world.surface::<E>(hit, (origin, asking), Wanted::Light, &mut scratch);
            let on = surface.point.point;
            let pdf = lights.surface_pdf(&at, direction, (hit.object(), hit.primitive), on);
            // To its nearer side.
            let normal = surface.normals.geometric;
            let away = direction.dot(normal) > 0.0;
            let facing = if away { -normal } else { normal };
            let target = ray_origin(surface.point, facing);
            found.push((surface.emission * opacity, pdf, source, Some(target)));
        });
        for (emitted, pdf, source, target) in found {
            let weight = self
                .light
                .weigh(settings, &self.beside.previous, source, emitted, pdf);
            let shining = self.throughput * self.left_by_roulette() * emitted * weight;
            if shining == Vec3::ZERO {
                continue;
            }
            let sender = Sender {
                depth: bounce,
                time: sender.time,
                past: sender.past,
                blockers: lights.blockers(source).unwrap_or(0),
                ..RayKind::Shadow.into()
            };
            let left = (self.transparent_left(), &sender);
            let mut share = match target {
                _ if world.has_priorities() => {
                    let within = &self.beside.within;
                    world.transmittance_nested(within, (origin, direction), target, left)
                }
                Some(target) => world.transmittance_to::<E>(origin, target, left),
                None => world.transmittance::<E>(origin, direction, f32::INFINITY, left),
            };
            if world.has_media() {
                let ray = (origin, direction);
                let key = self.sampler.key(Dimension::Opacity, bounce);
                let how = (&sender, key);
                share *= world.media_before(&self.beside.within, ray, target, how);
            }
            self.rays += 1;
            let kept = self.light.add_found(settings, shining * share, bounce);
            self.light.sink.grouped(kept, || lights.group(source));
        }
    }

    /// Whether the camera sees what its ray meets, straight or through glass through which the film is transparent.
    #[inline(always)]
    fn is_seen(&self) -> bool {
        self.bounce == 0 || E::EVERYTHING && self.beside.is_clear
    }

    /// The picture has nothing here, as often as light of this much gets through what is before it: as alpha counts. What holdouts on
    /// the way have emptied is added.
    fn see_through(&mut self, light: Vec3) {
        self.beside.seen_through += average(light);
        let through = self.beside.seen_through;
        self.first.transparent = through >= 1.0 || {
            let key = self.sampler.key(Dimension::Opacity, 0);
            hashed(key, FILM, 0) < through
        };
    }

    /// What a holdout that paths stop at takes, as Cycles counts it (`surface_shader_apply_holdout`): an object all but what passes,
    /// a shader its share, beside the others.
    #[cold]
    #[inline(never)]
    fn hold_out(&mut self, hit: &Hit) -> HeldOut {
        let past = self.past();
        let asking = self.asking(hit, &past);
        if self.world.is_holdout(hit) {
            let passes = self
                .world
                .tint(hit, asking)
                .map_or(Vec3::ZERO, |(passes, _)| passes);
            self.see_through(self.throughput * (Vec3::ONE - passes));
            return if passes == Vec3::ZERO {
                HeldOut::Whole
            } else {
                HeldOut::Object
            };
        }
        match self.world.held_out(hit, asking) {
            None => HeldOut::Share,
            Some(share) => {
                self.see_through(self.throughput * share);
                if share >= 1.0 {
                    HeldOut::Whole
                } else {
                    HeldOut::Share
                }
            }
        }
    }

    /// Light of the environment and of the suns, which no surface hides.
    #[inline(always)]
    fn add_environment(&mut self) {
        if self.is_seen() {
            self.first.transparent |= self.settings.transparent_film;
        }
        if !E::LIGHTS {
            return;
        }
        let ray = self.seen_by();
        let way = Way {
            origin: self.origin,
            direction: self.direction,
            span: (self.span.0, f32::INFINITY),
        };
        let key = || self.sampler.key(Dimension::Opacity, self.bounce);
        let past = self.past_in_media();
        let around = (self.world, &self.beside.within);
        let share = Self::share(around, (way, &self.sender(&past)), key);
        let throughput = self.throughput * share;
        if E::EVERYTHING && self.is_seen() && self.settings.transparent_film {
            self.see_through(throughput);
        }
        let throughput = throughput * self.left_by_roulette();
        let chance = self.passed_by_chance().map_or(1.0, |medium| {
            medium.coming_through(self.throughput, f32::INFINITY)
        });
        let (settings, bounce, is_seen) = (self.settings, self.bounce, self.is_seen());
        let world_share = self.world_share();
        let (previous, light) = (&self.beside.previous, &mut *self.light);
        let lights = &self.world.lights;
        lights.environment_le(
            &previous.at,
            self.direction,
            ray,
            |emitted, light_pdf, source| {
                let weight = light.weigh(settings, previous, source, emitted, light_pdf);
                let mut found = throughput * emitted * weight;
                if E::EVERYTHING && source == Source::Environment {
                    found *= world_share;
                }
                let kept = if !is_seen || source != Source::Environment {
                    light.add_found_by_chance(settings, found, (bounce, chance))
                } else if settings.transparent_film {
                    light.sink.environment(found);
                    if light.sink.keeps_environment() {
                        found
                    } else {
                        Vec3::ZERO
                    }
                } else {
                    let kept = light.add(settings, found, 0);
                    light.sink.environment(kept);
                    light.sink.shine(kept);
                    kept
                };
                light.sink.grouped(kept, || lights.group(source));
            },
        );
    }
}

/// Decides whether a path passes a surface that tints what passes straight on. The choice is by the mean of the channels.
#[cold]
#[inline(never)]
pub(in crate::integrator) fn tinted<E: Features>(
    world: &World,
    hit: &Hit,
    (origin, asking): (Vec3, Asking),
    (numbers, held): (Vec3, HeldOut),
) -> Tinted {
    // What is flat for a ray has no place by its corners.
    if world.lets_all_pass(hit) && world.strand_of(hit).is_none() {
        let (onward, skipped) = world.straight_on(hit, asking.direction);
        return Tinted::Passes(Passing {
            weight: Vec3::ONE,
            onward,
            skipped,
            rest: 0.0,
            passes: Vec3::ONE,
        });
    }
    let whole = Stopped {
        left_over: numbers,
        passes: Vec3::ZERO,
        passing: 0.0,
        brought: Vec3::ONE,
    };
    let Some((passes, rest)) = world.tint(hit, asking) else {
        return Tinted::Stops(Vec3::ONE, whole);
    };
    // Nothing but what passes is left of an object that is held out.
    let is_object = held == HeldOut::Object;
    let rest = if is_object { 0.0 } else { rest };
    let share = average(passes);
    // A path goes on with nothing where there is nothing but black.
    let p = if share + rest > 0.0 {
        share / (share + rest)
    } else {
        1.0
    };
    if numbers.z >= p {
        // What passes and what each lobe takes are parts of one choice, as in Cycles: a pixel's samples are shared out evenly among all.
        let left_over = ((numbers.z - p) / (1.0 - p)).min(ONE_MINUS_EPSILON);
        let weight = Vec3::splat(rest / (1.0 - p));
        let passing = if rest > 0.0 { share / rest } else { 0.0 };
        let stopped = Stopped {
            left_over: numbers.with_z(left_over),
            passes,
            passing,
            ..whole
        };
        return Tinted::Stops(weight, stopped);
    }
    let mut scratch = Scratch::default();
    let surface = world.surface::<E>(hit, (origin, asking), Wanted::Light, &mut scratch);
    let normal = surface.normals.geometric;
    let onward = ray_origin(surface.point, -normal);
    let skipped = onward.distance(surface.point.point);
    Tinted::Passes(Passing {
        weight: passes / p,
        onward,
        skipped,
        rest,
        // Data have it whole, as Cycles' have.
        passes: if is_object { Vec3::ZERO } else { passes },
    })
}

/// Light of the world along a ray of the camera, past everything.
pub fn behind(world: &World, settings: &PathSettings, ray: &CameraRay) -> Vec3 {
    let at = LightSampleContext::new(ray.origin, None).at_time(ray.time);
    let seen_by = (RayKind::Camera, 0, Shadows::Plain);
    let mut light = Vec3::ZERO;
    let mut add = |emitted: Vec3, _, source| {
        let mean = average(emitted);
        if source == Source::Environment {
            light += emitted * (settings.clamp[0] / mean).min(1.0);
        }
    };
    let lights = &world.lights;
    lights.environment_le(&at, ray.direction, seen_by, &mut add);
    light
}
