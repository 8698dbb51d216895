//! Which media fill which meshes, and those around a point on its way.

use super::asking::Asking;
use super::crossings::{Crossing, Crossings, enter_or_leave, in_order};
use super::draws::Draws;
use super::geometry::MeshInstance;
use super::nesting::Nesting;
use super::passing::{Share, shadow_ray};
use super::varying::{self, Varying};
use super::view::View;
use super::{Hit, Passage, Sender, World};
use crate::effects::{Effect, General};
use crate::light::emissive::Eye;
use crate::math::float::SHADOW_RAY_SHARE;
use crate::medium::tracking::{self, Gathered, Local, March, Places};
use crate::medium::{self, Flight, Lobe, Medium, transmittance};
use crate::scene::graph::Graph;
use crate::scene::{self, Instance, RayKind, Scene};
use arrayvec::ArrayVec;
use enumset::EnumSet;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// The media of a world.
#[derive(Debug)]
pub(super) struct Media {
    /// What fills an object.
    of_objects: Vec<Option<Filling>>,
    /// Which of several solids is there where they overlap.
    pub(super) nesting: Option<Nesting>,
    /// Whether paths take note of any object.
    pub(super) tracks_objects: bool,
    /// Whether something fills an object that shadow rays do not see.
    some_without_shadows: bool,
    /// Whether some of it scatters light.
    scatters: bool,
    /// What fills all space.
    everywhere: Option<Filling>,
    /// What the paths begin in.
    at_camera: Within,
}

/// What fills something: the part that is the same everywhere, and what varies.
#[derive(Clone, Debug)]
struct Filling {
    even: Arc<Medium>,
    varying: Option<Arc<Varying>>,
}

/// Within so many objects at once a path knows; more are as if they were not there. As in Cycles.
const MOST: usize = 32;

pub(super) type Objects = ArrayVec<u32, MOST>;

/// The media around a point on its way: the objects that were entered, and what they sum up to.
#[derive(Clone, Debug, Default)]
pub struct Within {
    pub(super) objects: Objects,
    /// All of them, without what varies.
    pub medium: Medium,
    /// Whether some of them vary.
    pub varies: bool,
}

/// What becomes of light on a way through what varies.
#[derive(Clone, Debug)]
pub struct Flown {
    /// Where it is scattered, with the weight of that.
    pub flight: Flight,
    /// What the way adds to it.
    pub emitted: Vec3,
    /// What is where it is scattered.
    pub there: Medium,
}

/// What light meets on a whole way through what varies.
#[derive(Clone, Debug)]
pub struct Met {
    /// What becomes of it.
    pub gathered: Gathered,
    /// What is where it is scattered.
    pub there: Medium,
}

/// A ray through media, from a distance to another along it.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Where it begins.
    pub origin: Vec3,
    /// Of length 1.
    pub direction: Vec3,
    /// From where to where.
    pub span: (f32, f32),
}

/// Tells the numbers of shadow rays from those of flights.
const SHADOW: u32 = 0x_7ab1_90e3;

fn casts_shadow(entry: &MeshInstance) -> bool {
    entry.visibility.sees(RayKind::Shadow)
}

fn prepared(of: &scene::Medium) -> Arc<Medium> {
    let lobes: Vec<Lobe> = of
        .scatterers
        .iter()
        .flat_map(|s| varying::lobes(s.coefficient.into(), s.phase))
        .collect();
    let scattering = lobes.iter().map(|lobe| lobe.coefficient).sum();
    Arc::new(Medium {
        extinction: Vec3::from(of.absorption) + scattering,
        scattering,
        emission: of.emission.into(),
        lobes,
    })
}

/// What is there with some effects.
fn kept(
    medium: Option<&scene::Medium>,
    effects: EnumSet<Effect>,
) -> Option<(Arc<Medium>, Option<&Graph>)> {
    let medium = medium?;
    let is_kept = effects.contains(medium.effect()?);
    is_kept.then(|| (prepared(medium), medium.varying.as_deref()))
}

