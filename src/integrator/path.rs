//! A path from the camera: at each surface light is looked for by sampling the lights and by
//! sampling the BSDF, the two weighted by multiple importance sampling
//! (Veach 1997, chapters 8 to 10; Kajiya 1986).

use super::record::{End, Lit, Record, Scattered, Step};
use crate::camera::CameraRay;
use crate::effects::{Features, General};
use crate::film::apart::{Apart, Together};
use crate::film::pixel::{FirstHit, Middle};
use crate::light::power_heuristic;
use crate::math::float::{BoundedPoint, RAY_START, is_unit};
use crate::math::luminance;
use crate::sampler::{Dimension, Sampler};
use crate::shading::{Bsdf, Kinds, Scattering};
use crate::world::{Hit, Met, Passage, RayKind, Shaded, Source, Surface, World};
use glam::{Vec2, Vec3};
use std::marker::PhantomData;

/// What a path takes from the settings.
#[derive(Clone, Copy, Debug)]
pub struct PathSettings {
    /// Indirect bounces: 0 is direct light only, as Cycles counts "Max Bounces".
    pub bounces: u32,
    /// The same for the scatterings of one kind, in the order of [`Scattering`]; `u32::MAX` for no limit.
    pub limits: [u32; 3],
    /// Surfaces that a path may pass by their opacity, as Cycles counts its transparent "Max Bounces";
    /// `u32::MAX` for no limit.
    pub transparent: u32,
    /// Greatest mean of the channels that one contribution may have: direct light, indirect light.
    /// Infinite for no limit.
    pub clamp: [f32; 2],
    /// Cycles' "Filter Glossy"; 0 for none.
    pub filter_glossy: f32,
    /// The world is no part of the picture where the camera looks straight at it.
    pub transparent_film: bool,
    /// What reflects, and what lets through, still does so behind a diffuse reflection.
    pub caustics: [bool; 2],
    /// Light is found by sampling lights.
    pub sample_lights: bool,
    /// Light is found by sampling BSDFs.
    pub sample_bsdf: bool,
    /// Directions are drawn without a look at the BSDF, wherever that can work. For studies; the general
    /// kernel alone can do it.
    pub uniform: bool,
    /// Rays start at a fixed distance off surfaces. For studies; the general kernel alone can do it.
    pub naive_offsets: bool,
    /// Light samples at the surface that the camera sees; their mean counts. At all others it is one.
    pub light_samples: u32,
    /// The first bounce that Russian roulette may be played at; `u32::MAX` for none.
    pub roulette: u32,
}

/// What a path brings back.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Radiance at the camera.
    pub radiance: Vec3,
    /// Luminance that clamping took from direct and from indirect light.
    pub clamped: [f32; 2],
    /// Rays that were traced.
    pub rays: u32,
    /// Features of the first hit.
    pub first: FirstHit,
}

/// The vertex from which a ray was sent, as the weights of what it finds need it.
struct Previous {
    at: Shaded,
    /// Density of the BSDF sample, for each light sample that was taken beside it.
    pdf: f32,
    /// Light sampling could not have found what the ray finds.
    only_bsdf: bool,
    /// What the surface did; `None` at the camera. With [`Scattering::Transmission`] the ray goes on
    /// beyond the surface; Cycles' ray visibility has the same three kinds.
    scattering: Option<Scattering>,
}

impl Previous {
    /// The kind of the ray.
    #[inline]
    fn kind(&self) -> RayKind {
        self.scattering.map_or(RayKind::Camera, kind_of)
    }
}

/// The kind of the rays that leave from a scattering.
#[inline]
fn kind_of(scattering: Scattering) -> RayKind {
    match scattering {
        Scattering::Diffuse => RayKind::Diffuse,
        Scattering::Glossy => RayKind::Glossy,
        Scattering::Transmission => RayKind::Transmission,
    }
}

/// Light that a path has gathered.
struct Gathered<'a, A> {
    radiance: Vec3,
    clamped: [f32; 2],
    apart: &'a mut A,
}

