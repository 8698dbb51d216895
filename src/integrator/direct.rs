//! Next-event estimation: light of sampled lights at a surface.

use super::path::{KernelBsdf, Walk, spawn_ray};
use super::record::{Lit, Record, Step};
use crate::effects::Features;
use crate::film::apart::Apart;
use crate::light::{LightSample, LightSampleContext, Rules};
use crate::math::float::is_unit;
use crate::sampler::{Dimension, Sampler};
use crate::shading::bsdf::BsdfValue;
use crate::world::{Hit, RayKind, Surface};
use glam::Vec3;

/// A surface that light falls on.
#[derive(Clone, Copy)]
struct Vertex<'a, E: Features> {
    hit: &'a Hit,
    surface: &'a Surface<'a>,
    bsdf: &'a KernelBsdf<E>,
    at: &'a LightSampleContext,
}

impl<E: Features, A: Apart + Record> Walk<'_, E, A> {
    /// Adds light that sampling lights finds.
    #[inline(always)]
    pub(super) fn add_direct_light(
        &mut self,
        hit: &Hit,
        surface: &Surface,
        bsdf: &KernelBsdf<E>,
        at: &LightSampleContext,
    ) {
        if !bsdf.is_samplable() || self.world.lights.is_empty() {
            return;
        }
        let vertex = Vertex {
            hit,
            surface,
            bsdf,
            at,
        };
        if self.settings.takes_one(self.bounce) {
            self.add_light_sample(&vertex, self.sampler, 1.0);
        } else {
            self.add_light_samples(&vertex);
        }
    }

    /// Adds the mean light of some light samples. Out of the way of the path that takes one.
    #[cold]
    #[inline(never)]
    fn add_light_samples(&mut self, vertex: &Vertex<E>) {
        let samples = self.settings.light_samples;
        for part in 0..samples {
            let sampler = self.sampler.part(part, samples);
            self.add_light_sample(vertex, &sampler, samples as f32);
        }
    }

    /// Adds the light of one of some light samples.
    #[inline(always)]
    fn add_light_sample(&mut self, vertex: &Vertex<E>, sampler: &Sampler, samples: f32) {
        let &Vertex {
            hit,
            surface,
            bsdf,
            at,
        } = vertex;
        let world = self.world;
        let u = sampler.triple(Dimension::Light, self.bounce);
        let Some((light, rules)) = world.lights.sample(at, u.z, u.truncate()) else {
            self.light.apart.step(|| Step::Light {
                light: None,
                numbers: u,
            });
            return;
        };
        check(&light);
        let value = bsdf.evaluate(light.wi);
        debug_assert!(
            value.value.min_element() >= 0.0 && value.value.is_finite() && value.pdf >= 0.0,
            "{value:?}"
        );
        let by_kind = E::EVERYTHING && world.by_kind;
        if by_kind && self.bounce > rules.max_bounces {
            return;
        }
        let casts_shadow = !by_kind || !rules.shines_through();
        let beyond = bsdf.is_beyond(light.wi);
        let (reflected, diffuse) = if by_kind {
            self.weighted_by_kind((&light, &rules), &value, samples, beyond)
        } else {
            let pdf = samples * light.pdf;
            let weight = self.settings.weight_of_sampled(pdf, light.delta, value.pdf);
            (value.value * weight, value.diffuse * weight)
        };
        let arriving = light.contribution();
        let contribution = self.throughput * reflected * arriving / samples;
        let drawn = |share| Step::Light {
            light: Some(Lit {
                source: world.lights.drawn(at, u.z),
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
            self.light.apart.step(|| drawn(None));
            return;
        }
        let start = spawn_ray::<E>(world, self.settings, (hit, surface), light.wi, beyond);
        let Some(start) = start else {
            return;
        };
        let left = self.transparent_left();
        let share = match light.target {
            _ if !casts_shadow => 1.0,
            Some(target) => world.transmittance_to::<E>(start, target, left),
            None => world.transmittance::<E>(start, light.wi, f32::INFINITY, left),
        };
        self.light.apart.step(|| drawn(Some(share)));
        if self.bounce == 0 {
            self.light
                .apart
                .first_scattering(reflected, diffuse, beyond);
        }
        self.light
            .add_scattered(self.settings, contribution * share, self.bounce);
        self.rays += 1;
    }

    /// The BSDF's value, weighted, and its diffuse part, where some kinds of rays do not see a light: each kind is an estimate
    /// of its own.
    #[inline(always)]
    fn weighted_by_kind(
        &self,
        (light, rules): (&LightSample, &Rules),
        value: &BsdfValue,
        samples: f32,
        beyond: bool,
    ) -> (Vec3, Vec3) {
        let delta = light.delta || rules.shines_through();
        let part = |kind, part: Vec3, pdf| {
            if rules.visibility.sees(kind) {
                part * self
                    .settings
                    .weight_of_sampled(samples * light.pdf, delta, pdf)
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
    // It may be infinite: a light of 3e38 over a density below 1.
    debug_assert!(
        light.contribution().min_element() >= 0.0,
        "light {}",
        light.contribution()
    );
}