/// What is at a point, with the lobes of what varies and of what is the same everywhere.
fn at((local, mut lobes): (Local, Vec<Lobe>), even: &Medium) -> Medium {
    lobes.splice(..0, even.lobes.iter().cloned());
    Medium {
        extinction: local.extinction,
        scattering: local.scattering,
        emission: local.emission,
        lobes,
    }
}

/// Places along a way: the last one that was asked for and the one that is kept, with the lobes of what varies.
struct Along<'a> {
    around: (&'a [&'a Varying], &'a Medium),
    way: &'a Way,
    asking: Asking<'a>,
    last: (Local, Vec<Lobe>),
    kept: (Local, Vec<Lobe>),
}

impl<'a> Along<'a> {
    fn new(around: (&'a [&'a Varying], &'a Medium), (way, sender): (&'a Way, &'a Sender)) -> Self {
        Self {
            around,
            way,
            asking: Asking::within(sender, way.direction),
            last: Default::default(),
            kept: Default::default(),
        }
    }
}

impl Places for Along<'_> {
    fn local(&mut self, t: f32) -> Local {
        let (last, lobes) = &mut self.last;
        lobes.clear();
        let point = self.way.origin + self.way.direction * t;
        *last = World::local(self.around, point, &self.asking, Some(lobes));
        *last
    }

    fn keep(&mut self) {
        std::mem::swap(&mut self.last, &mut self.kept);
    }
}

impl Within {
    /// Whether any object was entered.
    pub fn is_in_objects(&self) -> bool {
        !self.objects.is_empty()
    }

    /// The object that was entered last.
    pub fn last_entered(&self) -> Option<u32> {
        self.objects.last().copied()
    }
}

impl World {
    /// Takes note of the media of a scene; to be called when its geometry is ready.
    pub(super) fn fill(&mut self, scene: &Scene, effects: EnumSet<Effect>, view: View) {
        self.media = None;
        let everywhere = kept(scene.medium.as_ref(), effects);
        let materials = scene.materials.iter();
        let of_materials: Vec<_> = materials
            .map(|m| kept(m.medium.as_ref(), effects))
            .collect();
        let nesting = Nesting::new(scene, effects, &self.geometry);
        let fills_nothing = everywhere.is_none() && of_materials.iter().all(Option::is_none);
        if fills_nothing && nesting.is_none() {
            return;
        }
        let of_object = |entry: &MeshInstance| {
            let mesh = &self.geometry.meshes[entry.mesh as usize];
            if mesh.strands.is_some() {
                return None;
            }
            of_materials.get(mesh.material as usize)?.as_ref()
        };
        let entries = self.geometry.entries.iter();
        let varies = |entry: &&MeshInstance| of_object(entry).is_some_and(|f| f.1.is_some());
        let cells = varying::cells(entries.clone().filter(varies).count());
        // Entries are the instances with triangles, in their order.
        let placed = scene.instances.iter().filter(|i| scene.has_triangles(i));
        let fill = |(entry, instance): (&MeshInstance, &Instance)| {
            let (even, graph) = of_object(entry)?;
            let mesh = &scene.meshes[instance.mesh.0 as usize];
            let varying = |graph: &&Graph| {
                let (what, whence) = ((instance, mesh), (self.origin, view));
                Arc::new(Varying::of_object(scene, what, graph, whence, cells))
            };
            Some(Filling {
                even: even.clone(),
                varying: graph.as_ref().map(varying),
            })
        };
        let of_objects: Vec<_> = entries.zip(placed).map(fill).collect();
        let everywhere = everywhere.map(|(even, graph)| {
            let fill = |graph| {
                let bounds = self.bounds_around(scene);
                Varying::of_space(scene, graph, (self.origin, view), bounds)
            };
            Filling {
                even,
                varying: graph.map(fill).map(Arc::new),
            }
        });
        let fills_objects = of_objects.iter().any(Option::is_some);
        if fills_objects {
            let is_filled = |object: u32| of_objects[object as usize].is_some();
            let filled = (0..of_objects.len() as u32).filter(|&object| is_filled(object));
            let thin: Vec<u32> = filled
                .filter(|&object| self.has_faces_close(object, is_filled))
                .collect();
            let close = &mut self.geometry.close;
            if !thin.is_empty() {
                close.resize(of_objects.len(), false);
            }
            for object in thin {
                close[object as usize] = true;
            }
        }
        let tracks_objects = fills_objects || nesting.is_some();
        let some_without_shadows = (of_objects.iter().zip(&self.geometry.entries))
            .any(|(filling, entry)| filling.is_some() && !casts_shadow(entry));
        let varies = |of: &Filling| of.varying.as_ref().is_some_and(|v| v.scatters());
        let scatters = |of: &Filling| of.even.scattering != Vec3::ZERO || varies(of);
        if everywhere.is_some() || tracks_objects {
            self.media = Some(Box::new(Media {
                scatters: everywhere
                    .iter()
                    .chain(of_objects.iter().flatten())
                    .any(scatters),
                of_objects,
                nesting,
                tracks_objects,
                some_without_shadows,
                everywhere,
                at_camera: Within::default(),
            }));
        }
    }

