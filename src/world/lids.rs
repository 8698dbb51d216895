//! What lies on the faces that rays leave, and on lights: [`crate::scene::coincident`].
//!
//! A ray leaves its surface by the error bound of its point, and so steps over a face in the same plane. Where the scene has
//! such faces, they are asked for by a short ray through the surface, and are met first.

mod lamps;

use super::passing::{Share, parts, shadow_ray};
use super::{Hit, RayKind, Sender, Source, Surface, World};
use crate::effects::General;
use crate::ffi::embree::Ray;
use crate::light::Drawn;
use crate::math::float::{self, BoundedPoint};
use crate::sampler;
use crate::scene::coincident::{self, Coincident, Overlap};
use crate::scene::{AreaShape, LightKind, Scene};
use glam::Vec3;
use lamps::Lamp;
use std::collections::BTreeMap;

/// What lies on faces and lights.
pub(super) struct Lids {
    /// By entry, of each triangle; empty where none has anything on it.
    faces: Vec<Vec<Overlap>>,
    /// Area lights in the plane of a face, by their numbers in the scene.
    lights: BTreeMap<u32, Lamp>,
}

/// Faces are asked for within so many times the bound of a point: one for its own error, one for that of the other face, and
/// one for where Embree has the two.
const REACH: f32 = 3.0;

/// Rays to lamps in the plane of a face go on for so many times their length: no rounding of Embree's is as large.
const BEYOND_LAMP: f32 = 1.0 + 1e-4;

/// Which number of a key tells the side that a point lies on, and whether it stays on it.
const SIDE: u32 = 1;
const STAYS: u32 = 2;

/// The one of a plane's two normals that both of two faces in it have, whichever way they look.
fn of_plane(normal: Vec3) -> Vec3 {
    normal * 1f32.copysign(normal[normal.abs().max_position()])
}

impl Lids {
    /// `None` if nothing coincides. Solids whose materials state priorities are left to those.
    pub fn new(scene: &Scene, known: Option<&Coincident>) -> Option<Self> {
        let found = known.is_none().then(|| coincident::find(scene));
        let coincident = known.or(found.as_ref())?;
        let (mut faces, mut entries) = (Vec::new(), Vec::new());
        for (number, instance) in scene.instances.iter().enumerate() {
            entries.push(faces.len() as u32);
            let mesh = &scene.meshes[instance.mesh.0 as usize];
            if mesh.triangles.is_empty() {
                continue;
            }
            let material = mesh.material.map(|m| &scene.materials[m.0 as usize]);
            faces.push(match coincident.faces.get(&(number as u32)) {
                Some(of) if material.is_none_or(|m| m.priority.is_none()) => of.clone(),
                _ => Vec::new(),
            });
        }
        let lights = coincident.lights.iter().map(|(&number, on)| {
            let is_rectangle = matches!(
                scene.lights[number as usize].kind,
                LightKind::Area {
                    shape: AreaShape::Rectangle,
                    ..
                }
            );
            let lamp = Lamp::new(on, is_rectangle, |instance| entries[instance as usize]);
            (number, lamp)
        });
        let lids = Self {
            faces,
            lights: lights.collect(),
        };
        (!lids.lights.is_empty() || lids.faces.iter().any(|of| !of.is_empty())).then_some(lids)
    }

    fn on(&self, (object, triangle): (u32, u32)) -> Overlap {
        let of = &self.faces[object as usize];
        of.get(triangle as usize).copied().unwrap_or_default()
    }
}

fn place(hit: &Hit) -> (u32, u32) {
    (hit.object(), hit.primitive)
}

/// A face that lies on a surface, as a ray from there meets it.
fn on_surface(hit: &Hit) -> Hit {
    Hit {
        distance: 0.0,
        ..*hit
    }
}

impl World {
    /// Whether the point of a face that lies on another one is on the same side of the plane as that of the other was: both are
    /// rounded from about the same corners' shares, so that they are not independent. In Cycles 5.2.3 the light of a lamp that comes
    /// out of a ball whose faces stand twice says 0.37 and 0.63, of two turns of the ball.
    pub fn stays_on_side(key: u32) -> bool {
        sampler::hashed(key, STAYS, 0) < 0.5
    }

    /// Whether any face lies on another, or on a light.
    #[inline]
    pub fn has_lids(&self) -> bool {
        self.geometry.lids.is_some()
    }

    /// The short ray through a surface that meets the faces which lie on it on the side that a ray leaves it by, and which of what it
    /// meets lies there. A point of a turned plane lies on the one side or on the other by rounding, which `key` stands for: rays
    /// through the plane meet all other faces in it, rays that leave it none.
    fn through_lids(
        &self,
        (hit, surface): (&Hit, &Surface),
        (direction, kind, time): (Vec3, RayKind, f32),
        key: u32,
    ) -> Option<(Ray, impl Fn(&Hit) -> bool)> {
        let lids = self.geometry.lids.as_ref()?;
        let own = lids.on(place(hit));
        let normal = surface.normals.geometric;
        let is_beyond = sampler::hashed(key, SIDE, 0) < 0.5;
        let leaves = (direction.dot(of_plane(normal)) > 0.0) == is_beyond;
        if own == Overlap::None || own == Overlap::Turned && leaves {
            return None;
        }
        let side = normal * 1f32.copysign(direction.dot(normal));
        let about = BoundedPoint {
            error: surface.point.error * REACH,
            ..surface.point
        };
        let (start, end) = (
            float::ray_origin(about, -side),
            float::ray_origin(about, side),
        );
        let ray = Ray {
            origin: start.to_array(),
            direction: (end - start).to_array(),
            near: 0.0,
            far: 1.0,
            mask: kind.bit(),
            time,
        };
        let from = place(hit);
        let is_there = move |other: &Hit| {
            let there = match lids.on(place(other)) {
                Overlap::None => false,
                Overlap::Turned => !leaves,
                Overlap::Flat => true,
            };
            there && place(other) != from
        };
        Some((ray, is_there))
    }

