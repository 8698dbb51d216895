//! Objects by themselves, for light that goes on below their surfaces: it meets nothing but the object that it is in.

use super::geometry::MeshInstance;
use super::{Hit, World};
use crate::effects::General;
use crate::ffi::embree::{
    self, CommittedScene, DecomposedTransform, Device, EmbreeError, Ray, TriangleMesh,
};
use glam::Vec3;
use std::collections::btree_map::Entry::{Occupied, Vacant};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An entry of the top scene, as it was added there.
pub enum Part {
    /// A mesh in world space.
    Mesh(Arc<TriangleMesh>),
    /// A mesh in a place: the columns of its transform.
    Instance(CommittedScene, [[f32; 3]; 4]),
    /// A mesh on its way.
    Moving(CommittedScene, Vec<DecomposedTransform>),
}

/// An object with all of its parts.
struct Inside {
    embree: CommittedScene,
    /// The entries of the parts.
    entries: Vec<u32>,
}

/// The objects that light goes on below the surface of, by number.
#[derive(Default)]
pub struct Insides(BTreeMap<u32, Inside>);

impl Insides {
    /// Of the objects of which some part `goes_below`.
    pub fn new(
        device: &Device,
        robust: bool,
        (entries, parts): (&[MeshInstance], &[Part]),
        goes_below: impl Fn(&MeshInstance) -> bool,
    ) -> Result<Self, EmbreeError> {
        let there = entries.iter().filter(|entry| goes_below(entry));
        let there: BTreeSet<u32> = there.map(|entry| entry.object).collect();
        let mut made: BTreeMap<u32, (embree::Scene, Vec<u32>)> = BTreeMap::new();
        for (number, (entry, part)) in (0..).zip(entries.iter().zip(parts)) {
            if !there.contains(&entry.object) {
                continue;
            }
            let (scene, numbers) = match made.entry(entry.object) {
                Occupied(made) => made.into_mut(),
                Vacant(place) => place.insert((embree::Scene::new(device, robust)?, Vec::new())),
            };
            match part {
                Part::Mesh(mesh) => scene.add_triangles(mesh, false, u32::MAX)?,
                Part::Instance(mesh, place) => scene.add_instance(mesh, place, u32::MAX)?,
                Part::Moving(mesh, steps) => scene.add_moving_instance(mesh, steps, u32::MAX)?,
            };
            numbers.push(number);
        }
        let inside = |(object, (scene, entries)): (u32, (embree::Scene, Vec<u32>))| {
            let embree = scene.commit()?;
            Ok((object, Inside { embree, entries }))
        };
        Ok(Self(
            made.into_iter().map(inside).collect::<Result<_, _>>()?,
        ))
    }
}

impl World {
    /// Whether light goes on below some surface.
    #[inline]
    pub fn goes_below(&self) -> bool {
        !self.geometry.insides.0.is_empty()
    }

    /// What a ray within the object of a hit meets of that between two distances, whatever else is there.
    pub fn intersect_inside(
        &self,
        of: &Hit,
        (origin, direction): (Vec3, Vec3),
        [near, far]: [f32; 2],
    ) -> Option<Hit> {
        let object = self.geometry.entries[of.object() as usize].object;
        let inside = self.geometry.insides.0.get(&object)?;
        let hit = inside.embree.intersect(&Ray {
            origin: origin.to_array(),
            direction: direction.to_array(),
            near,
            far,
            mask: u32::MAX,
            time: of.time,
        })?;
        Some(hit.of_object(inside.entries[hit.object() as usize]))
    }

    /// Unit normal of the triangle of a hit, outside.
    pub fn outside(&self, hit: &Hit) -> Vec3 {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        entry.geometric_normal::<General>(mesh, triangle)
    }
}
