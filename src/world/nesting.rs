//! Solids that overlap, by priorities that the scene states: which interfaces are there, and what is on their other side.
//!
//! Schmidt and Budge, *Simple Nested Dielectrics in Ray Traced Images*, Journal of Graphics Tools 7(2), 2002.

use super::crossings::enter_or_leave;
use super::interfaces::Passage;
use super::media::{Objects, Within};
use super::passing::{Share, shadow_ray};
use super::{Geometry, Hit, Sender, World};
use crate::effects::{Effect, General};
use crate::math::float::{BoundedPoint, SHADOW_RAY_SHARE, ray_origin};
use crate::scene::{Material, Scene};
use crate::shading::dispersion::index_at;
use enumset::EnumSet;
use glam::Vec3;

/// The order of solids.
#[derive(Debug)]
pub(super) struct Nesting {
    /// By object; none that do not take part.
    solids: Vec<Option<Solid>>,
}

#[derive(Clone, Copy, Debug)]
struct Solid {
    priority: i32,
    ior: f32,
    /// 20 over the Abbe number.
    dispersion: f32,
}

/// What is on the other side of a surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct OtherSide {
    /// Its index of refraction; 0: that of air, of which materials tell theirs.
    pub index: f32,
    /// The index depends on the wavelength.
    pub disperses: bool,
}

impl Nesting {
    /// Of a scene; none where nothing overlaps by priorities.
    pub fn new(scene: &Scene, effects: EnumSet<Effect>, geometry: &Geometry) -> Option<Self> {
        if !effects.contains(Effect::NestedDielectrics) {
            return None;
        }
        let materials = scene.materials.iter().map(Material::nested);
        let of_materials: Vec<_> = materials
            .map(|nested| {
                nested.map(|(priority, index)| Solid {
                    priority,
                    ior: index.ior(),
                    dispersion: index.dispersion,
                })
            })
            .collect();
        let entries = geometry.entries.iter();
        let solids: Vec<_> = entries
            .map(|entry| {
                let mesh = &geometry.meshes[entry.mesh as usize];
                if mesh.strands.is_some() {
                    return None;
                }
                let material = mesh.material;
                of_materials.get(material as usize).copied().flatten()
            })
            .collect();
        solids
            .iter()
            .any(Option::is_some)
            .then_some(Self { solids })
    }

    fn solid(&self, object: u32) -> Option<&Solid> {
        self.solids[object as usize].as_ref()
    }

    /// Whether an object has a place in the order.
    pub fn takes_part(&self, object: u32) -> bool {
        self.solid(object).is_some()
    }

    /// Which of the objects that a point is within is there: that of the highest priority, of several such the last entered.
    pub fn top(&self, objects: &Objects) -> Option<u32> {
        self.top_without(objects, u32::MAX)
    }

    fn top_without(&self, objects: &Objects, without: u32) -> Option<u32> {
        let others = objects.iter().copied().filter(|&o| o != without);
        let solids = others.filter_map(|o| Some((self.solid(o)?.priority, o)));
        solids.max_by_key(|(priority, _)| *priority).map(|(_, o)| o)
    }

    /// Whether an object is there among those that its side of its surface is within. A mesh that is open may be left without
    /// having been entered: it is then as if it had been entered last.
    fn is_there(&self, object: u32, objects: &Objects) -> bool {
        let Some(own) = self.solid(object) else {
            return true;
        };
        let at = objects.iter().position(|&o| o == object);
        let mut others = objects.iter().enumerate();
        !others.any(|(place, &other)| {
            let is_later = at.is_some_and(|at| place > at);
            self.solid(other).is_some_and(|solid| {
                other != object
                    && (solid.priority > own.priority || solid.priority == own.priority && is_later)
            })
        })
    }

    /// What is on the other side of an object's surface, within some objects, for a wavelength.
    fn beside(&self, object: u32, objects: &Objects, wavelength: f32) -> OtherSide {
        let other = self.top_without(objects, object);
        let Some(solid) = other.and_then(|other| self.solid(other)) else {
            return OtherSide::default();
        };
        let disperses = solid.dispersion > 0.0 && wavelength > 0.0;
        let index = if disperses {
            index_at(solid.ior, solid.dispersion, wavelength)
        } else {
            solid.ior
        };
        OtherSide { index, disperses }
    }
}

