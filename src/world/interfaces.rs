//! Interfaces of glass that are nearer to each other than the errors of their points: which of them a ray meets first.
//!
//! A ray leaves its surface by the error bound of its point and steps over what is nearer: liquid a millionth off its
//! glass. It is in the liquid then as if it had never entered it, under an angle that no ray in liquid has, and is
//! reflected totally for ever. Where the boxes of transmitting objects overlap, the surfaces about each hit are therefore
//! asked for once more, and put in order along the ray in f64: from where it truly begins, on the plane of the triangle that
//! it leaves, by the planes through the corners as they are stored in f32. In f64 these are 1e-16 of the corners off, a
//! billionth of the bound in f32. No energy is lost then for the reason that none is in geometry without errors: all rays
//! meet the same closed surfaces, so that passages have an inverse, and what came in from outside finds out again.

use super::geometry::{MeshData, MeshInstance};
use super::{Hit, RayKind, World};
use crate::effects::General;
use crate::ffi::embree::Ray;
use crate::math::float::{self, BoundedPoint};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// The way between two surfaces, in f64.
#[derive(Clone, Default)]
pub struct Passage {
    /// How far it is from there to the next surface, if that has been found in f64.
    pub way: Option<f32>,
    /// Where the ray begins, if it leaves an interface that may have another close by.
    start: Option<Start>,
}

#[derive(Clone)]
struct Start {
    at: DVec3,
    /// The triangle that it leaves.
    left: Hit,
    /// Other interfaces within the errors of that point.
    close: Vec<Hit>,
}

/// A triangle and where a ray meets its plane.
struct Meeting {
    hit: Hit,
    /// Whether that is on the triangle.
    within: bool,
    distance: f64,
    /// What that may be off.
    error: f64,
    /// The distance is one in f64, from where the ray truly begins.
    exact: bool,
}

/// Roundings of f64 on the way from corners to the distance along a ray: differences, cross product, scalar products and
/// quotient are twelve in a row at most; as many more for the start, which was such a distance times a direction.
const ROUNDINGS: f64 = 24.0;

/// So many faces of an object are asked whether another one is close …
const MOST_FACES: usize = 1 << 16;
/// … at these points: near its corners, near the middles of its edges, and in its middle.
const ASKED: [(f32, f32); 7] = [
    (0.33, 0.33),
    (0.02, 0.02),
    (0.96, 0.02),
    (0.02, 0.96),
    (0.49, 0.02),
    (0.02, 0.49),
    (0.49, 0.49),
];

/// Interfaces are asked for within so many times the bound of a point: one for its own error, one for that of the other
/// surface, and one for where Embree has the two along its ray.
const REACH: f32 = 3.0;

fn is_same(a: &Hit, b: &Hit) -> bool {
    (a.object(), a.primitive) == (b.object(), b.primitive)
}

/// Which entries may have another's interface close by: those that let light through and whose boxes overlap with those of
/// others that do. (All of them where there are too many to compare: that costs time, but changes nothing.)
pub(super) fn close_entries(
    entries: &[MeshInstance],
    meshes: &[Arc<MeshData>],
    bounds_interface: impl Fn(&MeshData) -> bool,
) -> Vec<bool> {
    struct Placed {
        entry: usize,
        low: Vec3,
        high: Vec3,
    }
    let mut boxes: Vec<Placed> = entries
        .iter()
        .enumerate()
        .filter(|(_, entry)| bounds_interface(&meshes[entry.mesh as usize]))
        .map(|(number, entry)| {
            let mesh = &meshes[entry.mesh as usize];
            // What moves may come near to all others.
            let (low, high) = match entry.moves {
                true => (Vec3::splat(f32::MIN), Vec3::splat(f32::MAX)),
                false => mesh.bounds(&entry.transform()),
            };
            // The error of points is γ(8) of their coordinates and of the edges to them.
            let error = (low.abs().max(high.abs()) + (high - low)) * float::gamma(64);
            Placed {
                entry: number,
                low: low - error,
                high: high + error,
            }
        })
        .collect();
    if boxes.len() < 2 {
        return Vec::new();
    }
    boxes.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    let mut close = vec![false; entries.len()];
    let mut left = 64 * boxes.len();
    let mut any = false;
    for (i, a) in boxes.iter().enumerate() {
        for b in boxes[i + 1..].iter().take_while(|b| b.low.x <= a.high.x) {
            left = left.saturating_sub(1);
            if left == 0 || (a.low.cmple(b.high).all() && b.low.cmple(a.high).all()) {
                (close[a.entry], close[b.entry]) = (true, true);
                any = true;
            }
        }
    }
    if any { close } else { Vec::new() }
}

impl World {
    /// What a ray meets first, of the surface that Embree says and the interfaces close to it and close to where the ray
    /// begins; keeps in `passage` where that is.
    #[inline]
    pub fn first_in_order(
        &self,
        met: Option<Hit>,
        passage: &mut Passage,
        ray: (Vec3, Vec3),
        kind: RayKind,
    ) -> Option<Hit> {
        if passage.start.is_none() && met.as_ref().is_none_or(|hit| !self.is_close(hit)) {
            passage.way = None;
            return met;
        }
        self.in_order(met, passage, ray, kind)
    }

