//! A path from the camera: at each surface light is looked for by sampling the lights and by
//! sampling the BSDF, the two weighted by multiple importance sampling
//! (Veach 1997, chapters 8 to 10; Kajiya 1986).

use crate::effects::{self, ENVIRONMENT, LAMPS, MESH_LIGHTS, Mask, SUNS, TRANSMISSION};
use crate::film::pixel::{FirstHit, NO_DEPTH};
use crate::light::power_heuristic;
use crate::math::float::ray_origin;
use crate::sampler::{Dimension, Sampler};
use crate::shading::Bsdf;
use crate::world::{Shaded, Surface, World};
use glam::{Vec2, Vec3};

/// What a path takes from the settings.
#[derive(Clone, Copy, Debug)]
pub struct PathSettings {
    /// Indirect bounces: 0 is direct light only, as Cycles counts "Max Bounces".
    pub bounces: u32,
    /// Light is found by sampling lights.
    pub sample_lights: bool,
    /// Light is found by sampling BSDFs.
    pub sample_bsdf: bool,
}

/// What a path brings back.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Radiance at the camera.
    pub radiance: Vec3,
    /// Rays that were traced.
    pub rays: u32,
    /// Features of the first hit.
    pub first: FirstHit,
}

/// The vertex from which a ray was sent, as the weights of what it finds need it.
struct Previous {
    at: Shaded,
    /// Density of the BSDF sample.
    pdf: f32,
    /// Light sampling could not have found what the ray finds.
    only_bsdf: bool,
}

impl PathSettings {
    /// Weight of light that a BSDF sample found with density `previous.pdf`, and that light
    /// sampling finds with `light_pdf`.
    #[inline]
    fn weight_of_found(&self, previous: &Previous, light_pdf: f32) -> f32 {
        if previous.only_bsdf || light_pdf <= 0.0 || !self.sample_lights {
            1.0
        } else if self.sample_bsdf {
            power_heuristic(previous.pdf, light_pdf)
        } else {
            0.0
        }
    }

    /// Weight of light that light sampling found.
    #[inline]
    fn weight_of_sampled(&self, light_pdf: f32, delta: bool, bsdf_pdf: f32) -> f32 {
        if delta || !self.sample_bsdf {
            1.0 // Points and parallel light: nothing else finds them, whatever was asked for.
        } else if self.sample_lights {
            power_heuristic(light_pdf, bsdf_pdf)
        } else {
            0.0
        }
    }
}

