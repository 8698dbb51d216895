//! A path from the camera: at each surface light is looked for by sampling the lights and by
//! sampling the BSDF, the two weighted by multiple importance sampling
//! (Veach 1997, chapters 8 to 10; Kajiya 1986).

mod approximated;
mod below;
mod blended;
mod ends;
mod leave;
mod media;
mod onward;
mod passing;
mod past;
mod portal;
mod rounds;
mod start;
mod wide;

use blended::alpha;
pub(super) use blended::is_enough;
pub use onward::behind;
pub(super) use onward::{HeldOut, Tinted, tinted};
use onward::{Passing, Stopped};

use super::accumulator::Accumulator;
use super::direct::Vertex;
use super::record::{End, Record, Scattered, Step};
use super::settings::PathSettings;
use crate::camera::CameraRay;
use crate::effects::Features;
use crate::film::catchers::Split;
use crate::film::features::SurfaceFeatures;
use crate::film::light_passes::{NoPasses, PassSink};
use crate::film::pixel::FirstHit;
use crate::light::{LightSampleContext, Shadows};
use crate::math::float::{BoundedPoint, is_unit};
use crate::sampler::{Dimension, Sampler};
use crate::shading::{Bsdf, BsdfFeatures, BsdfSample, Scattering};
use crate::world::{
    Asking, Hit, LeftStrand, OtherSide, Passage, Past, RayKind, Scratch, Sender, Source, Surface,
    Widening, Within, World,
};
use glam::Vec3;
use std::marker::PhantomData;

pub(super) use start::{spawn_light_ray, spawn_ray};

/// Tells the number of a path's wavelength from all others.
const WAVELENGTH: u32 = 0x_7a3c_19e5;

/// What a path brings back.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Radiance at the camera.
    pub radiance: Vec3,
    /// Luminance that clamping took from direct and from indirect light.
    pub clamped: [f32; 2],
    /// Rays that were traced.
    pub rays: u32,
    /// Lobes that surfaces with too many of them went without.
    pub lobes_left_out: u32,
    /// Features of the first hit.
    pub first: FirstHit,
}

impl Path {
    /// Of no ray: black.
    pub const NONE: Self = Self {
        radiance: Vec3::ZERO,
        clamped: [0.0; 2],
        rays: 0,
        lobes_left_out: 0,
        first: FirstHit::NONE,
    };
}

/// The vertex from which a ray was sent, as the weights of what it finds need it.
#[derive(Clone)]
pub(super) struct Previous {
    pub at: LightSampleContext,
    /// Density of the BSDF sample, for each light sample that was taken beside it.
    pub pdf: f32,
    /// Light sampling could not have found what the ray finds.
    pub only_bsdf: bool,
    /// The kind of the ray. With [`RayKind::Transmission`] it goes on beyond the surface.
    pub kind: RayKind,
    /// It was a mirror or clear glass.
    pub delta: bool,
}

/// The kind of the rays that leave from a scattering: Cycles' ray visibility has the same three.
#[inline]
fn kind_of(scattering: Scattering) -> RayKind {
    match scattering {
        Scattering::Diffuse => RayKind::Diffuse,
        Scattering::Glossy => RayKind::Glossy,
        Scattering::Transmission => RayKind::Transmission,
    }
}

/// Of what else a ray that goes through a surface is: [`LightSampleContext::also`].
fn also(sample: &BsdfSample) -> u32 {
    if sample.is_translucent {
        RayKind::Diffuse.bit()
    } else {
        RayKind::Glossy.bit()
    }
}

/// Surfaces as a kernel has them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compiled<E>(PhantomData<E>);

impl<E: Features> BsdfFeatures for Compiled<E> {
    const FACETS: bool = E::FACETS;
    const TRANSMISSION: bool = E::EVERYTHING;
    const SMOOTH: bool = E::CURVED;
    const BUMPS: bool = E::EVERYTHING;
}

/// The BSDF of a kernel.
pub(super) type KernelBsdf<E> = Bsdf<Compiled<E>>;