    /// The same where there may be several.
    #[cold]
    #[inline(never)]
    fn in_order(
        &self,
        met: Option<Hit>,
        passage: &mut Passage,
        (origin, direction): (Vec3, Vec3),
        kind: RayKind,
    ) -> Option<Hit> {
        let start = passage.start.take();
        passage.way = None;
        let (from, d) = (
            start.as_ref().map_or(origin.as_dvec3(), |start| start.at),
            direction.as_dvec3(),
        );
        let mut meetings = Vec::new();
        let mut met = met;
        if let Some(start) = &start {
            for hit in &start.close {
                if self.geometry.entries[hit.object() as usize]
                    .visibility
                    .sees(kind)
                {
                    meetings.extend(self.ahead(hit, from, d));
                }
            }
            // What Embree says may lie behind where the ray truly begins.
            let behind = |hit: &Hit| {
                is_same(hit, &start.left)
                    || (start.close.iter().any(|close| is_same(close, hit))
                        && self.ahead(hit, from, d).is_none())
            };
            while let Some(hit) = met
                && behind(&hit)
            {
                met = self.geometry.embree.intersect(&Ray {
                    origin: origin.to_array(),
                    direction: direction.to_array(),
                    near: hit.distance.next_up(),
                    far: f32::INFINITY,
                    mask: kind.bit(),
                    time: hit.time,
                });
            }
        }
        let mut about = Vec::new();
        match met {
            Some(hit) if self.is_close(&hit) => {
                about = self.interfaces_about(&hit, kind);
                about.push(hit);
                meetings.extend(about.iter().filter_map(|other| {
                    let left = start.as_ref().map(|start| &start.left);
                    if left.is_some_and(|left| is_same(left, other)) {
                        return None;
                    }
                    let meeting = self.ahead(other, from, d)?;
                    // Embree has looked at what it says itself.
                    let within = meeting.within || is_same(other, &hit);
                    Some(Meeting { within, ..meeting })
                }));
            }
            Some(hit) => meetings.push(Meeting {
                hit,
                within: true,
                distance: f64::from(hit.distance),
                error: 0.0,
                exact: false,
            }),
            None => {}
        }
        // The plane of a triangle stands for its neighbours, too, where it ends before the ray comes, unless one of them is
        // there. The surface that the ray leaves has left no room for that: its points keep off its edges.
        let own = start.as_ref().map(|start| start.left.object());
        let on_it: Vec<u32> = meetings
            .iter()
            .filter(|m| m.within)
            .map(|m| m.hit.object())
            .collect();
        meetings.retain(|m| {
            let object = m.hit.object();
            m.within || (own != Some(object) && !on_it.contains(&object))
        });
        // Surfaces in one place are one: that of the first object, whichever Embree finds. What only bounds a medium comes last.
        let Some(nearest) = meetings
            .iter()
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
        else {
            return met;
        };
        let end = nearest.distance + nearest.error;
        let first = meetings
            .iter()
            .filter(|m| m.distance - m.error <= end)
            .min_by_key(|m| {
                let object = m.hit.object();
                let mesh = self.geometry.entries[object as usize].mesh;
                let material = self.geometry.meshes[mesh as usize].material;
                let only_bounds = self.materials[material as usize].is_tinted;
                (only_bounds, object, m.hit.primitive)
            })
            .unwrap_or(nearest);
        // A ray that leaves no interface begins where its span does: behind the camera's near plane.
        passage.way = (first.exact && start.is_some()).then_some(first.distance as f32);
        let chosen = met.filter(|hit| is_same(hit, &first.hit));
        let hit = chosen.unwrap_or(first.hit);
        if self.is_close(&hit) {
            if !about.iter().any(|other| is_same(other, &hit)) {
                about = self.interfaces_about(&hit, kind);
            }
            about.retain(|other| !is_same(other, &hit));
            passage.start = Some(Start {
                at: from + d * first.distance,
                left: hit,
                close: about,
            });
        }
        Some(hit)
    }

    /// The ray leaves another one of the interfaces in one place.
    pub(super) fn leave_by(passage: &mut Passage, hit: &Hit) {
        if let Some(start) = &mut passage.start
            && let Some(other) = start.close.iter_mut().find(|other| is_same(other, hit))
        {
            std::mem::swap(&mut start.left, other);
        }
    }

    /// Faces of filled objects that lie in the place of a hit which a ray has come to: it crosses them as well.
    pub(super) fn in_its_place(&self, passage: &Passage, hit: &Hit, d: DVec3) -> Vec<Hit> {
        let Some(start) = passage.start.as_ref().filter(|s| is_same(&s.left, hit)) else {
            return Vec::new();
        };
        let is_there = |other: &&Hit| {
            let [a, b, c] = self.exact_corners(other);
            let normal = (b - a).cross(c - a);
            let sizes = start.at.abs() + a.abs() + (b - a).abs() + (c - a).abs();
            let error = ROUNDINGS * 0.5 * f64::EPSILON * normal.abs().dot(sizes);
            normal.dot(a - start.at).abs() <= error && normal.dot(d) != 0.0
        };
        let mut found: Vec<Hit> = start.close.iter().filter(is_there).copied().collect();
        // An object is crossed once, also at an edge of its faces.
        found.retain(|other| other.object() != hit.object());
        found.dedup_by_key(|other| other.object());
        found
    }

