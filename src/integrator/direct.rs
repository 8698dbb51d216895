//! Next-event estimation: light of sampled lights at a surface.

use super::accumulator::Accumulator;
use super::path::{KernelBsdf, spawn_light_ray, spawn_ray};
use super::record::{Lit, Record, Step};
use super::settings::PathSettings;
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::light::{Drawn, LightSample, LightSampleContext, Rules};
use crate::math::average;
use crate::math::float::is_unit;
use crate::math::frame::Frame;
use crate::math::warp::cosine_hemisphere;
use crate::sampler::{Dimension, Sampler};
use crate::shading::bsdf::BsdfValue;
use crate::world::{Hit, Past, RayKind, Sender, Surface, Within, World};
use glam::Vec3;

/// A surface that light falls on, and what the path to it brings. By value, so that it stays in registers where no function
/// is called with it.
#[derive(Clone, Copy)]
pub(super) struct Vertex<'a, E: Features> {
    pub world: &'a World,
    pub settings: &'a PathSettings,
    pub hit: &'a Hit,
    pub surface: &'a Surface<'a>,
    pub bsdf: &'a KernelBsdf<E>,
    pub at: &'a LightSampleContext,
    pub throughput: Vec3,
    pub bounce: u32,
    /// Stands for the side of the surface that its point lies on by rounding, where faces lie in one place.
    pub side: u32,
    /// Surfaces that a shadow ray may pass.
    pub transparent: u32,
    /// The way that the path has come.
    pub past: &'a Past,
    /// The media that it has come through.
    pub within: &'a Within,
}

