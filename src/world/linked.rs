//! What a ray finds of surfaces that shine and have blockers of their own (shadow linking): all of them along it, whatever else
//! stands in their way.

use super::*;
use crate::scene::Links;

/// So many of them are found on one ray.
const MOST: usize = 64;

impl World {
    /// Visits the hits on such surfaces that rays of the sender's kind see, in their order, with their opacity.
    #[cold]
    #[inline(never)]
    pub fn shadow_linked_along(
        &self,
        (origin, direction): (Vec3, Vec3),
        sender: &Sender,
        mut visit: impl FnMut(&Hit, f32),
    ) {
        let mut near = float::RAY_START;
        for _ in 0..MOST {
            let ray = Ray {
                origin: origin.to_array(),
                direction: direction.to_array(),
                near,
                far: f32::INFINITY,
                mask: Links::SHADOW_LINKED,
                time: sender.time,
            };
            let Some(hit) = self.geometry.embree.intersect(&ray) else {
                return;
            };
            let entry = &self.geometry.entries[hit.object() as usize];
            if entry.visibility.sees(sender.kind) {
                visit(&hit, self.opacity::<General>(&hit, direction, sender));
            }
            // The next float: of faces at one distance one is enough, as on the path.
            near = hit.distance.next_up();
        }
    }
}