/// A hit that the path stops at.
#[derive(Default)]
struct Found {
    hit: Hit,
    /// The path has left the same surface: it is met again in [`Walk::own`], without a ray.
    again: bool,
    /// What it emits has been added.
    has_shone: bool,
}

/// What functions that are not inlined look at or change, and what is found by a number: a path stays in registers without.
#[derive(Clone)]
struct Beside {
    previous: Previous,
    /// By kind, in the order of [`Scattering`].
    scatterings: [u32; 3],
    passage: Passage,
    /// How far it had come when it was scattered last, and since then to surfaces that it has passed; the near plane of a ray
    /// of the camera.
    way: f32,
    wide: Widening,
    walked: f32,
    near: f32,
    /// A face that lies on the surface which the ray leaves: the next one, without a ray.
    lid: Option<Hit>,
    /// Stands for the side of its surface that its point lies on by rounding, where faces lie in one place.
    side: u32,
    /// When it is on its way.
    time: f32,
    /// The media around it, and how often they have scattered it.
    within: Within,
    scattered_in_media: u32,
    /// The number after the last bounce on whose way the sampler's own number for flights was taken.
    flown: u32,
    /// A medium scatters it before it meets what was found.
    scattered: Option<media::Event>,
    /// How far from its surface the ray begins: that way leads through a medium, too.
    skipped: f32,
    /// Nanometres; 0 where no index of refraction depends on it.
    wavelength: f32,
    /// What is on the other side of the surface that it has met.
    other_side: OtherSide,
    /// What the path counts from the first such surface on.
    counts: Option<Vec3>,
    /// What [`Walk::clamp_as_if`] has changed: times its throughput this is what roulette goes by.
    unplayed: f32,
    /// What that is to change once the path is scattered: what the camera sees directly counts as it is.
    deferred: f32,
    /// Lobes that surfaces with too many of them went without.
    lobes_left_out: u32,
    /// How far the ray sees from what it leaves if it stands for all further bounces.
    reach: f32,
    /// The strand that its ray leaves.
    left: Option<LeftStrand>,
    /// Portals that it has come to, and whether it goes on behind the last.
    portals: u32,
    is_through: bool,
    /// Of the surfaces that it has passed those that only bound a medium.
    bounds: u32,
    /// A bounce, and the surfaces that the path has passed since, at which it might have stopped to choose.
    tints: (u32, u32),
    rounds: rounds::Rounds,
    /// How it has stopped at its surface, if it could have passed that.
    stopped: Option<Stopped>,
    /// Whether passes of data have their surface.
    is_noted: bool,
    /// How much of the picture is empty, by what the path has met.
    seen_through: f32,
    /// All that has scattered it is glass through which the film is transparent.
    is_clear: bool,
}

impl Beside {
    /// A surface that light falls on. `way`: what the path brings there, how often it was scattered and has passed surfaces.
    #[inline(always)]
    fn vertex<'v, E: Features>(
        &'v self,
        (world, settings): (&'v World, &'v PathSettings),
        (hit, surface): (&'v Hit, &'v Surface),
        (bsdf, past): (&'v KernelBsdf<E>, &'v Past),
        (throughput, bounce, passed): (Vec3, u32, u32),
    ) -> Vertex<'v, E> {
        Vertex {
            world,
            settings,
            hit,
            surface,
            bsdf,
            at: &self.previous.at,
            throughput,
            bounce,
            side: self.side,
            transparent: settings.transparent_left(passed),
            past,
            within: &self.within,
        }
    }
}

