//! Which media fill which meshes, and those around a point on its way.

use super::geometry::MeshInstance;
use super::passing::shadow_ray;
use super::{Hit, World};
use crate::effects::{Effect, General};
use crate::ffi::embree::Ray;
use crate::light::emissive::Eye;
use crate::medium::{Lobe, Medium, Phase, transmittance};
use crate::scene::{self, RayKind, Scene};
use arrayvec::ArrayVec;
use enumset::EnumSet;
use glam::Vec3;
use std::sync::Arc;

/// The media of a world.
#[derive(Debug)]
pub(super) struct Media {
    /// What fills an object.
    of_objects: Vec<Option<Arc<Medium>>>,
    /// Whether there is any such.
    fills_objects: bool,
    /// What fills all space.
    everywhere: Option<Arc<Medium>>,
    /// What the paths begin in.
    at_camera: Within,
}

/// Within so many objects at once a path knows; more are as if they were not there. As in Cycles.
const MOST: usize = 32;

type Objects = ArrayVec<u32, MOST>;

/// The media around a point on its way: the objects that were entered, and what they sum up to.
#[derive(Clone, Debug, Default)]
pub struct Within {
    objects: Objects,
    /// All of them.
    pub medium: Medium,
}

/// Takes note of a crossing; whether that changes anything.
fn enter_or_leave(objects: &mut Objects, object: u32, leaves: bool) -> bool {
    let inside = objects.iter().position(|&o| o == object);
    match (leaves, inside) {
        (true, Some(at)) => {
            objects.remove(at);
            true
        }
        (false, None) => objects.try_push(object).is_ok(),
        _ => false,
    }
}