    /// Whether interfaces have to be put in order.
    #[inline]
    pub fn has_close_interfaces(&self) -> bool {
        !self.geometry.close.is_empty()
    }

    pub(super) fn is_close(&self, hit: &Hit) -> bool {
        self.geometry.close[hit.object() as usize]
    }

    /// Whether somewhere another face of filled objects lies within the errors of a point of a face of this one: a ray that goes on
    /// behind the one would begin beyond the other. Some points of each face are asked; of more faces than [`MOST_FACES`] some,
    /// evenly.
    pub(super) fn has_faces_close(&self, object: u32, is_filled: impl Fn(u32) -> bool) -> bool {
        let entry = &self.geometry.entries[object as usize];
        let mesh = &self.geometry.meshes[entry.mesh as usize];
        let faces = mesh.triangles.triangles().len();
        (0..faces)
            .step_by(faces.div_ceil(MOST_FACES).max(1))
            .flat_map(|face| ASKED.map(|place| (face, place)))
            .any(|(face, (u, v))| {
                let at: BoundedPoint = entry.point::<General>(mesh, face as u32, u, v);
                let normal = entry.geometric_normal::<General>(mesh, face as u32);
                let beyond = (float::ray_origin(at, normal) - at.point).length() * REACH;
                let mut any = false;
                let query = Ray {
                    origin: (at.point - normal * beyond).to_array(),
                    direction: normal.to_array(),
                    near: 0.0,
                    far: 2.0 * beyond,
                    mask: u32::MAX,
                    time: 0.0,
                };
                self.geometry.embree.visit(&query, |other| {
                    let own = (other.object(), other.primitive) == (object, face as u32);
                    any |= !own && is_filled(other.object());
                });
                any
            })
    }

    /// Where a ray meets the plane of a triangle, in f64.
    pub(super) fn exact_distance(&self, hit: &Hit, (from, d): (DVec3, DVec3)) -> f64 {
        let [a, b, c] = self.exact_corners(hit);
        let normal = (b - a).cross(c - a);
        normal.dot(a - from) / normal.dot(d)
    }

    /// Interfaces within the errors of the point of a hit, but not its own triangle.
    fn interfaces_about(&self, hit: &Hit, kind: RayKind) -> Vec<Hit> {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let at: BoundedPoint = entry.point::<General>(mesh, triangle, hit.u, hit.v);
        let normal = entry.geometric_normal::<General>(mesh, triangle);
        let beyond = (float::ray_origin(at, normal) - at.point).length() * REACH;
        let mut found: Vec<Hit> = Vec::new();
        self.geometry.embree.visit(
            &Ray {
                origin: (at.point - normal * beyond).to_array(),
                direction: normal.to_array(),
                near: 0.0,
                far: 2.0 * beyond,
                mask: kind.bit(),
                time: hit.time,
            },
            |other| {
                if self.is_close(other)
                    && !is_same(other, hit)
                    && !found.iter().any(|known| is_same(known, other))
                {
                    found.push(*other);
                }
            },
        );
        found
    }

    /// Where a ray meets the plane of a triangle, if that is ahead of it; the nearest place on the triangle, if it meets the
    /// plane beside it.
    fn ahead(&self, hit: &Hit, from: DVec3, d: DVec3) -> Option<Meeting> {
        let [a, b, c] = self.exact_corners(hit);
        let (e, f) = (b - a, c - a);
        let normal = e.cross(f);
        let cos = normal.dot(d);
        let distance = normal.dot(a - from) / cos;
        let sizes = from.abs() + a.abs() + e.abs() + f.abs();
        let error = ROUNDINGS * 0.5 * f64::EPSILON * normal.abs().dot(sizes) / cos.abs();
        (distance > error).then(|| {
            let p = from + d * distance - a;
            let area = normal.length_squared();
            let (u, v) = (p.cross(f).dot(normal) / area, e.cross(p).dot(normal) / area);
            Meeting {
                hit: Hit {
                    distance: distance as f32,
                    u: u.clamp(0.0, 1.0) as f32,
                    v: v.clamp(0.0, (1.0 - u).clamp(0.0, 1.0)) as f32,
                    ..*hit
                },
                within: u.min(v).min(1.0 - u - v) >= 0.0,
                distance,
                error,
                exact: true,
            }
        })
    }

    /// The corners of a triangle in world space: rounded to f32 as they are stored, and placed in f64.
    fn exact_corners(&self, hit: &Hit) -> [DVec3; 3] {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let t = entry.transform();
        mesh.corners(triangle).map(|corner| {
            let p = corner.as_dvec3();
            t.x.as_dvec3() * p.x
                + t.y.as_dvec3() * p.y
                + t.z.as_dvec3() * p.z
                + t.translation.as_dvec3()
        })
    }
}
