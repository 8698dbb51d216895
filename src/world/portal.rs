//! Where rays go on that meet a portal.

use super::World;
use super::view::from_blender;
use crate::shading::closure::Portal;
use glam::Vec3;

/// Of less than this, square metres, a ray has not moved: it leaves the surface that it has met, as in Cycles.
const SAME_PLACE: f32 = 1e-9;

impl World {
    /// Whether some surfaces send rays elsewhere.
    #[inline]
    pub fn has_portals(&self) -> bool {
        self.geometry.portals
    }

    /// Where a ray goes on that has met a portal at a point by a direction, `None` of that place itself, and in which direction.
    /// Numbers may be of no place or direction.
    pub fn beyond_portal(
        &self,
        portal: &Portal,
        (point, direction): (Vec3, Vec3),
    ) -> Option<(Option<Vec3>, Vec3)> {
        let onward = match portal.direction {
            Vec3::ZERO => direction,
            // Squares of its numbers may be beyond an f32.
            given => from_blender(given).as_dvec3().try_normalize()?.as_vec3(),
        };
        let place = |p: Vec3| (from_blender(p).as_dvec3() - self.origin).as_vec3();
        match portal.position.map(place) {
            Some(place) if !place.is_finite() => None,
            place => {
                let place = place.filter(|p| p.distance_squared(point) > SAME_PLACE);
                Some((place, onward))
            }
        }
    }
}