impl<A: Apart + Record> Gathered<'_, A> {
    /// Adds one contribution. `bounces`: scatterings between the camera and the surface that the light
    /// falls on, so that 0 is direct light; light that the camera sees itself counts as direct.
    ///
    /// As Cycles clamps: each contribution by itself, weights of multiple importance sampling included,
    /// scaled as a whole so that the mean of its channels is at most the limit.
    #[inline]
    fn add(&mut self, settings: &PathSettings, light: Vec3, bounces: u32) -> Vec3 {
        let indirect = usize::from(bounces > 0);
        let mean = light.element_sum() * (1.0 / 3.0);
        let limit = settings.clamp[indirect];
        let kept = if mean > limit {
            let kept = light * (limit / mean);
            self.clamped[indirect] += luminance(light - kept);
            kept
        } else {
            light
        };
        self.radiance += kept;
        self.apart.step(|| Step::Added { light, kept });
        kept
    }

    /// Weight of radiance that a ray has found and that light sampling finds with density `light_pdf`.
    #[inline]
    fn weigh(
        &mut self,
        settings: &PathSettings,
        previous: &Previous,
        source: Source,
        radiance: Vec3,
        light_pdf: f32,
    ) -> f32 {
        let weight = settings.weight_of_found(previous, light_pdf);
        self.apart.step(|| Step::Found {
            source,
            radiance,
            bsdf_pdf: previous.pdf,
            light_pdf,
            weight,
        });
        weight
    }

    /// Adds light of something that shines and that a ray has found after so many bounces: it falls on the
    /// surface before, or the camera sees it itself.
    #[inline]
    fn add_found(&mut self, settings: &PathSettings, light: Vec3, bounce: u32) {
        if bounce == 0 {
            let kept = self.add(settings, light, 0);
            self.apart.emission(kept);
        } else {
            self.add_scattered(settings, light, bounce - 1);
        }
    }

    /// Adds light that comes by way of at least one surface.
    #[inline]
    fn add_scattered(&mut self, settings: &PathSettings, light: Vec3, bounces: u32) {
        let kept = self.add(settings, light, bounces);
        self.apart.scattered(kept, bounces > 0);
    }
}

impl PathSettings {
    /// Weight of light that a BSDF sample found with density `previous.pdf`, and that light
    /// sampling finds with `light_pdf`.
    #[inline]
    fn weight_of_found(&self, previous: &Previous, light_pdf: f32) -> f32 {
        if previous.only_bsdf || light_pdf <= 0.0 {
            1.0
        } else if light_pdf.is_infinite() {
            0.0 // Lights without shadows: sampled lights reach farther than rays.
        } else if !self.sample_lights {
            1.0
        } else if self.sample_bsdf {
            power_heuristic(previous.pdf, light_pdf)
        } else {
            0.0
        }
    }

    /// Surfaces that a shadow ray may pass from a path that has passed some.
    #[inline]
    fn transparent_left(&self, passed: u32) -> u32 {
        if self.transparent == u32::MAX {
            u32::MAX
        } else {
            self.transparent.saturating_sub(passed)
        }
    }

    /// The least α that a surface is given after a path whose least density is `min_pdf`: a ray that
    /// came by a blurring bounce cannot tell a sharp highlight from a soft one, and the soft one is far
    /// less noisy. It changes the picture. Cycles' curve: ½ √(1 − p/x), nothing once p reaches x.
    #[inline]
    fn least_alpha(&self, min_pdf: f32) -> f32 {
        0.5 * (1.0 - min_pdf / self.filter_glossy).max(0.0).sqrt()
    }