impl World {
    /// Whether priorities say which of several solids is there.
    #[inline]
    pub fn has_priorities(&self) -> bool {
        self.nesting().is_some()
    }

    /// The interface that a path meets at a hit, with what is on its other side; none where a solid of a higher priority is on
    /// both sides. Of several surfaces in one place one counts, that of a solid which is there on its side.
    #[cold]
    #[inline(never)]
    pub fn interface(
        &self,
        (within, passage): (&Within, &mut Passage),
        (hit, direction): (&Hit, Vec3),
        wavelength: f32,
    ) -> Option<(Hit, OtherSide)> {
        let plain = (*hit, OtherSide::default());
        let Some(nesting) = self.nesting() else {
            return Some(plain);
        };
        if !nesting.takes_part(hit.object()) {
            return Some(plain);
        }
        let mut met = vec![*hit];
        if self.has_close_interfaces() {
            met.extend(self.in_its_place(passage, hit, direction.as_dvec3()));
        }
        let before = &within.objects;
        let mut after = before.clone();
        for one in &met {
            enter_or_leave(&mut after, one.object(), self.leaves(one, direction));
        }
        let found = met.iter().find_map(|one| {
            let (object, leaves) = (one.object(), self.leaves(one, direction));
            let (inside, outside) = if leaves {
                (before, &after)
            } else {
                (&after, before)
            };
            let there = nesting.takes_part(object) && nesting.is_there(object, inside);
            there.then(|| (*one, nesting.beside(object, outside, wavelength)))
        });
        let (one, other_side) = found?;
        if one.object() != hit.object() {
            Self::leave_by(passage, &one);
        }
        let distance = hit.distance;
        Some((Hit { distance, ..one }, other_side))
    }

    /// Where a ray goes on behind a surface that it passes straight on, and how far from that.
    pub fn straight_on(&self, hit: &Hit, direction: Vec3) -> (Vec3, f32) {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let at: BoundedPoint = entry.point::<General>(mesh, triangle, hit.u, hit.v);
        let normal = entry.geometric_normal::<General>(mesh, triangle);
        let onward = ray_origin(at, normal * normal.dot(direction).signum());
        (onward, onward.distance(at.point))
    }

    /// Share of light that a shadow ray brings, past interfaces that are not there. `target`: where it ends; none: at infinity.
    #[cold]
    #[inline(never)]
    pub fn transmittance_nested(
        &self,
        within: &Within,
        (origin, direction): (Vec3, Vec3),
        target: Option<Vec3>,
        (limit, sender): (u32, &Sender),
    ) -> Vec3 {
        let (way, far) = match target {
            Some(target) => (target - origin, SHADOW_RAY_SHARE),
            None => (direction, f32::INFINITY),
        };
        let mut gone = Vec::new();
        if let Some(nesting) = self.nesting() {
            let mut around = within.objects.clone();
            for crossing in self.crossings((origin, way), far, sender.time) {
                let object = crossing.hit.object();
                let before = around.clone();
                enter_or_leave(&mut around, object, crossing.leaves);
                let inside = if crossing.leaves { &before } else { &around };
                if !nesting.is_there(object, inside) {
                    gone.push((object, crossing.hit.primitive));
                }
            }
        }
        let mut ray = shadow_ray((origin, way), far, sender.time);
        if sender.blockers != 0 {
            ray.mask = sender.blockers;
        }
        let mut share = Share::within(limit);
        let blocked = self.geometry.embree.occluded_asking(&ray, |hit| {
            !gone.contains(&(hit.object(), hit.primitive))
                && self.dims::<General>(&mut share, hit, (way, sender))
        });
        if blocked { Vec3::ZERO } else { share.light }
    }
}

#[cfg(test)]
#[path = "../../tests/unit/world/nesting.rs"]
mod tests;
