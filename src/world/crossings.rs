//! Surfaces that rays cross, of objects of which paths take note.

use super::media::Objects;
use super::passing::shadow_ray;
use super::{Hit, World};
use crate::effects::General;
use crate::ffi::embree::Ray;
use crate::scene::RayKind;
use glam::Vec3;
use smallvec::SmallVec;

/// A surface of an object of which paths take note, on a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// How far.
    pub distance: f64,
    /// Which.
    pub hit: Hit,
    /// Whether the ray leaves the object there.
    pub leaves: bool,
}

/// Most rays cross a few.
pub(super) type Crossings = SmallVec<[Crossing; 4]>;

/// By distance; in one place by their objects.
pub(super) fn in_order(crossings: &mut [Crossing]) {
    crossings.sort_unstable_by(|a, b| {
        let key = |crossing: &Crossing| (crossing.hit.object(), crossing.leaves);
        let nearer = a.distance.total_cmp(&b.distance);
        nearer.then_with(|| key(a).cmp(&key(b)))
    });
}

/// Takes note of a crossing; whether that changes anything.
pub(super) fn enter_or_leave(objects: &mut Objects, object: u32, leaves: bool) -> bool {
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

impl World {
    /// Surfaces along a shadow ray of objects of which paths take note, in order.
    pub(super) fn crossings(&self, ray: (Vec3, Vec3), far: f32, time: f32) -> Crossings {
        self.crossings_of(RayKind::Shadow, ray, far, time)
    }

    /// The same along a ray of a kind.
    pub(super) fn crossings_of(
        &self,
        kind: RayKind,
        (origin, direction): (Vec3, Vec3),
        far: f32,
        time: f32,
    ) -> Crossings {
        let mut found = Crossings::new();
        if !self
            .media
            .as_ref()
            .is_some_and(|media| media.tracks_objects)
        {
            return found;
        }
        let ray = Ray {
            near: 0.0,
            mask: kind.bit(),
            ..shadow_ray((origin, direction), far, time)
        };
        let exact = (origin.as_dvec3(), direction.as_dvec3());
        self.geometry.embree.visit(&ray, |hit| {
            if self.is_tracked(hit) {
                // The faces of a shell may be nearer to each other than steps of f32 are there.
                let is_thin = self.has_close_interfaces() && self.is_close(hit);
                let distance = is_thin.then(|| self.exact_distance(hit, exact));
                let distance = distance.filter(|distance| distance.is_finite());
                let distance = distance.unwrap_or(f64::from(hit.distance));
                found.push(self.crossing(hit, direction, distance));
            }
        });
        in_order(&mut found);
        found
    }

    pub(super) fn crossing(&self, hit: &Hit, direction: Vec3, distance: f64) -> Crossing {
        Crossing {
            distance,
            hit: *hit,
            leaves: self.leaves(hit, direction),
        }
    }

    /// Whether a ray meets a surface from inside.
    pub(super) fn leaves(&self, hit: &Hit, direction: Vec3) -> bool {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let normal = entry.geometric_normal::<General>(mesh, triangle);
        normal.dot(direction) > 0.0
    }
}
