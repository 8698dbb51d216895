//! What meets the surface goes on elsewhere: Blender's Ray Portal. Where that is, is the path's affair; no direction is drawn here,
//! and no light found by its own.

use glam::Vec3;

/// The way through a portal. Place and direction stand in Blender's axes, as its sockets give them.
#[derive(Clone, Copy, Debug)]
pub struct Portal {
    /// Weight of the lobe, the colour included.
    pub weight: Vec3,
    /// Where rays go on, in the world; from where they have met the surface if there is none.
    pub position: Option<Vec3>,
    /// In which direction, of any length; straight on if it is 0.
    pub direction: Vec3,
    /// The surface's normal.
    pub normal: Vec3,
}