/// A path on its way.
struct Walk<'a, 's, E, A> {
    world: &'a World,
    settings: &'a PathSettings,
    sampler: &'a Sampler,
    light: &'a mut Accumulator<'s, A>,
    throughput: Vec3,
    /// Surfaces that have scattered it.
    bounce: u32,
    rays: u32,
    origin: Vec3,
    direction: Vec3,
    span: (f32, f32),
    beside: &'a mut Beside,
    first: FirstHit,
    /// The path may end at the next surface: what shines there is its last light.
    last: bool,
    /// Surfaces that it has passed by their opacity.
    passed: u32,
    min_pdf: f32,
    /// The surface that a direction is below, although its smooth normal sees it: the next one, without a ray.
    own: Option<(Hit, BoundedPoint)>,
    features: PhantomData<E>,
}

/// Traces the path that begins with a ray of the camera.
pub fn trace<E: Features>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    camera_ray: &CameraRay,
) -> Path {
    trace_with_passes::<E, NoPasses>(world, settings, sampler, camera_ray, &mut NoPasses)
}

/// The same, telling `sink` where the light comes from.
pub fn trace_with_passes<E: Features, A: PassSink + Record>(
    world: &World,
    settings: &PathSettings,
    sampler: &Sampler,
    camera_ray: &CameraRay,
    sink: &mut A,
) -> Path {
    let mut light = Accumulator::new(sink);
    let mut beside = Beside {
        previous: Previous {
            at: LightSampleContext::new(camera_ray.origin, None).at_time(camera_ray.time),
            pdf: 0.0,
            only_bsdf: true,
            kind: RayKind::Camera,
            delta: false,
        },
        scatterings: [0; 3],
        passage: Passage::default(),
        way: 0.0,
        wide: Widening::default(),
        walked: 0.0,
        near: camera_ray.near,
        lid: None,
        side: 0,
        time: camera_ray.time,
        within: Within::default(),
        scattered_in_media: 0,
        flown: 0,
        scattered: None,
        skipped: 0.0,
        wavelength: 0.0,
        other_side: OtherSide::default(),
        counts: None,
        unplayed: 1.0,
        deferred: 1.0,
        lobes_left_out: 0,
        reach: f32::INFINITY,
        left: None,
        portals: 0,
        bounds: 0,
        is_through: false,
        tints: (0, 0),
        rounds: rounds::Rounds::default(),
        stopped: None,
        is_noted: false,
        seen_through: 0.0,
        is_clear: true,
    };
    if E::EVERYTHING
        && let Some(spectrum) = world.spectrum()
    {
        let drawn = spectrum.sample(sampler.beside(WAVELENGTH).single(Dimension::Filter, 0));
        (beside.wavelength, beside.counts) = (drawn.nanometres, Some(drawn.weight));
    }
    if E::EVERYTHING && world.has_media() {
        beside.within = world.media_at_camera();
    }
    let scene = (world, settings, sampler);
    let mut walk = Walk::<E, A>::new(scene, camera_ray, (&mut light, &mut beside));
    walk.go();
    walk.follow_portals();
    let (rays, first) = (walk.rays, walk.first);
    Path {
        radiance: light.radiance,
        clamped: light.clamped,
        rays,
        lobes_left_out: beside.lobes_left_out,
        first,
    }
}