    /// The share of light that the faces on a surface let pass towards it.
    #[cold]
    #[inline(never)]
    pub fn passes_lids(
        &self,
        at: (&Hit, &Surface),
        direction: Vec3,
        key: u32,
        (limit, sender): (u32, &Sender),
    ) -> Vec3 {
        let sent = (direction, RayKind::Shadow, sender.time);
        let Some((ray, is_there)) = self.through_lids(at, sent, key) else {
            return Vec3::ONE;
        };
        // Hundreds may lie in one place: the first that lets nothing through is enough.
        let mut lets_pass: Vec<Hit> = Vec::new();
        let shut = self.geometry.embree.occluded_asking(&ray, |other| {
            if !is_there(other) {
                return false;
            }
            let lid = on_surface(other);
            if self.dims::<General>(&mut Share::within(limit), &lid, (direction, sender)) {
                return true;
            }
            lets_pass.push(lid);
            false
        });
        if shut {
            return Vec3::ZERO;
        }
        // Embree tells of them in any order, perhaps more than once of the same.
        lets_pass.sort_unstable_by_key(place);
        lets_pass.dedup_by_key(|lid| place(lid));
        let mut share = Share::within(limit);
        for lid in &lets_pass {
            if self.dims::<General>(&mut share, lid, (direction, sender)) {
                return Vec3::ZERO;
            }
        }
        share.light
    }

    /// The face on a surface that stops a ray from there, if one does; of several the first in the order of the scene.
    #[cold]
    #[inline(never)]
    pub fn lid(
        &self,
        at: (&Hit, &Surface),
        direction: Vec3,
        key: u32,
        sender: &Sender,
    ) -> Option<Hit> {
        let sent = (direction, sender.kind, sender.time);
        let (ray, is_there) = self.through_lids(at, sent, key)?;
        let mut first: Option<Hit> = None;
        self.geometry.embree.visit(&ray, |other| {
            let is_later = first.is_some_and(|known| place(&known) <= place(other));
            if is_later || !is_there(other) {
                return;
            }
            let lid = on_surface(other);
            let (a, b) = parts(&lid);
            let opacity = self.opacity::<General>(&lid, direction, sender);
            if Self::stops(opacity, || sampler::hashed(key, a, b)) {
                first = Some(lid);
            }
        });
        first
    }

    /// A lamp that was drawn, if it lies in the plane of a face.
    fn lamp_on_face(&self, drawn: Drawn) -> Option<&Lamp> {
        let number = self.lights.number_in_scene(self.lights.source(drawn))?;
        self.geometry.lids.as_ref()?.lights.get(&number)
    }

    /// Whether a light that was drawn lies in the plane of a face.
    #[cold]
    #[inline(never)]
    pub fn lies_on_face(&self, drawn: Drawn) -> bool {
        let Some(lids) = &self.geometry.lids else {
            return false;
        };
        match self.lights.source(drawn) {
            Source::Surface(object) => !lids.faces[object as usize].is_empty(),
            _ => self.lamp_on_face(drawn).is_some(),
        }
    }

    /// As [`World::transmittance_to`] for a light in the plane of a face: which of the two is nearer is decided by the rounding of
    /// a ray that ends at the light, as in Cycles. `on` is the point of the surface, `start` where the ray leaves it.
    #[cold]
    #[inline(never)]
    pub fn transmittance_up_to(
        &self,
        (on, start, target): (Vec3, Vec3, Vec3),
        drawn: Drawn,
        (limit, sender): (u32, &Sender),
    ) -> Vec3 {
        let source = self.lights.source(drawn);
        let way = target - start;
        let far = way.length();
        if far == 0.0 {
            return Vec3::ONE;
        }
        let direction = way * far.recip();
        let mut share = Share::within(limit);
        let mut dims = |hit: &Hit| self.dims::<General>(&mut share, hit, (direction, sender));
        let shut = if let Some(lamp) = self.lamp_on_face(drawn) {
            let in_file = |p: Vec3| (p.as_dvec3() + self.origin).as_vec3();
            let cycles = lamp.ray(in_file(on), in_file(target));
            // So far that faces in the plane are found.
            let ray = shadow_ray((start, direction), far * BEYOND_LAMP, sender.time);
            self.geometry.embree.occluded_asking(&ray, |hit| {
                let before = lamp.is_shut_by(place(hit), &cycles);
                before.unwrap_or(hit.distance <= far) && dims(hit)
            })
        } else {
            let ray = shadow_ray((start, direction), far, sender.time);
            self.geometry.embree.occluded_asking(&ray, |hit| {
                let is_light = source == Source::Surface(hit.object())
                    && hit.distance > far * float::SHADOW_RAY_SHARE;
                !is_light && dims(hit)
            })
        };
        if shut { Vec3::ZERO } else { share.light }
    }
}
