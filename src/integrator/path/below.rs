//! Light below surfaces on the way of a path: it enters, walks through the object or goes as far as a profile says, and comes out
//! elsewhere, diffusely.

use super::Walk;
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::path::KernelBsdf;
use crate::integrator::record::{End, Record, Step};
use crate::math::float::{RAY_START, next_up, ray_origin};
use crate::medium::profile::{Probe, Profile};
use crate::medium::walk::{Inside, Mapping, Numbers, Start, walk};
use crate::sampler::{Dimension, Sampler, hashed};
use crate::shading::closure::Below;
use crate::shading::{Changes, Normals};
use crate::world::{Hit, Mixed, Passage, Scratch, Surface, Wanted};
use glam::Vec3;

/// Tells the numbers of walks from those of the vertices.
const WALK: u32 = 0x_b510_a1cd;
/// Tells the numbers where light comes out from those where it enters.
const EXIT: u32 = 0x_2e81_700d;

/// No radius is below so many times the offset of the first ray: floats could not go such a way, and no picture shows it. That ray
/// starts the offset below the surface. What is scattered on the way there is scattered at its end: a sixteenth of the light a
/// thirty-second of a free path too deep.
const LEAST_STEPS: f32 = 16.0;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// Goes on below the surface to where it comes out, takes the light there, and goes on from there. Whether the path has not
    /// ended.
    #[cold]
    #[inline(never)]
    pub(super) fn go_below(&mut self, hit: &Hit, surface: &Surface, below: &Below) -> bool {
        self.throughput *= below.weight;
        let Some((hit, inwards)) = self.way_out(hit, surface, below) else {
            self.end(End::Below);
            return false;
        };
        if self.throughput.max_element() <= 0.0 {
            self.end(End::Black);
            return false;
        }
        self.come_out(&hit, inwards)
    }

    /// The hit where it comes out, and the way back inwards from the ray's turned end.
    fn way_out(
        &mut self,
        hit: &Hit,
        surface: &Surface,
        below: &Below,
    ) -> Option<(Hit, (Vec3, Vec3))> {
        let Normals {
            geometric, smooth, ..
        } = surface.normals;
        let numbers = self.sampler.beside(WALK);
        let u = numbers.triple(Dimension::Bsdf, self.bounce);
        let origin = ray_origin(surface.point, -geometric);
        let offset = origin.distance(surface.point.point);
        let least = below.radius.max(Vec3::splat(LEAST_STEPS * offset));
        let there = below.radius.cmpgt(Vec3::ZERO);
        let radius = Vec3::select(there, least, Vec3::ZERO);
        let key = numbers.key(Dimension::Opacity, self.bounce);
        if below.has_profile() {
            let probe = Probe::new(
                Profile::new(radius),
                surface.point.point,
                geometric,
                u.truncate(),
            );
            return self.found_by(&probe, (hit, surface.inside), key);
        }
        let entered = below.enter(geometric, -self.direction, u.truncate(), u.z)?;
        // The colour comes in by the scatterings.
        let throughput = Vec3::select(
            below.color.cmpgt(Vec3::ZERO),
            self.throughput / below.color.max(Vec3::splat(f32::MIN_POSITIVE)),
            Vec3::ZERO,
        );
        let mapping = if below.is_fitted() {
            Mapping::Fitted
        } else {
            Mapping::VanDeHulst
        };
        let inside = Inside::new(below.color, radius, below.anisotropy, mapping);
        let start = Start {
            origin,
            direction: entered,
            normal: smooth,
            skipped: offset / -entered.dot(geometric),
            throughput,
        };
        let (world, mut rays) = (self.world, 0);
        let found = walk(
            &inside,
            &start,
            |step| numbers_of((&numbers, key), self.bounce, step),
            |origin, direction, far| {
                rays += 1;
                let met = world.intersect_inside(hit, (origin, direction), [RAY_START, far])?;
                Some((met.distance, met))
            },
        );
        self.rays += rays;
        let exit = found?;
        self.light.sink.step(|| Step::Below {
            steps: exit.steps,
            from: origin,
            to: exit.origin + exit.direction * exit.hit.distance,
            throughput: exit.throughput,
        });
        self.throughput = exit.throughput;
        // As if a ray had come from outside.
        let turned = exit.origin + exit.direction * (2.0 * exit.hit.distance);
        Some((exit.hit, (turned, -exit.direction)))
    }

    /// One of the places where a ray through a disc meets the object, by how much each counts; of which side says where the
    /// path has come from. The hit and the way back as for walks.
    fn found_by(
        &mut self,
        probe: &Probe,
        (hit, from_inside): (&Hit, bool),
        key: u32,
    ) -> Option<(Hit, (Vec3, Vec3))> {
        let (world, way) = (self.world, (probe.origin, probe.direction));
        let (mut near, mut sum, mut count, mut kept) = (RAY_START, 0.0, 0, None);
        while near < probe.far {
            self.rays += 1;
            let Some(met) = world.intersect_inside(hit, way, [near, probe.far]) else {
                break;
            };
            let outside = world.outside(&met);
            let weight = probe.weight(met.distance, outside);
            let share = weight.element_sum() / 3.0;
            if share > 0.0 {
                sum += share;
                if hashed(key, count, 1) * sum < share {
                    kept = Some((met, outside, weight / share));
                }
            }
            count += 1;
            // Hits of one ray have the same distances wherever it is taken to begin.
            near = next_up(met.distance);
        }
        let (met, outside, weight) = kept?;
        let (from, to) = (way.0, way.0 + way.1 * met.distance);
        self.throughput *= weight * sum;
        let throughput = self.throughput;
        self.light.sink.step(|| Step::Below {
            steps: 0,
            from,
            to,
            throughput,
        });
        // As if a ray had come from the side that light has entered from.
        let is_behind = (outside.dot(way.1) > 0.0) != from_inside;
        let turned = from + way.1 * (2.0 * met.distance);
        Some((met, if is_behind { (turned, -way.1) } else { way }))
    }

    /// Takes the light where it comes out, and goes on.
    fn come_out(&mut self, hit: &Hit, (origin, inwards): (Vec3, Vec3)) -> bool {
        let world = self.world;
        (self.origin, self.direction) = (origin, inwards);
        // It has not come from where it went below, nor by what was left over of the numbers there, and nothing passes straight on here.
        self.beside.passage = Passage::default();
        self.beside.stopped = None;
        self.beside.is_clear = false;
        let past = self.past();
        let asking = self.asking(hit, &past);
        let mut scratch = Scratch::default();
        let mut surface = world.surface::<E>(hit, (origin, asking), Wanted::Lobes, &mut scratch);
        let normal = self.exit_normal(hit, &mut surface);
        let mut bsdf = KernelBsdf::<E>::new(
            Normals {
                shading: normal,
                ..surface.normals
            },
            -inwards,
            surface.inside,
            Changes {
                steeper: world.steepness(hit),
                ..Changes::NONE
            },
        );
        bsdf.add_lambert(Vec3::ONE, normal);
        bsdf.finish();
        self.receive(hit, surface.point.point, bsdf.receiving());
        let numbers = self.sampler.beside(EXIT);
        if world.has_lids() {
            self.beside.side = numbers.key(Dimension::Opacity, self.bounce);
        }
        let (scene, met) = ((world, self.settings), (hit, &surface));
        let way = (self.throughput, self.bounce, self.counted());
        let vertex = self.beside.vertex::<E>(scene, met, (&bsdf, &past), way);
        self.rays += vertex.add_direct_light(&numbers, self.light);
        if world.is_approximated() {
            self.rays += vertex.add_openness(&numbers, Vec3::ONE, self.light);
        }
        self.leave_by(met, &bsdf, &numbers)
    }

    /// The normal about which light comes out: the mean of what goes on below where that has normals of its own.
    fn exit_normal(&self, hit: &Hit, surface: &mut Surface) -> Vec3 {
        if !surface.mixed.as_ref().is_some_and(Mixed::bumps_below) {
            return surface.normals.smooth;
        }
        let mut bsdf = self.bare(hit, surface);
        if let Some(mixed) = &mut surface.mixed {
            mixed.add_to(&mut bsdf, surface.normals.smooth);
        }
        bsdf.normal_below()
    }
}

/// The numbers of a step: the first ones of the path's sequences, the others hashed.
fn numbers_of((sampler, key): (&Sampler, u32), bounce: u32, step: u32) -> Numbers {
    if step == 0 {
        let u = sampler.triple(Dimension::Light, bounce);
        return Numbers {
            channel: u.z,
            distance: u.x,
            guide: 0.0,
            cosine: 0.0,
            turn: 0.0,
            survival: sampler.single(Dimension::Roulette, bounce),
        };
    }
    let number = |which: u32| hashed(key, step, which);
    Numbers {
        channel: number(1),
        distance: number(2),
        guide: number(3),
        cosine: number(4),
        turn: number(5),
        survival: number(6),
    }
}
