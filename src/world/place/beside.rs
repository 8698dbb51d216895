//! Points beside a hit, which the heights of Bumps are asked at, and where points were before their surface was displaced.

use super::super::geometry::unit_or_zero;
use super::super::view::to_blender;
use super::{HitPoint, between};
use crate::scene::RayKind;
use crate::shading::closure::FibrePlace;
use crate::shading::program::{Place, Strand};
use glam::Vec3;

/// Where a point was before its surface was displaced.
#[derive(Clone, Copy)]
pub(in crate::world) struct Undisplaced {
    /// The attribute that tells where the corners were, in the object's space and in Blender's axes.
    pub(super) attribute: u32,
    /// As in Cycles from 5.0 on.
    pub(super) is_of_5: bool,
    /// The way that steps of Bumps have taken places from the hit, in Blender's world.
    pub(super) way: Vec3,
}

impl HitPoint<'_> {
    pub(super) fn displaced(&self) -> Self {
        Self {
            undisplaced: None,
            ..*self
        }
    }

    /// The way across the triangle by steps of its barycentric coordinates, in Blender's world.
    pub(super) fn way(&self, (u, v): (f32, f32)) -> Vec3 {
        let [p, q, r] = self.mesh_corners();
        let local = (q - p) * u + (r - p) * v;
        to_blender(match &self.entry.facts {
            Some(facts) if self.entry.is_instance() => facts.world_axes * local,
            _ => local,
        })
    }

    /// Steps across the mesh's triangle by its barycentric coordinates: least squares in the triangle's plane.
    #[inline]
    pub(super) fn barycentric<const N: usize>(&self, local: [Vec3; N]) -> Option<[(f32, f32); N]> {
        let [a, b, c] = self.mesh_corners();
        let (e1, e2) = (b - a, c - a);
        let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
        let det = d11 * d22 - d12 * d12;
        let scale = det.recip();
        // Not of a triangle without an area, or of one that f32's range cannot divide by.
        scale.is_finite().then(|| {
            local.map(|local| {
                let (s1, s2) = (local.dot(e1), local.dot(e2));
                ((s1 * d22 - s2 * d12) * scale, (s2 * d11 - s1 * d12) * scale)
            })
        })
    }

    /// Any number that differs from place to place.
    pub(in crate::world) fn seed(&self) -> u32 {
        self.u.to_bits() ^ self.v.to_bits().rotate_left(16)
    }

    /// What shaders of hair are told of meshes, as Cycles has it.
    pub(super) fn strand_of_mesh(&self) -> Strand {
        let [p, q, r] = self.mesh_corners();
        let along = |local: Vec3| {
            let world = match self.entry.is_instance() {
                true => self.entry.transform().vector(local),
                false => local,
            };
            self.side(unit_or_zero(world))
        };
        Strand {
            tangent: along(q - p),
            second: along(r - p),
            seed: self.seed(),
            ..Strand::NONE
        }
    }

    /// Whether the ray meets the elliptic section of a fibre, and does not pass beside it. Rays of shadows do not: Cycles has how
    /// much strands let through from their keys, at which all is seen in the middle.
    pub(super) fn is_on_fibre(&self, aspect: f32) -> bool {
        if self.asking.kind & RayKind::Shadow.bit() != 0 {
            return true;
        }
        let strand = self.strand();
        let normal = self.side(self.outer_normal());
        let view = -self.asking.direction.normalize_or_zero();
        !strand.is_strand || FibrePlace::of(&strand, normal).is_seen(aspect, view)
    }

    /// Which way steps of Bumps take attributes and places: 1 is along them, -1 against them. Of a triangle that is seen from behind
    /// Cycles turns the derivatives, by which attributes go and steps across what it was before it was displaced, and not places.
    pub(super) fn ways_of_steps(&self) -> (f32, f32) {
        match (self.is_inside(), self.undisplaced.is_some()) {
            (true, true) => (1.0, -1.0),
            (true, false) => (-1.0, 1.0),
            _ => (1.0, 1.0),
        }
    }

    /// The place between corners; `turned` brings a vector of the mesh's space to theirs.
    pub(super) fn place_between(
        &self,
        corners: [Vec3; 3],
        turned: impl FnOnce(Vec3) -> Vec3,
    ) -> Vec3 {
        match (self.undisplaced, self.hit) {
            (Some(before), Some((u, v))) => {
                between(corners, u, v) + turned(self.vector_to_mesh(before.way))
            }
            (None, Some((u, v))) if self.is_inside() => {
                between(corners, 2.0 * u - self.u, 2.0 * v - self.v)
            }
            _ => between(corners, self.u, self.v),
        }
    }

    /// The smooth normal outside as the node Texture Coordinate tells it: beside a hit it is that of the corners there, as in Cycles.
    pub(super) fn stepped_normal(&self) -> Vec3 {
        match (&self.mesh.normals, self.hit, self.undisplaced) {
            (Some(_), Some(_), None) => self.entry.smooth_normal(self.mesh, self),
            _ => self.outer_normal(),
        }
    }

    /// The place that was hit: rays of a Bump's height leave from there, and tangents are those of it, as in Cycles.
    pub(super) fn at_hit(&self) -> Self {
        let (u, v) = self.hit.unwrap_or((self.u, self.v));
        Self {
            u,
            v,
            hit: None,
            ..*self
        }
    }
}