    /// A box around all meshes and cameras, relative to the origin.
    fn bounds_around(&self, scene: &Scene) -> (Vec3, Vec3) {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let mut add = |point: DVec3| {
            let point = (point - self.origin).as_vec3();
            (low, high) = (low.min(point), high.max(point));
        };
        let cameras = scene.cameras.iter();
        cameras.for_each(|camera| add(camera.world_from_camera.translation));
        for instance in &scene.instances {
            let place = &instance.world_from_object;
            for p in &scene.meshes[instance.mesh.0 as usize].positions {
                add(place.transform_point3(Vec3::from(*p).as_dvec3()));
            }
        }
        if low.x > high.x {
            return (Vec3::NEG_ONE, Vec3::ONE);
        }
        (low, high)
    }

    /// Takes note of the media around a camera.
    pub(super) fn fill_camera(&mut self, camera: &scene::Camera) {
        if self.media.is_some() {
            let at_camera = self.around(Eye::new(camera, self.origin).at(), RayKind::Camera);
            if let Some(media) = &mut self.media {
                media.at_camera = at_camera;
            }
        }
    }

    /// Whether some of the media are others for another camera.
    pub(super) fn media_ask_about_view(&self) -> bool {
        self.media.as_ref().is_some_and(|media| {
            let objects = media.of_objects.iter().flatten();
            let mut all = media.everywhere.iter().chain(objects);
            all.any(|filling| {
                filling
                    .varying
                    .as_ref()
                    .is_some_and(|v| v.asks_about_view())
            })
        })
    }

    /// Which of several solids is there where they overlap, where the scene says it.
    #[inline]
    pub(super) fn nesting(&self) -> Option<&Nesting> {
        self.media.as_ref()?.nesting.as_ref()
    }

    /// Whether paths take note of what they enter.
    #[inline]
    pub fn has_media(&self) -> bool {
        self.media.is_some()
    }

    /// Whether something scatters light between surfaces, the same everywhere.
    pub fn has_even_fog(&self) -> bool {
        self.media.as_ref().is_some_and(|media| {
            let objects = media.of_objects.iter().flatten();
            let mut all = media.everywhere.iter().chain(objects);
            all.clone().all(|filling| filling.varying.is_none())
                && all.any(|filling| filling.even.scattering != Vec3::ZERO)
        })
    }

    /// Whether anything between surfaces scatters light.
    pub fn has_fog(&self) -> bool {
        self.media.as_ref().is_some_and(|media| media.scatters)
    }

    /// What is where no object is.
    #[cold]
    #[inline(never)]
    pub fn media_without_objects(&self) -> Within {
        let mut within = Within::default();
        self.sum_up(&mut within);
        within
    }

    /// What paths begin in.
    pub fn media_at_camera(&self) -> Within {
        let media = self.media.as_ref();
        media.map_or_else(Within::default, |media| media.at_camera.clone())
    }

