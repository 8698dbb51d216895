//! Points beside a hit, which the heights of Bumps are asked at, and where points were before their surface was displaced.

use super::super::geometry::unit_or_zero;
use super::super::view::to_blender;
use super::HitPoint;
use crate::effects::General;
use glam::Vec3;

/// Where a point was before its surface was displaced.
#[derive(Clone, Copy)]
pub(in crate::world) struct Undisplaced {
    /// The attribute that tells where the corners were, in the object's space and in Blender's axes.
    pub(super) attribute: u32,
    /// As in Cycles from 5.0 on.
    pub(super) is_of_5: bool,
    /// A point beside one of the surface: that one's barycentric coordinates, and the way from there, in Blender's world.
    pub(super) beside: Option<(f32, f32, Vec3)>,
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

    pub(super) fn beside(&self) -> Option<(f32, f32, Vec3)> {
        self.undisplaced.and_then(|before| before.beside)
    }

    /// The smooth normal outside as the node Texture Coordinate tells it: beside a hit it is that of the corners there, as in Cycles.
    pub(super) fn stepped_normal(&self) -> Vec3 {
        match (&self.mesh.normals, self.hit, self.undisplaced) {
            (Some(normals), Some(_), None) => {
                let there = unit_or_zero(self.entry.normal::<General>(self.vector(normals)));
                if there == Vec3::ZERO {
                    self.outer_normal()
                } else {
                    there
                }
            }
            _ => self.outer_normal(),
        }
    }

    /// The place that was hit: rays of a Bump's height leave from there, and tangents are those of it, as in Cycles.
    pub(super) fn at_hit(&self) -> Self {
        let (u, v) = self.hit.unwrap_or((self.u, self.v));
        let hit = None;
        Self { u, v, hit, ..*self }
    }
}