impl<'a, 's, E: Features, A: PassSink + Record> Walk<'a, 's, E, A> {
    #[inline(always)]
    fn new(
        (world, settings, sampler): (&'a World, &'a PathSettings, &'a Sampler),
        ray: &CameraRay,
        (light, beside): (&'a mut Accumulator<'s, A>, &'a mut Beside),
    ) -> Self {
        Self {
            world,
            settings,
            sampler,
            light,
            throughput: Vec3::ONE,
            bounce: 0,
            rays: 0,
            origin: ray.origin,
            direction: ray.direction,
            span: (ray.near, ray.far),
            beside,
            first: FirstHit::default(),
            last: false,
            passed: 0,
            min_pdf: f32::INFINITY,
            own: None,
            features: PhantomData,
        }
    }

    /// Follows the path to its end.
    #[inline(always)]
    fn go(&mut self) {
        let (world, sampler) = (self.world, self.sampler);
        let mut found = Found::default();
        while self.next_surface(&mut found) {
            if E::EVERYTHING
                && let Some(scattered) = self.beside.scattered.take()
            {
                if !self.scatter(scattered) {
                    break;
                }
                continue;
            }
            let mut scratch = Scratch::default();
            let past = self.past();
            let asking = self.asking(&found.hit, &past);
            let roulette = self.roulette();
            let wanted = self.wanted(roulette);
            let at = (self.origin, asking);
            let mut surface = world.surface::<E>(&found.hit, at, wanted, &mut scratch);
            self.arrive(&found, &mut surface);
            if !(E::EVERYTHING && found.has_shone) {
                self.add_emission(&found, &surface, 1.0);
            }
            if !self.goes_on(&surface, roulette) {
                break;
            }
            if E::EVERYTHING && (surface.disperses || self.beside.other_side.disperses) {
                self.disperse();
            }
            let mut bsdf = self.bare(&found.hit, &surface);
            self.add_lobes(&mut bsdf, &mut surface);
            let lit = self.throughput * self.lit(&found.hit);
            if self.bounce == 0 {
                self.first.albedo = bsdf.albedo();
                let sink = &mut *self.light.sink;
                sink.first_colors(lit, || bsdf.colors());
            }
            self.light.sink.surface(|| features(&bsdf));
            // From here on for rays that leave it.
            let past = Past {
                left: if E::EVERYTHING {
                    world.strand_of(&found.hit)
                } else {
                    None
                },
                ..past
            };
            let receiver = self.beside.previous.at.receiver;
            self.receive(&found.hit, surface.point.point, bsdf.receiving());
            let met = (&found.hit, &surface);
            let scene = (world, self.settings);
            let way = (lit, self.bounce, self.counted());
            let vertex = self.beside.vertex::<E>(scene, met, (&bsdf, &past), way);
            self.rays += if E::EVERYTHING {
                vertex.add_direct_light(&self.light_numbers(), self.light)
            } else {
                vertex.add_direct_light(sampler, self.light)
            };
            if E::EVERYTHING && world.is_approximated() {
                let (there, numbers) = (alpha(self.brought().1), self.light_numbers());
                self.rays += vertex.add_openness(&numbers, there, self.light);
            }
            if self.bounce == 0 {
                let (there, numbers) = (self.there(), self.light_numbers());
                let sink = &mut *self.light.sink;
                self.rays += sink.occlusion(|distance| there * vertex.openness(&numbers, distance));
            }
            let leave = |path: &mut Walk<'_, '_, E, A>| path.leave(met, &bsdf, receiver);
            if E::EVERYTHING && self.is_to_branch() {
                self.branch(self.settings.branches.at_surface, leave);
                break;
            }
            if !leave(self) {
                break;
            }
        }
    }

    /// Takes note of where light falls on a surface, for those who look for it.
    #[inline(always)]
    fn receive(&mut self, hit: &Hit, point: Vec3, (normal, facing): (Option<Vec3>, (Vec3, bool))) {
        let lights = &self.world.lights;
        let at = &mut self.beside.previous.at;
        if E::EVERYTHING && lights.is_linked() {
            at.receiver = lights.receiver(hit.object());
        }
        lights.context_into(at, point, normal);
        at.facing = Some(facing);
        at.clamps = self.settings.clamp[usize::from(self.bounce > 0)].is_finite();
        at.bounces = self.bounce;
    }

    /// The ray, as programs at what it meets may ask about it.
    #[inline(always)]
    fn asking<'p>(&self, hit: &Hit, past: &'p Past) -> Asking<'p> {
        Asking::of(&self.sender(past), self.direction, hit)
    }