    /// Whether paths take note of the object of a hit: something fills it, or it has a place among solids that overlap.
    pub(super) fn is_tracked(&self, hit: &Hit) -> bool {
        self.media.as_ref().is_some_and(|media| {
            let nesting = media.nesting.as_ref();
            media.of_objects[hit.object() as usize].is_some()
                || nesting.is_some_and(|nesting| nesting.takes_part(hit.object()))
        })
    }

    /// What is around a point: all objects that a ray of a kind leaves upwards before it enters them.
    fn around(&self, point: Vec3, kind: RayKind) -> Within {
        let mut within = Within::default();
        let mut met = Vec::new();
        let up = (point, Vec3::Y);
        for Crossing { hit, leaves, .. } in self.crossings_of(kind, up, f32::INFINITY, 0.0) {
            let object = hit.object();
            if !met.contains(&object) {
                met.push(object);
                if leaves {
                    within.objects.try_push(object).ok();
                }
            }
        }
        if self.nesting().is_some() {
            // The last one that is left was entered first.
            within.objects.reverse();
        }
        self.sum_up(&mut within);
        within
    }

    /// What is around where these objects were entered.
    fn parts(&self, objects: &Objects) -> impl Iterator<Item = &Filling> {
        let media = self.media.as_deref();
        let everywhere = media.and_then(|media| media.everywhere.as_ref());
        let nesting = media.and_then(|media| media.nesting.as_ref());
        // Of solids in one place one is there.
        let solid = nesting.and_then(|nesting| nesting.top(objects));
        let objects = objects.clone().into_iter();
        let objects = objects.filter(move |&o| {
            Some(o) == solid || nesting.is_none_or(|nesting| !nesting.takes_part(o))
        });
        let inside = objects.filter_map(move |o| media?.of_objects[o as usize].as_ref());
        everywhere.into_iter().chain(inside)
    }

    /// What they take together, 1/m, without what varies; whether some of them vary.
    fn extinction(&self, objects: &Objects) -> (Vec3, bool) {
        let add = |(sum, varies), part: &Filling| {
            (sum + part.even.extinction, varies || part.varying.is_some())
        };
        self.parts(objects).fold((Vec3::ZERO, false), add)
    }

    /// Those of them that vary.
    fn varying(&self, objects: &Objects) -> ArrayVec<&Varying, { MOST + 1 }> {
        let varying = self
            .parts(objects)
            .filter_map(|part| part.varying.as_deref());
        varying.take(MOST + 1).collect()
    }

    /// What a ray finds at a point; the lobes of what varies are added to those that are asked for.
    fn local(
        (varying, even): (&[&Varying], &Medium),
        point: Vec3,
        asking: &Asking,
        mut lobes: Option<&mut Vec<Lobe>>,
    ) -> Local {
        let mut sum = Local {
            extinction: even.extinction,
            scattering: even.scattering,
            emission: even.emission,
        };
        for varying in varying {
            let local = varying.local(point, asking, lobes.as_deref_mut());
            sum.extinction += local.extinction;
            sum.scattering += local.scattering;
            sum.emission += local.emission;
        }
        sum
    }

    /// Calls with the bounds of what varies along a way.
    #[inline(always)]
    fn with_marches<T>(
        varying: &[&Varying],
        way: &Way,
        call: impl FnOnce(&mut [March<'_>]) -> T,
    ) -> T {
        fn march<'v>(v: &'v Varying, way: &Way) -> March<'v> {
            v.majorants.along(way.origin, way.direction, way.span.0)
        }
        // Most often there is one, and no need for room for all that there may be.
        if let [one] = varying {
            return call(&mut [march(one, way)]);
        }
        let mut marches: ArrayVec<_, { MOST + 1 }> =
            varying.iter().map(|v| march(v, way)).collect();
        call(&mut marches)
    }