/// Traces one path through a point of the film (−1..1 in x and y).
pub fn trace<const E: Mask>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    film: Vec2,
) -> Path {
    let camera_ray = world.camera.ray(film);
    let (mut origin, mut direction) = (camera_ray.origin, camera_ray.direction);
    let (mut near, mut far) = (camera_ray.near, camera_ray.far);
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    let mut rays = 0;
    let mut first = FirstHit {
        depth: NO_DEPTH,
        ..FirstHit::default()
    };
    let mut previous = Previous {
        at: Shaded {
            point: origin,
            normal: None,
        },
        pdf: 0.0,
        only_bsdf: true,
    };

    let mut bounce = 0;
    loop {
        // ---- The next surface, and the lamps on the way to it ----
        rays += 1;
        let hit = world.intersect::<E>(
            origin,
            direction,
            near,
            far,
            sampler.key(Dimension::Opacity, bounce),
        );
        if effects::has(E, LAMPS) && bounce > 0 {
            let end = hit.map_or(far, |h| h.distance);
            world.lights.lamps_along(
                &previous.at,
                origin,
                direction,
                end,
                |emitted, light_pdf| {
                    radiance +=
                        throughput * emitted * settings.weight_of_found(&previous, light_pdf);
                },
            );
        }
        let Some(hit) = hit else {
            if effects::has(E, ENVIRONMENT | SUNS) {
                if bounce == 0 {
                    radiance += world.lights.background(direction);
                } else {
                    world
                        .lights
                        .from_infinity(&previous.at, direction, |emitted, light_pdf| {
                            radiance += throughput
                                * emitted
                                * settings.weight_of_found(&previous, light_pdf);
                        });
                }
            }
            break;
        };
        let surface = world.surface::<E>(&hit, direction);

        // ---- Emission ----
        if effects::has(E, MESH_LIGHTS) && surface.emission != Vec3::ZERO {
            let light_pdf = if bounce == 0 || surface.emitter == u32::MAX || !settings.sample_lights
            {
                0.0
            } else {
                world
                    .lights
                    .triangle_pdf(&previous.at, surface.emitter, &surface.point)
            };
            radiance +=
                throughput * surface.emission * settings.weight_of_found(&previous, light_pdf);
        }
        if bounce == 0 {
            first.depth = world.camera.depth(surface.point.point);
            first.position = world.origin + surface.point.point.as_dvec3();
            first.normal = surface.normals.shading;
        }

        // ---- The BSDF ----
        let Some(parameters) = &surface.parameters else {
            break;
        };
        if bounce > settings.bounces {
            break;
        }

        // ---- Russian roulette ----
        // Only here, when the light that the ray found has been added: the ray is the other half of the
        // estimate of direct light, and roulette before it would make that noisier. With the square root
        // of the throughput: half-way, in variance, between always going on and keeping the throughput
        // constant.
        if bounce > 0 {
            let survival = throughput.max_element().sqrt().min(1.0);
            if survival < 1.0 {
                if sampler.single(Dimension::Roulette, bounce) >= survival {
                    break;
                }
                throughput /= survival;
            }
        }

        let wo = -direction;
        let bsdf = if effects::has(E, TRANSMISSION) {
            Bsdf::new::<true>(
                parameters,
                surface.dielectrics,
                surface.normals,
                wo,
                surface.inside,
            )
        } else {
            Bsdf::new::<false>(
                parameters,
                surface.dielectrics,
                surface.normals,
                wo,
                surface.inside,
            )
        };
        if bounce == 0 {
            first.albedo = bsdf.albedo();
        }
        let at = Shaded {
            point: surface.point.point,
            normal: bsdf.receiving_normal(),
        };

        // ---- Direct light (next-event estimation) ----
        if bsdf.is_samplable() && !world.lights.is_empty() {
            rays += direct_light::<E>(
                world,
                settings,
                sampler,
                bounce,
                &surface,
                &bsdf,
                &at,
                throughput,
                &mut radiance,
            );
        }

        // ---- Onwards ----
        let Some(s) = bsdf.sample(
            sampler.pair(Dimension::Lobe, bounce),
            sampler.pair(Dimension::Direction, bounce),
        ) else {
            break;
        };
        throughput *= s.weight;
        // NaN goes on, to be counted at the film.
        if throughput.max_element() <= 0.0 {
            break;
        }
        previous = Previous {
            at,
            pdf: s.pdf,
            only_bsdf: s.delta,
        };
        origin = ray_origin(surface.point, surface.normals.geometric, s.wi);
        direction = s.wi;
        (near, far) = (0.0, f32::INFINITY);
        bounce += 1;
    }
    Path {
        radiance,
        rays,
        first,
    }
}

/// Adds the light of one light sample; returns the rays it took.
#[allow(clippy::too_many_arguments)]
#[inline]
fn direct_light<const E: Mask>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    bounce: u32,
    surface: &Surface,
    bsdf: &Bsdf,
    at: &Shaded,
    throughput: Vec3,
    radiance: &mut Vec3,
) -> u32 {
    let u_light = sampler.single(Dimension::Light, bounce);
    let u = sampler.pair(Dimension::LightPosition, bounce);
    let Some(light) = world.lights.sample(world, at, u_light, u) else {
        return 0;
    };
    let value = bsdf.evaluate(light.wi);
    let contribution = throughput
        * value.value
        * light.contribution
        * settings.weight_of_sampled(light.pdf, light.delta, value.pdf);
    if contribution == Vec3::ZERO {
        return 0;
    }
    let start = ray_origin(surface.point, surface.normals.geometric, light.wi);
    let share = match light.target {
        Some(target) => world.transmittance_to::<E>(start, target),
        None => world.transmittance::<E>(start, light.wi, f32::INFINITY),
    };
    *radiance += contribution * share;
    1
}