    /// Whether a surface takes one light sample.
    #[inline]
    fn takes_one(&self, bounce: u32) -> bool {
        bounce > 0 || self.light_samples == 1
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

/// Surfaces as a kernel has them.
#[derive(Clone, Copy, Debug)]
struct Compiled<E>(PhantomData<E>);

impl<E: Features> Kinds for Compiled<E> {
    const FACETS: bool = E::FACETS;
    const TRANSMISSION: bool = E::EVERYTHING;
    const SMOOTH: bool = E::CURVED;
    const BUMPS: bool = E::EVERYTHING;
}

/// The BSDF of a kernel.
type KernelBsdf<E> = Bsdf<Compiled<E>>;

/// Traces the path that begins with a ray of the camera.
pub fn trace<E: Features>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    camera_ray: &CameraRay,
) -> Path {
    trace_apart::<E, Together>(world, settings, sampler, camera_ray, &mut Together)
}

/// The same, telling `apart` where the light comes from.
pub fn trace_apart<E: Features, A: Apart + Record>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    camera_ray: &CameraRay,
    apart: &mut A,
) -> Path {
    let (mut origin, mut direction) = (camera_ray.origin, camera_ray.direction);
    let (mut near, mut far) = (camera_ray.near, camera_ray.far);
    let mut gathered = Gathered {
        radiance: Vec3::ZERO,
        clamped: [0.0; 2],
        apart,
    };
    let mut throughput = Vec3::ONE;
    let mut rays = 0;
    let mut first = FirstHit::default();
    let mut previous = Previous {
        at: Shaded::unlit(origin),
        pdf: 0.0,
        only_bsdf: true,
        scattering: None,
    };
    let mut scatterings = [0u32; 3];
    // The path may end at the next surface: what shines there is its last light.
    let mut last = false;
    let mut passed = 0;
    let mut min_pdf = f32::INFINITY;

    // The surface that a direction is below, although its smooth normal sees it: the next one, without a ray.
    let mut own: Option<(Hit, BoundedPoint)> = None;
    let mut passage = Passage::default();

    let mut bounce = 0;
    loop {
        // ---- The next surface, and the lamps on the way to it ----
        let again = if E::CURVED { own.take() } else { None };
        rays += u32::from(again.is_none());
        gathered.apart.step(|| Step::Ray {
            bounce,
            kind: previous.kind(),
            origin,
            direction,
            span: (near, far),
            throughput,
        });
        let key = || sampler.key(Dimension::Opacity, bounce);
        let mut ended = false;
        let hit = if let Some((hit, _)) = again {
            Some(hit)
        } else if E::EVERYTHING && settings.transparent != u32::MAX {
            match world.intersect_limited::<E>(
                origin,
                direction,
                (near, far),
                previous.kind(),
                key(),
                // Cycles notices the limit when it has passed a surface: one always is.
                settings.transparent.max(1) - passed,
            ) {
                Met::Surface(hit, more) => {
                    passed += more;
                    last |= passed > 0 && passed >= settings.transparent;
                    Some(hit)
                }
                Met::Nothing => None,
                Met::Limit(distance) => {
                    ended = true;
                    far = distance;
                    None
                }
            }
        } else {
            world.intersect::<E>(origin, direction, (near, far), previous.kind(), key)
        };
        let hit = if E::EVERYTHING && world.has_close_interfaces() && again.is_none() {
            world.first_in_order(hit, &mut passage, (origin, direction), previous.kind())
        } else {
            hit
        };
        let ray = (previous.kind(), bounce.saturating_sub(1));
        if E::LIGHTS && (bounce > 0 || world.lights.camera_sees_lamps()) {
            let end = hit.map_or(far, |h| h.distance);
            world.lights.lamps_along::<E>(
                &previous.at,
                (origin, direction, end),
                ray,
                |emitted, light_pdf, source| {
                    let weight = gathered.weigh(settings, &previous, source, emitted, light_pdf);
                    gathered.add_found(settings, throughput * emitted * weight, bounce);
                },
            );
        }
        if ended {
            gathered.apart.step(|| Step::End(End::Transparent));
            break;
        }
        let Some(hit) = hit else {
            if bounce == 0 {
                first.transparent = settings.transparent_film;
            }
            if E::LIGHTS {
                world.lights.from_infinity::<E>(
                    &previous.at,
                    direction,
                    ray,
                    |emitted, light_pdf, source| {
                        let weight =
                            gathered.weigh(settings, &previous, source, emitted, light_pdf);
                        let light = throughput * emitted * weight;
                        if bounce > 0 || source != Source::Environment {
                            gathered.add_found(settings, light, bounce);
                        } else if settings.transparent_film {
                            gathered.apart.environment(light);
                        } else {
                            let kept = gathered.add(settings, light, 0);
                            gathered.apart.environment(kept);
                        }
                    },
                );
            }
            gathered.apart.step(|| Step::End(End::Nothing));
            break;
        };
        if bounce == 0 && world.is_holdout(&hit) {
            first.transparent = true;
            gathered.apart.step(|| Step::End(End::Holdout));
            break;
        }
        let mut surface = world.surface::<E>(&hit, origin, direction);
        if let Some((_, point)) = again {
            surface.point = point;
        }
        gathered.apart.step(|| Step::Surface {
            object: hit.object(),
            triangle: hit.primitive,
            weights: Vec2::new(hit.u, hit.v),
            distance: hit.distance,
            point: surface.point,
            normals: surface.normals,
            inside: surface.inside,
        });

        // ---- Emission ----
        if surface.emission != Vec3::ZERO {
            let unsampled = bounce == 0 || again.is_some() || surface.shining == u32::MAX;
            let light_pdf = if unsampled || !settings.sample_lights {
                0.0
            } else {
                world
                    .lights
                    .triangle_pdf::<E>(&previous.at, surface.shining, &surface.point)
            };
            let source = Source::Surface(hit.object());
            let weight = gathered.weigh(settings, &previous, source, surface.emission, light_pdf);
            let emitted = throughput * surface.emission * weight;
            gathered.add_found(settings, emitted, bounce);
        }
        if bounce == 0 {
            first.normal = surface.normals.shading;
        }

        // ---- The BSDF ----
        let Some(parameters) = &surface.parameters else {
            gathered.apart.step(|| Step::End(End::Unlit));
            break;
        };
        if last {
            gathered.apart.step(|| Step::End(End::Bounces));
            break;
        }

        // ---- Russian roulette ----
        // Only here, when the light that the ray found has been added: the ray is the other half of the
        // estimate of direct light, and roulette before it would make that noisier. With the square root
        // of the throughput: half-way, in variance, between always going on and keeping the throughput
        // constant. Not at the first bounce if one is not asked to: it carries most of the indirect light, and
        // on the scenes of the gallery roulette there saves 2 to 12 % of the time for 3 to 25 % more variance.
        if bounce >= settings.roulette {
            let survival = throughput.max_element().sqrt().min(1.0);
            if survival < 1.0 {
                let drawn = sampler.single(Dimension::Roulette, bounce);
                gathered.apart.step(|| Step::Roulette { survival, drawn });
                if drawn >= survival {
                    gathered.apart.step(|| Step::End(End::Roulette));
                    break;
                }
                throughput /= survival;
            }
        }

        let mut parameters = *parameters;
        if E::FACETS && settings.filter_glossy > 0.0 {
            parameters.roughen(settings.least_alpha(min_pdf));
        }
        // As Cycles leaves caustics out: the kind of the ray decides, so that a reflection seen in a mirror stays.
        let cut = E::FACETS
            && settings.caustics != [true; 2]
            && previous.scattering == Some(Scattering::Diffuse);
        if cut && !settings.caustics[0] {
            parameters.specular = 0.0;
        }
        let wo = -direction;
        let mut bsdf = KernelBsdf::<E>::new(
            &parameters,
            surface.dielectrics,
            surface.normals,
            wo,
            surface.inside,
        );
        if cut {
            bsdf.cut(settings.caustics);
        }
        if bounce == 0 {
            first.albedo = bsdf.albedo();
            gathered
                .apart
                .first_surface(|| bsdf.colors(), || world.texture_coordinates(&hit));
        }
        let at = world
            .lights
            .shaded::<E>(surface.point.point, bsdf.receiving_normal());

        // ---- Direct light (next-event estimation) ----
        if bsdf.is_samplable() && !world.lights.is_empty() {
            let vertex = || Vertex::<E> {
                bounce,
                hit: &hit,
                surface: &surface,
                bsdf: &bsdf,
                at: &at,
                throughput,
                transparent: settings.transparent_left(passed),
            };
            rays += if settings.takes_one(bounce) {
                direct_light::<E, A>(world, settings, sampler, &vertex(), 1.0, &mut gathered)
            } else {
                direct_lights::<E, A>(world, settings, sampler, &vertex(), &mut gathered)
            };
        }

        // ---- Onwards ----
        let u = sampler.triple(Dimension::Bsdf, bounce);
        // In the general kernel alone: the choice costs half a percent of the instructions.
        let drawn = if E::EVERYTHING && settings.uniform {
            bsdf.sample_uniform(u)
        } else {
            bsdf.sample(u)
        };
        let Some(s) = drawn else {
            gathered.apart.step(|| Step::Scattered {
                sample: None,
                numbers: u,
            });
            gathered.apart.step(|| Step::End(End::Absorbed));
            break;
        };
        // Where some kinds of rays see less than others, each kind is an estimate of its own.
        let alone = E::EVERYTHING && world.by_kind;
        let (weight, pdf) = if alone { s.alone } else { (s.weight, s.pdf) };
        debug_assert!(is_unit(s.wi), "direction {}", s.wi);
        debug_assert!(
            weight.min_element() >= 0.0 && weight.is_finite(),
            "weight {weight}"
        );
        debug_assert!(s.delta || (pdf > 0.0 && pdf.is_finite()), "density {pdf}");
        debug_assert!(
            settings.uniform || weight.max_element() <= bsdf.greatest_weight(),
            "weight {weight} of at most {}",
            bsdf.greatest_weight()
        );
        gathered.apart.step(|| Step::Scattered {
            sample: Some(Scattered {
                scattering: s.scattering,
                direction: s.wi,
                weight,
                pdf,
                delta: s.delta,
            }),
            numbers: u,
        });
        let beyond = s.scattering == Scattering::Transmission;
        let (start, onward) = match leave::<E>(world, settings, (&hit, &surface), s.wi, beyond) {
            Some(start) => (start, s.wi),
            None => {
                let Some(back) =
                    world.meets_itself::<E>(&hit, &surface, s.wi, kind_of(s.scattering))
                else {
                    gathered.apart.step(|| Step::End(End::Own));
                    break;
                };
                own = Some((
                    Hit {
                        distance: 0.0,
                        ..hit
                    },
                    surface.point,
                ));
                (surface.point.point, back)
            }
        };
        if bounce == 0 {
            let diffuse = match s.scattering {
                _ if !alone => s.diffuse,
                Scattering::Diffuse => weight,
                _ => Vec3::ZERO,
            };
            gathered.apart.first_scattering(weight, diffuse, beyond);
        }
        throughput *= weight;
        // NaN goes on, to be counted at the film.
        if throughput.max_element() <= 0.0 {
            gathered.apart.step(|| Step::End(End::Black));
            break;
        }
        previous = Previous {
            at,
            pdf: if settings.takes_one(bounce) {
                pdf
            } else {
                pdf / settings.light_samples as f32
            },
            // No light sample passes the surface that is in its way.
            only_bsdf: s.delta || own.is_some(),
            scattering: Some(s.scattering),
        };
        if !s.delta {
            min_pdf = min_pdf.min(s.pdf);
        }
        origin = start;
        direction = onward;
        (near, far) = if own.is_some() {
            (0.0, 0.0)
        } else {
            (RAY_START, f32::INFINITY)
        };
        bounce += 1;
        let kind = s.scattering as usize;
        scatterings[kind] += 1;
        last = bounce > settings.bounces || scatterings[kind] > settings.limits[kind];
    }
    Path {
        radiance: gathered.radiance,
        clamped: gathered.clamped,
        rays,
        first,
    }
}