    /// Where light of a throughput is scattered in what varies, on a ray of a sender.
    #[cold]
    #[inline(never)]
    pub fn fly(
        &self,
        within: &Within,
        (way, sender): (&Way, &Sender),
        light: (Vec3, bool),
        mut draws: Draws,
    ) -> Flown {
        let varying = self.varying(&within.objects);
        let even = within.medium.extinction.max_element();
        let mut places = Along::new((&varying, &within.medium), (way, sender));
        let (flight, emitted) = Self::with_marches(&varying, way, |marches| {
            let draw = || draws.draw();
            tracking::fly(marches, even, way.span, light, draw, |t| places.local(t))
        });
        Flown {
            flight,
            emitted,
            there: at(places.last, &within.medium),
        }
    }

    /// What light of a throughput meets on the whole way through what varies, on a ray of a sender.
    #[cold]
    #[inline(never)]
    pub fn gather(
        &self,
        within: &Within,
        (way, sender): (&Way, &Sender),
        throughput: Vec3,
        mut draws: Draws,
    ) -> Met {
        let varying = self.varying(&within.objects);
        let even = within.medium.extinction.max_element();
        let mut places = Along::new((&varying, &within.medium), (way, sender));
        let gathered = Self::with_marches(&varying, way, |marches| {
            let draw = || draws.draw();
            tracking::gather(marches, even, way.span, throughput, draw, &mut places)
        });
        Met {
            gathered,
            there: at(places.kept, &within.medium),
        }
    }

    /// Share of light that what is around lets through on a way of a sender's ray.
    #[cold]
    #[inline(never)]
    pub fn share(&self, within: &Within, ray: (&Way, &Sender), draws: &mut Draws) -> Vec3 {
        self.share_within((&within.objects, within.medium.extinction), ray, draws)
    }

    fn share_within(
        &self,
        (objects, even): (&Objects, Vec3),
        (way, sender): (&Way, &Sender),
        draws: &mut Draws,
    ) -> Vec3 {
        let varying = self.varying(objects);
        let passed = transmittance(even, way.span.1 - way.span.0);
        if varying.is_empty() || passed == Vec3::ZERO {
            return passed;
        }
        let asking = Asking::within(sender, way.direction);
        // What is the same everywhere is known.
        let local = |t: f32| {
            let point = way.origin + way.direction * t;
            Self::local((&varying, &Medium::EMPTY), point, &asking, None)
        };
        let share = |marches: &mut [March<'_>]| {
            medium::share(marches, 0.0, way.span, || draws.draw(), local)
        };
        passed * Self::with_marches(&varying, way, share)
    }

    fn sum_up(&self, within: &mut Within) {
        let (mut medium, mut varies) = (Medium::EMPTY, false);
        for part in self.parts(&within.objects) {
            medium.add(&part.even);
            varies |= part.varying.is_some();
        }
        (within.medium, within.varies) = (medium, varies);
    }

    /// A path crosses the surface of a hit.
    #[cold]
    #[inline(never)]
    pub fn cross(&self, within: &mut Within, hit: &Hit, direction: Vec3) {
        if self.is_tracked(hit)
            && enter_or_leave(
                &mut within.objects,
                hit.object(),
                self.leaves(hit, direction),
            )
        {
            self.sum_up(within);
        }
    }

    /// A path crosses what lies in the place of a hit as well.
    #[cold]
    #[inline(never)]
    pub fn cross_in_its_place(
        &self,
        within: &mut Within,
        passage: &Passage,
        (hit, direction): (&Hit, Vec3),
    ) {
        for other in self.in_its_place(passage, hit, direction.as_dvec3()) {
            self.cross(within, &other, direction);
        }
    }