impl<E: Features> Vertex<'_, E> {
    /// Adds light that sampling lights finds; returns the rays that it took.
    #[inline(always)]
    pub fn add_direct_light<A: PassSink + Record>(
        self,
        sampler: &Sampler,
        light: &mut Accumulator<A>,
    ) -> u32 {
        if !self.bsdf.is_samplable() || self.world.lights.is_empty() {
            0
        } else if self.settings.takes_one(self.bounce) {
            self.add_light_sample(sampler, 1.0, light)
        } else {
            self.add_light_samples(sampler, light)
        }
    }

    /// Adds the mean light of some light samples. Out of the way of the path that takes one.
    #[cold]
    #[inline(never)]
    fn add_light_samples<A: PassSink + Record>(
        self,
        sampler: &Sampler,
        light: &mut Accumulator<A>,
    ) -> u32 {
        let samples = self.settings.light_samples;
        let mut rays = 0;
        for part in 0..samples {
            let sampler = sampler.part(part, samples);
            rays += self.add_light_sample(&sampler, samples as f32, light);
        }
        rays
    }

    /// Adds the light of one of some light samples.
    #[inline(always)]
    fn add_light_sample<A: PassSink + Record>(
        self,
        sampler: &Sampler,
        samples: f32,
        sum: &mut Accumulator<A>,
    ) -> u32 {
        let Self {
            world,
            settings,
            hit,
            surface,
            bsdf,
            at,
            ..
        } = self;
        let u = sampler.triple(Dimension::Light, self.bounce);
        let Some((mut light, drawn)) = world.lights.sample(at, u.z, u.truncate()) else {
            sum.sink.step(|| Step::Light {
                light: None,
                numbers: u,
            });
            return 0;
        };
        check(&light);
        if E::EVERYTHING && world.meets_own_surface(hit, surface, light.wi) {
            sum.sink.step(|| Step::Light {
                light: None,
                numbers: u,
            });
            return 0;
        }
        let value = if world.lights_backs(drawn) {
            bsdf.evaluate_sampled(light.wi)
        } else {
            bsdf.evaluate(light.wi)
        };
        debug_assert!(
            value.value.min_element() >= 0.0 && value.value.is_finite() && value.pdf >= 0.0,
            "{value:?}"
        );
        let beyond = bsdf.is_beyond(light.wi);
        if world.ends_below::<E>(surface, light.wi, beyond) {
            // Rays bring nothing from there: how much is lost hangs on how often Cycles draws the light.
            light.pdf = world.lights.density_in_cycles(at, drawn, light.pdf);
        }
        let mut casts_shadow = true;
        let (reflected, diffuse) = if E::EVERYTHING && world.by_kind {
            let rules = world.lights.rules(drawn);
            if self.bounce > rules.max_bounces {
                return 0;
            }
            casts_shadow = !rules.shines_through();
            self.weighted_by_kind((&light, &rules, drawn), &value, samples, beyond)
        } else {
            let pdf = samples * light.pdf;
            let weight = self.settings.weight_of_sampled(pdf, light.delta, value.pdf);
            (value.value * weight, value.diffuse * weight)
        };
        let arriving = light.contribution();
        let contribution = self.throughput * reflected * arriving / samples;
        let step = |share| Step::Light {
            light: Some(Lit {
                source: Some(world.lights.source(drawn)),
                direction: light.wi,
                pdf: light.pdf,
                contribution: arriving,
                bsdf: value.value,
                bsdf_pdf: value.pdf,
                weighted: reflected,
                share,
            }),
            numbers: u,
        };
        if contribution == Vec3::ZERO {
            sum.sink.step(|| step(None));
            return 0;
        }
        let start = spawn_light_ray::<E>(world, settings, (hit, surface), light.wi, beyond);
        let Some(start) = start else {
            return 0;
        };
        // As Cycles counts: a shadow ray is one surface further than the path.
        let mut sender = Sender {
            depth: self.bounce + 1,
            time: self.hit.time,
            past: self.past,
            ..RayKind::Shadow.into()
        };
        if E::EVERYTHING && world.lights.is_linked() {
            let blockers = world.lights.blockers(world.lights.source(drawn));
            sender.blockers = blockers.unwrap_or(0);
        }
        let left = (self.transparent, &sender);
        let lids = E::EVERYTHING && casts_shadow && world.has_lids();
        let has_media = E::EVERYTHING && world.has_media();
        // Where faces lie in one place, and where priorities say which is there, what shadow rays meet and what they cross differ.
        let at_once = has_media && casts_shadow && !lids && !world.has_priorities();
        let mut share = match light.target {
            _ if !casts_shadow => Vec3::ONE,
            _ if at_once => {
                let key = sampler.key(Dimension::Opacity, self.bounce);
                self.light_through((start, light.wi), light.target, beyond, (left, key))
            }
            _ if E::EVERYTHING && world.has_priorities() => {
                self.nested_share((start, light.wi), light.target, beyond, left)
            }
            Some(target) if lids && world.lies_on_face(drawn) => {
                world.transmittance_up_to((surface.point.point, start, target), drawn, left)
            }
            Some(target) => world.transmittance_to::<E>(start, target, left),
            None => world.transmittance::<E>(start, light.wi, f32::INFINITY, left),
        };
        if lids && share != Vec3::ZERO {
            share *= world.passes_lids((hit, surface), light.wi, self.side, left);
        }
        if has_media && !at_once && share != Vec3::ZERO {
            let key = sampler.key(Dimension::Opacity, self.bounce);
            let ray = (start, light.wi);
            share *= self.media_share(ray, light.target, beyond, (&sender, key));
        }
        sum.sink.step(|| step(Some(average(share))));
        if self.bounce == 0 {
            sum.sink
                .first_scattering(reflected, diffuse, || bsdf.through(light.wi));
        }
        let kept = sum.add_sampled(settings, contribution * share, (self.bounce, light.counts));
        let source = || world.lights.source(drawn);
        sum.sink.grouped(kept, || world.lights.group(source()));
        1
    }

    /// The media around a ray that crosses the surface, if it does.
    fn crossed(&self, direction: Vec3, beyond: bool) -> Option<Within> {
        beyond.then(|| {
            let mut within = self.within.clone();
            self.world.cross(&mut within, self.hit, direction);
            within
        })
    }

    /// Share of a light sample that surfaces let through, where priorities say which of them are there.
    #[cold]
    #[inline(never)]
    fn nested_share(
        &self,
        ray: (Vec3, Vec3),
        target: Option<Vec3>,
        beyond: bool,
        left: (u32, &Sender),
    ) -> Vec3 {
        let crossed = self.crossed(ray.1, beyond);
        let within = crossed.as_ref().unwrap_or(self.within);
        self.world.transmittance_nested(within, ray, target, left)
    }

    /// Share of a light sample that surfaces and media let through; `direction`: of the light; `beyond`: its ray crosses the
    /// surface.
    #[cold]
    #[inline(never)]
    fn light_through(
        &self,
        ray: (Vec3, Vec3),
        target: Option<Vec3>,
        beyond: bool,
        (left, key): ((u32, &Sender), u32),
    ) -> Vec3 {
        let crossed = self.crossed(ray.1, beyond);
        let within = crossed.as_ref().unwrap_or(self.within);
        self.world.light_through(within, ray, target, left, key)
    }

    /// Share of a light sample that media let through; `direction`: of the light; `beyond`: its ray crosses the surface.
    #[cold]
    #[inline(never)]
    fn media_share(
        &self,
        ray: (Vec3, Vec3),
        target: Option<Vec3>,
        beyond: bool,
        how: (&Sender, u32),
    ) -> Vec3 {
        let crossed = self.crossed(ray.1, beyond);
        let within = crossed.as_ref().unwrap_or(self.within);
        self.world.media_before(within, ray, target, how)
    }

    /// Adds light from all around to what scatters diffusely, where nothing that is near hides it: Cycles' fast GI approximation by Add
    /// (`integrate_surface_ao`). `there`: how much of the surface is. Rays that it took.
    #[cold]
    #[inline(never)]
    pub fn add_openness<A: PassSink + Record>(
        self,
        sampler: &Sampler,
        there: Vec3,
        light: &mut Accumulator<A>,
    ) -> u32 {
        let Some((factor, distance)) = self.world.added_openness() else {
            return 0;
        };
        let color = self.bsdf.diffuse_color();
        if color == Vec3::ZERO {
            return 0;
        }
        let open = self.throughput * there * self.openness(sampler, distance);
        light.add_open(self.settings, open, (color * factor, self.bounce));
        1
    }

    /// What comes through from a direction about the diffuse normal, from within a distance: Cycles' ambient occlusion.
    ///
    /// By the numbers of the next direction, as there: it is another estimate, and they are spread as evenly.
    #[inline(never)]
    pub fn openness(&self, sampler: &Sampler, distance: f32) -> Vec3 {
        let numbers = sampler.triple(Dimension::Bsdf, self.bounce).truncate();
        let about = Frame::from_normal(self.bsdf.diffuse_normal());
        let direction = about.to_world(cosine_hemisphere(numbers));
        let surface = (self.hit, self.surface);
        let Some(start) = spawn_ray::<E>(self.world, self.settings, surface, direction, false)
        else {
            return Vec3::ZERO;
        };
        let sender = Sender {
            depth: self.bounce + 1,
            past: self.past,
            ..RayKind::Shadow.into()
        };
        let left = (self.transparent, &sender);
        if E::EVERYTHING && self.world.has_priorities() {
            let target = Some(start + direction * distance);
            let ray = (start, direction);
            return self.nested_share(ray, target, false, left);
        }
        let mut share = self
            .world
            .transmittance::<E>(start, direction, distance, left);
        if E::EVERYTHING && self.world.has_media() && share != Vec3::ZERO {
            let target = Some(start + direction * distance);
            let key = sampler.key(Dimension::Opacity, self.bounce);
            share *= self.media_share((start, direction), target, false, (&sender, key));
        }
        share
    }

    /// The BSDF's value, weighted, and its diffuse part, where some kinds of rays do not see a light: each kind is an estimate
    /// of its own. In Cycles all are one, in which lobes that do not see it have no light.
    #[inline(always)]
    fn weighted_by_kind(
        &self,
        (light, rules, drawn): (&LightSample, &Rules, Drawn),
        value: &BsdfValue,
        samples: f32,
        beyond: bool,
    ) -> (Vec3, Vec3) {
        let delta = light.delta || rules.only_sampled();
        let weight = |pdf| {
            self.settings
                .weight_of_sampled(samples * light.pdf, delta, pdf)
        };
        if self.world.is_as_in_cycles() {
            let weight = weight(value.pdf);
            let (seen, diffuse) = if rules.is_seen_by_all_that_scatters() {
                (value.value, value.diffuse)
            } else {
                let backs = self.world.lights_backs(drawn);
                self.bsdf.seen_by_light(rules.visibility, light.wi, backs)
            };
            return (seen * weight, diffuse * weight);
        }
        let part = |kind, part: Vec3, pdf| {
            if rules.visibility.sees(kind) {
                part * weight(pdf)
            } else {
                Vec3::ZERO
            }
        };
        let other = if beyond {
            RayKind::Transmission
        } else {
            RayKind::Glossy
        };
        let diffuse = part(RayKind::Diffuse, value.diffuse, value.diffuse_pdf);
        let rest = part(
            other,
            value.value - value.diffuse,
            value.pdf - value.diffuse_pdf,
        );
        (diffuse + rest, diffuse)
    }
}

/// What a light sample must be.
#[inline(always)]
fn check(light: &LightSample) {
    debug_assert!(is_unit(light.wi), "direction {}", light.wi);
    debug_assert!(
        light.pdf >= 0.0 && light.pdf.is_finite(),
        "density {}",
        light.pdf
    );
    // It may be infinite: a light of 3e38 over a density below 1. Node trees may make it negative.
    debug_assert!(
        !light.contribution().is_nan(),
        "light {}",
        light.contribution()
    );
}