    /// The ray, as programs at what it passes may ask about it.
    #[inline(always)]
    fn sender<'p>(&self, past: &'p Past) -> Sender<'p> {
        Sender {
            kind: self.beside.previous.kind,
            depth: self.bounce,
            walked: self.beside.walked,
            near: self.beside.near,
            time: self.beside.time,
            blockers: 0,
            past,
        }
    }

    /// The path ends, for a reason. The path without a recorder has no code for it.
    #[inline(always)]
    fn end(&mut self, why: End) {
        self.light.sink.step(|| Step::End(why));
    }

    /// Takes note of a surface, which is where the path has left it if it is met again.
    #[inline(always)]
    fn arrive(&mut self, Found { hit, again, .. }: &Found, surface: &mut Surface) {
        if E::CURVED
            && *again
            && let Some((_, point)) = self.own.take()
        {
            surface.point = point;
        }
        self.light.sink.step(|| Step::met(hit, surface));
        // Depths begin at the clip plane, as in Cycles.
        self.light.sink.meet(hit.distance - self.span.0);
        if self.bounce == 0 {
            if E::EVERYTHING && self.world.is_catcher(hit) {
                let (throughput, before) = (self.throughput, self.light.radiance);
                self.light.sink.split(|| Split { throughput, before });
            }
            let (brought, passes) = self.brought();
            self.note(hit, surface, brought, passes);
        }
    }

    /// Light that the surface emits itself, as far as it is there.
    #[inline(always)]
    fn add_emission(&mut self, found: &Found, surface: &Surface, share: f32) {
        let Found { hit, again, .. } = found;
        if surface.emission == Vec3::ZERO {
            return;
        }
        if E::EVERYTHING && self.world.lights.is_linked() {
            let source = Source::Surface(hit.object());
            let (kind, receiver) = (self.beside.previous.kind, self.beside.previous.at.receiver);
            let lights = &self.world.lights;
            if !lights.is_found(source, receiver, (kind, Shadows::Plain)) {
                return;
            }
        }
        let unsampled = self.bounce == 0 || *again;
        let light_pdf = if unsampled || !self.settings.sample_lights {
            0.0
        } else {
            let triangle = (hit.object(), hit.primitive);
            let (at, on) = (&self.beside.previous.at, surface.point.point);
            let lights = &self.world.lights;
            lights.surface_pdf(at, self.direction, triangle, on)
        };
        let source = Source::Surface(hit.object());
        let emitted = surface.emission * share;
        let weight = self.light.weigh(
            self.settings,
            &self.beside.previous,
            source,
            emitted,
            light_pdf,
        );
        let found = self.throughput * emitted * weight;
        let kept = self.light.add_found(self.settings, found, self.bounce);
        self.light
            .sink
            .grouped(kept, || self.world.lights.group(source));
    }

    /// Whether it has been scattered diffusely.
    #[inline(always)]
    fn has_diffused(&self) -> bool {
        E::EVERYTHING && self.beside.scatterings[Scattering::Diffuse as usize] > 0
    }

    /// Becomes light of one wavelength, if it is not yet.
    #[inline]
    fn disperse(&mut self) {
        if let Some(counts) = self.beside.counts.take() {
            self.throughput *= counts;
        }
    }

    /// A surface without lobes, as the path sees it.
    #[inline(always)]
    fn bare(&self, hit: &Hit, surface: &Surface) -> KernelBsdf<E> {
        let mut changes = self.settings.changes::<E>(
            self.min_pdf,
            self.beside.previous.kind,
            self.has_diffused(),
        );
        if E::EVERYTHING {
            changes.behind = self.world.is_as_in_cycles();
            changes.steeper = self.world.steepness(hit);
        }
        KernelBsdf::<E>::new(surface.normals, -self.direction, surface.inside, changes)
    }

    /// Draws the next direction.
    #[inline(always)]
    fn sample(&mut self, bsdf: &KernelBsdf<E>, sampler: &Sampler) -> Option<BsdfSample> {
        let u = self.numbers(sampler);
        // In the general kernel alone: the choice costs half a percent of the instructions.
        let drawn = if E::EVERYTHING && self.settings.uniform {
            bsdf.sample_uniform(u)
        } else if E::EVERYTHING && self.world.has_media() {
            self.sample_in_media(bsdf, u)
        } else {
            bsdf.sample(u)
        };
        let Some(mut s) = drawn else {
            self.light.sink.step(|| Step::Scattered {
                sample: None,
                numbers: u,
            });
            self.end(End::Absorbed);
            return None;
        };
        if s.is_as_diffuse && self.world.is_as_in_cycles() {
            s.scattering = Scattering::Diffuse;
        }
        // Where some kinds of rays see less than others, each kind is an estimate of its own.
        if E::EVERYTHING && self.world.by_kind && !self.world.is_as_in_cycles() {
            (s.weight, s.pdf) = s.alone;
            s.diffuse = if s.scattering == Scattering::Diffuse {
                s.weight
            } else {
                Vec3::ZERO
            };
        }
        debug_assert!(is_unit(s.wi), "direction {}", s.wi);
        debug_assert!(
            s.weight.min_element() >= 0.0 && s.weight.is_finite(),
            "weight {}",
            s.weight
        );
        debug_assert!(
            s.delta || (s.pdf > 0.0 && s.pdf.is_finite()),
            "density {}",
            s.pdf
        );
        debug_assert!(
            self.settings.uniform || s.weight.max_element() <= bsdf.max_sample_weight(),
            "weight {} of at most {}",
            s.weight,
            bsdf.max_sample_weight()
        );
        self.light.sink.step(|| Step::Scattered {
            sample: Some(Scattered {
                scattering: s.scattering,
                direction: s.wi,
                weight: s.weight,
                pdf: s.pdf,
                delta: s.delta,
            }),
            numbers: u,
        });
        Some(s)
    }

    /// Goes on in a direction; whether the path has not ended.
    #[inline(always)]
    fn follow(
        &mut self,
        (hit, surface): (&Hit, &Surface),
        bsdf: &KernelBsdf<E>,
        s: &BsdfSample,
    ) -> bool {
        let beyond = s.beyond;
        let kind = kind_of(s.scattering);
        if self.world.ends_below::<E>(surface, s.wi, beyond) {
            self.end(End::Own);
            return false;
        }
        let next = (kind, self.bounce + 1);
        if !self.depart((hit, surface), s.wi, (beyond, beyond), next) {
            self.end(End::Own);
            return false;
        }
        if self.bounce == 0 {
            self.light
                .sink
                .first_scattering(s.weight, s.diffuse, || bsdf.through(s.wi));
        }
        self.beside.way += self.beside.walked + hit.distance;
        (self.beside.walked, self.beside.near) = (0.0, 0.0);
        self.throughput *= s.weight;
        // NaN goes on, to be counted at the film.
        if self.throughput.max_element() <= 0.0 {
            self.end(End::Black);
            return false;
        }
        self.beside.previous.pdf = if self.settings.takes_one(self.bounce) {
            s.pdf
        } else {
            s.pdf / self.settings.light_samples as f32
        };
        // No light sample passes the surface that is in its way.
        self.beside.previous.only_bsdf =
            s.delta || self.own.is_some() || E::EVERYTHING && self.beside.lid.is_some();
        self.beside.previous.kind = kind;
        if E::EVERYTHING {
            self.beside.is_clear &= s.beyond && s.alpha <= self.settings.clear_alpha;
            self.beside.previous.at.also = match kind {
                RayKind::Transmission if self.world.is_as_in_cycles() => also(s),
                _ => 0,
            };
        }
        self.beside.previous.delta = s.delta;
        self.bounce += 1;
        self.clamp_as_deferred();
        let kind = s.scattering as usize;
        let scatterings = &mut self.beside.scatterings[kind];
        *scatterings += 1;
        self.last =
            self.bounce > self.settings.bounces || *scatterings > self.settings.limits[kind];
        true
    }
}

/// What a surface is to denoisers.
fn features<E: Features>(bsdf: &KernelBsdf<E>) -> SurfaceFeatures {
    let mut features = SurfaceFeatures::default();
    for (normal, albedo, alpha) in bsdf.facets() {
        features.add(normal, albedo, alpha);
    }
    features
}