    /// Share of light that surfaces and media let through from a target to where a ray begins, or from infinity; `key` for the
    /// numbers of what varies. One query of Embree finds both: a surface that lets no light pass ends it, and the others are noted.
    #[cold]
    #[inline(never)]
    pub fn light_through(
        &self,
        within: &Within,
        ray: (Vec3, Vec3),
        target: Option<Vec3>,
        (limit, sender): (u32, &Sender),
        key: u32,
    ) -> Vec3 {
        // What may be in the way of a linked light is not all that it passes; faces in one place have an order of their own.
        if sender.blockers != 0 || self.has_close_interfaces() {
            let limited = (limit, sender);
            let share = match target {
                Some(target) => self.transmittance_to::<General>(ray.0, target, limited),
                None => self.transmittance::<General>(ray.0, ray.1, f32::INFINITY, limited),
            };
            return if share == Vec3::ZERO {
                share
            } else {
                share * self.media_before(within, ray, target, (sender, key))
            };
        }
        let (way, far) = match target {
            Some(target) => (target - ray.0, SHADOW_RAY_SHARE),
            None => (ray.1, f32::INFINITY),
        };
        let query = shadow_ray((ray.0, way), far, sender.time);
        let mut share = Share::within(limit);
        let mut crossings = Crossings::new();
        let blocked = self.geometry.embree.occluded_filtered(&query, |hit| {
            if self.dims::<General>(&mut share, hit, (way, sender)) {
                return true;
            }
            if self.is_tracked(hit) {
                crossings.push(self.crossing(hit, way, f64::from(hit.distance)));
            }
            false
        });
        if blocked {
            return Vec3::ZERO;
        }
        in_order(&mut crossings);
        let far = if target.is_some() { 1.0 } else { far };
        share.light * self.media_along(within, (ray.0, way, far), &crossings, (sender, key))
    }

    /// Share of light that media let through from a target to where a ray begins, or from infinity; `key` for the numbers of what
    /// varies.
    #[cold]
    #[inline(never)]
    pub fn media_before(
        &self,
        within: &Within,
        (origin, direction): (Vec3, Vec3),
        target: Option<Vec3>,
        (sender, key): (&Sender, u32),
    ) -> Vec3 {
        let (way, far) = match target {
            Some(target) => (target - origin, 1.0),
            None => (direction, f32::INFINITY),
        };
        let crossings = self.crossings((origin, way), far, sender.time);
        self.media_along(within, (origin, way, far), &crossings, (sender, key))
    }

    /// Share of light that media let through on a way, as far as so many times its length, with its crossings in order.
    fn media_along(
        &self,
        within: &Within,
        (origin, way, far): (Vec3, Vec3, f32),
        crossings: &[Crossing],
        (sender, key): (&Sender, u32),
    ) -> Vec3 {
        let scale = way.length();
        let (mut extinction, mut varies) = (within.medium.extinction, within.varies);
        let mut objects = within.objects.clone();
        let media = self.media.as_ref();
        if media.is_some_and(|media| media.some_without_shadows) {
            // What shadow rays do not see does not dim them, wherever they begin: as in Cycles from 5.0 on.
            objects.retain(|o| casts_shadow(&self.geometry.entries[*o as usize]));
            (extinction, varies) = self.extinction(&objects);
        }
        if crossings.is_empty() && !varies {
            return transmittance(extinction, far * scale);
        }
        let mut draws = Draws::new(key, SHADOW ^ way.x.to_bits());
        let (mut depth, mut from, mut share) = (Vec3::ZERO, 0.0f64, Vec3::ONE);
        let along = |from: f32, to: f32| Way {
            origin,
            direction: way / scale,
            span: (from * scale, to * scale),
        };
        for crossing in crossings {
            let distance = crossing.distance;
            if varies {
                let way = along(from as f32, distance as f32);
                share *= self.share_within((&objects, extinction), (&way, sender), &mut draws);
            } else {
                depth += extinction * ((distance - from) as f32 * scale);
            }
            from = distance;
            if enter_or_leave(&mut objects, crossing.hit.object(), crossing.leaves) {
                (extinction, varies) = self.extinction(&objects);
            }
        }
        if varies {
            let way = along(from as f32, far);
            share *= self.share_within((&objects, extinction), (&way, sender), &mut draws);
        } else {
            let rest = (f64::from(far) - from) as f32;
            share *= transmittance(extinction, rest * scale);
        }
        share * transmittance(depth, 1.0)
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/media.rs"]
mod tests;