/// How far rays start off surfaces in toy renderers, metres.
const NAIVE_OFFSET: f32 = 1e-4;

/// Where a ray starts that leaves a surface; `None` where the surface is in its way.
#[inline]
fn leave<E: Features>(
    world: &World,
    settings: &PathSettings,
    (hit, surface): (&Hit, &Surface),
    direction: Vec3,
    beyond: bool,
) -> Option<Vec3> {
    if E::EVERYTHING && settings.naive_offsets {
        let normal = surface.normals.geometric;
        let offset = normal * NAIVE_OFFSET.copysign(direction.dot(normal));
        return Some(surface.point.point + offset);
    }
    world.leave::<E>(hit, surface, direction, beyond)
}

/// A surface that light falls on, and the path to it.
struct Vertex<'a, E: Features> {
    bounce: u32,
    hit: &'a Hit,
    surface: &'a Surface<'a>,
    bsdf: &'a KernelBsdf<E>,
    at: &'a Shaded,
    throughput: Vec3,
    /// Surfaces that a shadow ray may pass.
    transparent: u32,
}

/// Adds the mean light of some light samples; returns the rays it took. Out of the way of the path that takes
/// one.
#[cold]
#[inline(never)]
fn direct_lights<E: Features, A: Apart + Record>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    vertex: &Vertex<E>,
    gathered: &mut Gathered<A>,
) -> u32 {
    let samples = settings.light_samples;
    (0..samples)
        .map(|part| {
            let sampler = sampler.part(part, samples);
            direct_light::<E, A>(world, settings, &sampler, vertex, samples as f32, gathered)
        })
        .sum()
}