fn prepared(of: &scene::Medium) -> Arc<Medium> {
    let lobes: Vec<Lobe> = of
        .scatterers
        .iter()
        .map(|scatterer| Lobe {
            coefficient: scatterer.coefficient.into(),
            phase: match scatterer.phase {
                scene::Phase::HenyeyGreenstein(g) => Phase::HenyeyGreenstein(g),
                scene::Phase::Rayleigh => Phase::Rayleigh,
            },
        })
        .filter(|lobe| lobe.coefficient != Vec3::ZERO)
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
fn kept(medium: Option<&scene::Medium>, effects: EnumSet<Effect>) -> Option<Arc<Medium>> {
    let medium = medium?;
    effects.contains(medium.effect()?).then(|| prepared(medium))
}

impl Within {
    /// The object that was entered last.
    pub fn last_entered(&self) -> Option<u32> {
        self.objects.last().copied()
    }
}

impl World {
    /// Takes note of the media of a scene; to be called when its geometry is ready.
    pub(super) fn fill(&mut self, scene: &Scene, effects: EnumSet<Effect>) {
        self.media = None;
        let everywhere = kept(scene.medium.as_ref(), effects);
        let materials = scene.materials.iter();
        let of_materials: Vec<_> = materials
            .map(|m| kept(m.medium.as_ref(), effects))
            .collect();
        if everywhere.is_none() && of_materials.iter().all(Option::is_none) {
            return;
        }
        let of_object = |entry: &MeshInstance| {
            let mesh = &self.geometry.meshes[entry.mesh as usize];
            of_materials.get(mesh.material as usize)?.clone()
        };
        let of_objects: Vec<_> = self.geometry.entries.iter().map(of_object).collect();
        let fills_objects = of_objects.iter().any(Option::is_some);
        if everywhere.is_some() || fills_objects {
            self.media = Some(Box::new(Media {
                of_objects,
                fills_objects,
                everywhere,
                at_camera: Within::default(),
            }));
        }
    }

    /// Takes note of the media around a camera.
    pub(super) fn fill_camera(&mut self, camera: &scene::Camera) {
        if self.media.is_some() {
            let at_camera = self.around(Eye::new(camera, self.origin).at());
            if let Some(media) = &mut self.media {
                media.at_camera = at_camera;
            }
        }
    }

    /// Whether something fills space somewhere.
    #[inline]
    pub fn has_media(&self) -> bool {
        self.media.is_some()
    }

    /// What paths begin in.
    pub fn media_at_camera(&self) -> Within {
        let media = self.media.as_ref();
        media.map_or_else(Within::default, |media| media.at_camera.clone())
    }

    /// Whether something fills the object of a hit.
    fn is_filled(&self, hit: &Hit) -> bool {
        let media = self.media.as_ref();
        media.is_some_and(|media| media.of_objects[hit.object() as usize].is_some())
    }

    /// What is around a point: all objects that a ray upwards leaves before it enters them.
    fn around(&self, point: Vec3) -> Within {
        let mut within = Within::default();
        let mut met = Vec::new();
        for (_, object, leaves) in self.crossings((point, Vec3::Y), f32::INFINITY, 0.0) {
            if !met.contains(&object) {
                met.push(object);
                if leaves {
                    within.objects.try_push(object).ok();
                }
            }
        }
        self.sum_up(&mut within);
        within
    }

    /// Surfaces of filled objects along a ray, in order: how far, which, and whether the ray leaves it there.
    fn crossings(
        &self,
        (origin, direction): (Vec3, Vec3),
        far: f32,
        time: f32,
    ) -> Vec<(f32, u32, bool)> {
        let mut found = Vec::new();
        if !self.media.as_ref().is_some_and(|media| media.fills_objects) {
            return found;
        }
        let ray = Ray {
            near: 0.0,
            mask: RayKind::Shadow.bit(),
            ..shadow_ray((origin, direction), far, time)
        };
        self.geometry.embree.visit(&ray, |hit| {
            if self.is_filled(hit) {
                found.push((hit.distance, hit.object(), self.leaves(hit, direction)));
            }
        });
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        found
    }

    /// Whether a ray meets a surface from inside.
    fn leaves(&self, hit: &Hit, direction: Vec3) -> bool {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let normal = entry.geometric_normal::<General>(mesh, triangle);
        normal.dot(direction) > 0.0
    }

    /// What is around where these objects were entered.
    fn parts(&self, objects: &Objects) -> impl Iterator<Item = &Medium> {
        let media = self.media.as_deref();
        let everywhere = media.and_then(|media| media.everywhere.as_deref());
        let objects = objects.clone().into_iter();
        let inside = objects.filter_map(move |o| media?.of_objects[o as usize].as_deref());
        everywhere.into_iter().chain(inside)
    }

    fn sum_up(&self, within: &mut Within) {
        let mut medium = Medium::EMPTY;
        self.parts(&within.objects)
            .for_each(|part| medium.add(part));
        within.medium = medium;
    }

    /// A path crosses the surface of a hit.
    #[cold]
    #[inline(never)]
    pub fn cross(&self, within: &mut Within, hit: &Hit, direction: Vec3) {
        if self.is_filled(hit)
            && enter_or_leave(
                &mut within.objects,
                hit.object(),
                self.leaves(hit, direction),
            )
        {
            self.sum_up(within);
        }
    }

    /// Share of light that media let through from a target to where a ray begins, or from infinity.
    #[cold]
    #[inline(never)]
    pub fn media_before(
        &self,
        within: &Within,
        (origin, direction): (Vec3, Vec3),
        target: Option<Vec3>,
        time: f32,
    ) -> Vec3 {
        let (way, far) = match target {
            Some(target) => (target - origin, 1.0),
            None => (direction, f32::INFINITY),
        };
        let scale = way.length();
        let (mut depth, mut from) = (Vec3::ZERO, 0.0);
        let (mut objects, mut extinction) = (within.objects.clone(), within.medium.extinction);
        for (distance, object, leaves) in self.crossings((origin, way), far, time) {
            depth += extinction * ((distance - from) * scale);
            from = distance;
            if enter_or_leave(&mut objects, object, leaves) {
                extinction = self.parts(&objects).map(|part| part.extinction).sum();
            }
        }
        transmittance(depth, 1.0) * transmittance(extinction, (far - from) * scale)
    }
}