/// Adds the light of one of some light samples; returns the rays it took.
#[inline(always)]
fn direct_light<E: Features, A: Apart + Record>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    vertex: &Vertex<E>,
    samples: f32,
    gathered: &mut Gathered<A>,
) -> u32 {
    let &Vertex {
        bounce,
        hit,
        surface,
        bsdf,
        at,
        throughput,
        transparent,
    } = vertex;
    let u = sampler.triple(Dimension::Light, bounce);
    let Some(light) = world.lights.sample::<E>(world, at, u.z, u.truncate()) else {
        gathered.apart.step(|| Step::Light {
            light: None,
            numbers: u,
        });
        return 0;
    };
    debug_assert!(is_unit(light.wi), "direction {}", light.wi);
    debug_assert!(
        light.pdf >= 0.0 && light.pdf.is_finite(),
        "density {}",
        light.pdf
    );
    // It may be infinite: a light of 3e38 over a density below 1.
    debug_assert!(
        light.contribution.min_element() >= 0.0,
        "light {}",
        light.contribution
    );
    let value = bsdf.evaluate(light.wi);
    debug_assert!(
        value.value.min_element() >= 0.0 && value.value.is_finite() && value.pdf >= 0.0,
        "{value:?}"
    );
    let by_kind = E::EVERYTHING && world.by_kind;
    let casts_shadow = !by_kind || light.rules.visibility.sees(RayKind::Shadow);
    let delta = light.delta || !casts_shadow;
    let beyond = bsdf.is_beyond(light.wi);
    let (reflected, diffuse) = if by_kind {
        if bounce > light.rules.max_bounces {
            return 0;
        }
        let other = if beyond {
            RayKind::Transmission
        } else {
            RayKind::Glossy
        };
        let part = |kind, part: Vec3, pdf| {
            if light.rules.visibility.sees(kind) {
                part * settings.weight_of_sampled(samples * light.pdf, delta, pdf)
            } else {
                Vec3::ZERO
            }
        };
        let diffuse = part(RayKind::Diffuse, value.diffuse, value.diffuse_pdf);
        let rest = part(
            other,
            value.value - value.diffuse,
            value.pdf - value.diffuse_pdf,
        );
        (diffuse + rest, diffuse)
    } else {
        let weight = settings.weight_of_sampled(samples * light.pdf, delta, value.pdf);
        (value.value * weight, value.diffuse * weight)
    };
    let contribution = throughput * reflected * light.contribution / samples;
    let drawn = |share| Step::Light {
        light: Some(Lit {
            source: world.lights.drawn(at, u.z),
            direction: light.wi,
            pdf: light.pdf,
            contribution: light.contribution,
            bsdf: value.value,
            bsdf_pdf: value.pdf,
            weighted: reflected,
            share,
        }),
        numbers: u,
    };
    if contribution == Vec3::ZERO {
        gathered.apart.step(|| drawn(None));
        return 0;
    }
    let Some(start) = leave::<E>(world, settings, (hit, surface), light.wi, beyond) else {
        return 0;
    };
    let share = match light.target {
        _ if !casts_shadow => 1.0,
        Some(target) => world.transmittance_to::<E>(start, target, transparent),
        None => world.transmittance::<E>(start, light.wi, f32::INFINITY, transparent),
    };
    gathered.apart.step(|| drawn(Some(share)));
    if bounce == 0 {
        gathered.apart.first_scattering(reflected, diffuse, beyond);
    }
    gathered.add_scattered(settings, contribution * share, bounce);
    1
}

/// What a ray of the camera meets; a holdout counts as nothing, as in Cycles.
pub fn meet(world: &World, sampler: &Sampler, ray: &CameraRay) -> Middle {
    let key = || sampler.key(Dimension::Opacity, 0);
    let hit = world.intersect::<General>(
        ray.origin,
        ray.direction,
        (ray.near, ray.far),
        RayKind::Camera,
        key,
    );
    let hit = hit.filter(|hit| !world.is_holdout(hit));
    hit.map_or(Middle::default(), |hit| {
        let point = ray.origin + ray.direction * hit.distance;
        Middle {
            depth: world.camera.depth(point),
            position: (world.origin + point.as_dvec3()).as_vec3(),
        }
    })
}
